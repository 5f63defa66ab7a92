"""Tables of docs/skipping.md."""

from __future__ import annotations

from typing import Any

from benchmarks.harness import Page, Result, Tables, number, one_line, provenance, table
from benchmarks.skipping.base import State
from benchmarks.skipping.catalogue import GROUPS, SKIPS

Row = dict[str, Any]


def write_tables(result: Result) -> Tables:
    """The tables of docs/skipping.md."""
    rows: dict[str, Row] = {row["name"]: row for section in result.values() for row in section["rows"]}
    tables = {"runs": provenance(result, tuple(GROUPS)), "summary": _summarise(rows)}
    for title, skips in GROUPS.items():
        members = [rows[skip.name] for skip in skips if skip.name in rows]
        if members:
            tables[title.lower()] = _make_table(members)
    return tables


def _summarise(rows: dict[str, Row]) -> str:
    def named(chosen: list[Row]) -> str:
        return ", ".join(row["name"] for row in chosen) or "none"

    measured = list(rows.values())
    of_state = {state: [row for row in measured if row["state"] == state] for state in State}
    unseen = [row for row in of_state[State.SKIPPED] if row.get("verdict") not in (None, "saves")]
    text = f"\n{len(measured)} rows. Failing: {named([row for row in measured if not row['good']])}.\n"
    text += f"\nSkipped without a measurable saving here: {named(unseen)}.\n"
    text += f"\nNot skipped yet: {named(of_state[State.MISSING])}.\n"
    absent = [name for name in SKIPS if name not in rows]
    return text + (f"\nNot measured yet: {', '.join(absent)}.\n" if absent else "")


def _make_table(rows: list[Row]) -> str:
    errors = any("lean_error" in row for row in rows)
    difference = "difference, or errors with and without" if errors else "largest difference"
    columns = ("skip", "", "particles", "per", "with [ms]", "without [ms]", "saving", difference)
    columns += ("tolerated", "compilation, both [s]")
    text = table(columns, [_make_line(row) for row in rows]) + "\n"
    for row in rows:
        reason = f" Tolerated: {row['reason']}." if row["reason"] else ""
        note = f" Here: {row['note']}." if row.get("note") else ""
        text += one_line(
            f"- **{row['name']}** leaves out {row['left_out']}. Without: {row['forced']}.{reason}{note}"
        )
        text += "\n"
    return text


def _make_line(row: Row) -> list:
    start = [row["name"], row["state"]]
    if "saving" not in row:
        return [*start, "", "", f"**failed**: {one_line(row['message'])}", "", "", "", "", ""]
    verdict = {"saves": "", "costs": " (costs)"}.get(row["verdict"], f" ({row['verdict']})")
    message = "" if row["good"] else f" **FAILS**: {one_line(row['message'])}"
    compiled = f"{row['lean_compile_seconds']:.3g}, {row['full_compile_seconds']:.3g}"
    start += [f"{row['particles']:,}", row["unit"], _format_time(row, "lean"), _format_time(row, "full")]
    start += [f"{row['saving']:.2f} x{verdict}", _format_difference(row) + message]
    return [*start, f"{row['tolerance']:.0e}", compiled]


def _format_time(row: Row, way: str) -> str:
    low, high = row[f"{way}_range_ms"]
    return f"{number(row[f'{way}_ms'])} ({number(low)} to {number(high)})"


def _format_difference(row: Row) -> str:
    if "lean_error" in row:
        return f"errors {row['lean_error']:.2g} and {row['full_error']:.2g}"
    if row["disagreement"] is None:
        return "infinite"
    return "0" if row["disagreement"] == 0 else f"{row['disagreement']:.1e} ({row['where']})"


PAGE = Page(
    "skipping",
    "python -m benchmarks.skipping",
    write_tables,
    ("physagent_jax/mpm", "physagent_jax/kernels", "physagent_jax/gaussians", "physagent_jax/output"),
)
