"""The tables of codes on an equal footing: one law, equal threads, one order of particles, and errors."""

from __future__ import annotations

from benchmarks.harness import Row, Rows, Tables, number, one_line, table
from benchmarks.peers.flight import CELLS
from benchmarks.throughput.same_job import ENOUGH

_LAW_NAMES = {"neo_hookean": "neo-Hookean", "jelly": "fixed corotated"}

_ORDERS = ("sorted", "random")

_REFERENCE_COLUMNS = ("code", "cells", "particles", "substeps", "dt [s]", "change [mm]", "error [mm]")


def same_law(rows: Rows) -> str:
    """Times of substeps, a line for each code, number of threads and order, and columns for each law."""
    laws = list(dict.fromkeys(row["law"] for row in rows))
    base = {
        (row["law"], row["threads"], row["order"]): row["median_ms"]
        for row in rows
        if row["code"].startswith("ours") and row["median_ms"]
    }
    lines: dict[tuple, dict[str, list]] = {}
    for row in rows:
        key = row["code"].removesuffix(", unsorted"), row["threads"], row["order"]
        ours = base.get((row["law"], row["threads"], row["order"]))
        lines.setdefault(key, {})[row["law"]] = [
            format_time(row),
            number(row["median_ms"] / ours if ours and row["median_ms"] else None),
        ]
    heads = [head for law in laws for head in (f"{_LAW_NAMES.get(law, law)} [ms]", "x ours")]
    return table(
        ("code", "threads", "order", *heads),
        [
            [*key, *(cell for law in laws for cell in found.get(law, ["", ""]))]
            for key, found in lines.items()
        ],
    )


def format_time(row: Row) -> str:
    """The median with the fastest and the slowest round, and what there is to remark."""
    if row["median_ms"] is None:
        return one_line(row["message"])
    remark = one_line(row["message"] or row["note"])
    text = f"{number(row['median_ms'])} ({number(row['min_ms'])} to {number(row['max_ms'])})"
    return f"{text}: {remark}" if remark else text


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
        "same_job": _write_headline(pairs) + _compare_clips(pairs),
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


def _compare_clips(pairs: list[tuple[Row, Row | None]]) -> str:
    """A line for each code, number of threads and step, and columns for each order."""
    lines: dict[tuple, dict[str, list]] = {}
    for row, ours in pairs:
        substeps = "" if row["substeps"] is None else f"{row['substeps']:,}"
        key = row["code"], row["threads"], row["step"], substeps
        lines.setdefault(key, {})[row["order"]] = _make_clip_cells(row, ours)
    columns = [
        f"{order}: {head}" for order in _ORDERS for head in ("seconds", "x ours", "error [mm] (x ours)")
    ]
    cells = [
        [*key, *(cell for order in _ORDERS for cell in found.get(order, [""] * 3))]
        for key, found in lines.items()
    ]
    return table(("code", "threads", "step", "substeps", *columns), cells)


def _make_clip_cells(row: Row, ours: Row | None) -> list[str]:
    """Seconds, and seconds and error over ours."""
    if row["seconds"] is None:
        return [one_line(row["message"]), "", ""]
    seconds = f"{number(row['seconds'])} ({' to '.join(map(number, dict.fromkeys(row['range'])))})"
    ratio = "" if ours is None else number(row["seconds"] / ours["seconds"])
    if row["error"] is None:
        return [seconds, ratio, one_line(row["message"])]
    error = _format_millimetres(row["error"])
    return [
        seconds,
        ratio,
        f"{error} ({number(row['error'] / ours['error'])})" if ours and ours["error"] else error,
    ]


def _judge_reference(reference: Rows, timed: Rows) -> str:
    """Return whether the reference is one, for the errors that are compared."""
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
