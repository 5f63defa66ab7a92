"""Outcomes of sentences, and how many there must be of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from benchmarks.harness import Row

OUTCOMES = ("right", "right but marked", "wrong and marked", "wrongly refused", "silently wrong")
REQUIRED = {"development": (0.70, 0.07), "test": (0.76, 0.07)}
"""Least share that is right, and largest that is silently wrong, of all authors of a split together."""


def find_outcome(row: Row) -> str:
    """One of `OUTCOMES`; a sentence that is right has every field right, its answer too."""
    if not row["wrong"]:
        return "right"
    if row["answer"] == "motion":
        return "silently wrong"
    if row["answer"] == "refused":
        return "wrongly refused"
    return "right but marked" if row["wrong"] == ["answer"] and row["fields"] > 1 else "wrong and marked"


def count_outcomes(rows: Iterable[Row]) -> Counter[str]:
    """Numbers of rows of each outcome."""
    return Counter(map(find_outcome, rows))


def is_met(split: str, count: Counter[str]) -> bool:
    """Return whether the outcomes of a split are as `REQUIRED`; of some splits nothing is required."""
    least, most = REQUIRED.get(split, (0.0, 1.0))
    return count["right"] >= least * count.total() and count["silently wrong"] <= most * count.total()


def describe_shares(count: Counter[str]) -> str:
    """Shares of all outcomes in a line."""
    told = (f"{name} {100 * count[name] / max(count.total(), 1):.2f} %" for name in OUTCOMES)
    return f"{count.total()} sentences: {', '.join(told)}"
