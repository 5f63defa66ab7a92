"""Lexicon of what tells no motion: words of grammar, moods, fixed expressions, whoever acts."""

from __future__ import annotations

# Words that carry nothing by themselves: grammar, light verbs, whoever acts, the scene around.
FUNCTION_WORDS = frozenset(
    (
        "a an the this that these those it its itself he she him her his they them their themselves we us our i me "
        "my you your is are was were be been being am do does did done has have had having will would can could "
        "should shall may might must of to in into on onto at by for from with within under over against through "
        "across along about around past beyond off out near and or if than there here where what who whom whose how "
        "why which as so also just only even again still all each every both some any own other one ones first second "
        "now like until upon up due because while let lets letting make makes made making cause causes caused causing "
        "get gets got getting give gives gave given giving take takes took taken put puts keep keeps kept prevent "
        "prevents preventing start starts started starting begin begins began beginning become becomes became try "
        "tries continue continues come comes came coming act acts acting applied apply applies applying receive "
        "receives received undergo undergoes experience experiences feel feels want wants need needs thank thanks "
        "kindly see show mind wish hope imagine suppose supposing assume assuming possible set sets setting react "
        "reacts pointing directed aimed shot touch touching touched arrive arrives reach reaches happen happens "
        "likes please ok someone somebody person people something nothing anything everything hand hands finger "
        "fingers fist fists hammer ball foot feet rope string invisible giant between two three object thing model "
        "subject scene video clip camera viewer axis direction side way bit ground floor table ceiling sky wall "
        "walls plate plates place motion movement effect shape position body part end ends rest time times seconds "
        "frame frames degrees whole entire entirely original straight directly toward towards much suddenly s t per "
        "percent base bottom right series pls plz thx ty dat dis da duration impose imposes imposed imposing creak "
        "creaks creaking squeak squeaks squeaking hum hums humming buzz buzzes buzzing whistle whistles whistling "
        "sigh sighs sighing laugh laughs laughing giggle giggles giggling full complete passes passing hey hi hello "
        "okay alright well oh ah hmm yes yeah sorry maybe perhaps possibly whether favour favor love loves enjoy "
        "merely simply purely solely actually basically literally everywhere herself himself myself yourself "
        "constant steady uniform net single external resultant initial sustained simple pure uniaxial subjected "
        "delivered imparted exerted perform performs performed performing exhibit exhibits approx ca ie eg "
        "approximately mean roughly grab grabs grabbed grip grips grasp grasps seize seizes gradually specimen sample "
        "item product prop figure character creature background backdrop studio turntable pedestal stage smoothly"
    ).split()
)
# Moods and styles, as adjectives; adverbs follow.
MOODS = frozenset(
    (
        "merry happy cheerful sad curious proud majestic graceful elegant playful nervous angry loving sleepy dreamy "
        "mysterious magical beautiful nice natural realistic photorealistic cinematic comical funny clumsy awkward "
        "neat proper accidental deliberate naughty polite joyful joyous grumpy lonely brave shy cheeky silly dramatic "
        "peaceful serene solemn eager excited anxious mischievous thoughtful respectful hesitant confident stubborn "
        "spectacular stylish romantic smooth gradual good proper real dynamic precarious ghostly unseen rigid"
    ).split()
)
# Strokes that are counted are apart anyway.
PAUSES = frozenset(
    f"{rest} {where}"
    for rest in ("pause", "a pause", "wait", "rest", "a rest", "stop", "halt", "a break")
    for where in ("in between", "between", "between them", "after each", "after each time", "each time")
)
FUNCTION_PHRASES = frozenset(
    {
        "in the air",
        "into frame",
        "into view",
        "out of view",
        "out of sight",
        "slow motion",
        "locked off",
        "into the frame",
        "into shot",
        "out of frame",
        "out of the frame",
        "out of shot",
        "off screen",
        "across the screen",
        "across the frame",
        "across the picture",
        "through the air",
        "not only",
        "split second",
        "all right",
        "off center",
        "off centre",
        "top heavy",
        "bottom heavy",
        "from rest",
        "rock steady",
        "rock solid",
        "in front of",
        "end up",
        "ends up",
        "kind of",
        "sort of",
        "as if",
        "as though",
        "would ~ look like",
        "does ~ look like",
        "would ~ look",
        "does ~ look",
        "will ~ look",
        "will ~ look like",
        "lots of",
        "each other",
        "do nothing more",
        "do nothing else",
        "does nothing more",
        "does nothing else",
        "turn out that",
        "turns out that",
        "turned out that",
    }
    | PAUSES
)
# Words for whoever acts; with "a" or "an" in front they are not parts of the object.
AGENT_NOUNS = frozenset("hand hands finger fingers fist foot arm leg head hammer stick ball".split())
