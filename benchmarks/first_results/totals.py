"""Shares of the pairs that show what was asked, and of the verdicts that are wrong."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence

from benchmarks.first_results.catalogue import SETS, name_cases
from benchmarks.first_results.viewing import Remark, Remarks, find_remark
from benchmarks.harness import Result, Row, table

Seen = tuple[Row, Remark]

_SUCCESS = "SUCCESS"
_KINDS = {name: case.kinds for group in SETS for name, case in name_cases(group).items()}
_FIGURES: dict[str, tuple[Callable[[Seen], bool], Callable[[Seen], bool], str]] = {
    "shows it": (lambda seen: True, lambda seen: seen[1].viewer == "yes", "at least 75 %"),
    "partly": (lambda seen: True, lambda seen: seen[1].viewer == "partly", ""),
    "would show": (
        lambda seen: seen[1].would_show is not None,
        lambda seen: seen[1].would_show == "yes",
        "at least 50 %",
    ),
    "shows it, of parts": (
        lambda seen: _is_of("part", seen),
        lambda seen: seen[1].viewer == "yes",
        "at least 60 %",
    ),
    "shows it, of materials": (
        lambda seen: _is_of("material", seen),
        lambda seen: seen[1].viewer == "yes",
        "",
    ),
    "shows it, of sequences": (
        lambda seen: _is_of("sequence", seen),
        lambda seen: seen[1].viewer == "yes",
        "",
    ),
    "false SUCCESS, of clips that do not show it": (
        lambda seen: seen[1].viewer == "no",
        lambda seen: seen[0]["verdict"] == _SUCCESS,
        "at most 3 %",
    ),
    "false FAIL, of clips that show it": (
        lambda seen: seen[1].viewer == "yes",
        lambda seen: seen[0]["verdict"] != _SUCCESS,
        "at most 10 %",
    ),
    "shows it, of runs that went past round 1": (
        lambda seen: seen[0].get("iterations", 1) > 1,
        lambda seen: seen[1].viewer == "yes",
        "",
    ),
}
"""Rows that a figure is a share of, rows that count, and the share that is wanted."""


_POOLED = 4
"""Sets that are counted together in a row of their own: of 20 pairs alone, 50 % is 30 to 70 % (Wilson, 95 %)."""


def count_totals(result: Result, remarks: Remarks) -> str:
    """A table with a row per set, the newest first, and one of the newest sets together; figures with their counts."""
    groups = [group for group in SETS if group in result][::-1]
    rows = {f"`{group}`": result[group]["rows"] for group in groups}
    if len(groups) > _POOLED:
        newest = [row for group in groups[:_POOLED] for row in result[group]["rows"]]
        rows = {f"newest {_POOLED} together": newest} | rows
    lines = [["wanted", "", "", *(wanted for _, _, wanted in _FIGURES.values()), ""]]
    for name, section in rows.items():
        seen = look_up(section, remarks)
        shares = [
            write_share([counts(pair) for pair in seen if whole(pair)])
            for whole, counts, _ in _FIGURES.values()
        ]
        lines.append([name, len(section), len(seen), *shares, _find_median(section)])
    return table(("set", "pairs", "looked at", *_FIGURES, "seconds, median"), lines)


def look_up(rows: Sequence[Row], remarks: Remarks) -> list[Seen]:
    """The rows that somebody has looked at, with the remarks."""
    found = [(row, find_remark(row, remarks)) for row in rows]
    return [(row, remark) for row, remark in found if remark is not None]


def write_share(counted: Sequence[bool]) -> str:
    """A share in percent with its counts; nothing of nothing."""
    if not counted:
        return ""
    return f"{100 * sum(counted) / len(counted):.0f} % ({sum(counted)} of {len(counted)})"


def _is_of(kind: str, seen: Seen) -> bool:
    return kind in _KINDS.get(seen[0]["case"], "").split()


def _find_median(rows: Sequence[Row]) -> str:
    """Of whole processes; rows of earlier runs have the time without the start of the process."""
    seconds = [row.get("seconds") or row["wall_s"]["total"] for row in rows if row["video"] is not None]
    return f"{statistics.median(seconds):.0f}" if seconds else ""
