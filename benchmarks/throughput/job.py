"""The whole job: what a clip costs, and how far it is from a finer one."""

from __future__ import annotations

import contextlib
import os
import statistics
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.drop import CELLS, DT, FRAME_DT
from benchmarks.peers.scene import Material
from benchmarks.throughput.measure import Child, ChildError, Contender, open_child, store
from benchmarks.throughput.parts import DEFAULT, Rows, Sizes, Tell, row_of

FINER = 1.5  # times as many cells along the domain, for the reference of the error
CHUNK = 50  # substeps by which a peer's seconds are extrapolated, five times


def job(sizes: Sizes, tell: Tell) -> Iterator[Rows]:
    """What a whole clip costs: ours with the automatic step, peers with the customary fixed one."""
    for law in (DEFAULT, Material.JELLY):
        yield [_own_job(law, sizes, tell)]
    for code, law, threads in (
        ("warp_classical", Material.JELLY, 1),
        ("warp_classical", DEFAULT, 1),
        ("taichi_mls", Material.JELLY, sizes.most_threads),
    ):
        yield [_peer_job(Contender(code, law, threads), sizes, tell)]


def error(sizes: Sizes, tell: Tell) -> Iterator[Rows]:
    """How far the same clip is from a finer one: heights of the mass centre, every substep run, nothing timed.

    The reference is ours with `FINER` times the cells and as many particles in each.
    """
    finest = dict(particles=round(FINER**3 * sizes.main), cells=round(FINER * CELLS))
    reference = _own_heights(sizes, tell, label=f"ours, {finest['cells']} cells", **finest)
    yield [reference]
    for follow in (_own_heights, _peer_heights):
        row = follow(sizes, tell, particles=sizes.main, cells=CELLS)
        if row["heights"] and reference["heights"]:
            row |= _errors(row["heights"], reference["heights"])
            tell(f"error, {row['code']}: {1e3 * row['error']:.3g} mm")
        yield [row]


@contextlib.contextmanager
def _child_with(
    row: dict[str, Any], contender: Contender, particles: int, cells: int
) -> Iterator[tuple[Child, str]]:
    """A process for ``contender``, and its scene's file; if it fails, ``row`` says why."""
    with tempfile.TemporaryDirectory() as folder, open_child(contender) as child:
        scene, row["note"] = store(Path(folder), contender, particles, cells)
        try:
            yield child, scene
        except ChildError as error:
            row["message"] = str(error)
    row["load_average"] = round(os.getloadavg()[0], 2)


def _own_job(law: Material, sizes: Sizes, tell: Tell) -> dict[str, Any]:
    contender = Contender("ours", law, sizes.most_threads)
    row = row_of("job", contender, sizes.main, seconds=None, extrapolated=False)
    with _child_with(row, contender, sizes.main, CELLS) as (child, scene):
        cold = child.ask("job", scene=scene, frames=sizes.frames)
        warm = child.ask("job", scene=scene, frames=sizes.frames)
        row |= warm | {"setup_seconds": cold["seconds"] - warm["seconds"]}
    tell(f"job, ours, {law.value}: {row['message'] or row['seconds']} s")
    return row


def _peer_job(contender: Contender, sizes: Sizes, tell: Tell) -> dict[str, Any]:
    """A peer's row, extrapolated from a part of the substeps."""
    row = row_of("job", contender, sizes.main, seconds=None, extrapolated=True)
    total = round(FRAME_DT / DT) * sizes.frames
    row |= {"substeps": total, "least_dt": DT, "largest_dt": DT, "measured_substeps": 5 * CHUNK}
    with _child_with(row, contender, sizes.main, CELLS) as (child, scene):
        row["setup_seconds"] = child.ask("load", scene=scene, dt=DT)["seconds"]
        took = [child.ask("run", steps=CHUNK)["seconds"] / CHUNK for _ in range(5)]
        row["seconds"] = total * statistics.median(took)
    tell(f"job, {contender.label}, {contender.law.value}: {row['message'] or row['seconds']} s")
    return row


def _own_heights(sizes: Sizes, tell: Tell, particles: int, cells: int, label: str = "ours") -> dict[str, Any]:
    contender = Contender("ours", Material.JELLY, sizes.most_threads)
    row = row_of("error", contender, particles, heights=None, error=None) | {"code": label, "cells": cells}
    with _child_with(row, contender, particles, cells) as (child, scene):
        found = child.ask("job", scene=scene, frames=sizes.frames)
        row |= {key: found[key] for key in ("substeps", "least_dt", "largest_dt", "heights")}
    tell(f"error, {label}: {row['message'] or 'done'}")
    return row


def _peer_heights(sizes: Sizes, tell: Tell, particles: int, cells: int) -> dict[str, Any]:
    contender, frame = Contender("warp_classical", Material.JELLY, 1), round(FRAME_DT / DT)
    row = row_of("error", contender, particles, heights=None, error=None) | {"cells": cells}
    row |= {"substeps": frame * sizes.frames, "least_dt": DT, "largest_dt": DT}
    with _child_with(row, contender, particles, cells) as (child, scene):
        child.ask("load", scene=scene, dt=DT)
        heights = [child.ask("height")["height"]]
        for index in range(sizes.frames):
            child.ask("run", steps=frame)
            heights.append(child.ask("height")["height"])
            tell(f"error, {contender.label}: frame {index + 1} of {sizes.frames}")
        row["heights"] = heights
    return row


def _errors(heights: list[float], reference: list[float]) -> dict[str, float]:
    """Root mean square and largest deviation of the heights [m]."""
    deviation = np.asarray(heights) - np.asarray(reference)
    return {"error": float(np.sqrt((deviation**2).mean())), "largest_error": float(np.abs(deviation).max())}


def ratios(rows: Rows) -> None:
    """Adds to the rows of a job their time over ours: with the same law, and with our default jelly."""
    mine = {row["law"]: row["seconds"] for row in rows if row["code"] == "ours"}
    for row in rows:
        for name, law in (("over_ours", row["law"]), ("over_default", DEFAULT.value)):
            known = row["seconds"] and mine.get(law)
            row[name] = round(row["seconds"] / mine[law], 2) if known else None
