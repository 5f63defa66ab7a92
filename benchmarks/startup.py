"""`python -m benchmarks.startup --json OUT [--markdown OUT] [--quick]`: how long the first result takes.

Runs the job of `make demo` in a new process: first with an empty folder for compiled programs (cold), then again with
what that run left there (warm); some rounds of both. What compilation adds is the difference of the two.
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

import tyro
from rich.console import Console

from benchmarks.machine import circumstances
from physagent_jax.output.files import write_text

OBJECT = Path(__file__).resolve().parents[1] / "examples" / "assets" / "robot.ply"
JOB = ("--object", str(OBJECT), "--prompt", "a strong wind pushes the robot to the left")
SMALL = ("--frames", "8", "--particles", "1000", "--resolution", "96", "--max-iterations", "1")
AIM = 0.5  # greatest share of the first result's time that compilation may have
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
    report = {**circumstances(), "quick": command.quick, "rows": rows, "summary": summary(rows)}
    write_text(command.json, json.dumps(report, indent=1) + "\n")
    if command.markdown:
        write_text(command.markdown, document(report))
    print(command.json)
    return 0


def run(job: tuple[str, ...], folder: Path) -> dict:
    """The row of one run, whose compiled programs are kept in ``folder``."""
    script = "import sys; from physagent_jax.cli import main; sys.exit(main())"
    out, load = folder / "run", os.getloadavg()[0]
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache")}
    for name in ("NUMBA_CACHE_DIR", "JAX_COMPILATION_CACHE_DIR"):
        environment.pop(name, None)
    begun = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", script, "run", *job, "--out", str(out), "--overwrite"],
        env=environment,
        check=True,
        capture_output=True,
    )
    seconds = time.perf_counter() - begun
    manifest = json.loads((out / "manifest.json").read_text())
    return {"seconds": round(seconds, 2), "stages": manifest["stages"], "load_average": round(load, 2)}


def summary(rows: list[dict]) -> dict:
    """Medians and ranges of the whole, and what compilation adds."""
    found = {}
    for state in ("cold", "warm"):
        seconds = [row["seconds"] for row in rows if row["programs"] == state]
        found[state] = {"median": statistics.median(seconds), "range": [min(seconds), max(seconds)]}
    cold, warm = found["cold"]["median"], found["warm"]["median"]
    return {**found, "share_of_compilation": round(1 - warm / cold, 3), "aim": AIM}


def document(report: dict) -> str:
    """The tables as Markdown."""
    found = report["summary"]
    stages = list(report["rows"][0]["stages"])
    text = f"""# How long the first result takes

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
    return text


if __name__ == "__main__":
    sys.exit(main())
