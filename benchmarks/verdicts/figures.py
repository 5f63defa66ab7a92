"""Shares of false verdicts, and what is allowed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from benchmarks.harness import Row

SIGHTS = ("truth", "pictures")
ALLOWED = {"truth": (0.02, 0.10), "pictures": (0.05, 0.15)}  # false SUCCESS, false FAIL
HALVES = ("development", "test")


def get_rows(result: Mapping[str, Any], part: str, **wanted: object) -> list[Row]:
    """The rows of a part whose fields are as wanted."""
    rows = result[part]["rows"] if part in result else []
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def count_false(rows: Iterable[Row], label: str) -> tuple[int, int]:
    """Number of clips of this label that are judged otherwise, and of all with it."""
    mine = [row for row in rows if row["label"] == label]
    return sum(not row["right"] for row in mine), len(mine)


def find_excess(result: Mapping[str, Any]) -> list[str]:
    """A sentence for each share of false verdicts that is larger than allowed."""
    found = []
    for part in SIGHTS:
        rows = get_rows(result, part)
        # A false SUCCESS is a wrong motion that passes; a false FAIL is a right one that does not.
        for name, label, allowed in zip(("SUCCESS", "FAIL"), ("FAIL", "SUCCESS"), ALLOWED[part]):
            false, of = count_false(rows, label)
            if of and false / of > allowed:
                found.append(
                    f"{part}: {false} of {of} clips are a false {name} ({100 * false / of:.1f} %), "
                    f"allowed are {100 * allowed:.0f} %"
                )
    return found
