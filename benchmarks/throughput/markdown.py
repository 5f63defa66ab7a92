"""docs/throughput.md from the JSON: no figure is typed by hand."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.peers.drop import CELLS, DT, FRAME_DT

PARTS = ("materials", "sizes", "grids", "stages", "memory", "job", "error")

AIMED_AT = 200_000  # particles

Rows = list[dict[str, Any]]

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

| part | rows | seconds | command, machine, revision |
|---|---|---|---|
"""

_TABLE = """
| code | law | threads | {key} | ms / substep | fastest, slowest | x ours | x default | set-up [s] | busy cores | load |
|---|---|---|---|---|---|---|---|---|---|---|
"""

_SPARSE = """
A substep also clears, updates and sums every node of its window, whatever lies in it: where particles are few, that is
what is left.
"""

_STAGES = """
## Stages of our substep

Each stage function of `mpm.step` jitted alone on the same state, median ms. A substep consists of p2g, grid update,
g2p, projection and stress. Within one, stages share work, and a stage alone pays for a call and for writing its result
to memory: the sum can differ from the substep.

| law | particles | threads | {names} |
|---|---|---|{rule}|
"""

_JOB = """
## A whole job

{frames} frames of {frame_dt:g} s. Ours: `mpm.simulate` with its automatic step, warm, host work included; peers: the
customary fixed step of {dt:g} s, warm.

| code | law | threads | substeps | dt [s] | seconds | x ours | x default | set-up [s] | load |
|---|---|---|---|---|---|---|---|---|---|
"""

_ERROR = """
## Error of the job

The same clip with the fixed-corotated law, every substep run, and the height of its mass centre at every frame: root
mean square and largest difference from the first row, which has finer cells, as many particles in each, and the
shorter step that goes with them. That row is ours, of the MLS form; the peer's classical form tends to the same limit,
but has no row of its own this fine (it would take three hours). Nothing is timed here.

| code | cells | particles | substeps | dt [s] | error [mm] | largest [mm] |
|---|---|---|---|---|---|---|
"""

_TARGETS: tuple[tuple[str, float, str, Callable[[dict], bool]], ...] = (
    (
        "Warp, each code's default jelly",
        14,
        "machine_default",
        lambda row: row["group"] == "jelly" and row["code"] == "warp_classical",
    ),
    (
        "Taichi, each code's default jelly, equal threads",
        5,
        "over_default",
        lambda row: row["group"] == "jelly" and row["code"] == "taichi_mls",
    ),
    (
        "Warp, the same corotated law",
        8,
        "machine_ours",
        lambda row: row["group"] == "jelly" and row["code"] == "warp_classical",
    ),
    (
        "Warp, sand",
        10,
        "machine_ours",
        lambda row: row["group"] == "sand" and row["code"] == "warp_classical",
    ),
    (
        "Warp, metal",
        10,
        "machine_ours",
        lambda row: row["group"] == "metal" and row["code"] == "warp_classical",
    ),
    (
        "Warp, the whole job, each code's default jelly",
        50,
        "over_default",
        lambda row: row["group"] == "job" and row["code"] == "warp_classical" and row["law"] == "jelly",
    ),
)


def document(result: dict, json_path: Path, target: Path) -> str:
    """The text of docs/throughput.md."""
    link = Path(os.path.relpath(json_path.resolve(), target.resolve().parent)).as_posix()
    text = _HEAD.format(name=json_path.name, link=link, cells=CELLS, dt=DT)
    for part, section in result.items():
        origin = f"`{section['command']}`; {section['machine']}; {section['git_revision']}"
        quick = " (quick: not to be quoted)" if section["quick"] else ""
        stopped = "" if section["complete"] else " (stopped before its end)"
        seconds = section.get("seconds", "")
        text += f"| {part}{quick}{stopped} | {len(section['rows'])} | {seconds} | {origin} |\n"
    absent = [part for part in PARTS if part not in result]
    if absent:
        text += f"\nNot measured yet: {', '.join(absent)}.\n"
    text += _targets(result)
    for part, key, title in (
        ("materials", "particles", "Materials"),
        ("sizes", "particles", "Number of particles"),
        ("grids", "cells", "Cells along the domain"),
    ):
        if part in result:
            text += _table(title, key, result[part]["rows"])
    if "stages" in result:
        text += _stages(result["stages"]["rows"])
    if "memory" in result:
        text += _memory(result["memory"]["rows"])
    if "job" in result:
        text += _job(result["job"]["rows"])
    if "error" in result:
        text += _error(result["error"]["rows"])
    return text + _versions(result)


def _targets(result: dict) -> str:
    """What was aimed at, and what was reached. Only full-size rows count: an aim says nothing of a quick look."""
    rows = [row for section in result.values() if not section["quick"] for row in section["rows"]]
    full = _on_the_machine([row for row in rows if row["particles"] == AIMED_AT])
    text = f"\n## Aims\n\nAt {AIMED_AT:,} particles; quick runs do not count. Warp has one thread on a CPU:\n"
    text += "against it the aims are for the whole machine, ours with all threads; with one thread each beside it.\n"
    text += "\n| times slower than ours | aim | measured | |\n|---|---|---|---|\n"
    short = []
    for words, aim, name, wanted in _TARGETS:
        found = [row for row in full if wanted(row) and row.get(name)]
        shown = ", ".join(f"{row[name]:.1f} ({_how(row, full)})" for row in found)
        if name.startswith("machine"):
            shown += "".join(
                f"; {row[name.replace('machine', 'over')]:.1f} (one thread each)" for row in found
            )
        reached = bool(found) and min(row[name] for row in found) >= aim
        verdict = ("reached" if reached else "**falls short**") if found else "not measured"
        short += [words] if found and not reached else []
        text += f"| {words} | {aim} | {shown} | {verdict} |\n"
    text += f"\nFalls short: {'; '.join(short)}.\n" if short else ""
    return text + _no_larger_error(full)


