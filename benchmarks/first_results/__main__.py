"""`python -m benchmarks.first_results --json OUT --out DIR [--data DIR] [--markdown MD]`: twelve sentences.

Runs the command-line job for each sentence in a process of its own and gathers what was asked, simulated, perceived and
true, how far the two are apart, and what is odd. Real captures that are not bundled are looked for in ``--data``;
objects that are missing are left out and named.
"""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
import tyro

from benchmarks import harness
from benchmarks.first_results.markdown import document
from benchmarks.first_results.oddities import find_oddities
from benchmarks.harness import Job, Row
from physagent_jax.metrics.motion import compare
from physagent_jax.run.finished import open_run

ASSETS = Path(__file__).resolve().parents[2] / "examples" / "assets"

CASES = [
    ("robot", "a strong wind pushes the robot to the left"),
    ("robot", "hit the robot hard from the left"),
    ("robot", "spin the robot clockwise about the vertical axis"),
    ("guitar", "drop the guitar"),
    ("guitar", "stretch the guitar vertically"),
    ("guitar", "push the guitar gently to the right, then pull it up"),
    ("plant", "a strong wind bends the plant to the left, then lets go"),
    ("plant", "the plant sways left and right twice, then is still"),
    ("plant", "hit the top of the plant from the right"),
    ("cow", "squeeze the cow from both sides"),
    ("cow", "twist the cow violently"),
    ("cow", "drop the cow and push it to the right"),
]


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Run the sentences, or write the tables of an earlier run."""

    parts: tuple[Literal["sentences"], ...] = ("sentences",)
    """There is one."""
    out: Path = Path("runs/first")
    """Folder for the runs."""
    data: Path | None = None
    """Folder with guitar_sh0.ply and spot.obj."""
    frames: int | None = None
    """Shorter clips; quick: eight frames."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    objects = prepare_objects(command) if command.parts else {}
    left_out = sorted({name for name, _ in CASES} - objects.keys())
    jobs = [
        Job(f"{number}: {name}: {prompt}", partial(run_case, command, number, name, objects[name], prompt))
        for number, (name, prompt) in enumerate(CASES, 1)
        if name in objects
    ]
    return harness.main(command, {"sentences": lambda: jobs}, document, {"left_out": left_out})


def prepare_objects(command: Command) -> dict[str, list[str]]:
    """Object options of the command line, by name."""
    command.out.mkdir(parents=True, exist_ok=True)
    plant = command.out / "plant.ply"
    physagent("make", "plant", "--out", str(plant))
    objects = {"robot": ["--object", str(ASSETS / "robot.ply")], "plant": ["--object", str(plant)]}
    extra = {
        "guitar": ("guitar_sh0.ply", ["--up", "-y", "--kind", "instrument"]),
        "cow": ("spot.obj", ["--up", "+y", "--kind", "animal", "--azimuth", "-60"]),
    }
    for name, (file, options) in extra.items():
        if command.data is not None and (command.data / file).is_file():
            objects[name] = ["--object", str(command.data / file), *options]
    return objects


def run_case(command: Command, number: int, name: str, options: list[str], prompt: str) -> list[Row]:
    """One sentence: runs it in its own process and gathers the figures."""
    folder = command.out / f"{number:02d}-{name}"
    count = 8 if command.quick else command.frames
    frames = ["--frames", str(count)] if count else []
    arguments = ["--prompt", prompt, "--out", str(folder), "--overwrite", "--json", *frames]
    summary = json.loads(physagent("run", *options, *arguments))
    harness.say(f"{number:2d} {summary['verdict']:8s} {summary['wall_s']['total']:6.1f} s  {name}: {prompt}")
    run = open_run(folder)
    best = run.best
    assert best and best.motion and best.simulation and best.judgement and best.force_field, run.problems
    report, truth, judgement = best.motion, best.simulation.truth, best.judgement
    assert truth is not None
    stretch = report.windows[0].stretch
    row = {
        "number": number,
        "object": name,
        "prompt": prompt,
        "force_field": best.force_field.model_dump(mode="json", exclude_none=True),
        "perceived": report.text,
        "perceived_centroid": report.centroid[-1],
        "true_centroid": truth.centroid[-1],
        "perceived_farthest": farthest(report.centroid),
        "true_farthest": farthest(truth.centroid),
        "perceived_rotation": report.rotation_degrees[-1],
        "true_rotation": truth.rotation_degrees[-1],
        "perceived_stretch": None if stretch is None else np.diag(stretch).tolist(),
        "true_stretch": truth.stretch[-1],
        "frames": report.frame_count,
        "errors": compare(report, truth),
        "oddities": find_oddities(run),
        "verdict": summary["verdict"],
        "score": judgement.score,
        "failed_checks": [
            f"{check.question} expected {check.expected}, observed {check.observed}"
            for check in judgement.checks
            if check.passed is not True
        ],
        "iterations": summary["iterations"],
        "particle_count": summary["particle_count"],
        "substeps": summary["substeps"],
        "wall_s": summary["wall_s"],
    }
    return [row]


def farthest(path) -> tuple[float, float, float] | None:
    """The largest displacement on a path [body lengths]; None if nothing of it was observable."""
    seen = [point for point in path if point is not None]
    return max(seen, key=lambda point: sum(c * c for c in point)) if seen else None


def physagent(*arguments: str) -> str:
    """Runs the command line in a fresh process; returns its standard output."""
    done = subprocess.run([sys.executable, "-m", "physagent_jax", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"physagent {' '.join(arguments)} failed:\n{done.stderr}")
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
