"""Turnings towards a viewer: "turn to the camera", "so that its back faces us", "in turn"."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import find_telling, get_phrase, has_motion
from physagent_jax.agents.rules.language.verbs import Effect, Verb


def find_turnings(mentions: list[Mention], names: frozenset[str]) -> list[str]:
    """Plain sentences about turns; ``names`` are words for the object."""
    return [
        doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index, names)
    ]


def _find_turns(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "from both sides in turn": one after the other, and no rotation."""
    mention = mentions[index]
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    bare = mention.form in ("turn", "turns") and isinstance(mention.value, Verb) and ends
    if bare and get_phrase(mentions, index - 1) in ("in", "by", "take", "takes"):
        return [f"What goes 'in {mention.words}' is not understood."]
    return []


def _find_facing(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "it turns to the camera": so that it faces there, and not that its top goes there."""
    mention, verb = mentions[index], find_telling(mentions, index, -1)
    turns = verb is not None and isinstance(verb.value, Verb) and verb.value.effect is Effect.TURN
    spins = turns and mention.value in (("up",), ("down",)) and mentions[index - 1] is verb
    if spins and verb is not None and verb.phrase == "spin":
        return [f"What '{verb.words} {mention.words}' means is not understood."]  # faster, or slower
    if not turns or verb is None or verb.form not in ("turn", "turns", "turning", "turned"):
        return []
    if mention.kind is MentionKind.DIRECTION and mention.value in (("toward",), ("up",)):
        return [f"What it is to turn '{mention.words}' is not understood."]
    return []


def _find_slowing(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "spin it, then let it slow down": what it does dies out, and does not begin again more weakly."""
    mention = mentions[index]
    if mention.kind is not MentionKind.COMPARATIVE or not mention.phrase.startswith("slow"):
        return []
    before = mentions[:index]
    starts = max((i for i, m in enumerate(before) if m.kind is MentionKind.JOIN), default=-1)
    if has_motion(before) and not has_motion(before[starts + 1 :]):
        return [f"How it comes to '{mention.words}' is not understood."]
    return []


def _find_shown(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "so that its back faces us": all of it turns, and no part is moved."""
    mention, after = mentions[index], [m.form for m in mentions[index + 1 : index + 3]]
    if mention.kind is MentionKind.PLACE and {"faces", "facing", "points", "pointing"} & set(after):
        return [f"How '{mention.words}' comes to be there is not understood."]
    return []


def _find_seen(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "turn it so that we see the back": what is seen then, and no part that is moved."""
    mention, before = mentions[index], [m.form for m in mentions[max(index - 2, 0) : index]]
    if mention.kind is MentionKind.PLACE and {"see", "sees", "seen"} & set(before):
        return [f"How it is turned to show '{mention.words}' is not understood."]
    return []


def _find_turned(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "the breeze turns it": the object, and not the wind."""
    mention, after = mentions[index], get_phrase(mentions, index + 1)
    if mention.kind is not MentionKind.VERB or mention.form not in ("turns", "turned", "turning"):
        return []
    wind = any(isinstance(m.value, Verb) and m.value.wind for m in mentions[:index])
    if wind and after in DETERMINERS | names | {"it", "him", "her"}:
        return [f"What the wind '{mention.words}' is not understood."]
    return []


def _find_viewpoint(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "can we see it from the left": whence it is seen, and not moved."""
    mention = mentions[index]
    if mention.kind is not MentionKind.FROM:
        return []
    begin = max((i for i in range(index) if mentions[i].kind is MentionKind.JOIN), default=-1) + 1
    segment = mentions[begin:index]
    sees = any(m.form in ("see", "show", "watch", "view", "look", "looking") for m in segment)
    if sees and not has_motion(segment):
        return [f"Whether it is seen '{mention.words}' is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int, frozenset[str]], list[str]], ...] = (
    _find_turns,
    _find_facing,
    _find_slowing,
    _find_shown,
    _find_seen,
    _find_turned,
    _find_viewpoint,
)
