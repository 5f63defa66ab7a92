"""Suppositions and earlier states: "it would have fallen", "too heavy to be lifted", "that had fallen over".

The verbs are the grammar's own, so that word by word all of it would happen.
"""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import get_phrase, has_motion
from physagent_jax.agents.rules.language.tokens import FORMS, is_participle

_MODALS = frozenset({"would", "could", "might", "should", "must", "d"})
_PRONOUNS = frozenset({"it", "he", "she", "they", "that", "which", "who"})
_NEAR = 4  # words between "too" and its "to"


def find_suppositions(mentions: list[Mention], names: frozenset[str]) -> list[str]:
    """Plain sentences about motions that are not told to happen; ``names`` are words for the object."""
    return [
        doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index, names)
    ]


def _find_unreal(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "it would have fallen": it has not."""
    unreal = mentions[index].form == "have" and get_phrase(mentions, index - 1) in _MODALS
    if unreal and has_motion(mentions[index : index + 4]):
        return [f"Whether what '{get_phrase(mentions, index - 1)} have' been happens is not understood."]
    return []


def _find_otherwise(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "if it were light it would fly, but it only trembles": the first is not so."""
    if mentions[index].form != "if":
        return []
    behind = [m.form for m in mentions[index + 1 :]]
    supposed = "were" in behind[:4] and "would" in behind
    if supposed and any(m.value is Join.BUT for m in mentions[index:]):
        return ["What would happen 'if' it were otherwise is not understood."]
    return []


def _find_prevented(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "it is too heavy to be pushed over": it is not."""
    mention = mentions[index]
    if mention.form != "too" or mention.kind not in (MentionKind.DEGREE, MentionKind.INTENSITY):
        return []
    for at in range(index + 1, min(index + _NEAR, len(mentions))):
        if mentions[at].kind is MentionKind.JOIN:
            return []
        if mentions[at].form == "to" and has_motion(mentions[at + 1 : at + 3]):
            return [f"Whether what it is '{mention.words} ...' to do happens is not understood."]
    return []


def _find_past(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "the robot that had fallen over": it did before, and does not now."""
    if mentions[index].form != "had":
        return []
    verb = mentions[index + 1] if index + 1 < len(mentions) else None
    done = verb is not None and verb.kind is MentionKind.VERB and verb.form != FORMS.get(verb.form)
    subject = get_phrase(mentions, index - 1) in _PRONOUNS | names
    time = any(m.value in (Join.AFTER, Join.BEFORE, Join.RESULT) for m in mentions[:index])
    if done and subject and not time and verb is not None:
        return [f"Whether '{verb.words}' was so before is not understood."]
    return []


def _find_posture(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "the robot leaning left straightens up": how it is at first."""
    mention = mentions[index]
    participle = mention.kind is MentionKind.VERB and is_participle(mention.form)
    if not participle or get_phrase(mentions, index - 1) not in names:
        return []
    begins = index < 2 or mentions[index - 2].phrase in DETERMINERS and index < 3
    for other in mentions[index + 1 :]:
        if other.kind is MentionKind.JOIN:
            return []
        finite = other.kind is MentionKind.VERB and other.form.endswith("s") and other.form in FORMS
        if finite and begins and FORMS[other.form] != other.form:
            return [f"Whether '{mention.words}' is how it is at first is not understood."]
    return []


def _find_origin(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "let it fall from a tilt to the left": how it is before."""
    mention = mentions[index]
    article = get_phrase(mentions, index - 1) in ("a", "an") and get_phrase(mentions, index - 2) == "from"
    if article and mention.kind is MentionKind.VERB and has_motion(mentions[:index]):
        return [f"Whether it is in a '{mention.words}' at first is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int, frozenset[str]], list[str]], ...] = (
    _find_unreal,
    _find_otherwise,
    _find_prevented,
    _find_past,
    _find_posture,
    _find_origin,
)
