"""Markdown of rows: no figure is typed by hand."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

_PROVENANCE = ("seconds", "command, machine, load at the start, revision")
_FEW = 2  # commands that a cell may name; more of them are listed behind the table


def table(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table with these columns, and an empty line before it."""
    head, *lines = (f"| {' | '.join(map(str, cells))} |" for cells in (columns, *rows))
    return "\n".join(["", head, f"|{'---|' * len(columns)}", *lines, ""])


def provenance(
    result: Mapping[str, Any],
    parts: Sequence[str],
    counts: Mapping[str, Callable[[list[dict]], Any]] | None = None,
) -> str:
    """What each part was measured with, and which parts are missing.

    Args:
        result: The sections.
        parts: All parts there are.
        counts: More columns, made of a part's rows.
    """
    counts, lines, lists = counts or {}, [], ""
    for part in (part for part in parts if part in result):
        section = result[part]
        used = [
            run for i, run in enumerate(section["runs"]) if any(row["run"] == i for row in section["rows"])
        ]
        quick = " (quick: not to be quoted)" if any(run["quick"] for run in used) else ""
        stopped = "" if section["complete"] else " (stopped before its end)"
        figures = [count(section["rows"]) for count in counts.values()]
        seconds = round(sum(run["seconds"] for run in used), 1)  # 0: not known
        origins = _describe_origins(used)
        origin = "; then ".join(origins)
        if len(origins) > _FEW:
            origin = f"{len(origins)} commands, below"
            lists += f"\nThe commands of {part}:\n\n" + "".join(f"- {each}\n" for each in origins)
        lines.append([part + quick + stopped, len(section["rows"]), *figures, seconds or "", origin])
    absent = [part for part in parts if part not in result]
    missing = f"\nNot measured yet: {', '.join(absent)}.\n" if absent else ""
    return table(["part", "rows", *counts, *_PROVENANCE], lines) + lists + missing


def _describe_origins(runs: Sequence[Mapping[str, Any]]) -> list[str]:
    """A text per command and machine: what was begun again is named once, with all of its loads and revisions."""
    same: dict[tuple, list[Mapping[str, Any]]] = {}
    for run in runs:
        same.setdefault((run["command"], run["machine"], run.get("remark")), []).append(run)
    texts = []
    for (command, machine, remark), mine in same.items():
        loads = ", ".join(str(run["load_average"][0]) for run in mine)
        revisions = ", ".join(dict.fromkeys(str(run["git_revision"]) for run in mine))
        texts.append(f"`{command}`; {machine}; {loads}; {revisions}" + (f". {remark}" if remark else ""))
    return texts


def link(path: Path, target: Path) -> str:
    """``path`` as ``target``, a file, links to it."""
    return Path(os.path.relpath(path.resolve(), target.resolve().parent)).as_posix()


def number(value: float | None) -> str:
    """Three figures; nothing for None."""
    return "" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"


def one_line(text: str) -> str:
    """Text that fits a cell."""
    return " ".join(text.split()).replace("|", "/")
