"""docs/throughput.md from the JSON: no figure is typed by hand."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness import Rows, link, number, one_line, provenance, table
from benchmarks.peers.drop import CELLS, DT, FRAME_DT
from benchmarks.throughput.job import errors, ratios
from benchmarks.throughput.strict import same_job, same_law, steps

PARTS = ("same_law", "same_job", "materials", "sizes", "grids", "stages", "memory", "job", "error")

AIMED_AT = 200_000  # particles

_HEAD = """# Throughput

What a substep and a job cost, measured; every row is in [{name}]({link}), written by `python -m
benchmarks.throughput`.

The scene: a 0.6 m cube of uniformly random, unsorted particles in a domain of 2 m, E = 1e5 Pa, nu = 0.3, 1000 kg/m^3,
falls at 1 m/s from 4 mm above a sticky floor at z = 0.2 m; walls around; {cells} cells along the domain unless the
table says otherwise; substep {dt:g} s; float32. All codes get the same particles in the same order. Ours sorts them
by cell as it loads, as compiling a scene does (time in the column set-up); "unsorted" does not. Each code lives in a
process of its own, kept on as many cores as it has threads; the processes take turns, round after round, so that a
change of the machine's mood meets all. A turn takes about a second or longer, so that a fast code gets further into
the motion than a slow one. Figures are the median over the rounds of warm substeps, with the fastest and slowest
round; compilation is in the column set-up (codes that keep compiled kernels on disk may have found them there). "x
ours": time over ours with as many threads and the same law; "x default": over our default jelly (neo-Hookean) with as
many threads, which is what a user gets who takes each code's default (peers: fixed corotated). "busy cores":
processor time over wall time.

Laws are the same to the letter (`benchmarks/peers/scene.py`), with two exceptions: our sand also corrects the volume
that it gained in tension, which the peers' does not; and Warp has the classical stress form, the others MLS.
"""

_TIMES = ("ms / substep", "fastest, slowest", "x ours", "x default", "set-up [s]", "busy cores", "load")

_SPARSE = """
A substep also clears, updates and sums every node of its window, whatever lies in it: where particles are few, that is
what is left.
"""

_AIMS = """
## Machine against machine

Each code as a machine's owner would run it, from here on. Aims, at {particles:,} particles; quick runs do not count.
Warp has one thread on a CPU: against it the aims are for the whole machine, ours with all threads; with one thread each
beside it.
"""

_STAGES = """
## Stages of our substep

Each stage function of `mpm.step` jitted alone on the same state, median ms. A substep consists of p2g, grid update,
g2p, projection and stress. Within one, stages share work, and a stage alone pays for a call and for writing its result
to memory: the sum can differ from the substep.
"""

_JOB = """
## A whole job

{frames} frames of {frame_dt:g} s. Ours: `mpm.simulate` with its automatic step, warm, host work included; peers: the
customary fixed step of {dt:g} s, warm.
"""
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

_ERROR = """
## Error of the job

