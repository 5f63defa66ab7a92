"""Passes over the mentions of a sentence: exceptions, corrections, comparisons, and what is said of other things.

Each takes all mentions and the words for the object, and gives the mentions back with some emptied or changed. They
are independent of each other but for one thing: what is said of the camera or of other things goes first, so that no
later pass meets it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise, takewhile

from physagent_jax.agents.grammar.landmarks import read_landmarks
from physagent_jax.agents.grammar.mentions import (
    LOOSE,
    MOTIONS,
    WAYS,
    Mention,
    MentionKind,
    empty,
    get_last_motion,
    get_phrase,
    has_motion,
    ignore,
    list_segments,
    read_as,
)
from physagent_jax.agents.grammar.missiles import read_missiles
from physagent_jax.agents.grammar.outcomes import read_aims, read_ends, read_outcomes, read_tumbles
from physagent_jax.agents.grammar.poses import read_landings, read_poses
from physagent_jax.agents.grammar.sequels import (
    read_captions,
    read_debris,
    read_exits,
    read_lulls,
    read_trends,
)
from physagent_jax.agents.grammar.subjects import read_lists, read_subjects, sticks_out
from physagent_jax.agents.grammar.tables import LEXICON, get_set, read_sections
from physagent_jax.agents.intent import Quantity, Solid
from physagent_jax.agents.lexicon import Effect, Join, Motion, Place, Repeat
from physagent_jax.forces.part import is_plural

OTHER = "other"
"""Phrase of emptied words that are said of something else than the object."""
_ECHO = "again and again"  # phrase of a verb's repetition

_REPLACED = {kind: (kind,) for kind in (MentionKind.PLACE, MentionKind.SENSE, MentionKind.QUANTITY)} | {
    way: WAYS for way in WAYS
}
_REST = {("nothing", "else"), ("everything", "else"), ("all", "else")}
_UPPERMOST = ("top", "lid", "crown", "head")  # first roles of what is on top
_HOVERING = (Effect.TURN, Effect.ROLL, Effect.STILL)
_ALOFT = frozenset(("in the air", "in mid air", "in midair"))
_HELD_ALOFT = frozenset(("held in the air", "hold ~ in the air"))
_HELD = "hold ~ there"
_NEAR = 6  # words from a part to the one that it is on
_REBOUNDING = ("bounc", "rebound", "ricochet")
_LATER = frozenset((Join.THEN, Join.AFTER, Join.BEFORE))
_REACH = 20  # words before a correction in which the corrected ones stand
# What ends a comparison.
_GOES_ON = (MentionKind.JOIN, MentionKind.TIME, MentionKind.REPEAT, MentionKind.QUANTITY)
_GOES_ON += (MentionKind.SENSE, MentionKind.FROM, MentionKind.SOLID)
# Motions whose form is told by the verb, so that a comparison adds nothing; how fast a fall is, it would tell.
_SHAPED = frozenset((Effect.SWAY, Effect.TURN, Effect.LEAN, Effect.TOPPLE, Effect.SCALE, Effect.SWELL))
_SHAPED |= {Effect.BURST, Effect.JUMP, Effect.ROLL}


def drop_others(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Empties what the camera does, what another thing than the object does by itself, and that nothing else moves.

    "Pan the camera to the left", "a bird flies past the robot", "everything else stays still": the motion and all that
    is told of it.
    """
    result = list(mentions)
    named = any(mention.phrase in names for mention in mentions)
    pronouns = [at for at, mention in enumerate(mentions) if mention.phrase in get_set("pronouns")]
    places = _count_places(mentions)
    before = None  # where a subject begins that goes on with the segment's: "the buns and everything else stay put"
    for begin, end in list_segments(mentions):
        segment = mentions[begin:end]
        rest = bool({(a.form, b.form) for a, b in pairwise(segment)} & _REST)
        rest |= _is_rest_still(segment, apart=places > _count_places(segment))
        rest |= _is_own_still(mentions, begin, end, names)
        first = before if rest and before is not None else begin
        begin, before = first, begin if _is_subject(segment) else None
        segment = mentions[begin:end]
        own = any(each.phrase == "the" for each in segment[:2])
        # "the gizmo tips before it stops": "it" is that
        later = [at for at in pronouns if at >= end and own and has_motion(mentions[at + 1 : at + 2])]
        meant = named or len(later) < len(pronouns)
        if _is_strange_still(segment, lambda a=begin, b=end: mentions[:a] + mentions[b:], names):
            result[begin:end] = map(ignore, segment)
        elif rest or _is_filmed(segment, names) or meant and _is_done_by_another(segment, names):
            result[begin:end] = [
                empty(m, OTHER if m.kind in MOTIONS or m.form in get_set("camera_verbs") else "aside")
                for m in segment
            ]
    return result


