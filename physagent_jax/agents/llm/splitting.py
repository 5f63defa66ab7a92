"""A sentence cut into clauses, for models that read one at a time."""

from __future__ import annotations

import re
from typing import Literal, NamedTuple

Order = Literal["then", "together"]
_CONNECTIVES = {  # the more telling first
    "after": r"\bafter\b(?! that)",
    "before": r"\bbefore\b",
    "then": r"\b(?:then|after that|afterwards|finally|until)\b",
    "together": r"\b(?:while|whilst|at the same time(?: as)?|simultaneously|meanwhile|as(?= (?:it|the)\b))\b",
    "stop": r"[.;!?]+(?=\s|$)|\n",
    "and": r"\band\b",
    "comma": r",",
}
_CUT = re.compile("|".join(f"(?P<{kind}>{words})" for kind, words in _CONNECTIVES.items()), re.IGNORECASE)
# Words that say no more than where, how strongly, on which part, or how long: alone they are no clause.
_NO_CLAUSE = frozenset(
    """
    left right up down upward upwards downward downwards forward forwards backward backwards away toward towards
    top bottom front back side sides upper lower middle end ends half head base both all other
    forth fro off out in again over around round
    very quite so gently softly slowly slightly lightly strongly hard harder quickly fast violently fiercely suddenly
    second seconds frame frames moment metre metres meter meters degree degrees times time time length lengths
    once twice half one two three four five
    a an the it its to from of for on at with by then and i you
    """.split()
)


class Piece(NamedTuple):
    """A clause of a sentence.

    Attributes:
        text: Its words.
        order: How it follows the clause before.
    """

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
            texts.append((min(kinds, key=list(_CONNECTIVES).index), text))
            kinds = []
        if cut is not None:
            kinds.append(cut.lastgroup or "")
            start = cut.end()
    return texts


def _says_something(text: str) -> bool:
    words = re.findall(r"[^\W\d_]+", text.casefold())
    return any(word not in _NO_CLAUSE for word in words)
