"""`python -m benchmarks.startup [--json OUT] [--data DIR] [--markdown MD] [--quick]`: time to a first result.

Runs the job of `make demo` in a new process: first with an empty folder for compiled programs (cold), then again with
what that run left there (warm); some rounds of both. What compilation adds is the difference of the two.

What one iteration of the loop takes (simulate, render, perceive, decide), once all is compiled, is measured with a
mesh that is filled with as many particles as ``--preset fast`` has at most.

Part "clips" runs each sentence of the first results (`benchmarks.first_results`) for one round and notes when its clip
was there. Objects that are not bundled and cannot be made are looked for in ``--data``.

Part "plan" reads a sentence for the bundled robot, by `physagent plan`, once all packages are imported: for the first
time, and again in a new process, which finds the parts of the robot on disk.

Part "meshes" samples closed meshes as obstacles (`benchmarks.meshes`).
"""

from __future__ import annotations

import dataclasses
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Literal

import trimesh
import tyro

from benchmarks import clips, harness, meshes
from benchmarks.harness import RAW, Job, Page, Row, Rows, provenance, table

OBJECT = Path(__file__).resolve().parents[1] / "examples" / "assets" / "robot.ply"
JOB = ("--object", str(OBJECT), "--prompt", "a strong wind pushes the robot to the left")
LARGEST = ("--up", "+z", "--prompt", "a strong wind pushes the ring to the left", "--max-iterations", "1")
ITERATION = ("simulate", "render", "perceive", "agents")  # stages
SMALL = ("--frames", "8", "--particles", "1000", "--resolution", "96", "--max-iterations", "1")
AIM = 0.5  # greatest share of the first result's time that compilation may have
ITERATION_AIM = 10.0  # most seconds of an iteration
PLAN_AIM = 0.5  # most seconds of a plan
SENTENCES = (JOB[3], "the robot raises its left arm")
PLAN = """import contextlib, os, sys, time
from physagent_jax.cli import main
def plan(*options):
    begun = time.perf_counter()
    with open(os.devnull, "w") as silent, contextlib.redirect_stdout(silent):
        failed = main(["plan", *options])
    return sys.exit(failed) if failed else time.perf_counter() - begun
plan("--object", sys.argv[1], "--prompt", "push it to the left")
print(plan("--object", sys.argv[2], "--prompt", sys.argv[3]))
"""  # of another object first, which imports what a plan needs
PARTS = ("first", "iteration", "clips", "plan", "meshes")


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure how long the first result takes, and the next."""

    json: Path = RAW / "startup.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["first", "iteration", "clips", "plan", "meshes"], ...] = PARTS
    """The job of `make demo`, one iteration of the loop, the first clips of all first results, plans, and mesh
    obstacles."""
    data: Path | None = None
    """Folder of objects that are not bundled and cannot be made."""
    rounds: int = 3
    """Pairs of a cold and a warm run, iterations, and pairs of plans; quick: one."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    rounds, small = (1, SMALL) if command.quick else (command.rounds, ())
    parts = {
        "first": lambda: [
            Job(f"round {n + 1}", partial(_measure_first, n, (*JOB, *small))) for n in range(rounds)
        ],
        "iteration": lambda: [Job("iterations", partial(_measure_iterations, rounds, small))],
        "clips": lambda: clips.list_jobs(
            command.data, (*JOB, *small), small, every=6 if command.quick else 1
        ),
        "plan": lambda: [
            Job(f"plans of {text!r}, round {n + 1}", partial(_measure_plans, n, text))
            for n in range(rounds)
            for text in SENTENCES
        ],
        "meshes": lambda: meshes.list_jobs(command.quick),
    }
    return harness.main(command, parts, PAGE)


def _measure_first(number: int, job: tuple[str, ...]) -> Rows:
    """A cold and a warm run."""
    with tempfile.TemporaryDirectory() as folder:
        states = ("cold", "warm")
        return [{"round": number, "programs": state, **run(job, Path(folder))} for state in states]


def _measure_iterations(rounds: int, options: tuple[str, ...]) -> Rows:
    """Warm runs of one iteration each, with a solid ring in place of the robot."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        trimesh.creation.torus(major_radius=0.35, minor_radius=0.15).export(folder / "ring.obj")
        job = ("--object", str(folder / "ring.obj"), *LARGEST, *options)
        run(job, folder)  # compiles
        return [{"round": number, **run(job, folder)} for number in range(rounds)]


def _measure_plans(number: int, sentence: str) -> Rows:
    """The first plan of an object, and one that finds its parts on disk."""
    with tempfile.TemporaryDirectory() as name:
        box = Path(name) / "box.obj"
        trimesh.creation.box().export(box)
        return [
            {"round": number, "parts": parts, "sentence": sentence, **_time_plan(sentence, box)}
            for parts in ("found", "on disk")
        ]


def _time_plan(sentence: str, other: Path) -> Row:
    """The row of a plan of the robot in a new process, after one of another object."""
    done = subprocess.run(
        [sys.executable, "-c", PLAN, str(other), str(OBJECT), sentence],
        env=_isolate(other.parent),
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        sys.exit(f"physagent plan failed:\n{done.stderr}")
    return {"seconds": round(float(done.stdout), 3)}


def _isolate(folder: Path) -> dict[str, str]:
    """The environment of a process that keeps all it can find again in ``folder``."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache")}
    for name in ("NUMBA_CACHE_DIR", "JAX_COMPILATION_CACHE_DIR"):
        environment.pop(name, None)
    return environment


