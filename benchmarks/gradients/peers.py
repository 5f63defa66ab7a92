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


def measure_peers(particles: int, steps: int, cores: int, order: str, repeats: int) -> list[Row]:
    """Ours and the peers' that are there, one after another, given the particles in ``order``."""
    rows: list[Row] = []
    scene = make_scene(particles)
    if order == "sorted":
        scene = scene.take(cell_order(scene.x, scene.dx))
    with tempfile.TemporaryDirectory() as folder:
        stored = Path(folder) / "scene.npz"
        scene.save(stored)
        for code in CODES:
            python = sys.executable if code == "ours" else os.environ.get(PYTHON_VARIABLE, sys.executable)
            command = [
                python,
                "-m",
                "benchmarks.peers.gradient",
                "--code",
                code,
                "--scene",
                str(stored),
                "--dt",
                "1e-4",
            ]
            command += ["--steps", str(steps), "--repeats", str(repeats), "--threads", str(cores)]
            done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
            if done.returncode != 0:
                harness.say(f"{code} is left out: {(done.stderr or done.stdout).strip().splitlines()[-1]}")
                continue
            rows.append(json.loads(done.stdout.strip().splitlines()[-1]))
    ours = rows[0]
    for row in rows:
        seconds = row.pop("seconds")
        row |= {"seconds": float(np.median(seconds)), "range": [min(seconds), max(seconds)], "cores": cores}
        row["order"] = order
        row |= {"particles": particles, "substeps": steps, "ratio": row["seconds"] / ours["seconds"]}
        a, b = np.asarray(row["gradient"]), np.asarray(ours["gradient"])
        row["cosine"] = float(a @ b / np.sqrt((a @ a) * (b @ b)))
        harness.say(str(row))
    return rows
