"""Words outside the grammar: ignored ones, which no motion depends on, and doubtful ones, which may change it.

Words of looks, scenery, camera, light, mood and talk are ignored wherever they stand (`lexicon/scenery.yaml`). Other
unknown words are judged by their place: what stands where a verb, an object or a part would stand is doubtful; what
tells a place, describes, accompanies or stands in a fragment of its own is ignored.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from physagent_jax.agents.grammar.mentions import MOTIONS, Mention, MentionKind, get_last_motion, get_phrase
from physagent_jax.agents.grammar.nouns import is_telling
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.schema import SceneBrief

_LEAST_WORDS, _MOST_UNKNOWN = 3, 0.5
_LOOSE = (MentionKind.UNKNOWN, MentionKind.IGNORED, MentionKind.INTENSITY, MentionKind.DEGREE)


@dataclass(frozen=True)
class Coverage:
    """The words of a sentence that the grammar has no place for.

    Attributes:
        ignored: Words that do not bear on the motion.
        doubtful: Words that may bear on it.
        taken: Words taken for the object's name.
    """

    ignored: tuple[str, ...] = ()
    doubtful: tuple[str, ...] = ()
    taken: tuple[str, ...] = ()


def sort_words(mentions: list[Mention], names: frozenset[str], brief: SceneBrief) -> Coverage:
    """The unknown words of a sentence by whether they may bear on the motion; ``names`` are words for the object."""
    named = any(mention.phrase in names for mention in mentions)
    nameless = not is_telling(brief.object_name)
    found: dict[str, list[str]] = {"ignored": [], "doubtful": [], "taken": []}
    for index, mention in enumerate(mentions):
        word = mention.phrase
        if mention.kind is MentionKind.IGNORED:
            kind = "ignored"
        elif mention.kind is not MentionKind.UNKNOWN or word in names:
            continue
        elif is_look(word) and not _is_telling_a_part(mentions, index, names):
            kind = "ignored"
        elif nameless and word.isalpha() and _is_named_here(mentions, index, named, found["taken"]):
            kind = "taken"
        else:
            kind = "ignored" if _is_ignored(mentions, index, names) else "doubtful"
        if not any(word in words for words in found.values()):
            found[kind].append(word)
    return Coverage(*(tuple(found[kind]) for kind in ("ignored", "doubtful", "taken")))


def is_mostly_unknown(mentions: list[Mention], coverage: Coverage) -> bool:
    """Whether so little was understood that what was is probably misunderstood: another language, say."""
    words = [m for m in mentions if m.kind is not MentionKind.JOIN or m.words.isalpha()]
    unknown = sum(mention.kind is MentionKind.UNKNOWN and not is_look(mention.phrase) for mention in mentions)
    return len(words) >= _LEAST_WORDS and unknown >= _MOST_UNKNOWN * len(words)


def is_look(word: str) -> bool:
    """Whether a word tells a look, a mood, a light, a camera or the like: "merrily", "naughty", "cinematic"."""
    if word in LEXICON.moods or any(word in get_set(section) for section in _LOOKS):
        return True
    stem = word.removesuffix("ly")
    return stem != word and not LEXICON.moods.isdisjoint((stem, stem.removesuffix("i") + "y", stem + "le"))


_LOOKS = ("cameras", "camera_words", "light", "colours", "weather", "scenery", "talk")


def _is_ignored(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """Whether the place of an unknown word tells that no motion depends on it."""
    for rule, ignored in _RULES:
        if rule(mentions, index, names):
            return ignored
    return False


def _is_named_here(mentions: list[Mention], index: int, named: bool, taken: list[str]) -> bool:
    """Whether a noun is the object of a sentence that does not name it otherwise: "the castle", "the sand castle"."""
    before = get_phrase(mentions, index - 1)
    done_to = before in get_set("determiners") and get_phrase(mentions, index - 2) not in get_set(
        "prepositions"
    )
    return before in taken or not named and not taken and done_to


def _is_heading(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """A number that counts sentences: "3.2 Push it", "Run 3: push it"."""
    first = index == 0 and len(mentions) > 1
    return mentions[index].phrase[0].isdigit() and (first or get_phrase(mentions, index + 1) in (":", "."))


def _is_number(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    return not mentions[index].phrase.isalpha()


def _is_measured(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Behind a quantity that says it all: "a third of its length farther to the right"."""
    return index > 0 and mentions[index - 1].kind is MentionKind.QUANTITY


