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
from benchmarks.latency import SHARED, measure_latency
from benchmarks.peers.base import PYTHON_VARIABLE
from benchmarks.peers.gradient import CODES
from physagent_jax.mpm import cell_order

ROOT = Path(__file__).resolve().parents[2]
ORDERS = ("sorted", "random")
"""Orders of the particles that every code is given: by cell, or as they were drawn. Ours sorts them in any case."""
ROUNDS = 3  # in which the codes take turns, each in a new process: a machine is not equally fast for minutes


def measure_peers(
    particles: int, steps: int, cores: int, order: str, repeats: int, rounds: int = ROUNDS
) -> list[Row]:
    """Ours and the peers' that are there, given the particles in ``order``.

    Apart by whether the cores had a cache in common before and after a repeat; repeats during which that changed are
    left out.
    """
    scene = make_scene(particles)
    if order == "sorted":
        scene = scene.take(cell_order(scene.x, scene.dx))
    made: dict[str, list[Row]] = {}
    with tempfile.TemporaryDirectory() as folder:
        stored = Path(folder) / "scene.npz"
        scene.save(stored)
        options = ["--scene", str(stored), "--dt", "1e-4", "--steps", str(steps), "--threads", str(cores)]
        for number in range(rounds):
            for code in CODES if number == 0 else tuple(made):
                row = _run(code, options, repeats, cores)
                if row is not None:
                    made.setdefault(code, []).append(row)
    fixed = {"cores": cores, "order": order, "particles": particles, "substeps": steps, "rounds": rounds}
    rows = []
    for cache in ("one", "two"):
        ours = _select(made["ours"], cache)
        for code, each in made.items():
            seconds = _select(each, cache)
            if seconds and ours:
                rows.append(_summarise(each[0], seconds, ours, made["ours"][0]) | fixed | {"caches": cache})
                harness.say(f"{code}: {rows[-1]}")
    return rows


def _run(code: str, options: list[str], repeats: int, cores: int) -> Row | None:
    """Answer of a process that runs ``code``, with its times and the caches then; None if it fails."""
    python = sys.executable if code == "ours" else os.environ.get(PYTHON_VARIABLE, sys.executable)
    command = [python, "-m", "benchmarks.peers.gradient", "--code", code, *options]
    with (
        tempfile.TemporaryFile("w+") as errors,
        subprocess.Popen(
            command, cwd=ROOT, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors
        ) as process,
    ):
        assert process.stdin is not None and process.stdout is not None
        timed = []
        try:
            row = _ask(process)
            for _ in range(repeats):
                before = _find_caches(cores)
                seconds = _ask(process)["seconds"]
                timed.append((seconds, before if before == _find_caches(cores) else ""))
            process.stdin.close()
        except (BrokenPipeError, json.JSONDecodeError):  # it has ended before its time
            process.wait()
            errors.seek(0)
            harness.say(f"{code} is left out: {(errors.read().strip() or 'no word').splitlines()[-1]}")
            return None
    return row | {"timed": timed}


def _ask(process: subprocess.Popen) -> Row:
    """Let a process go on, and wait for its next line of JSON; libraries may write others."""
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write("\n")
    process.stdin.flush()
    for line in process.stdout:
        if line.startswith("{"):
            return json.loads(line)
    raise BrokenPipeError


def _find_caches(cores: int) -> str:
    """Over how many caches the cores are spread, one or two, as far as the first two tell."""
    latency = measure_latency() if cores > 1 else None
    return "one" if latency is None or latency < SHARED else "two"


def _select(rounds: list[Row], cache: str) -> list[float]:
    return [seconds for row in rounds for seconds, found in row["timed"] if found == cache]


def _summarise(first: Row, seconds: list[float], ours: list[float], our_first: Row) -> Row:
    """A code's repeats as one row, beside ours."""
    a, b = np.asarray(first["gradient"]), np.asarray(our_first["gradient"])
    return {key: value for key, value in first.items() if key != "timed"} | {
        "seconds": float(np.median(seconds)),
        "range": [min(seconds), max(seconds)],
        "repeats": len(seconds),
        "ratio": float(np.median(seconds) / np.median(ours)),
        "ratio_of_fastest": min(seconds) / min(ours),
        "cosine": float(a @ b / np.sqrt((a @ a) * (b @ b))),
    }
