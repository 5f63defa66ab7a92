"""docs/skipping.md from the JSON: no figure is typed by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.harness import link, number, one_line, provenance, table
from benchmarks.skipping.base import State
from benchmarks.skipping.catalogue import GROUPS, SKIPS
from benchmarks.skipping.measure import CHANCE, LEAST, NOT_MEASURABLE

Row = dict[str, Any]

_HEAD = """# What is not computed

The simulator leaves out what a scene does not need. Every row of the tables is one such skip, measured: *with* it, as
the product runs, and *without*, with the work forced in. Both ways start from the same state and must give the same
answer, positions, velocities and deformation gradients of every particle unless the row says otherwise; the largest
difference over the largest value is in the table beside what is tolerated, and a row that exceeds it fails. Every row
is in [{name}]({link}), written by `python -m benchmarks.skipping`, which ends with an error if one fails.

Unless the row says otherwise the scene is a cube of 0.6 m of random particles in a domain of 2 m, neo-Hookean, 1e5 Pa,
deformed by up to 5 %, moving at up to 0.5 m/s, with nothing else in it, so that the work that is forced in is seen
against the cheapest substep there is: in dearer scenes the same saving is a smaller share. Times are medians over
rounds in which the two ways take turns, warm, with the fastest and slowest round; what the first run took beyond a warm
one is called compilation (first with the skip, then without). *Saving* is the median over the rounds of the time
without over the time with. It counts as measurable if it is above {least:.0%} and as many rounds going one way would be
chance in less than {chance:.0%} of cases (sign test); all else is "{none}".

- *{skipped}*: the product does so.
- *{missing}*: the product computes it; the lean way was made by hand, and the row shows what a skip would save.
- *{kept}*: likewise, and it is to stay: the row shows the price.
- *{choice}*: both ways are right; the row shows time and error.
"""


def document(result: dict[str, Any], json_path: Path, target: Path) -> str:
    """The text of docs/skipping.md."""
    words = {state.name.lower(): state.value for state in State}
    text = _HEAD.format(
        name=json_path.name,
        link=link(json_path, target),
        least=LEAST,
        chance=CHANCE,
        none=NOT_MEASURABLE,
        **words,
    )
    rows: dict[str, Row] = {row["name"]: row for section in result.values() for row in section["rows"]}
    text += provenance(result, tuple(GROUPS)) + _summarise(rows)
    for title, skips in GROUPS.items():
        members = [rows[skip.name] for skip in skips if skip.name in rows]
        if members:
            text += _make_table(title, members)
    return text


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


def _make_table(title: str, rows: list[Row]) -> str:
    errors = any("lean_error" in row for row in rows)
    difference = "difference, or errors with and without" if errors else "largest difference"
    columns = ("skip", "", "particles", "per", "with [ms]", "without [ms]", "saving", difference)
    columns += ("tolerated", "compilation, both [s]")
    text = f"\n## {title}\n" + table(columns, [_make_line(row) for row in rows]) + "\n"
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
