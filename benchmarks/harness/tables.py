"""Markdown of rows: no figure is typed by hand."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from benchmarks.harness.pages import count_rows, read_runs

_PROVENANCE = ("seconds", "machine, load at the start, revision")
_FEW = 3  # revisions that a cell names
_NOT_KEPT = "revision not recorded"


def table(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table with these columns, and an empty line before it."""
    head, *lines = (f"| {' | '.join(map(str, cells))} |" for cells in (columns, *rows))
    return "\n".join(["", head, f"|{'---|' * len(columns)}", *lines, ""])


def provenance(
    result: Mapping[str, Any],
    parts: Sequence[str],
    counts: Mapping[str, Callable[[list[dict]], Any]] | None = None,
) -> str:
    """Rows, seconds, machine and revisions of each part, and which parts are missing. Commands are in the summary.

    Args:
        result: The sections.
        parts: All parts there are.
        counts: More columns, made of a part's rows.
    """
    counts, lines = counts or {}, []
    shown = [part for part in parts if part in result]
    machines = list(dict.fromkeys(run["machine"] for part in shown for run in read_runs(result[part])))
    letters = {machine: chr(ord("A") + index) for index, machine in enumerate(machines)}
    for part in shown:
        section = result[part]
        used = read_runs(section)
        quick = " (quick: not to be quoted)" if any(run["quick"] for run in used) else ""
        stopped = "" if section["complete"] else " (stopped before its end)"
        figures = [count(section["rows"]) for count in counts.values()]
        seconds = round(sum(run["seconds"] for run in used), 1)  # 0: not known
        origin = _describe_origins(used, letters)
        lines.append([part + quick + stopped, count_rows(section), *figures, seconds or "", origin])
    text = table(["part", "rows", *counts, *_PROVENANCE], lines)
    text += "".join(f"\n{letter}: {machine}.\n" for machine, letter in letters.items())
    absent = [part for part in parts if part not in result]
    return text + (f"\nNot measured yet: {', '.join(absent)}.\n" if absent else "")


def _describe_origins(runs: Sequence[Mapping[str, Any]], letters: Mapping[str, str]) -> str:
    """A text per machine, with the loads and the revisions of its runs."""
    same: dict[tuple, list[Mapping[str, Any]]] = {}
    for run in runs:
        same.setdefault((run["machine"], run.get("remark")), []).append(run)
    texts = []
    for (machine, remark), mine in same.items():
        loads = sorted({run["load_average"][0] for run in mine})
        load = f"{loads[0]}" if len(loads) == 1 else f"{loads[0]} to {loads[-1]}"
        named = _name_revisions([run["git_revision"] for run in mine])
        texts.append(f"{letters[machine]}; {load}; {named}" + (f". {remark}" if remark else ""))
    return "; then ".join(texts)


def _name_revisions(revisions: Sequence[str | None]) -> str:
    """A few by their names, more by the last; those that were not recorded too."""
    known = [name for name in dict.fromkeys(revisions) if name]
    text = ", ".join(known) if len(known) <= _FEW else f"{len(known)} revisions, the last {known[-1]}"
    return ", ".join(filter(None, (text, "" if all(revisions) else _NOT_KEPT)))


def number(value: float | None) -> str:
    """Three figures; nothing for None."""
    return "" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"


def one_line(text: str) -> str:
    """Text that fits a cell."""
    return " ".join(text.split()).replace("|", "/")
