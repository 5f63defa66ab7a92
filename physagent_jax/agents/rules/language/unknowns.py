"""Words that are not understood: which of them matter, and which only decorate."""

from __future__ import annotations

from physagent_jax.agents.rules.language.frames import is_mood
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import ENDS, PARTS, SCENE_NOUNS
from physagent_jax.agents.rules.language.naming import DETERMINERS, PREPOSITIONS, is_telling
from physagent_jax.agents.rules.language.neighbours import get_phrase
from physagent_jax.agents.rules.language.tokens import FORMS
from physagent_jax.agents.rules.language.unplaced import UNPLACED_PARTS
from physagent_jax.agents.rules.language.verbs import Effect, Verb
from physagent_jax.agents.schema import SceneBrief

_OWNERS = frozenset({"its", "his", "her", "their"})
_SETTING = frozenset({"in", "on", "at", "inside", "near"})
_PATHS = frozenset("circle spiral zigzag arc curve loop square triangle figure wave".split())
_LEAST_WORDS, _MOST_UNKNOWN = 3, 0.5


def list_unknown(
    mentions: list[Mention], names: frozenset[str], brief: SceneBrief
) -> tuple[list[str], list[str]]:
    """Unknown content words, and notes; a noun is taken for the object if the sentence does not name it otherwise."""
    named = any(mention.phrase in names for mention in mentions)
    may_be_named = not is_telling(brief.object_name)
    unknown: list[str] = []
    taken: list[str] = []
    for index, mention in enumerate(mentions):
        word = mention.phrase
        if mention.kind is not MentionKind.UNKNOWN or word in unknown or word in names:
            continue
        if is_mood(word):
            continue
        before = get_phrase(mentions, index - 1)
        owned = (
            before in _OWNERS and not _is_harmless(mentions, index) or word.removesuffix("s") in PARTS
        )  # "its corners", "the arms"
        if _is_describing_part(mentions, index) or word in UNPLACED_PARTS or owned:
            unknown.append(word)
        elif (
            word.isalpha()
            and may_be_named
            and (before in taken or not (named or taken) and _is_done_to(mentions, index))
        ):
            taken.append(word)  # "the castle", "the sand castle"
        elif word not in taken and not _is_decorating(mentions, index, names):
            unknown.append(word)
    notes = [f"'{' '.join(taken)}' is taken to be the object ({brief.object_name})."] if taken else []
    return unknown, notes


def _is_harmless(mentions: list[Mention], index: int) -> bool:
    """Whether an owned thing takes no part: "topples from its plinth", "its round belly", "its quill is glued down"."""
    following = mentions[index + 1] if index + 1 < len(mentions) else None
    if following is None:
        return _is_left(mentions, index)
    describes = following.kind is MentionKind.PLACE and not _is_describing_part(mentions, index)
    held = next((m.value for m in mentions[index + 1 : index + 3] if isinstance(m.value, Verb)), None)
    fixed = isinstance(held, Verb) and held.effect is Effect.HOLD and held.holds == "base"
    down = any(m.form in ("down", "to") for m in mentions[index + 1 : index + 5])
    return describes or _is_left(mentions, index) or fixed and down


def _is_left(mentions: list[Mention], index: int) -> bool:
    """Whether a noun is what the object comes off: "is lifted off the stove", "topples from its plinth"."""
    determined = get_phrase(mentions, index - 1) in DETERMINERS
    return determined and get_phrase(mentions, index - 2) in ("off", "from") and _is_leaving(mentions[:index])


def is_mostly_unknown(mentions: list[Mention], unknown: list[str]) -> bool:
    """Whether so little was understood that what was is probably misunderstood: another language, say."""
    words = [
        mention for mention in mentions if mention.kind is not MentionKind.JOIN or mention.words.isalpha()
    ]
    return len(words) >= _LEAST_WORDS and len(unknown) >= _MOST_UNKNOWN * len(words)


def _is_describing_part(mentions: list[Mention], index: int) -> bool:
    """Whether a word tells which part: "the red part", "the blue corner"."""
    following = mentions[index + 1] if index + 1 < len(mentions) else None
    if following is None or get_phrase(mentions, index - 1) not in DETERMINERS:
        return False
    if get_phrase(mentions, index - 1) in _OWNERS and following.kind is MentionKind.PLACE:
        return following.phrase in ENDS or " " in following.phrase  # "its round belly": it has one
    return (
        following.kind is MentionKind.PLACE
        or following.phrase in PARTS
        or following.phrase in ("part", "end")
    )


