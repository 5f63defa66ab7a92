"""The same gradient by Warp's tape and by Taichi's automatic differentiation."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks import harness
from benchmarks.gradients.cube import make_scene
from benchmarks.harness import Row
from benchmarks.peers.base import PYTHON_VARIABLE
from benchmarks.peers.gradient import CODES
from physagent_jax.mpm import cell_order

ROOT = Path(__file__).resolve().parents[2]
ORDERS = ("sorted", "random")
"""Of the particles that every code is given: by cell, or as they were drawn. Ours sorts them in any case."""
ROUNDS = 3  # in which the codes take turns, each in a new process: a machine is not equally fast for minutes


def measure_peers(
    particles: int, steps: int, cores: int, order: str, repeats: int, rounds: int = ROUNDS
) -> list[Row]:
    """Ours and the peers' that are there, given the particles in ``order``; a ratio is the median over the rounds."""
    scene = make_scene(particles)
    if order == "sorted":
        scene = scene.take(cell_order(scene.x, scene.dx))
    made: dict[str, list[Row]] = {}
    with tempfile.TemporaryDirectory() as folder:
        stored = Path(folder) / "scene.npz"
        scene.save(stored)
        options = ["--scene", str(stored), "--dt", "1e-4", "--steps", str(steps), "--threads", str(cores)]
        options += ["--repeats", str(repeats)]
        for number in range(rounds):
            for code in CODES if number == 0 else tuple(made):
                row = _run(code, options)
                if row is not None:
                    made.setdefault(code, []).append(row)
    ours = made["ours"]
    rows = [_summarise(each, ours) for each in made.values() if len(each) == rounds]
    rows = [
        row | {"cores": cores, "order": order, "particles": particles, "substeps": steps, "rounds": rounds}
        for row in rows
    ]
    for row in rows:
        harness.say(str(row))
    return rows


def _run(code: str, options: list[str]) -> Row | None:
    """What a process that runs ``code`` prints; None if it fails."""
    python = sys.executable if code == "ours" else os.environ.get(PYTHON_VARIABLE, sys.executable)
    command = [python, "-m", "benchmarks.peers.gradient", "--code", code, *options]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        harness.say(f"{code} is left out: {(done.stderr or done.stdout).strip().splitlines()[-1]}")
        return None
    return json.loads(done.stdout.strip().splitlines()[-1])


def _summarise(rounds: list[Row], ours: list[Row]) -> Row:
    """One code's rounds as one row, beside ours."""
    seconds = [each for row in rounds for each in row["seconds"]]
    ratios = [
        float(np.median(row["seconds"]) / np.median(own["seconds"]))
        for row, own in zip(rounds, ours, strict=True)
    ]
    a, b = np.asarray(rounds[0]["gradient"]), np.asarray(ours[0]["gradient"])
    return rounds[0] | {
        "seconds": float(np.median(seconds)),
        "range": [min(seconds), max(seconds)],
        "ratio": float(np.median(ratios)),
        "ratio_range": [min(ratios), max(ratios)],
        "cosine": float(a @ b / np.sqrt((a @ a) * (b @ b))),
    }