def run(job: tuple[str, ...], folder: Path) -> Row:
    """The row of one run, whose compiled programs are kept in ``folder``."""
    out, load = folder / "run", os.getloadavg()[0]
    begun = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "physagent_jax", "run", *job, "--out", str(out), "--overwrite", "--json"],
        env=_isolate(folder),
        capture_output=True,
        text=True,
    )
    seconds = time.perf_counter() - begun
    if done.returncode != 0:
        sys.exit(f"physagent run {' '.join(job)} failed:\n{done.stderr}")
    told = json.loads(done.stdout)
    stages = {stage: round(took, 2) for stage, took in told["wall_s"].items() if stage != "total"}
    row = {"seconds": round(seconds, 2), "stages": stages, "load_average": round(load, 2)}
    sizes = {"particles": told["particle_count"], "frames": told["frames"], "substeps": told["substeps"]}
    harness.say(str(row))
    return {**row, **sizes}


def summary(rows: list[dict]) -> dict:
    """Medians and ranges of the whole, and what compilation adds."""
    found = {}
    for state in ("cold", "warm"):
        seconds = [row["seconds"] for row in rows if row["programs"] == state]
        found[state] = {"median": statistics.median(seconds), "range": [min(seconds), max(seconds)]}
    cold, warm = found["cold"]["median"], found["warm"]["median"]
    return {**found, "share_of_compilation": round(1 - warm / cold, 3), "aim": AIM}


def iteration(rows: list[dict]) -> dict:
    """Median and range of the seconds of an iteration, of how many particles."""
    seconds = [round(sum(row["stages"][stage] for stage in ITERATION), 2) for row in rows]
    found = {"median": statistics.median(seconds), "range": [min(seconds), max(seconds)]}
    sizes = {"particles": rows[0]["particles"], "frames": rows[0]["frames"]}
    return {**found, "aim": ITERATION_AIM, **sizes}


def write_tables(result: harness.Result) -> harness.Tables:
    """The tables of docs/startup.md."""
    tables = {"runs": provenance(result, PARTS)}
    if "first" in result:
        tables |= _write_first_result(result["first"]["rows"])
    if "iteration" in result:
        tables |= _write_iteration(result["iteration"]["rows"])
    if "clips" in result:
        tables |= clips.write_tables(result["clips"]["rows"])
    if "plan" in result:
        tables["plan"] = _write_plans(result["plan"]["rows"])
    if "meshes" in result:
        tables["meshes"] = meshes.write_table(result["meshes"]["rows"])
    return tables


def _write_first_result(rows: Rows) -> harness.Tables:
    found, stages = summary(rows), list(rows[0]["stages"])
    medians = [
        (state, f"{found[state]['median']:.1f}", _format_range(found[state])) for state in ("cold", "warm")
    ]
    share = f"Compilation is {found['share_of_compilation']:.0%} of the first result's time (aim: at most {AIM:.0%})."
    lines = []
    for row in rows:
        parts = [row["stages"][stage] for stage in stages]
        numbers = [f"{part:.1f}" for part in (*parts, row["seconds"] - sum(parts), row["seconds"])]
        lines.append([row["round"] + 1, row["programs"], *numbers])
    return {
        "first": table(("programs", "median [s]", "range [s]"), medians) + f"\n{share}\n",
        "stages": table(("round", "programs", *stages, "rest", "all"), lines),
    }


def _write_iteration(rows: Rows) -> harness.Tables:
    found, stages = iteration(rows), list(rows[0]["stages"])
    text = f"""A solid ring of {found["particles"]:,} particles, {found["frames"]} frames, preset fast. Once all is
compiled, simulating, rendering, perceiving and deciding take **{found["median"]:.1f} s** ({_format_range(found)};
aim: at most {found["aim"]:.0f}).
"""
    lines = [
        [row["round"] + 1, *(f"{row['stages'][stage]:.1f}" for stage in stages), row["substeps"]]
        for row in rows
    ]
    return {"iteration": text + table(("round", *stages, "substeps"), lines)}


def _write_plans(rows: Rows) -> str:
    lines = []
    for sentence in SENTENCES:
        for parts in ("found", "on disk"):
            seconds = [row["seconds"] for row in rows if (row["sentence"], row["parts"]) == (sentence, parts)]
            spread = f"{min(seconds):.2f} to {max(seconds):.2f}"
            lines.append((sentence, parts, f"{statistics.median(seconds):.2f}", spread))
    return table(("sentence", "parts", f"median [s] (aim: at most {PLAN_AIM})", "range [s]"), lines)


PAGE = Page("startup", "python -m benchmarks.startup", write_tables, ("physagent_jax",))


def _format_range(found: dict) -> str:
    low, high = found["range"]
    return f"{low:.1f} to {high:.1f}"


if __name__ == "__main__":
    sys.exit(main())
