"""Tables of docs/throughput.md."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial

from benchmarks.harness import Page, Result, Rows, Tables, number, one_line, provenance, table
from benchmarks.throughput.job import errors, ratios
from benchmarks.throughput.strict import format_time, same_job, same_law, steps

PARTS = ("same_law", "same_job", "materials", "sizes", "grids", "stages", "memory", "job", "error")

AIMED_AT = 200_000  # particles

_TIMES = ("ms / substep", "x ours", "x default", "set-up [s]")

_JOBS = (
    "code",
    "law",
    "threads",
    "substeps",
    "dt [s]",
    "seconds",
    "x ours",
    "x default",
    "set-up [s]",
    "load",
)

_ERRORS = ("code", "cells", "particles", "substeps", "dt [s]", "error [mm]", "largest [mm]")

# What is aimed at: how many times slower than ours (the column), in which group of rows, which code and law.
_TARGETS = (
    ("Warp, each code's default jelly", 14, "machine_default", "jelly", "warp_classical", "jelly"),
    ("Taichi, each code's default jelly, equal threads", 5, "over_default", "jelly", "taichi_mls", "jelly"),
    ("Warp, the same corotated law", 8, "machine_ours", "jelly", "warp_classical", "jelly"),
    ("Warp, sand", 10, "machine_ours", "sand", "warp_classical", "sand"),
    ("Warp, metal", 10, "machine_ours", "metal", "warp_classical", "metal"),
    ("Warp, the whole job, each code's default jelly", 50, "over_default", "job", "warp_classical", "jelly"),
)


def write_tables(result: Result) -> Tables:
    """The tables of docs/throughput.md."""
    rows = {part: result[part]["rows"] for part in PARTS if part in result}
    if "error" in rows:
        rows["error"] = errors(rows["error"])
    if "job" in rows:
        rows["job"] = ratios(rows["job"])
    shows: dict[str, Callable[[Rows], str]] = {
        "same_law": same_law,
        "materials": _write_materials,
        "sizes": partial(_compare_sizes, "particles"),
        "grids": partial(_compare_sizes, "cells"),
        "stages": _write_stages,
        "memory": _write_memory,
        "job": _write_job,
        "error": _write_error,
    }
    tables = {part: show(rows[part]) for part, show in shows.items() if part in rows}
    if "same_job" in rows:
        tables |= same_job(rows["same_job"])
    return tables | {
        "aims": _write_targets(result, rows),
        "versions": _list_versions(result),
        "runs": provenance(result, PARTS),
    }


def _write_targets(result: dict, parts: dict[str, Rows]) -> str:
    """Aims, and what was reached. Only full-size rows count: an aim says nothing of a quick look."""
    slow = {part for part, section in result.items() if not any(run["quick"] for run in section["runs"])}
    rows = [row for part in parts if part in slow for row in parts[part] if not part.startswith("same")]
    full = _add_ratios([row for row in rows if row["particles"] == AIMED_AT])
    short, lines = [], []
    for words, aim, name, *wanted in _TARGETS:
        found = [row for row in full if [row["group"], row["code"], row["law"]] == wanted and row.get(name)]
        shown = ", ".join(f"{row[name]:.1f} ({_describe_threads(row, full)})" for row in found)
        if name.startswith("machine"):
            shown += "".join(
                f"; {row[name.replace('machine', 'over')]:.1f} (one thread each)" for row in found
            )
        reached = bool(found) and min(row[name] for row in found) >= aim
        verdict = ("reached" if reached else "**falls short**") if found else "not measured"
        short += [words] if found and not reached else []
        lines.append((words, aim, shown, verdict))
    text = table(("times slower than ours", "aim", "measured", ""), lines)
    text += f"\nFalls short: {'; '.join(short)}.\n" if short else ""
    return text + _compare_errors(full)


def _compare_errors(rows: Rows) -> str:
    """Return whether the job, for all its longer steps, is as accurate as Warp's."""
    found = {
        row["code"]: row["error"] for row in rows if row["group"] == "error" and row["error"] is not None
    }
    if len(found) < 2:
        return "\nThe job is to be at no larger error than Warp's: not measured.\n"
    ours, warp = (1e3 * found[code] for code in ("ours", "warp_classical"))
    verdict = "reached" if ours <= warp else "**falls short**"
    return f"\nThe job at no larger error than Warp's: {ours:.3g} mm against {warp:.3g} mm, {verdict}.\n"


def _add_ratios(rows: Rows) -> Rows:
    """The rows, with their time over ours of the most threads in the same group: same law, and our default jelly."""
    found = []
    for row in rows:
        mine = [other for other in rows if other["group"] == row["group"] and other["code"] == "ours"]
        most = max((other["threads"] for other in mine), default=0)
        extra = {}
        for name, law in (("machine_ours", row["law"]), ("machine_default", "neo_hookean")):
            base = [other for other in mine if other["threads"] == most and other["law"] == law]
            known = base and row.get("median_ms") and base[0].get("median_ms")
            extra[name] = row["median_ms"] / base[0]["median_ms"] if known else None
        found.append(row | extra)
    return found