The same clip with the fixed-corotated law, every substep run, and the height of its mass centre at every frame: root
mean square and largest difference from the first row, which has finer cells, as many particles in each, and the
shorter step that goes with them. That row is ours, of the MLS form; the peer's classical form tends to the same limit,
but has no row of its own this fine (it would take three hours). Nothing is timed here.
"""
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


def document(result: dict, json_path: Path, target: Path) -> str:
    """The text of docs/throughput.md."""
    text = _HEAD.format(name=json_path.name, link=link(json_path, target), cells=CELLS, dt=DT)
    text += provenance(result, PARTS)
    rows = {part: result[part]["rows"] for part in PARTS if part in result}
    if "error" in rows:
        rows["error"] = errors(rows["error"])
    if "job" in rows:
        rows["job"] = ratios(rows["job"])
    for part, show in (
        ("same_law", same_law),
        ("same_job", same_job),
        ("", lambda _: _write_targets(result, rows)),
        ("materials", lambda rows: _make_table("Materials", "particles", rows)),
        ("sizes", lambda rows: _make_table("Number of particles", "particles", rows)),
        ("grids", lambda rows: _make_table("Cells along the domain", "cells", rows)),
        ("stages", _write_stages),
        ("memory", _write_memory),
        ("job", _write_job),
        ("error", _write_error),
    ):
        if part in rows or not part:
            text += show(rows.get(part, []))
    return text + _list_versions(result)


def _write_targets(result: dict, parts: dict[str, Rows]) -> str:
    """What was aimed at, and what was reached. Only full-size rows count: an aim says nothing of a quick look."""
    slow = {part for part, section in result.items() if not any(run["quick"] for run in section["runs"])}
    rows = [row for part in parts if part in slow for row in parts[part] if not part.startswith("same")]
    full = _add_ratios([row for row in rows if row["particles"] == AIMED_AT])
    text = _AIMS.format(particles=AIMED_AT)
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
    text += table(("times slower than ours", "aim", "measured", ""), lines)
    text += f"\nFalls short: {'; '.join(short)}.\n" if short else ""
    return text + _compare_errors(full)


def _compare_errors(rows: Rows) -> str:
    """Whether the job, for all its longer steps, is as accurate as Warp's."""
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


def _make_table(title: str, key: str, rows: Rows) -> str:
    text = f"\n## {title}\n" + (_SPARSE if title == "Number of particles" else "")
    groups = [title] if title != "Materials" else dict.fromkeys(row["group"] for row in rows)
    for group in groups:
        members = [row for row in rows if title != "Materials" or row["group"] == group]
        for_all = f", {members[0]['particles']:,} particles"
        text += f"\n### {group}{for_all}\n" if title == "Materials" else ""
        columns = ("code", "law", "threads", key, *_TIMES)
        text += table(columns, [_make_line(row, key) for row in members])
    return text


def _make_line(row: dict, key: str) -> list:
    return [row["code"], row["law"], row["threads"], f"{row[key]:,}", *_make_timed_cells(row)]


def _make_timed_cells(row: dict) -> list:
    """Time per substep and what goes with it."""
    if row["median_ms"] is None:
        return [one_line(row["message"]), "", "", "", number(row["setup_seconds"]), "", ""]
    remark = one_line(row["message"] or row["note"])
    median = number(row["median_ms"]) + (f" ({remark})" if remark else "")
    names = ("over_ours", "over_default", "setup_seconds", "busy", "load_average")
    return [median, f"{number(row['min_ms'])} to {number(row['max_ms'])}", *(number(row[n]) for n in names)]


def _write_stages(rows: Rows) -> str:
    names = next((list(row["milliseconds"]) for row in rows if row["milliseconds"]), [])
    lines = []
    for row in rows:
        figures = [number((row["milliseconds"] or {}).get(name)) for name in names]
        if row["message"]:
            figures = [one_line(row["message"]), *figures[1:]]
        lines.append([row["law"], f"{row['particles']:,}", row["threads"], *figures])
    return _STAGES + table(("law", "particles", "threads", *names), lines)


def _write_memory(rows: Rows) -> str:
    text = "\n## Memory\n\nPeak resident memory of each code's process, libraries and compilation included.\n"
    lines = [
        [row["code"], row["law"], row["threads"], f"{row['particles']:,}"]
        + [one_line(row["message"]) or f"{row['peak_mb']:,}"]
        for row in rows
    ]
    return text + table(("code", "law", "threads", "particles", "peak [MB]"), lines)


def _write_job(rows: Rows) -> str:
    frames, lines = max((len(row.get("heights", [])) - 1 for row in rows), default=0), []
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
    return _JOB.format(frames=frames, frame_dt=FRAME_DT, dt=DT) + table(_JOBS, lines)


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
    return _ERROR + table(_ERRORS, lines)


def _list_versions(result: dict) -> str:
    """What the codes said of themselves."""
    said = {
        (row["code"], row["version"])
        for section in result.values()
        for row in section["rows"]
        if row.get("version")
    }
    return "\nVersions: " + "; ".join(f"{code}: {version}" for code, version in sorted(said)) + ".\n"