def _is_decorating(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """Whether a word changes nothing: an adjective of the object, or who acts ("by a crane", "the baker presses")."""
    before = get_phrase(mentions, index - 1)
    behind = index + 1
    while behind < len(mentions) and mentions[behind].kind is MentionKind.UNKNOWN:
        behind += 1
    after = mentions[behind] if behind < len(mentions) else None
    if before in DETERMINERS and after is not None and after.phrase in names:
        return True  # "the old robot"
    if _is_left(mentions, index) or before == "by" and _is_passive(mentions[: index - 1]):
        return True  # "is carried by servants"
    if before in _OWNERS and _is_harmless(mentions, index):
        return True
    if _is_held_to(mentions, index) or _is_accompanying(mentions, index) or _is_purpose(mentions, index):
        return True
    if before in DETERMINERS and after is not None and after.form in SCENE_NOUNS:
        return True  # "the polished floor"
    if _is_feeling(mentions, index):
        return True
    if before in DETERMINERS and after is not None and isinstance(after.value, Verb) and after.value.wind:
        return True  # "the howling wind"
    if (
        before in DETERMINERS
        and get_phrase(mentions, index - 2) in _SETTING
        and _is_in_place(mentions[:index])
    ):
        return True  # "it spins on the potter's wheel"
    first = index
    while first > 0 and _is_adjective(mentions[first - 1]):
        first -= 1
    determined = get_phrase(mentions, first - 1) in DETERMINERS | {"two", "three", "some"}
    if determined and get_phrase(mentions, first - 2) == "by" and _is_passive(mentions[: first - 2]):
        return True  # "is lifted by a crane"
    begins = first - 1 <= 0
    acts = after is not None and after.kind is MentionKind.VERB and not after.form.endswith("ing")
    ends = next((i for i in range(behind, len(mentions)) if mentions[i].words == "."), len(mentions))
    done_to = any(m.phrase in names or m.phrase in ("it", "him", "her") for m in mentions[behind:ends])
    return determined and begins and acts and done_to  # "the baker presses the bread"


def _is_done_to(mentions: list[Mention], index: int) -> bool:
    """Whether a noun with its article stands as a subject or an object, not after a preposition: "in a circle"."""
    return get_phrase(mentions, index - 1) in DETERMINERS and (
        get_phrase(mentions, index - 2) not in PREPOSITIONS
    )


def _get_last_verb(mentions: list[Mention]) -> Verb | None:
    return next((m.value for m in reversed(mentions) if isinstance(m.value, Verb)), None)


def _is_leaving(mentions: list[Mention]) -> bool:
    """Whether the last verb lifts, or lets fall: what it stood on changes nothing."""
    verb = _get_last_verb(mentions)
    lifts = verb is not None and verb.bound and verb.direction == "up"
    return lifts or verb is not None and verb.effect in (Effect.FALL, Effect.TOPPLE)


def _is_in_place(mentions: list[Mention]) -> bool:
    """Whether the last verb moves nothing from its place: where it is, is no goal."""
    verb = _get_last_verb(mentions)
    return verb is not None and verb.effect in (Effect.SWAY, Effect.TURN, Effect.SCALE, Effect.SWELL)


def _is_held_to(mentions: list[Mention], index: int) -> bool:
    """Whether a noun is what the object is fixed to: "bolted to the pavement"."""
    determined = get_phrase(mentions, index - 1) in DETERMINERS
    verb = _get_last_verb(mentions[:index])
    return (
        determined
        and get_phrase(mentions, index - 2) in ("to", "onto", "on", "in", "into")
        and verb is not None
        and verb.effect is Effect.HOLD
        and verb.holds == "base"
    )


def _is_accompanying(mentions: list[Mention], index: int) -> bool:
    """Whether "with a groan" stands by itself between commas: what goes with it is no motion, unless it is a shape."""
    begin, end = index, index + 1
    while begin > 0 and mentions[begin - 1].kind is not MentionKind.JOIN:
        begin -= 1
    while end < len(mentions) and mentions[end].kind is not MentionKind.JOIN:
        end += 1
    opening = mentions[begin - 1].form == "with" if begin else False  # "with" joins
    verb = _get_last_verb(mentions[:begin])
    used = (
        verb is not None and verb.effect in (Effect.STRIKE, Effect.PUSH) and not verb.generic
    )  # "with a pencil"
    inside = mentions[begin:end]
    kinds = {m.kind for m in inside} - {MentionKind.FUNCTION, MentionKind.UNKNOWN, MentionKind.INTENSITY}
    article = bool(inside) and inside[0].form in ("a", "an")
    alone = used or begin < 2 or mentions[begin - 2].kind is MentionKind.JOIN
    return opening and article and alone and not kinds and not any(m.form in _PATHS for m in inside)


def _is_feeling(mentions: list[Mention], index: int) -> bool:
    """Whether a bare noun tells why it moves so: "it trembles with rage", "it jumps for joy"."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    verb = _get_last_verb(mentions[:index])
    feels = verb is not None and verb.effect in (Effect.SWAY, Effect.JUMP, Effect.TURN)
    return ends and feels and get_phrase(mentions, index - 1) in ("with", "for", "from")


def _is_purpose(mentions: list[Mention], index: int) -> bool:
    """Whether a verb tells what a motion with a way of its own is for: "it tilts right to pour"."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    told = False
    for mention in reversed(mentions[:index]):
        if mention.kind is MentionKind.JOIN:
            return False
        told = told or mention.kind is MentionKind.DIRECTION
        if mention.kind is MentionKind.VERB:
            return ends and told and get_phrase(mentions, index - 1) == "to"
    return False


def _is_passive(mentions: list[Mention]) -> bool:
    """Whether the last verb tells what is done to the object: "is lifted", not "move it left"."""
    verbs = [mention for mention in mentions if mention.kind is MentionKind.VERB]
    if not verbs:
        return True
    return FORMS.get(verbs[-1].form) != verbs[-1].form or any(
        mention.form in ("is", "are", "gets", "being", "be") for mention in mentions[:-1]
    )


def _is_adjective(mention: Mention) -> bool:
    """Whether a word may stand between an article and its noun."""
    loose = mention.kind is MentionKind.FUNCTION and mention.phrase not in DETERMINERS | {"by", "with", "of"}
    return loose or mention.kind in (MentionKind.UNKNOWN, MentionKind.INTENSITY)