def _no_larger_error(rows: Rows) -> str:
    """Whether the job, for all its longer steps, is as accurate as Warp's."""
    found = {
        row["code"]: row["error"] for row in rows if row["group"] == "error" and row["error"] is not None
    }
    if len(found) < 2:
        return "\nThe job is to be at no larger error than Warp's: not measured.\n"
    ours, warp = (1e3 * found[code] for code in ("ours", "warp_classical"))
    verdict = "reached" if ours <= warp else "**falls short**"
    return f"\nThe job at no larger error than Warp's: {ours:.3g} mm against {warp:.3g} mm, {verdict}.\n"


def _on_the_machine(rows: Rows) -> Rows:
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


def _how(row: dict, rows: Rows) -> str:
    """Threads on both sides, and whether the figure is extrapolated."""
    words = f"{row['threads']} thread{'s' if row['threads'] > 1 else ''}"
    if row["group"] != "job" and row["code"] != "warp_classical":
        return words
    ours = {other["threads"] for other in rows if other["group"] == row["group"] and other["code"] == "ours"}
    words += f", ours {max(ours)}"
    if row["group"] != "job":
        return words
    return words + (", extrapolated" if row["extrapolated"] else "")


def _table(title: str, key: str, rows: Rows) -> str:
    text = f"\n## {title}\n" + (_SPARSE if title == "Number of particles" else "")
    for group in dict.fromkeys(row["group"] for row in rows):
        members = [row for row in rows if row["group"] == group]
        heading = f", {members[0]['particles']:,} particles" if key == "cells" or title == "Materials" else ""
        text += f"\n### {group}{heading}\n" if title == "Materials" else ""
        text += _TABLE.format(key=key)
        text += "".join(_line(row, key) for row in members)
    return text


def _line(row: dict, key: str) -> str:
    start = f"| {row['code']} | {row['law']} | {row['threads']} | {row[key]:,} "
    if row["median_ms"] is None:
        return f"{start}| {_plain(row['message'])} | | | | {_number(row['setup_seconds'])} | | |\n"
    remark = row["message"] or row["note"]
    remark = f" ({_plain(remark)})" if remark else ""
    return (
        f"{start}| {_number(row['median_ms'])}{remark} | {_number(row['min_ms'])} to {_number(row['max_ms'])} "
        f"| {_number(row['over_ours'])} | {_number(row['over_default'])} | {_number(row['setup_seconds'])} "
        f"| {_number(row['busy'])} | {_number(row['load_average'])} |\n"
    )


def _stages(rows: Rows) -> str:
    names = next((list(row["milliseconds"]) for row in rows if row["milliseconds"]), [])
    text = _STAGES.format(names=" | ".join(names), rule="|".join(["---"] * len(names)))
    for row in rows:
        figures = row["milliseconds"] or {}
        cells = " | ".join(_number(figures.get(name)) for name in names)
        text += f"| {row['law']} | {row['particles']:,} | {row['threads']} | {_plain(row['message']) or cells} |\n"
    return text


def _memory(rows: Rows) -> str:
    text = "\n## Memory\n\nPeak resident memory of each code's process, libraries and compilation included.\n"
    text += "\n| code | law | threads | particles | peak [MB] |\n|---|---|---|---|---|\n"
    for row in rows:
        peak = _plain(row["message"]) or f"{row['peak_mb']:,}"
        text += f"| {row['code']} | {row['law']} | {row['threads']} | {row['particles']:,} | {peak} |\n"
    return text


def _job(rows: Rows) -> str:
    frames = max((len(row.get("heights", [])) - 1 for row in rows), default=0)
    text = _JOB.format(frames=frames, frame_dt=FRAME_DT, dt=DT)
    for row in rows:
        start = f"| {row['code']} | {row['law']} | {row['threads']} "
        if row["seconds"] is None:
            text += f"{start}| | | {_plain(row['message'])} | | | | |\n"
            continue
        seconds = _number(row["seconds"])
        if row["extrapolated"]:
            seconds += f" (extrapolated from {row['measured_substeps']} substeps)"
        text += (
            f"{start}| {row['substeps']:,} | {_steps(row)} | {seconds} | {_number(row['over_ours'])} "
            f"| {_number(row['over_default'])} | {_number(row['setup_seconds'])} "
            f"| {_number(row['load_average'])} |\n"
        )
    return text


def _error(rows: Rows) -> str:
    text = _ERROR
    for row in rows:
        start = f"| {row['code']} | {row['cells']} | {row['particles']:,} "
        if row["heights"] is None:
            text += f"{start}| | | {_plain(row['message'])} | |\n"
            continue
        errors = (
            " | | "
            if row["error"] is None
            else " | ".join(_number(1e3 * row[name]) for name in ("error", "largest_error"))
        )
        text += f"{start}| {row['substeps']:,} | {_steps(row)} | {errors.strip()} |\n"
    return text


def _steps(row: dict) -> str:
    """The step, or the smallest and the largest [s]."""
    least, largest = _number(row["least_dt"]), _number(row["largest_dt"])
    return least if least == largest else f"{least} to {largest}"


def _versions(result: dict) -> str:
    """What the codes said of themselves."""
    said = {
        (row["code"], row["version"])
        for section in result.values()
        for row in section["rows"]
        if row.get("version")
    }
    return "\nVersions: " + "; ".join(f"{code}: {version}" for code, version in sorted(said)) + ".\n"


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"


def _plain(text: str) -> str:
    return " ".join(text.split()).replace("|", "/")