def _is_asking(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """Somebody speaks: "I was wondering whether it could bow", "my daughter wants it to", "I am over the moon"."""
    begin, end = _find_segment(mentions, index)
    before = mentions[begin:index]
    told = any(m.kind in MOTIONS or m.phrase in names for m in before)
    done_to = any(m.phrase in get_set("objects") | names for m in mentions[index + 1 : index + 3])
    return any(m.form in get_set("speakers") for m in before) and not told and not done_to


def _is_described(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """How something is: "she is fragile", "until he was dizzy"."""
    before = index - 1
    while before > 0 and mentions[before].kind in _LOOSE:
        before -= 1
    linked = before >= 0 and mentions[before].form in get_set("copulas")
    return linked and not mentions[index].form.endswith(("ing", "ed"))


def _is_reaching(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """What a wind does to what it meets: "a gust catches the sign"."""
    begin, _ = _find_segment(mentions, index)
    motion = get_last_motion(mentions[begin:index])
    return (
        motion is not None
        and motion.wind
        and not any(m.kind is MentionKind.VERB for m in mentions[begin:index])
    )


def _is_in_a_fragment(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """A segment without motion, way, number or subject beside one with a motion: ", soft focus, volumetric,"."""
    begin, end = _find_segment(mentions, index)
    inside = mentions[begin:end]
    subject = any(m.phrase in names or m.phrase in get_set("pronouns") for m in inside)
    told = {m.kind for m in inside} - {MentionKind.FUNCTION, *_LOOSE}
    apart = all(
        m.words in (",", ".", "!", ";", ":", "?")
        for m in (*mentions[begin - 1 : begin], *mentions[end : end + 1])
    )
    repeats = any(m.phrase in get_set("repeating") for m in inside)
    return apart and not subject and not told and not repeats and any(m.kind in MOTIONS for m in mentions)


def _is_a_part(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """A part of the object: "its corners", "the handle", "the arms"."""
    word = mentions[index].phrase
    return word in LEXICON.unplaced or word.removesuffix("s") in LEXICON.part_nouns


def _is_owned(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    placed = get_phrase(mentions, index - 2) in get_set("prepositions")
    return get_phrase(mentions, index - 1) in get_set("pronouns_of_owners") and not placed


def _is_telling_a_part(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Which part: "the red part", "the blue corner"; an object has one head."""
    after = mentions[index + 1] if index + 1 < len(mentions) else None
    if after is None or get_phrase(mentions, index - 1) not in get_set("owners_of_parts"):
        return False
    several = after.phrase in LEXICON.ends or " " in after.phrase or after.phrase in LEXICON.one_of_many
    return after.kind is MentionKind.PLACE and several or after.phrase in LEXICON.part_nouns


def _is_predicate(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """Where a verb would stand: behind the object as its subject, or before it as its object."""
    subjects, objects = names | get_set("pronouns"), names | get_set("objects")
    before = index - 1
    while before >= 0 and (
        mentions[before].kind in _LOOSE or mentions[before].phrase in get_set("auxiliaries")
    ):
        before -= 1
    behind = index + 1 + (get_phrase(mentions, index + 1) in get_set("determiners"))
    word = mentions[index].phrase
    after_subject = before >= 0 and mentions[before].phrase in subjects and not word.endswith("ly")
    linked = any(m.form in get_set("finite") for m in mentions[before + 1 : index])
    described = linked and not word.endswith(("ing", "ed"))  # "it is fragile"
    before_object = get_phrase(mentions, behind) in objects and get_phrase(
        mentions, index - 1
    ) not in get_set("determiners")
    return (
        after_subject
        and not described
        or before_object
        and get_phrase(mentions, index - 1) not in get_set("prepositions")
    )


def _is_a_path(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """A shape of the way, or another world: "in a spiral", "on the moon"."""
    begin, end = _find_segment(mentions, index)
    return mentions[index].phrase in get_set("paths") or mentions[index].phrase in get_set("worlds")


def _is_placed(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """A noun behind a preposition: "in the garden", "by a crane", "with a spoon"."""
    return get_phrase(mentions, _find_phrase(mentions, index) - 1) in get_set("prepositions")


def _is_struck(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Where a blow or a pull acts: "tap it on the forehead", "tug at the collar"."""
    before = _find_phrase(mentions, index) - 1
    motion = get_last_motion(mentions[:index])
    acts = motion is not None and (motion.effect is Effect.STRIKE or motion.pulls)
    return acts and get_phrase(mentions, before) in ("at", "on", "against")


def _is_result(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Into what it is made: "bend it into a knot"; or a way: "toward the north"."""
    before = get_phrase(mentions, _find_phrase(mentions, index) - 1)
    return before in ("into", "toward", "towards", "like")


def _is_describing(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """An adjective: "the old robot", "the polished floor", "the howling wind", "the slender neck"."""
    behind = index
    while behind < len(mentions) and mentions[behind].kind in _LOOSE:
        behind += 1
    if behind == len(mentions):
        return False
    noun, motion = mentions[behind], mentions[behind].motion
    known = noun.phrase in names or noun.form in LEXICON.scene_nouns or noun.kind is MentionKind.PLACE
    return known or motion is not None and motion.wind


def _is_acting(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """Whoever does it: "the baker presses the bread", "Alice nudges it"."""
    behind = index + 1
    while behind < len(mentions) and (
        mentions[behind].kind in _LOOSE or mentions[behind].phrase in get_set("auxiliaries")
    ):
        behind += 1
    verb = mentions[behind] if behind < len(mentions) else None
    if verb is None or verb.kind not in MOTIONS:
        return False
    end = next((i for i in range(behind, len(mentions)) if mentions[i].words == "."), len(mentions))
    done_to = names | get_set("objects")
    return any(mention.phrase in done_to for mention in mentions[behind:end])


def _is_adverb(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    return mentions[index].phrase.endswith("ly")


def _find_phrase(mentions: list[Mention], index: int) -> int:
    """Index of the first word of a noun's phrase: its article, or its first adjective."""
    while index > 0 and (mentions[index - 1].kind in _LOOSE):
        index -= 1
    return index - (get_phrase(mentions, index - 1) in get_set("determiners"))


def _find_segment(mentions: list[Mention], index: int) -> tuple[int, int]:
    """From behind the connective before to the one behind."""
    begin, end = index, index + 1
    while begin > 0 and mentions[begin - 1].kind is not MentionKind.JOIN:
        begin -= 1
    while end < len(mentions) and mentions[end].kind is not MentionKind.JOIN:
        end += 1
    return begin, end


# In their order: the first that holds decides whether the word is ignored.
_RULES: tuple[tuple[Callable[[list[Mention], int, frozenset[str]], bool], bool], ...] = (
    (_is_heading, True),
    (_is_number, False),
    (_is_measured, True),
    (_is_asking, True),
    (_is_described, True),
    (_is_reaching, True),
    (_is_a_part, False),
    (_is_telling_a_part, False),
    (_is_a_path, False),
    (_is_struck, False),
    (_is_result, False),
    (_is_placed, True),
    (_is_in_a_fragment, True),
    (_is_owned, False),
    (_is_describing, True),
    (_is_predicate, False),
    (_is_acting, True),
)
