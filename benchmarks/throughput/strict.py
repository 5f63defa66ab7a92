"""The tables of codes on an equal footing: one law, equal threads, one order of particles, and errors."""

from __future__ import annotations

from benchmarks.harness import Row, Rows, Tables, number, one_line, table
from benchmarks.peers.flight import CELLS
from benchmarks.throughput.same_job import ENOUGH

_LAW_COLUMNS = (
    "code",
    "threads",
    "order",
    "ms / substep",
    "fastest, slowest",
    "x ours",
    "busy cores",
    "load",
)

_LAW_NAMES = {"neo_hookean": "Neo-Hookean", "jelly": "Fixed corotated"}

_JOB_COLUMNS = ("code", "threads", "order", "step", "dt [s]", "substeps", "seconds", "range", "error [mm]")
_JOB_COLUMNS += ("x ours: seconds", "x ours: error", "load")

_REFERENCE_COLUMNS = ("code", "cells", "particles", "substeps", "dt [s]", "change [mm]", "error [mm]")


def same_law(rows: Rows) -> str:
    """Substeps, by law."""
    text = ""
    for law in dict.fromkeys(row["law"] for row in rows):
        members = [row for row in rows if row["law"] == law]
        base = {
            (row["threads"], row["order"]): row["median_ms"]
            for row in members
            if row["code"].startswith("ours") and row["median_ms"]
        }
        text += f"\n### {_LAW_NAMES.get(law, law)}\n" + table(
            _LAW_COLUMNS, [_make_substep_line(row, base) for row in members]
        )
    return text


def _make_substep_line(row: Row, base: dict) -> list:
    start = [row["code"].removesuffix(", unsorted"), row["threads"], row["order"]]
    if row["median_ms"] is None:
        return [*start, one_line(row["message"]), "", "", "", ""]
    ours = base.get((row["threads"], row["order"]))
    remark = one_line(row["message"] or row["note"])
    figures = [number(row["median_ms"]) + (f" ({remark})" if remark else "")]
    figures += [f"{number(row['min_ms'])} to {number(row['max_ms'])}"]
    figures += [number(row["median_ms"] / ours if ours else None)]
    return [*start, *figures, number(row["busy"]), number(row["load_average"])]


def same_job(rows: Rows) -> Tables:
    """The whole job with the headline figures, and the reference that it is set against."""
    reference = [row for row in rows if row["double"] or row["cells"] != CELLS]
    timed = [row for row in rows if row not in reference]
    base = {
        (row["threads"], row["order"]): row
        for row in timed
        if row["code"] == "ours" and row["step"] == "automatic" and row["seconds"]
    }
    pairs = [(row, base.get((row["threads"], row["order"]))) for row in timed]
    return {
        "same_job": _write_headline(pairs) + table(_JOB_COLUMNS, [_make_clip_line(*pair) for pair in pairs]),
        "reference": f"{_judge_reference(reference, timed)}\n"
        + table(_REFERENCE_COLUMNS, [_make_level_line(row) for row in reference]),
    }


def _write_headline(pairs: list[tuple[Row, Row | None]]) -> str:
    """The peer that is least behind, by step."""
    text = ""
    for step, words in (("bound", "its own bound"), ("customary", "the customary step")):
        found = [
            (row["seconds"] / ours["seconds"], row, ours)
            for row, ours in pairs
            if ours and row["code"] != "ours" and row["step"] == step and row["seconds"] and row["error"]
        ]
        if found:
            ratio, row, ours = min(found, key=lambda entry: entry[0])
            text += (
                f"\nAt {words} the fastest peer, {row['code']} ({row['threads']} thread(s), {row['order']}), takes "
                f"**{number(ratio)}** times our seconds, with {number(row['error'] / ours['error'])} times our error.\n"
            )
    return text


def _make_clip_line(row: Row, ours: Row | None) -> list:
    start = [row["code"], row["threads"], row["order"], row["step"]]
    if row["seconds"] is None:
        return [*start, "", "", one_line(row["message"]), *[""] * 5]
    ratio = "" if ours is None else number(row["seconds"] / ours["seconds"])
    figures = [steps(row), f"{row['substeps']:,}", number(row["seconds"])]
    figures += [" to ".join(map(number, row["range"]))]
    known = row["error"] is not None
    figures += [_format_millimetres(row["error"]) if known else one_line(row["message"]), ratio]
    figures += [number(row["error"] / ours["error"]) if known and ours and ours["error"] else ""]
    return [*start, *figures, number(row["load_average"])]


def _judge_reference(reference: Rows, timed: Rows) -> str:
    """Whether the reference is one, for the errors that are compared."""
    errors = [row["error"] for row in timed if row["error"]]
    changes = [row["change"] for row in reference if row["change"] is not None]
    if not errors or not changes:
        return "Its last change cannot be judged yet."
    share = changes[-1] / min(errors)
    words = "less" if share < ENOUGH else "**more**"
    return f"The last change is {share:.2g} of the least error above, {words} than the tenth that is allowed."


def _make_level_line(row: Row) -> list:
    code = f"{row['code']}, float64" if row["double"] else f"{row['code']}, {row['step']}"
    start = [code, row["cells"], f"{row['particles']:,}"]
    if row["substeps"] is None:
        return [*start, "", one_line(row["message"]), "", ""]
    error = "(reference)" if row.get("means") else _format_millimetres(row["error"])
    return [*start, f"{row['substeps']:,}", steps(row), _format_millimetres(row["change"]), error]


def _format_millimetres(value: float | None) -> str:
    return number(None if value is None else 1e3 * value)


def steps(row: Row) -> str:
    """The step, or the smallest and the largest [s]."""
    least, largest = number(row["least_dt"]), number(row["largest_dt"])
    return least if least == largest else f"{least} to {largest}"
