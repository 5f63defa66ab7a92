"""Words that are not understood and change nothing: who acts, where it is, what goes with it, how somebody feels.

Each rule looks at the place of a word in the sentence; what a word itself means decides only where a shape or another
world is named ("in a spiral", "on the moon").
"""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.grammar.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import ENDS, ONE_OF_MANY, PARTS, SCENE_NOUNS
from physagent_jax.agents.rules.language.naming import DETERMINERS, OWNERS
from physagent_jax.agents.grammar.mentions import get_phrase
from physagent_jax.agents.grammar.tokens import FORMS, is_participle
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_SETTING = frozenset({"in", "inside", "near", "during", "beside"})  # "on" and "at" tell a part as well
# Where the way goes, or into what: these change the motion.
_PATHS = frozenset(
    (
        "circle circles spiral spirals zigzag zigzags arc arcs curve curves loop loops square triangle figure wave "
        "waves half halves piece pieces shred shreds two pair pairs row line bow"
    ).split()
)
_REACHING = frozenset(
    "catches caught catching meets met reaches reached grips gripped seizes seized finds takes".split()
)
# Where things move otherwise.
_WORLDS = frozenset(
    (
        "moon mars planet space water sea ocean lake river pool honey oil mud syrup vacuum slope ramp hill incline "
        "ice "
        "trampoline swing seesaw rope string strings spring springs wheels skates ball cloud clouds"
    ).split()
)


