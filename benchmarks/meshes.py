"""Costs of sampling closed meshes as obstacles, each in a process of its own."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import trimesh

from benchmarks import harness
from benchmarks.harness import Job, Row, Rows, table
from physagent_jax.scene.signed_distance import sample

CELLS, QUICK_CELLS = 128, 32


def _make_cube(side: float, turn: float = 0.0) -> trimesh.Trimesh:
    cube = trimesh.creation.box((side,) * 3)
    return cube.apply_transform(trimesh.transformations.euler_matrix(turn, 0.6 * turn, 1.6 * turn))


def _make_ball(subdivisions: int) -> trimesh.Trimesh:
    return trimesh.creation.icosphere(subdivisions=subdivisions, radius=0.45)


SOLIDS: dict[str, Callable[[], trimesh.Trimesh]] = {
    "cube, half the domain": partial(_make_cube, 0.5),
    "cube, three quarters": partial(_make_cube, 0.75),
    "cube, the domain": partial(_make_cube, 1.0),
    "cube, the domain, turned": partial(_make_cube, 1.0, 0.5),
    "ball, 0.9 of the domain": partial(_make_ball, 6),
    "ball, finer": partial(_make_ball, 7),
    "ring": lambda: trimesh.creation.torus(0.32, 0.13, major_sections=320, minor_sections=160),
    "cylinder of slivers": lambda: trimesh.creation.cylinder(radius=0.4, height=0.9, sections=25_000),
}


def list_jobs(quick: bool) -> list[Job]:
    """A job for each solid."""
    names = list(SOLIDS)[: 1 if quick else None]
    return [Job(name, partial(_measure, name, QUICK_CELLS if quick else CELLS)) for name in names]


def write_table(rows: Rows) -> str:
    """Seconds and memory of each solid."""
    lines = [
        [
            row["solid"],
            f"{row['triangles']:,}",
            f"{row['samples']:,}",
            f"{row['seconds']:.2f}",
            row["added_mb"],
        ]
        for row in rows
    ]
    return table(("solid", "triangles", "samples", "processor time [s]", "memory [MB]"), lines)


def _measure(name: str, cells: int) -> Rows:
    command = [sys.executable, "-m", "benchmarks.meshes", name, str(cells)]
    for _ in range(2):  # the first may have compiled the kernel
        told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    row: Row = json.loads(told)
    harness.say(str(row))
    return [row]


def _sample(name: str, cells: int) -> Row:
    """The row of one solid: processor time of sampling it, and what the greatest memory grew by."""
    triangles = np.asarray(SOLIDS[name]().triangles) + 0.5
    sample(
        np.asarray(trimesh.creation.box((0.5,) * 3).triangles) + 0.5, 0.25, 0.0, 1.0, name
    )  # loads the kernel
    before, begun = _read_peak(), time.process_time()
    phi, _ = sample(triangles, 1 / cells, 0.0, 1.0, name)
    seconds = time.process_time() - begun
    sizes = {"solid": name, "cells": cells, "triangles": len(triangles), "samples": phi.size}
    return {**sizes, "seconds": round(seconds, 3), "added_mb": round(_read_peak() - before)}


def _read_peak() -> float:
    """The greatest memory that this process has held [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


if __name__ == "__main__":
    print(json.dumps(_sample(sys.argv[1], int(sys.argv[2]))))
