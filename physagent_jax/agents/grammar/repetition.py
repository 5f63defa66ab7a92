"""A verb that is said again and again: "bounce bounce bounce", "they pushed and pushed"."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import Mention, MentionKind, empty
from physagent_jax.agents.rules.language.modifiers import Join, Repeat
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_COUNTABLE = (Effect.STRIKE, Effect.JUMP)


def merge_repetitions(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """One mention of a verb that stands several times with nothing but commas or "and" between.

    Blows and jumps are counted; what goes on anyway goes on. ``names`` are words for the object.
    """
    result: list[Mention] = []
    at = 0
    while at < len(mentions):
        first, count, end = mentions[at], 1, at + 1
        while (
            first.kind is MentionKind.VERB and (again := _find_again(mentions, first, end, names)) is not None
        ):
            count, end = count + 1, again + 1
        sounds = count > 1 and _is_sound(result, first)
        result.append(empty(first, "again") if sounds else first)
        if count == 1 and first.kind is MentionKind.VERB and _is_cognate(result[:-1], first):
            result[-1] = empty(first, "again")
        if count > 1:
            assert isinstance(first.value, Verb)
            counts = first.value.effect in _COUNTABLE or first.phrase == "bounce"
            told = any(m.words.lower() == "and" for m in mentions[at:end])
            repeat = Repeat(3, vague=True) if told else Repeat(count)
            second = mentions[end - 1]
            filler = empty(second, "again")
            result.append(replace(second, kind=MentionKind.REPEAT, value=repeat) if counts else filler)
        at = end
    return result


def _is_cognate(before: list[Mention], noun: Mention) -> bool:
    """Return whether a verb has itself for its object: "it hops a tiny hop to the left"."""
    at = len(before) - 1
    while at >= 0 and before[at].kind in (MentionKind.INTENSITY, MentionKind.UNKNOWN):
        at -= 1
    if at + 1 < len(before) and before[at + 1].form in ("a", "an"):
        at += 1  # "a little"
    article = at > 0 and before[at].form in ("a", "an", "its")
    return article and before[at - 1].kind is MentionKind.VERB and before[at - 1].phrase == noun.phrase


def _is_sound(before: list[Mention], verb: Mention) -> bool:
    """Return whether blows that were told are only heard: "they hit it from the left, bang bang bang"."""
    told = [m.value for m in before if isinstance(m.value, Verb)]
    strikes = isinstance(verb.value, Verb) and verb.value.effect is Effect.STRIKE
    apart = bool(before) and before[-1].value is Join.COMMA
    return strikes and apart and bool(told) and told[-1].effect is Effect.STRIKE


def _find_again(mentions: list[Mention], verb: Mention, at: int, names: frozenset[str]) -> int | None:
    """The next place of the same form of the verb, past a comma, an "and" or a form of address."""
    while at < len(mentions) and (mentions[at].kind is MentionKind.JOIN or _is_called(mentions, at, names)):
        if mentions[at].kind is MentionKind.JOIN and mentions[at].value not in (Join.COMMA, Join.AND):
            return None
        at += 1
    if at == len(mentions) or mentions[at].kind is not MentionKind.VERB:
        return None
    return at if (mentions[at].phrase, mentions[at].form) == (verb.phrase, verb.form) else None


def _is_called(mentions: list[Mention], at: int, names: frozenset[str]) -> bool:
    """Return whether the object is called by its name: "swing, lantern, swing"."""
    commas = [mentions[i].value for i in (at - 1, at + 1) if i < len(mentions)]
    return mentions[at].phrase in names and commas == [Join.COMMA, Join.COMMA]