def is_decorating(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """Return whether the word at ``index``, which is not understood, changes nothing."""
    return any(rule(mentions, index, names) for rule in _RULES)


def is_describing_part(mentions: list[Mention], index: int) -> bool:
    """Return whether a word tells which part: "the red part", "the blue corner"; an object has one head."""
    following = mentions[index + 1] if index + 1 < len(mentions) else None
    if following is None or get_phrase(mentions, index - 1) not in DETERMINERS:
        return False
    if following.kind is MentionKind.PLACE:
        owned = get_phrase(mentions, index - 1) in OWNERS
        several = following.phrase in ONE_OF_MANY and not owned
        return following.phrase in ENDS or " " in following.phrase or several
    return following.phrase in PARTS or following.phrase in ("part", "end")


def is_owned_aside(mentions: list[Mention], index: int) -> bool:
    """Return whether an owned thing takes no part: "topples from its plinth", "its quill is glued down"."""
    following = mentions[index + 1] if index + 1 < len(mentions) else None
    if following is None:
        return _is_left(mentions, index, frozenset())
    describes = following.kind is MentionKind.PLACE and not is_describing_part(mentions, index)
    held = next((m.value for m in mentions[index + 1 : index + 3] if isinstance(m.value, Verb)), None)
    fixed = isinstance(held, Verb) and held.effect is Effect.HOLD and held.holds == "base"
    down = any(m.form in ("down", "to") for m in mentions[index + 1 : index + 5])
    return describes or _is_left(mentions, index, frozenset()) or fixed and down


def _is_describing(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """Says "the old robot", "the polished floor", "the howling wind", "the slender neck"."""
    after = (
        mentions[_skip_unknown(mentions, index)] if _skip_unknown(mentions, index) < len(mentions) else None
    )
    if _find_determiner(mentions, index) < 0 or after is None:
        return False
    if after.phrase in names or after.form in SCENE_NOUNS:
        return True
    if after.kind is MentionKind.PLACE:
        return not is_describing_part(mentions, index)
    return isinstance(after.value, Verb) and after.value.wind


def _is_left(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Says what the object comes off: "is lifted off the stove", "topples from its plinth"."""
    determined = get_phrase(mentions, index - 1) in DETERMINERS
    if not determined or get_phrase(mentions, index - 2) not in ("off", "from"):
        return False
    verb = _get_last_verb(mentions[:index])
    lifts = verb is not None and verb.bound and verb.direction == "up"
    return lifts or verb is not None and verb.effect in (Effect.FALL, Effect.TOPPLE)


def _is_owned(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    return get_phrase(mentions, index - 1) in OWNERS and is_owned_aside(mentions, index)


def _is_held_to(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Says what the object is fixed to: "bolted to the pavement"."""
    determined = get_phrase(mentions, index - 1) in DETERMINERS
    verb = _get_last_verb(mentions[:index])
    fixed = verb is not None and verb.effect is Effect.HOLD and verb.holds == "base"
    return determined and fixed and get_phrase(mentions, index - 2) in ("to", "onto", "on", "in", "into")


def _is_accompanying(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Says "with a groan" by itself, or "hit it with a pencil": what goes with it, or is used, and is no shape."""
    begin, end = _find_segment(mentions, index)
    inside = mentions[begin:end]
    opening = begin > 0 and mentions[begin - 1].form == "with"  # "with" joins
    verb = _get_last_verb(mentions[:begin])
    used = verb is not None and verb.effect in (Effect.STRIKE, Effect.PUSH) and not verb.generic
    alone = begin < 2 or mentions[begin - 2].kind is MentionKind.JOIN
    article = inside[0].form in ("a", "an")
    kinds = {m.kind for m in inside} - {MentionKind.FUNCTION, MentionKind.UNKNOWN, MentionKind.INTENSITY}
    changing = any(m.form in _PATHS | _WORLDS or m.form.endswith("ing") for m in inside)
    return opening and article and (used or alone) and not kinds and not changing


def _is_feeling(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Says why it moves so with a bare noun: "it trembles from rage", "it jumps for joy"."""
    verb = _get_last_verb(mentions[:index])
    why = get_phrase(mentions, index - 1)
    feels = verb is not None and verb.effect in (Effect.SWAY, Effect.JUMP, Effect.TURN)
    return _ends(mentions, index) and (
        feels and why in ("with", "from", "of") or verb is not None and why == "for"
    )


def _is_purpose(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Says what a motion with a way of its own is for: "it tilts right to pour"."""
    begin, _ = _find_segment(mentions, index)
    kinds = [m.kind for m in mentions[begin:index]]
    told = MentionKind.VERB in kinds and MentionKind.DIRECTION in kinds[kinds.index(MentionKind.VERB) :]
    return told and _ends(mentions, index) and get_phrase(mentions, index - 1) == "to"


def _is_setting(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Says where or when it is: "it spins on the potter's wheel", "in the garden it sways", "at dawn"."""
    begin, end = _find_segment(mentions, index)
    first = index
    while first > begin and mentions[first - 1].kind in (MentionKind.UNKNOWN, MentionKind.INTENSITY):
        first -= 1
    first -= get_phrase(mentions, first - 1) in DETERMINERS
    table = mentions[first - 1].form == "on" and get_phrase(mentions, first) in DETERMINERS
    placed = first > begin and (mentions[first - 1].form in _SETTING or table)
    behind = _skip_unknown(mentions, index)
    alone = behind == len(mentions) or mentions[behind].kind is MentionKind.JOIN
    if not placed or not alone or any(m.form in _PATHS | _WORLDS for m in mentions[first:behind]):
        return False
    before = mentions[begin:first]
    verb = _get_last_verb(before)
    stays = verb is not None and verb.effect in (
        Effect.SWAY,
        Effect.TURN,
        Effect.SCALE,
        Effect.SWELL,
        Effect.JUMP,
    )
    told = (
        verb is not None
        and not table
        and any(m.kind in (MentionKind.DIRECTION, MentionKind.FROM) for m in before)
    )
    leading = begin == 0 and end < len(mentions) and first - 1 == begin
    return stays or told or leading


def _is_reaching(mentions: list[Mention], index: int, _names: frozenset[str]) -> bool:
    """Says "a gust catches the sign": what a wind does to what it meets."""
    begin, _ = _find_segment(mentions, index)
    wind = any(isinstance(m.value, Verb) and m.value.wind for m in mentions[begin:index])
    return wind and mentions[index].form in _REACHING


def _is_acting(mentions: list[Mention], index: int, names: frozenset[str]) -> bool:
    """Says who acts: "the baker presses the bread", "Alice nudges it", "is lifted by a crane", "by servants"."""
    if get_phrase(mentions, index - 1) == "by" and _is_passive(mentions[: index - 1]):
        return True
    first = index
    while first > 0 and _is_adjective(mentions[first - 1]):
        first -= 1
    determined = get_phrase(mentions, first - 1) in DETERMINERS | {"two", "three", "some"}
    if determined and get_phrase(mentions, first - 2) == "by" and _is_passive(mentions[: first - 2]):
        return True
    behind = _skip_unknown(mentions, index)
    while behind < len(mentions) and mentions[behind].kind in (MentionKind.INTENSITY, MentionKind.DEGREE):
        behind += 1
    after = mentions[behind] if behind < len(mentions) else None
    if after is None or after.kind is not MentionKind.VERB or is_participle(after.form):
        return False
    named = index == 0 and after.form != FORMS.get(after.form)  # "Alice nudges it"
    early = {MentionKind.JOIN, MentionKind.TIME, MentionKind.INTENSITY, MentionKind.FUNCTION}
    begins = first - 1 <= 0 or {m.kind for m in mentions[: first - 1]} <= early
    ends = next((i for i in range(behind, len(mentions)) if mentions[i].words == "."), len(mentions))
    done_to = any(m.phrase in names or m.phrase in ("it", "him", "her") for m in mentions[behind:ends])
    return (determined and begins or named) and done_to


def _ends(mentions: list[Mention], index: int) -> bool:
    return index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN


def _find_segment(mentions: list[Mention], index: int) -> tuple[int, int]:
    """From behind the connective before to the one behind."""
    begin, end = index, index + 1
    while begin > 0 and mentions[begin - 1].kind is not MentionKind.JOIN:
        begin -= 1
    while end < len(mentions) and mentions[end].kind is not MentionKind.JOIN:
        end += 1
    return begin, end


def _skip_unknown(mentions: list[Mention], index: int) -> int:
    while index < len(mentions) and mentions[index].kind is MentionKind.UNKNOWN:
        index += 1
    return index


def _find_determiner(mentions: list[Mention], index: int) -> int:
    """The article before a word and the adjectives with it; -1 if there is none."""
    at = index - 1
    while at >= 0 and mentions[at].kind in (MentionKind.UNKNOWN, MentionKind.INTENSITY):
        at -= 1
    return at if get_phrase(mentions, at) in DETERMINERS else -1


def _get_last_verb(mentions: list[Mention]) -> Verb | None:
    return next((m.value for m in reversed(mentions) if isinstance(m.value, Verb)), None)


def _is_passive(mentions: list[Mention]) -> bool:
    """Return whether the last verb tells what is done to the object: "is lifted", not "move it left"."""
    verbs = [mention for mention in mentions if mention.kind is MentionKind.VERB]
    if not verbs:
        return True
    return FORMS.get(verbs[-1].form) != verbs[-1].form or any(
        mention.form in ("is", "are", "gets", "being", "be") for mention in mentions[:-1]
    )


def _is_adjective(mention: Mention) -> bool:
    """Return whether a word may stand between an article and its noun."""
    loose = mention.kind is MentionKind.FUNCTION and mention.phrase not in DETERMINERS | {"by", "with", "of"}
    return loose or mention.kind in (MentionKind.UNKNOWN, MentionKind.INTENSITY)


_RULES: tuple[Callable[[list[Mention], int, frozenset[str]], bool], ...] = (
    _is_describing,
    _is_left,
    _is_owned,
    _is_held_to,
    _is_accompanying,
    _is_feeling,
    _is_purpose,
    _is_setting,
    _is_reaching,
    _is_acting,
)