def read_rebounds(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Lets what meets a wall come off it, if the next verb, or the one before, says so.

    "It hits the wall and bounces back" asks for no other motion than that the wall gives it.
    """
    result = list(mentions)
    for at, solid in enumerate(mentions):
        if not isinstance(solid.value, Solid):
            continue
        verbs = [i for i, each in enumerate(mentions) if each.kind is MentionKind.VERB]
        behind = next((i for i in verbs if i > at), None)
        if behind is not None and mentions[behind].phrase in get_set("rebounding"):
            joins = (i for i in range(behind, len(mentions)) if mentions[i].kind is MentionKind.JOIN)
            told = mentions[behind : next(joins, None)]
            if any(each.kind in (MentionKind.REPEAT, MentionKind.SOLID) for each in told):
                continue
            result[behind : behind + len(told)] = map(empty, told)
        elif (before := next((i for i in reversed(verbs) if i < at), None)) is None or not (
            mentions[before].form.startswith(_REBOUNDING)
        ):
            continue
        elif (verb := mentions[before].motion) is not None and verb.effect is Effect.RELEASE:
            result[before] = replace(mentions[before], value=LEXICON.motions["move"], phrase="move")
        result[at] = replace(solid, value=solid.value.model_copy(update=dict(rebounds=True)))
    return result


def read_heights(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Measures a leap by the one before: "it jumps twice, the second time higher" pushes nothing up."""
    result, last = list(mentions), None
    for at, mention in enumerate(mentions):
        if mention.phrase == "higher" and last is not None and last.effect is Effect.JUMP:
            stronger = dict(value=LEXICON.comparatives["harder"], phrase="harder")
            result[at] = replace(mention, kind=MentionKind.COMPARATIVE, **stronger)
        else:
            last = mention.motion or last
    return result


def _count_places(mentions: list[Mention]) -> int:
    return sum(each.kind is MentionKind.PLACE for each in mentions)


def _is_rest_still(segment: list[Mention], *, apart: bool) -> bool:
    """Return whether a segment says that the rest is still: "while the rest of him (or the body) stays frozen".

    Args:
        segment: The segment.
        apart: Whether the others name a part.
    """
    verb = next((each.motion for each in segment if each.motion is not None), None)
    named = any((a.form, b.form) == ("the", "rest") for a, b in pairwise(segment))
    named |= apart and any(each.form == "body" for each in segment)
    return named and verb is not None and verb.effect is Effect.STILL


def _is_own_still(mentions: list[Mention], begin: int, end: int, names: frozenset[str]) -> bool:
    """Return whether the object by its noun is all but a part: "the stem bends while the pumpkin itself stays put"."""
    segment, sides = mentions[begin:end], (reversed(mentions[:begin]), mentions[end:])
    joins = [m for each in sides for m in takewhile(lambda m: m.kind is MentionKind.JOIN, each)]
    verb, kinds = _find_motion(segment), {each.kind for each in segment}
    still = any(each.motion and each.motion.effect is Effect.STILL for each in segment[verb : verb + 1])
    still |= MentionKind.NOT in kinds and get_phrase(segment, verb) in get_set("budging")
    later = MentionKind.TIME in kinds or any(each.value in _LATER or each.phrase == "with" for each in joins)
    own = any(each.phrase in names for each in segment[:verb])
    own &= not later or any(each.form == "itself" for each in segment)
    if not (still and own) or MentionKind.PLACE in kinds:
        return False
    others = (mentions[first:last] for first, last in list_segments(mentions) if first != begin)
    return any(_count_places(each[: _find_motion(each)]) and has_motion(each) for each in others)


def _find_motion(segment: list[Mention]) -> int:
    return next((at for at, each in enumerate(segment) if each.kind in MOTIONS), len(segment))


def _is_strange_still(
    segment: list[Mention], others: Callable[[], list[Mention]], names: frozenset[str]
) -> bool:
    """Return whether what stays put is no part that is known: "the robot spins while its cargo stays put"."""
    verb = next((at for at, each in enumerate(segment) if each.kind in MOTIONS), 0)
    subject, motion = segment[:verb], segment[verb].motion if segment else None
    strange = {m.phrase for m in subject if m.kind is MentionKind.UNKNOWN}
    still = motion and motion.effect is Effect.STILL or any(m.kind is MentionKind.NOT for m in subject)
    if not (motion and strange and still):
        return False
    own, told = names | get_set("pronouns") | get_set("objects"), others()
    named = [any(m.kind is MentionKind.PLACE or m.phrase in own for m in each) for each in (subject, told)]
    moved = any(m.motion and m.motion.effect is not Effect.STILL for m in told)
    return named == [False, True] and moved and strange.isdisjoint(m.phrase for m in told)


def _is_subject(segment: list[Mention]) -> bool:
    """Return whether a segment is parts alone, of which another tells what they do."""
    kinds = {mention.kind for mention in segment}
    return MentionKind.PLACE in kinds and kinds <= {MentionKind.PLACE, MentionKind.FUNCTION}


def _is_filmed(segment: list[Mention], names: frozenset[str]) -> bool:
    """Return whether a segment tells what the camera does."""
    first = _find_motion(segment)
    camera = any(m.phrase in get_set("cameras") for m in segment[:first])
    films = any(m.form in get_set("camera_verbs") for m in segment[: first + 1])
    object_first = any(m.phrase in names for m in segment[:first])
    told = any(m.phrase in get_set("cameras") for m in segment[first:])
    moves = first < len(segment)
    return films and (camera or told or not moves) or camera and not object_first and moves


def _is_done_by_another(segment: list[Mention], names: frozenset[str]) -> bool:
    """Return whether the subject is another thing, and nothing is done to the object: "the door slams on the left"."""
    at = next((i for i, m in enumerate(segment) if m.kind is MentionKind.VERB), None)
    caused = any(m.kind is MentionKind.CAUSE for m in segment)
    if at is None or caused or not segment[at].form.endswith(("s", "ed")):
        return False
    subject, beside, ends = at, (MentionKind.FUNCTION, *LOOSE), get_set("determiners")
    while subject and segment[subject - 1].kind in beside and segment[subject - 1].phrase not in ends:
        subject -= 1
    noun, things = segment[subject:at], LEXICON.agents
    told = any(m.phrase in things or m.kind in LOOSE[:2] and not m.phrase.endswith("ly") for m in noun)
    own = names | get_set("pronouns") | get_set("relatives")
    another = subject > 0 and segment[subject - 1].phrase in ("a", "an", "the")
    some = any(m.form == "something" for m in noun)  # "something heavy comes down"
    if not (told and another or some) or any(m.phrase in own for m in segment[:at]):
        return False
    if segment[at].phrase.endswith(("soft", "soften")):
        return False  # "the metal goes soft": its own
    verb, skipped = segment[at].motion, {"one", "of", "both", "all"} | get_set("determiners")
    # "A plate presses down on the robot", "a hand tugs at one of its horns".
    pushes = verb is not None and verb.effect is Effect.PUSH and not verb.generic
    if acts := pushes or verb is not None and verb.effect in (Effect.SCALE, Effect.STRIKE):
        skipped |= {"down", "on", "onto", "upon", "against", "at"}
    behind = [m for m in segment[at + 1 : at + 8] if m.phrase not in skipped]
    meant = next((m for m in behind if m.kind not in LOOSE or m.phrase in LEXICON.unplaced), None)
    if meant is None or not acts and segment[at + 1].form in get_set("pronouns_of_owners"):
        return True  # "a bird flaps its wings"
    part = meant.kind is MentionKind.PLACE or meant.phrase in LEXICON.unplaced
    return not part and meant.phrase not in names | get_set("objects")  # "a crane lifts the robot"


def mark_exceptions(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes the place in "except the head", "but not the head", "everything but the head" an excluded one."""
    result: list[Mention] = []
    at = 0
    while at < len(mentions):
        place = _find_exception(mentions, at)
        result.append(mentions[at] if place is None else replace(mentions[place], kind=MentionKind.EXCLUDED))
        at = at + 1 if place is None else place + 1
    return result


def _find_exception(mentions: list[Mention], at: int) -> int | None:
    """Index of the excluded place if an exception begins at ``at``."""
    contrasts = mentions[at].kind is MentionKind.JOIN and mentions[at].value is Join.BUT
    if mentions[at].kind is not MentionKind.EXCEPT and not contrasts:
        return None
    place = at + 1
    while place < len(mentions) and mentions[place].kind in (MentionKind.FUNCTION, MentionKind.NOT):
        place += 1
    if place >= len(mentions) or mentions[place].kind is not MentionKind.PLACE:
        return None
    if not contrasts:
        return place
    negated = any(m.kind is MentionKind.NOT for m in mentions[at:place])
    begin = next((i for i in range(at - 1, -1, -1) if mentions[i].kind is MentionKind.JOIN), -1)
    whole = any(m.phrase in LEXICON.whole for m in mentions[begin + 1 : at])
    after = mentions[place + 1].kind if place + 1 < len(mentions) else MentionKind.JOIN
    if whole and not negated:  # but "all of it is still, but the top sways"
        return None if has_motion(mentions[:at]) and after is MentionKind.VERB else place
    return place if negated and after is MentionKind.JOIN else None


def read_corrections(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Puts what corrects a phrase in its place: "to the left, no wait, to the right", "the tip, i.e. the top"."""
    result = list(mentions)
    for begin in range(1, len(mentions)):
        size = _match_correction(mentions, begin)
        if not size or mentions[begin - 1].kind is not MentionKind.JOIN and mentions[begin].form != "or":
            continue
        while begin + size < len(mentions) and mentions[begin + size].kind is MentionKind.JOIN:
            size += 1
        stop = begin + size
        while stop < len(mentions) and mentions[stop].kind not in (MentionKind.JOIN, *MOTIONS):
            stop += 1
        said = mentions[begin + size : stop]
        plain = {m.kind for m in said} <= {MentionKind.FUNCTION}
        if plain and stop < len(mentions) and mentions[stop].kind is MentionKind.VERB:
            last = max((i for i in range(begin) if mentions[i].kind is MentionKind.VERB), default=None)
            if last is not None and begin - last <= _REACH:  # "lift it, sorry, I meant drop it"
                result[last : begin + size] = [empty(m) for m in mentions[last : begin + size]]
            continue
        told = [m for m in said if m.kind in _REPLACED]
        if not told or any(m.kind not in (*_REPLACED, MentionKind.FUNCTION) for m in said):
            continue
        for mention in told:
            for place in [
                i for i in range(max(begin - _REACH, 0), begin) if result[i].kind in _REPLACED[mention.kind]
            ][-1:]:
                result[place] = empty(result[place])
        first = begin
        while first > 0 and mentions[first - 1].kind is MentionKind.JOIN:
            first -= 1
        result[first : begin + size] = [empty(m) for m in result[first : begin + size]]
    return result


def _match_correction(mentions: list[Mention], at: int) -> int:
    """The number of mentions from ``at`` on that take back what stands before; 0 if they do not."""
    if mentions[at].phrase == "rather than":
        return 0
    words = [m.words.lower() if m.kind is MentionKind.JOIN else m.form for m in mentions[at : at + 3]]
    for size in (3, 2, 1):
        if " ".join(word for word in words[:size] if word != ",") in get_set("corrections"):
            return size
    return 0


def read_comparisons(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Empties "like a leaf", "as though it were alive", where the motion is known without it.

    Where the verb says nothing by itself ("moves"), a thing known for one motion does ("like a pendulum").
    """
    result = _drop_similes(mentions)
    at: int | None = None
    for index, mention in enumerate(mentions):
        at = index if mention.kind is MentionKind.VERB else at
        verb = result[at].motion if at is not None else None
        spoken = index > 0 and mentions[index - 1].form in get_set("before_likes")
        likens = mention.form == "like" and not spoken
        supposes = mention.phrase in ("as if", "as though")
        if mention.kind is not MentionKind.FUNCTION or not (likens or supposes) or at is None or verb is None:
            continue
        end = _find_end(mentions, index)
        telling = _is_telling(verb) or likens and _is_told(verb, mentions[at:end])
        models, likened = read_sections()["models"], mentions[index:end] if likens else []
        words = [word for each in likened for word in (each.words.lower(), each.form)]
        model = next((models[word] for word in words if word in models), None)
        same = model is not None and LEXICON.motions[model].effect is verb.effect
        if model is not None and verb.generic and not same:
            result[at] = replace(result[at], value=LEXICON.motions[model], phrase=model)
        elif not (telling or same or supposes and not verb.generic):
            continue
        told = (MentionKind.VERB, MentionKind.PLACE, *LOOSE[:2])
        inside = [i for i in range(index, end) if not supposes or mentions[i].kind in told]
        done = supposes and any(mentions[i].kind in MOTIONS for i in range(index, end))
        for place in inside if done else range(index, end):
            result[place] = empty(mentions[place], "comparison")
    return result


def _drop_similes(mentions: list[Mention]) -> list[Mention]:
    """The mentions without "as a board" of "stiff as a board", and without an adjective that means nothing here."""
    result = list(mentions)
    for at in range(1, len(mentions) - 1):
        before, article = mentions[at - 1], mentions[at + 1].form in ("a", "an")
        likens = before.form in get_set("copulas") if before.kind is MentionKind.VERB else article
        # "As light as cloth".
        twice = at > 1 and mentions[at - 2].form == "as" and mentions[at + 1].kind in LOOSE
        if mentions[at].form == "as" and (likens or twice):
            first, end = at - 1 if before.kind is MentionKind.UNKNOWN else at, at + 2 + article
            first = first if article else at - 2 if twice else first
            while end < len(mentions) and mentions[end].kind in LOOSE[:2]:
                end += 1  # "as a rubber hose"
            result[first:end] = [empty(each, "comparison") for each in mentions[first:end]]
    return result


def _is_telling(verb: Motion) -> bool:
    """Return whether a verb says what form its motion has; which way a stretch goes, a comparison may tell."""
    # "scurries", "walks"
    paced = verb.effect is Effect.PUSH and (verb.strength != 1 or verb.direction == "ahead")
    shaped = paced or verb.effect in _SHAPED or verb.direction in ("up", "down")  # "floats like a feather"
    return not verb.generic and shaped and not (verb.effect is Effect.SCALE and verb.sign > 0)


def _is_told(verb: Motion, told: list[Mention]) -> bool:
    """Return whether a comparison adds nothing to a verb and its way: "push it to the left like a bulldozer"."""
    words = {mention.form for mention in told}
    if words & get_set("telling_models") or told[0].phrase in ("move", "go"):
        return False
    way = any(each.kind in (*WAYS, MentionKind.AXIS, MentionKind.PLANE, MentionKind.SIDES) for each in told)
    stretched = verb.effect is Effect.SCALE and (way or bool(words & get_set("stretchy")))
    struck = verb.effect is Effect.STRIKE and not verb.gravity
    return stretched or struck or verb.bounces or verb.effect is Effect.PUSH and way


def _find_end(mentions: list[Mention], index: int) -> int:
    """The end of a comparison: a connective, a way, a time, a count; "and the beast" is no end."""
    names = (MentionKind.FUNCTION, *LOOSE[:2])
    for at in range(index + 1, len(mentions)):
        if mentions[at].value is Join.AND:
            behind = next((each for each in mentions[at + 1 :] if each.kind not in names), None)
            if at + 1 < len(mentions) and (behind is None or behind.kind is MentionKind.JOIN):
                continue
        way = mentions[at].kind is MentionKind.DIRECTION and mentions[at - 1].form in ("to", "the")
        if mentions[at].kind in _GOES_ON or way:
            return at
    return len(mentions)


def read_returns(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a step of "and back" behind a turn or behind measured steps: "left by a third, then right, and back"."""
    result: list[Mention] = []
    for at, mention in enumerate(mentions):
        result.append(mention)
        if mention.phrase not in ("and back", "and back again"):
            continue
        # "Up 10 cm and back down".
        if at + 1 < len(mentions) and mentions[at + 1].kind is MentionKind.DIRECTION:
            result[-1] = replace(mention, kind=MentionKind.JOIN, value=Join.THEN, phrase="then")
            continue
        steps = any(m.value is Join.THEN and m.words.isalpha() for m in mentions[:at])
        measured = any(m.kind is MentionKind.QUANTITY for m in mentions[:at])
        verb = get_last_motion(mentions[:at])
        swings = verb is not None and verb.effect is Effect.SWAY
        if steps and measured and not swings or verb is not None and verb.effect is Effect.TURN:
            back = replace(mention, kind=MentionKind.DIRECTION, value=("away",), phrase="back", words="back")
            result[-1:] = [replace(mention, kind=MentionKind.JOIN, value=Join.THEN, phrase="then"), back]
    return result


def read_aloft(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Takes its weight from what only turns "in the air", where what rolls turns about its own line.

    What is thrown or flips there keeps it, and what spins there and comes down again leaps for it.
    """
    motions = [mention.motion for mention in mentions if mention.motion is not None]
    rises = any(e.gravity or e.effect is Effect.PUSH and e.direction == "up" or e.leaps for e in motions)
    falls = rises or any(each.effect is Effect.FALL for each in motions)
    falls &= not any(each.floats for each in motions)
    aloft = any(each.phrase in _ALOFT or each.value == "none" for each in mentions)
    hovers = all(each.floats or each.effect in _HOVERING for each in motions) and bool(motions)
    if not aloft or not (hovers or falls) or any(m.kind is MentionKind.PLACE for m in mentions):
        return mentions
    turned = {Effect.ROLL: "roll over"}
    if falls:
        spins = motions[0].effect is Effect.TURN and not rises
        turned = {Effect.TURN: "whirl in the air"} if spins else {}

    def lift(each: Mention) -> Mention:
        if each.phrase in _ALOFT:
            return empty(each) if falls else replace(each, kind=MentionKind.GRAVITY, value="none")
        if each.phrase in _HELD_ALOFT and falls:
            return replace(each, kind=MentionKind.VERB, value=LEXICON.motions[_HELD], phrase=_HELD)
        phrase = turned.get(each.motion.effect) if each.motion else None
        return replace(each, value=LEXICON.motions[phrase], phrase=phrase) if phrase else each

    return list(map(lift, mentions))


def read_results(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Makes what a stretch or a squeeze leads to of the adjectives behind it: "stretch it until it is tall and thin".

    It gets thin by itself as it gets tall; where that alone is told, it is stretched lengthwise.
    """
    scaled = next((m.motion for m in mentions if m.motion is not None), None)
    if scaled is None or scaled.effect is not Effect.SCALE or scaled.generic:
        return mentions
    result, own, others = list(mentions), False, dict[int, str]()
    for at, mention in enumerate(mentions):
        plain = read_sections()["results"].get(mention.form) if mention.kind in LOOSE else None
        behind = mentions[at + 1] if at + 1 < len(mentions) else None
        describes = behind is not None and (behind.kind is MentionKind.UNKNOWN or behind.phrase in names)
        shape = mention.motion if mention.motion is not None and mention.motion.generic else None
        fatter = scaled.sign < 0 and mention.phrase in read_sections()["made_by"]
        grows = shape is not None and (shape.effect is Effect.SCALE or fatter)
        word = mention.phrase if grows else plain
        if mention.value is Join.THEN:
            break
        if word is None or not grows and (describes or at == 0):
            continue
        if LEXICON.motions[word].sign == scaled.sign:
            result[at], own = read_as(mention, word), True
        else:
            result[at], others[at] = empty(mention), word
    for at, word in list(others.items())[: not own]:
        result[at] = read_as(mentions[at], read_sections()["made_by"][word])
    sizes = [each.value for each in mentions if isinstance(each.value, Quantity)]
    shaped = own or bool(others) or any(each.relation == "is" for each in sizes)  # "until it's half as tall"
    return _drop_uppermost(result) if scaled.sign < 0 and shaped else result


def _drop_uppermost(mentions: list[Mention]) -> list[Mention]:
    """The mentions without the one part, on top, that is pressed on to squash all of it: "press on its head"."""
    parts = [at for at, each in enumerate(mentions) if isinstance(each.value, Place)]
    place = mentions[parts[0]].value if len(parts) == 1 else None
    top = isinstance(place, Place) and (place.names == ("up",) or place.role.startswith(_UPPERMOST))
    before = mentions[max(parts[0] - 2, 0) : parts[0]] if top else []
    pressed = any(each.words.lower().split()[-1] in ("on", "upon", "onto") for each in before)
    return [empty(each) if pressed and at == parts[0] else each for at, each in enumerate(mentions)]


def read_locations(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Empties the part that only says where another one is, or what that is closed onto.

    "The ears on its hat", "the fin on top", "both arms above its head", "the screen closes onto the keyboard", "it
    comes off and lands next to the stem".
    """
    result, hinged, ended = list(mentions), False, None
    for at, mention in enumerate(mentions):
        behind = next((m for m in mentions[at + 1 :] if m.kind is not MentionKind.FUNCTION), mention)
        placed = mentions[at - 1].kind is MentionKind.PLACE if at else False
        if placed and mention.form == "of" and sticks_out(behind):
            result[at - 1] = empty(mentions[at - 1])  # "the tip of its tail": that turns
        hinged |= mention.motion is not None and mention.motion.manner == "hinge"
        ended = mention.motion or ended
        on = placed and mention.form in ("on", "over", "above", "behind", "beside")
        severed = ended is not None and ended.manner == "detach"
        bends = ended is not None and ended.effect is Effect.LEAN and _count_places(mentions[:at]) > 0
        on |= (severed or bends) and mention.form in (
            "in",
            "at",
        )  # "it snaps in the middle", "droops at the tip"
        on |= ended is not None and mention.phrase in ("beside", "next to", "right next to")
        if not on and not (hinged and mention.form in ("onto", "against", "over")):
            continue
        for here in range(at + 1, min(at + _NEAR, len(mentions))):
            kind = mentions[here].kind
            if kind is MentionKind.PLACE or hinged and kind is MentionKind.UNKNOWN:
                result[at : here + 1] = [empty(m) for m in mentions[at : here + 1]]
                if mentions[here].form == "head" and mention.form in ("over", "above"):
                    up = dict(kind=MentionKind.DIRECTION, value=("up",), words="overhead", phrase="overhead")
                    result[here] = replace(mentions[here], **up)
            # "The cab roof".
            again = [each.kind for each in mentions[here : here + 2]] == [MentionKind.PLACE] * 2
            if kind not in (MentionKind.FUNCTION, *LOOSE) and not again:
                break
    return result


def read_stands(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a way of the part that something leans onto: "tilt it onto its back legs" moves no leg."""
    result, leaning = list(mentions), False
    for at, mention in enumerate(mentions):
        if mention.motion is not None:
            leaning = mention.motion.effect is Effect.LEAN
        if not leaning or mention.form != "onto":
            continue
        near = mentions[at + 1 : at + _NEAR]
        places = [each for each in near if isinstance(each.value, Place)]
        between = near[: near.index(places[0])] if places else near
        told = (MentionKind.FUNCTION, MentionKind.QUANTITY, MentionKind.DIRECTION, *LOOSE)
        if not places or any(each.kind not in told for each in between):
            continue
        ways = (each.value for each in between if each.kind is MentionKind.DIRECTION)
        named = next(ways, None) or getattr(places[0].value, "names", ())
        names = named if isinstance(named, tuple) else ()
        sides = tuple(name for name in names if name not in ("up", "down"))
        last = at + 1 + len(between)
        result[at : last + 1] = [empty(each) for each in mentions[at : last + 1]]
        if sides and not any(each.kind in WAYS for each in mentions[max(at - _NEAR, 0) : at]):
            way = dict(kind=MentionKind.DIRECTION, value=sides, phrase=" ".join(sides))
            result[last] = replace(places[0], **way)
    return result


def read_grounding(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a way of what a bend is to touch: "bend it until its top touches the ground" bends it to the ground."""
    result, bends, until = list(mentions), False, None
    for at, mention in enumerate(mentions):
        motion = mention.motion
        if mention.kind is MentionKind.JOIN:
            until = at if mention.value is Join.RESULT else None
        elif motion is None:
            bends |= until is None and mention.kind is MentionKind.PLACE and sticks_out(mention)
        elif until is None:
            bends = motion.manner == "bend" or motion.effect is Effect.PUSH and bends
        elif bends and motion.lands:
            result[until:at] = [empty(each) for each in mentions[until:at]]
            way = dict(kind=MentionKind.DIRECTION, value=("down",), phrase="to the ground")
            result[at] = replace(mention, **way)
    return result


def read_looks(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Empties the way to or from the viewer in which something turns to look: it turns about the upright for that."""
    result, looks, last = list(mentions), False, None
    for at, mention in enumerate(mentions):
        looks |= mention.form in get_set("looking") and last is not None and last.effect is Effect.TURN
        last = mention.motion or last
        if looks and mention.kind in WAYS and mention.value in (("away",), ("toward",)):
            result[at] = empty(mention)
    return result


def read_stances(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Empties how a part is held by what moves, "with its arms out"; "stands with its arms up" brings it there."""
    result, rests = list(mentions), True
    for at, mention in enumerate(mentions):
        owned, motion = mention.form == "with", mention.motion
        holds = mention.form in get_set("holding") and not has_motion(mentions[:at])
        holds |= owned and rests and has_motion(mentions[:at])
        rests &= motion is None or motion.effect is Effect.STILL and motion.generic
        end = next((k for k in range(at + 1, len(mentions)) if mentions[k].kind is MentionKind.JOIN), None)
        near = range(at + 1, min(at + _NEAR + 2, len(mentions) if end is None else end))
        place = next((k for k in near if mentions[k].kind is MentionKind.PLACE), None)
        swings = place is not None and owned and any(_swings(mentions[k]) for k in range(place, near.stop))
        if swings and not rests:  # "with its tail wagging"
            result[at] = replace(mention, kind=MentionKind.JOIN, value=Join.WHILE, phrase="while")
        elif place is not None and holds and sticks_out(mentions[place]):
            _take_stance(result, at, place, near.stop)
        elif place is not None and owned and not rests:
            last = next((k for k in near if mentions[k].form in get_set("stances")), at)
            owned = place == at + 1 or mentions[at + 1].form in get_set("pronouns_of_owners")
            result[at : last + owned] = [empty(m) for m in mentions[at : last + owned]]
    return result


def _swings(mention: Mention) -> bool:
    """Return whether a participle tells a motion that goes on: "wagging", but not "hanging" or "stretched"."""
    goes = (Effect.SWAY, Effect.TURN, Effect.LEAN, Effect.PUSH)
    return mention.motion is not None and mention.motion.effect in goes and mention.form.endswith("ing")


def _take_stance(mentions: list[Mention], at: int, place: int, end: int) -> None:
    """Makes a motion of how the part at ``place`` is held: of a verb behind it, or of the word at ``at``."""
    behind = range(place + 1, end)
    words = {word for k in range(at, end) for word in f"{mentions[k].phrase} {mentions[k].form}".split()}
    front = next((k for k in behind if mentions[k].phrase in ("front", "in front of")), None)
    ways = {mentions[k].kind for k in behind} & {*WAYS, MentionKind.PLANE, MentionKind.SIDES}
    spread = front is None and not ways and is_plural(mentions[place].words)
    phrase = "raise" if words & get_set("raised") else "spread out" if spread else "hold ~ out"
    if not words & (get_set("stances") - {"down"} | get_set("raised")):
        return
    if front is not None:
        ahead = replace(mentions[front], kind=MentionKind.DIRECTION, value=("toward",), phrase="forward")
        mentions[front:end] = [ahead, *map(empty, mentions[front + 1 : end])]
    verb = next((k for k in behind if mentions[k].kind is MentionKind.VERB), place - 1)
    if verb < place or getattr(mentions[verb].motion, "effect", None) in (Effect.SCALE, Effect.HOLD):
        mentions[verb] = read_as(mentions[verb], phrase)
    if at != verb:
        mentions[at] = replace(empty(mentions[at]), form="keep")


def read_grips(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Empties what all is taken by: "lift it by the end of its wooden handle", "grab its brim and lift the hat"."""
    result, own, kinds = list(mentions), names | get_set("objects"), (MentionKind.PLACE, *LOOSE)
    idle = {"of", "one", "both", *LEXICON.part_adjectives, *LEXICON.part_nouns, *get_set("determiners")}
    for begin, end in list_segments(mentions):
        at = max((k for k in range(begin, end) if mentions[k].phrase in get_set("gripping")), default=end)
        first = next((k for k in range(end, len(mentions)) if mentions[k].motion), end)
        noun = next((m.phrase for m in mentions[first + 1 :] if m.phrase not in idle), "")
        denied = any(m.kind in (MentionKind.NOT, *MOTIONS) for m in mentions[begin:first])
        motion, whole = get_last_motion(mentions[: first + 1]), noun in names and not denied
        if by := get_phrase(mentions, at) == "by":
            beside = {k for k in range(at, end) if mentions[k].kind in kinds or mentions[k].phrase in idle}
            end = next((k for k in range(at + 1, end) if k not in beside), end)
            motion, whole = get_last_motion(mentions[:at]), any(m.phrase in own for m in mentions[begin:at])
        taken, effect = mentions[at + 1 : end], motion and motion.effect
        local = effect in (Effect.LEAN, Effect.SCALE, Effect.SWELL, Effect.RELEASE)
        placed = any(m.kind is MentionKind.PLACE and not m.phrase.startswith("one ") for m in taken)
        if by and placed:  # "lift it by one handle" raises that side
            whole, local = effect is Effect.LEAN or all(m.phrase != "one" for m in taken), False
        for k, each in enumerate(taken if whole and not local else [], at + 1):
            if each.kind is not MentionKind.UNKNOWN:
                result[k] = each if by and not placed else empty(each)
            elif each.words.isalpha():
                result[k] = replace(each, kind=MentionKind.IGNORED)
    return result


def read_echoes(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a count of a verb that is said again and again, and empties doubled comparatives.

    "Hop hop hop" hops three times; "smaller and smaller swings" are swings, and "lower and lower" is lower.
    """
    result: list[Mention] = []
    for at, mention in enumerate(mentions):
        last = result[-1] if result else None
        motion = mention.motion
        # "Clatter clatter".
        lands = motion is not None and motion.effect is Effect.FALL and not motion.bounces
        if mention.kind is MentionKind.VERB and last is not None and not lands:
            count = last.value.count or 0 if isinstance(last.value, Repeat) and last.phrase == _ECHO else 1
            said = result[-2] if count > 1 and len(result) > 1 else last
            if said.phrase == mention.phrase and said.form == mention.form:
                told = replace(mention, kind=MentionKind.REPEAT, value=Repeat(count + 1), phrase=_ECHO)
                result[-1:] = [told] if count > 1 else [last, told]
                continue
        result.append(mention)
        around = [mentions[k] for k in (at - 1, at + 1) if 0 <= k < len(mentions)]
        apart = all(each.kind is MentionKind.JOIN and not each.words.isalnum() for each in around)
        if apart and around and mention.words.lower() in get_set("sounds"):
            result[-1] = empty(mention)  # "Thump. It tips over"
        doubled = len(result) > 2 and result[-2].value is Join.AND and result[-3].form == mention.form
        compares = mention.motion is not None and mention.motion.generic and mention.form.endswith("er")
        if doubled and compares:
            behind = mentions[at + 1] if at + 1 < len(mentions) else None
            noun = behind is not None and behind.kind not in (MentionKind.JOIN, MentionKind.TIME)
            result[-3 if noun else -2 :] = [empty(m) for m in result[-3 if noun else -2 :]]
    return result


def read_exclamations(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a count of a verb that is called out before it is told: "hop hop hop! It hops forward"."""
    result, calls, count = list(mentions), [], 0
    for at, (mention, behind) in enumerate(zip(mentions, [*mentions[1:], None])):
        verb, mark = mention.kind is MentionKind.VERB, _is_mark(mention)
        same = verb and bool(calls) and mention.phrase == mentions[calls[0]].phrase
        begins = at == 0 or _is_mark(mentions[at - 1])
        ends = behind is not None and (_is_mark(behind) or behind.phrase == _ECHO)
        if verb and begins and ends and mention.form == mention.phrase and (same or not calls):
            calls.append(at)
            count += 1
        elif calls and (mark or mention.phrase == _ECHO and isinstance(mention.value, Repeat)):
            calls.append(at)
            count += 0 if mark or not isinstance(mention.value, Repeat) else (mention.value.count or 1) - 1
        elif same and count > 1:
            end = next((k for k in range(at, len(mentions)) if mentions[k].kind is MentionKind.JOIN), None)
            told = any(each.kind is MentionKind.REPEAT for each in mentions[calls[-1] + 1 : end])
            count += begins and mentions[at - 1].value is Join.COMMA  # "push, push, push it"
            repeat = replace(mention, kind=MentionKind.REPEAT, value=Repeat(count), phrase=_ECHO)
            for call in calls:
                result[call] = empty(mentions[call])
            return result if told else [*result[: at + 1], repeat, *result[at + 1 :]]
        elif verb or mention.kind is MentionKind.JOIN:
            calls, count = [], 0
    return result


def _is_mark(mention: Mention) -> bool:
    """Return whether a connective is a mark of punctuation."""
    return mention.kind is MentionKind.JOIN and not mention.words.isalpha()


def read_stillness(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a verb of a "still" that is said of a part, and none of an adverb; empties what denies a part the same.

    "The leaves rustle, trunk perfectly still"; "it is still wet"; "the cap wobbles, the stem doesn't".
    """
    result = list(mentions)
    for begin, end in list_segments(mentions):
        segment = mentions[begin:end]
        for at, (each, behind) in enumerate(pairwise(segment), begin):
            lasting = each.words.lower().endswith("still") and each.motion is not None
            if lasting and (behind.kind is MentionKind.UNKNOWN or behind.form.endswith("ing")):
                result[at] = empty(each, each.form)
        if has_motion(result[begin:end]) or not _count_places(segment):
            continue
        if begin and segment[-1].kind is MentionKind.NOT:
            result[begin:end] = [empty(each) for each in segment]
        if segment[-1].form == "still":
            result[end - 1] = read_as(segment[-1], "stay still")
            if begin and mentions[begin - 1].value in (Join.COMMA, Join.BUT):
                result[begin - 1] = replace(mentions[begin - 1], value=Join.WHILE)
    return result


PASSES = (
    read_grips, read_trends, read_debris, read_lulls, read_exits, read_captions, read_echoes,
    read_exclamations, read_missiles, drop_others, read_corrections, mark_exceptions, read_comparisons,
    read_aims, read_outcomes, read_ends, read_tumbles, read_stillness, read_returns, read_rebounds,
    read_heights, read_landmarks, read_poses, read_landings, read_grounding, read_aloft, read_results,
    read_locations, read_stands, read_stances, read_looks, read_subjects, read_lists
)  # fmt: skip
