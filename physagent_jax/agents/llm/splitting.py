"""A sentence cut into clauses, for models that read one at a time."""

from __future__ import annotations

import re
from typing import Literal, NamedTuple

from physagent_jax.core.reading import read_packaged_yaml

Order = Literal["then", "together"]
_WORDS = read_packaged_yaml("physagent_jax.agents.llm", "splitting.yaml")
_KINDS = list(_WORDS["connectives"])
_CUT = re.compile("|".join(f"(?P<{kind}>{words})" for kind, words in _WORDS["connectives"].items()), re.I)
_NO_CLAUSE = frozenset(_WORDS["no_clause"].split())


class Piece(NamedTuple):
    """The words of a clause, and how it follows the clause before."""

    text: str
    order: Order


def split_clauses(sentence: str) -> list[Piece]:
    """The clauses of a sentence, in the order of time; one that is cut nowhere is one clause.

    It is cut at full stops, at "then", "while", "before" and "after", and at commas and "and" where more than a
    direction, a part, a strength or a time follows. A bare "and" means at the same time, as in the grammar.
    """
    pieces: list[Piece] = []
    led_by_before = False
    for kind, text in _cut(sentence):
        if not pieces:
            pieces.append(Piece(text, "then"))
            led_by_before = kind == "before"
        elif kind in ("comma", "and") and not _says_something(text) and not led_by_before:
            joint = ", " if kind == "comma" else " and "
            pieces[-1] = Piece(pieces[-1].text + joint + text, pieces[-1].order)
        elif kind == "after" or led_by_before:  # what stands behind happens first
            last = pieces.pop()
            pieces += [Piece(text, last.order), Piece(last.text, "then")]
            led_by_before = False
        else:
            pieces.append(Piece(text, "together" if kind in ("together", "and") else "then"))
    return pieces or [Piece(" ".join(sentence.split()), "then")]


def _cut(sentence: str) -> list[tuple[str, str]]:
    """Texts between connectives, each with the most telling connective in front of it."""
    texts: list[tuple[str, str]] = []
    start, kinds = 0, ["stop"]
    for cut in [*_CUT.finditer(sentence), None]:
        text = " ".join(sentence[start : cut.start() if cut else len(sentence)].split())
        if text:
            texts.append((min(kinds, key=_KINDS.index), text))
            kinds = []
        if cut is not None:
            kinds.append(cut.lastgroup or "")
            start = cut.end()
    return texts


def _says_something(text: str) -> bool:
    return not _NO_CLAUSE.issuperset(re.findall(r"[^\W\d_]+", text.casefold()))
