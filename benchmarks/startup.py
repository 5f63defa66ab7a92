"""`python -m benchmarks.startup --json OUT [--markdown OUT] [--quick]`: how long a first result and an iteration take.

Runs the job of `make demo` in a new process: first with an empty folder for compiled programs (cold), then again with
what that run left there (warm); some rounds of both. What compilation adds is the difference of the two.

What one iteration of the loop takes (simulate, render, perceive, decide), once all is compiled, is measured with a
mesh that is filled with as many particles as ``--preset fast`` has at most.
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
from pathlib import Path

import trimesh
import tyro
from rich.console import Console

from benchmarks.machine import circumstances
from physagent_jax.core.files import write_text

OBJECT = Path(__file__).resolve().parents[1] / "examples" / "assets" / "robot.ply"
JOB = ("--object", str(OBJECT), "--prompt", "a strong wind pushes the robot to the left")
LARGEST = ("--up", "+z", "--prompt", "a strong wind pushes the ring to the left", "--max-iterations", "1")
ITERATION = ("simulate", "render", "perceive", "agents")  # stages
SMALL = ("--frames", "8", "--particles", "1000", "--resolution", "96", "--max-iterations", "1")
AIM = 0.5  # greatest share of the first result's time that compilation may have
ITERATION_AIM = 10.0  # most seconds of an iteration
console = Console(stderr=True)


@dataclasses.dataclass(frozen=True)
class Command:
    """Measure how long the first result takes, and the next."""

    json: Path
    """File to write."""
    markdown: Path | None = None
    """Also write the tables here."""
    rounds: int = 3
    """Pairs of a cold and a warm run."""
    quick: bool = False
    """One round of a small job."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    job = (*JOB, *SMALL) if command.quick else JOB
    rows = []
    for number in range(1 if command.quick else command.rounds):
        with tempfile.TemporaryDirectory() as folder:
            for state in ("cold", "warm"):
                rows.append({"round": number, "programs": state, **run(job, Path(folder))})
                console.print(rows[-1], highlight=False)
    iterations = measure_iterations(1 if command.quick else command.rounds, SMALL if command.quick else ())
    found = {
        "rows": rows,
        "summary": summary(rows),
        "iterations": iterations,
        "iteration": iteration(iterations),
    }
    report = {**circumstances(), "quick": command.quick, **found}
    write_text(command.json, json.dumps(report, indent=1) + "\n")
    if command.markdown:
        write_text(command.markdown, document(report))
    print(command.json)
    return 0


def measure_iterations(rounds: int, options: tuple[str, ...]) -> list[dict]:
    """The rows of ``rounds`` warm runs of one iteration each, with a solid ring in place of the robot."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        trimesh.creation.torus(major_radius=0.35, minor_radius=0.15).export(folder / "ring.obj")
        job = ("--object", str(folder / "ring.obj"), *LARGEST, *options)
        run(job, folder)  # compiles
        for number in range(rounds):
            rows.append({"round": number, **run(job, folder)})
            console.print(rows[-1], highlight=False)
    return rows


def run(job: tuple[str, ...], folder: Path) -> dict:
    """The row of one run, whose compiled programs are kept in ``folder``."""
    out, load = folder / "run", os.getloadavg()[0]
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache")}
    for name in ("NUMBA_CACHE_DIR", "JAX_COMPILATION_CACHE_DIR"):
        environment.pop(name, None)
    begun = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "physagent_jax", "run", *job, "--out", str(out), "--overwrite", "--json"],
        env=environment,
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


def document(report: dict) -> str:
    """The tables as Markdown."""
    found = report["summary"]
    stages = list(report["rows"][0]["stages"])
    text = f"""# How long results take

The job of `make demo`, installation excluded, in a new process: *cold* without any compiled program on disk, *warm*
with those that the run before left. Made by `{report["command"]}` on {report["machine"]},
revision {report["git_revision"]}.

| programs | median [s] | range [s] |
|---|---|---|
"""
    for state in ("cold", "warm"):
        low, high = found[state]["range"]
        text += f"| {state} | {found[state]['median']:.1f} | {low:.1f} to {high:.1f} |\n"
    text += f"""
Compilation is {found["share_of_compilation"]:.0%} of the first result's time (aim: at most {AIM:.0%}).

Seconds per stage, as the run's manifest has them. "compile" is the time that stages spent waiting for compilers or
loading what these made before, and belongs to no other stage; "rest" is Python starting up and shutting down.

| round | programs | {" | ".join(stages)} | rest | all |
|---|---|{"---|" * (len(stages) + 2)}
"""
    for row in report["rows"]:
        parts = [row["stages"][stage] for stage in stages]
        rest = row["seconds"] - sum(parts)
        numbers = " | ".join(f"{part:.1f}" for part in (*parts, rest, row["seconds"]))
        text += f"| {row['round'] + 1} | {row['programs']} | {numbers} |\n"
    return text + _iterations(report)


def _iterations(report: dict) -> str:
    found, stages = report["iteration"], list(report["iterations"][0]["stages"])
    low, high = found["range"]
    text = f"""
## An iteration of the loop

A solid ring of {found["particles"]:,} particles, {found["frames"]} frames, preset fast. Once all is compiled,
simulating, rendering, perceiving and deciding take **{found["median"]:.1f} s** ({low:.1f} to {high:.1f}; aim: at most
{found["aim"]:.0f}).
Seconds per stage of these runs, each in a new process:

| round | {" | ".join(stages)} | substeps |
|---|{"---|" * (len(stages) + 1)}
"""
    for row in report["iterations"]:
        numbers = " | ".join(f"{row['stages'][stage]:.1f}" for stage in stages)
        text += f"| {row['round'] + 1} | {numbers} | {row['substeps']} |\n"
    return text


if __name__ == "__main__":
    sys.exit(main())
