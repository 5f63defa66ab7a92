"""More, less and as much as: "harder than before", "faster and faster", "the harder it is pushed, the more"."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import (
    NUMBERS,
    UNITS,
)
from physagent_jax.agents.rules.language.neighbours import WAYS, get_phrase
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_DOERS = frozenset({"people", "persons", "hands", "fingers", "fists", "plates"})
_PRONOUNS = frozenset({"it", "he", "she", "him", "her"})
_SCALES = (Effect.SCALE, Effect.SWELL)
_BECOMING = frozenset({"get", "gets", "getting", "become", "becomes", "becoming", "got", "became"})


def find_comparisons(mentions: list[Mention]) -> list[str]:
    """Plain sentences about what is measured by something else."""
    return [doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index)]


def _find_comparison(mentions: list[Mention], index: int) -> list[str]:
    """Says "harder than before", "faster and faster", "each time harder"."""
    mention = mentions[index]
    if mention.form == "than":
        return ["What is compared by 'than' is not understood."]
    pair = mentions[index + 1 : index + 3]
    doubled = len(pair) == 2 and pair[0].phrase == "and" and pair[1].words.lower() == mention.words.lower()
    if doubled and mention.kind is not MentionKind.JOIN and mention.phrase not in _PRONOUNS:
        return [f"How it changes by '{mention.words} and {mention.words}' is not understood."]
    each = any(other.form in ("each", "every") for other in mentions[max(index - 3, 0) : index + 4])
    alike = mention.kind is MentionKind.INTENSITY and "as" in (mention.form, get_phrase(mentions, index - 1))
    if alike and get_phrase(mentions, index + 1) == "as":
        return [f"What is as '{mention.words}' as it is not understood."]
    becomes = mention.kind is MentionKind.COMPARATIVE and get_phrase(mentions, index - 1) in _BECOMING
    if becomes:
        return [f"How it changes by '{mention.words}' is not understood."]
    if mention.kind is MentionKind.COMPARATIVE and each:
        return [f"How '{mention.words}' grows from time to time is not understood."]
    return []


def _find_correlation(mentions: list[Mention], index: int) -> list[str]:
    """Says "the harder it is pushed, the more it tilts": both grow together."""
    here, more = mentions[index], MentionKind.COMPARATIVE
    if here.kind is not more:
        return []
    heads = [i for i in range(1, len(mentions)) if mentions[i].kind is more and mentions[i - 1].form == "the"]
    begins = {i for i in heads if i == 1 or mentions[i - 2].kind is MentionKind.JOIN}
    if index in begins and len(begins) > 1 and index == min(begins):
        return [f"How much 'the {here.words}' is, is not understood."]
    return []


def _find_halfway(mentions: list[Mention], index: int) -> list[str]:
    """Says "tilt it halfway to the left": how far, and not when."""
    if mentions[index].phrase not in ("halfway", "midway"):
        return []
    behind = next((m for m in mentions[index + 1 :] if m.phrase not in ("to", "the")), None)
    far = behind is not None and behind.kind in WAYS
    return [f"How far '{mentions[index].words}' is, is not understood."] if far else []


def _find_growth(mentions: list[Mention], index: int) -> list[str]:
    """Says "jump higher", "throw it twice, the second time longer": more of it, and no growth."""
    mention = mentions[index]
    grows = isinstance(mention.value, Verb) and mention.value.generic and mention.value.effect in _SCALES
    if not grows or not mention.form.endswith("er"):
        return []
    for other in reversed(mentions[:index]):
        if other.kind is MentionKind.SIDES and other.phrase == "outward":
            return []  # "pull its ends apart, a fifth longer"
        if other.form in _BECOMING | {"make", "makes", "made", "making", "is", "be"}:
            return []
        if isinstance(other.value, Verb):
            same = other.value.effect in (*_SCALES, Effect.STILL)
            return [] if same else [f"What is '{mention.words}' is not understood."]
    return []


def _find_delay(mentions: list[Mention], index: int) -> list[str]:
    """Says "a second later", "every second"."""
    mention, before = mentions[index], get_phrase(mentions, index - 1)
    loose = mention.kind is MentionKind.FUNCTION and mention.form in UNITS
    if loose and before in (*NUMBERS, "another"):
        return [f"When '{before} {mention.words}' is, is not understood."]
    rate = mention.kind is MentionKind.TIME and before in ("every", "each")
    if rate or mention.form == "per" or loose and before in ("every", "each", "per"):
        return [f"How often '{before} {mention.words}' is, is not understood."]
    return []


def _find_bare_unit(mentions: list[Mention], index: int) -> list[str]:
    """Says "push it a foot to the left": a length, or whose foot?"""
    measured = mentions[index].form == "foot" and get_phrase(mentions, index - 1) == "a" and index > 2
    if measured and get_phrase(mentions, index - 2) not in ("by", "with", "of"):
        return [f"Whether 'a {mentions[index].words}' is a length is not understood."]
    return []


def _find_loose_number(mentions: list[Mention], index: int) -> list[str]:
    """Says "in two"; how many do it ("two people") does not matter."""
    mention = mentions[index]
    counts = mention.kind is MentionKind.FUNCTION and NUMBERS.get(mention.form, 0) >= 2
    behind = [get_phrase(mentions, index + reach) for reach in (1, 2)]
    if counts and not _DOERS & set(behind):
        return [f"What '{mention.words}' counts is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int], list[str]], ...] = (
    _find_comparison,
    _find_correlation,
    _find_halfway,
    _find_growth,
    _find_delay,
    _find_bare_unit,
    _find_loose_number,
)
