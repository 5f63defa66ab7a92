"""Patterns of the documented language: a form, example sentences, and what each means."""

from __future__ import annotations

import functools
from dataclasses import dataclass

from physagent_jax.agents.grammar.tokens import tokenise
from physagent_jax.core.reading import read_packaged_yaml

_SHOWN = 2


@dataclass(frozen=True)
class Pattern:
    """A form of sentence that the grammar promises to read.

    Attributes:
        name: A short name.
        group: Heading under which the documentation shows it.
        form: Words in small letters stand as they are, those in capitals for others of a kind; ``|`` separates choices,
            brackets hold what may be left out.
        examples: Sentences about ``object``.
        reading: Their meaning, in the notation of the corpus of sentences.
        object: Name of the object.
    """

    name: str
    group: str
    form: str
    examples: tuple[str, ...]
    reading: str
    object: str = "robot"


@functools.cache
def read_patterns() -> tuple[Pattern, ...]:
    """All patterns, in their order."""
    groups = read_packaged_yaml("physagent_jax.agents.grammar", "patterns.yaml")
    return tuple(
        Pattern(**{**row, "group": group, "examples": tuple(row["examples"])})
        for group, rows in groups.items()
        for row in rows
    )


def suggest_patterns(sentence: str) -> list[Pattern]:
    """The documented patterns whose words are most like those of a sentence."""
    said = [token for token in tokenise(sentence[:1000]) if token.text not in ("the", "a", "it")]
    words = {token.lemma for token in said if token.is_word}

    def count(pattern: Pattern) -> int:
        own = {token.lemma for example in (*pattern.examples, pattern.form) for token in tokenise(example)}
        return len(words & own)

    return sorted(read_patterns(), key=count, reverse=True)[:_SHOWN]