def _describe_threads(row: dict, rows: Rows) -> str:
    """Threads on both sides, and whether the figure is extrapolated."""
    words = f"{row['threads']} thread{'s' if row['threads'] > 1 else ''}"
    if row["group"] != "job" and row["code"] != "warp_classical":
        return words
    ours = {other["threads"] for other in rows if other["group"] == row["group"] and other["code"] == "ours"}
    words += f", ours {max(ours)}"
    if row["group"] != "job":
        return words
    return words + (", extrapolated" if row["extrapolated"] else "")


def _write_materials(rows: Rows) -> str:
    text = ""
    for group in dict.fromkeys(row["group"] for row in rows):
        members = [row for row in rows if row["group"] == group]
        default = any(row["over_default"] for row in members)  # other laws have none
        columns = [name for name in _TIMES if default or name != "x default"]
        lines = [
            [row["code"], row["law"], row["threads"], *_make_timed_cells(row, columns[1:])] for row in members
        ]
        text += f"\n### {group}, {members[0]['particles']:,} particles\n"
        text += table(("code", "law", "threads", *columns), lines)
    return text


def _make_timed_cells(row: dict, columns: Sequence[str]) -> list:
    """Time per substep and what goes with it."""
    names = {"x ours": "over_ours", "x default": "over_default", "set-up [s]": "setup_seconds"}
    return [format_time(row), *(number(row[names[column]]) for column in columns)]


def _compare_sizes(key: str, rows: Rows) -> str:
    """Time per substep and over our default, a line for each code and a column for each size."""
    sizes = list(dict.fromkeys(row[key] for row in rows))
    lines: dict[tuple, dict[int, str]] = {}
    remarks: dict[str, str] = {}
    for row in rows:
        cell = one_line(row["message"])
        if row["median_ms"] is not None:
            ratio = number(row["over_default"])
            cell = number(row["median_ms"]) + (f" ({ratio})" if ratio else "")
            if remark := one_line(row["message"] or row["note"]):
                remarks[row["code"]] = remark
        lines.setdefault((row["code"], row["law"], row["threads"]), {})[row[key]] = cell
    text = table(
        ("code", "law", "threads", *(f"{size:,}" for size in sizes)),
        [[*name, *(found.get(size, "") for size in sizes)] for name, found in lines.items()],
    )
    return text + "".join(f"\n{code}: {remark}.\n" for code, remark in remarks.items())


def _write_stages(rows: Rows) -> str:
    names = next((list(row["milliseconds"]) for row in rows if row["milliseconds"]), [])
    lines = []
    for row in rows:
        figures = [number((row["milliseconds"] or {}).get(name)) for name in names]
        if row["message"]:
            figures = [one_line(row["message"]), *figures[1:]]
        lines.append([row["law"], f"{row['particles']:,}", row["threads"], *figures])
    return table(("law", "particles", "threads", *names), lines)


def _write_memory(rows: Rows) -> str:
    sizes = list(dict.fromkeys(row["particles"] for row in rows))
    lines: dict[tuple, dict[int, str]] = {}
    for row in rows:
        cell = one_line(row["message"]) or f"{row['peak_mb']:,}"
        lines.setdefault((row["code"], row["law"], row["threads"]), {})[row["particles"]] = cell
    return table(
        ("code", "law", "threads", *(f"{size:,}" for size in sizes)),
        [[*name, *(found.get(size, "") for size in sizes)] for name, found in lines.items()],
    )


def _write_job(rows: Rows) -> str:
    lines = []
    for row in rows:
        line = [row["code"], row["law"], row["threads"]]
        if row["seconds"] is None:
            lines.append([*line, "", "", one_line(row["message"]), "", "", "", ""])
            continue
        seconds = number(row["seconds"])
        if row["extrapolated"]:
            seconds += f" (extrapolated from {row['measured_substeps']} substeps)"
        line += [f"{row['substeps']:,}", steps(row), seconds]
        names = ("over_ours", "over_default", "setup_seconds", "load_average")
        lines.append([*line, *(number(row[name]) for name in names)])
    return table(_JOBS, lines)


def _write_error(rows: Rows) -> str:
    lines = []
    for row in rows:
        line = [row["code"], row["cells"], f"{row['particles']:,}"]
        if row["heights"] is None:
            lines.append([*line, "", "", one_line(row["message"]), ""])
            continue
        both = [row["error"], row.get("largest_error")]
        figures = [number(None if value is None else 1e3 * value) for value in both]
        lines.append([*line, f"{row['substeps']:,}", steps(row), *figures])
    return table(_ERRORS, lines)


def _list_versions(result: dict) -> str:
    """The versions that the codes tell, without numbers of threads."""
    said = {
        (row["code"].split(",")[0], re.sub(r" with \d+ thread\(s\)| \(\d+ threads\)", "", row["version"]))
        for section in result.values()
        for row in section["rows"]
        if row.get("version")
    }
    return "Versions: " + "; ".join(f"{code}: {version}" for code, version in sorted(said)) + ".\n"


PAGE = Page(
    "throughput",
    "python -m benchmarks.throughput",
    write_tables,
    ("physagent_jax/mpm", "physagent_jax/kernels", "benchmarks/peers"),
)
