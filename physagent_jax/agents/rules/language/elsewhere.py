"""Statements about another time or place, or a pretence: "last time it fell", "up in the attic".

Its words are the grammar's own, so that word by word all of it would be of the motion.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import MOTIONS, WAYS, get_phrase, has_motion

_ELSE = frozenset({"time", "week", "year", "month", "night", "summer", "winter"})
_WAYS = frozenset({"up", "down", "back", "away", "behind"})  # adverbs of place as well: "down in the cellar"
_WITHIN = frozenset({"in", "at"})
_PASSING = frozenset({"pass", "passes", "passed", "elapse", "elapses", "elapsed"})
_TIMES = frozenset({"second", "seconds", "moment", "instant", "while", "time", "frames"})
_NEAR = 5
_OF_MOTION = (MentionKind.REPEAT, MentionKind.QUANTITY, MentionKind.PLACE)
_SHOWING = frozenset({"clip", "video", "film", "shot", "scene", "recording", "animation", "movie"})


def find_elsewhere(mentions: Sequence[Mention]) -> list[str]:
    """Plain sentences about what may belong to another time or place."""
    listed = list(mentions)
    return [doubt for index in range(len(listed)) for rule in _RULES for doubt in rule(listed, index)]


def _find_earlier(mentions: list[Mention], index: int) -> list[str]:
    """Says "last time you pushed it": that was then."""
    first, second = mentions[index].words.lower(), get_phrase(mentions, index + 1)
    then = first == "last" and second in _ELSE and get_phrase(mentions, index - 1) not in ("the", "one")
    if (then or first in ("yesterday", "formerly", "previously")) and has_motion(mentions[index + 1 :]):
        words = f"last {second}" if then else first
        return [f"Whether what is said of '{words}' is to happen is not understood."]
    return []


def _find_pretended(mentions: list[Mention], index: int) -> list[str]:
    """Says "lift it as if to throw it": it is not thrown."""
    said = mentions[index].words.lower()
    if said not in ("as if", "as though") or get_phrase(mentions, index + 1) != "to":
        return []
    pretended = itertools.takewhile(lambda m: m.kind is not MentionKind.JOIN, mentions[index + 1 :])
    if any(m.kind in (*MOTIONS, *WAYS, *_OF_MOTION) for m in pretended):
        return [f"How it moves '{said} to' do something is not understood."]
    return []


def _find_room(mentions: list[Mention], index: int) -> list[str]:
    """Says "up in the attic": where it is, and not where it goes."""
    mention = mentions[index]
    if mention.form not in _WAYS or get_phrase(mentions, index + 1) not in _WITHIN:
        return []
    if get_phrase(mentions, index + 2) not in DETERMINERS or index + 3 >= len(mentions):
        return []
    noun = mentions[index + 3]
    if noun.kind is MentionKind.UNKNOWN:
        return [f"Whether '{mention.words} in the {noun.words}' is a place or a way is not understood."]
    return []


def _find_moment(mentions: list[Mention], index: int) -> list[str]:
    """Says "until the middle of the clip", which is no part of the object."""
    mention = mentions[index]
    behind = [get_phrase(mentions, index + step) for step in (1, 2, 3)]
    if mention.kind is MentionKind.PLACE and behind[0] == "of" and _SHOWING & set(behind):
        return [f"When the '{mention.words}' of the clip is, is not understood."]
    return []


def _find_passing(mentions: list[Mention], index: int) -> list[str]:
    """Says "let a second pass, then push it": how long nothing happens."""
    mention = mentions[index]
    if mention.words.lower() not in _PASSING or any(m.value is Join.AFTER for m in mentions):
        return []
    before = [m for m in mentions[max(0, index - _NEAR) : index] if m.kind is not MentionKind.JOIN]
    timed = any(m.kind is MentionKind.TIME or _TIMES & set(m.words.lower().split()) for m in before)
    return ["How long it takes to 'pass' is not understood."] if timed else []


def _find_at_once(mentions: list[Mention], index: int) -> list[str]:
    """Says "push it and shake it at once": together, and not without delay."""
    if mentions[index].words.lower() != "at once":
        return []
    motions = [m for m in mentions[:index] if m.kind in MOTIONS]
    joined = any(m.kind is MentionKind.JOIN and m.words.lower() == "and" for m in mentions[:index])
    if joined and len(motions) > 1:
        return ["Whether 'at once' is together or without delay is not understood."]
    return []


_RULES = (_find_earlier, _find_pretended, _find_room, _find_moment, _find_passing, _find_at_once)
