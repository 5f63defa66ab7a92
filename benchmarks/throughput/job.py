"""The whole job: what a clip costs, and how far it is from a finer one."""

from __future__ import annotations

import contextlib
import os
import statistics
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import Job, Row, Rows, say
from benchmarks.peers.drop import CELLS, DT, FRAME_DT
from benchmarks.peers.scene import Material
from benchmarks.throughput.measure import Child, ChildError, Contender, open_child, store
from benchmarks.throughput.parts import DEFAULT, Sizes, row_of

FINER = 1.5  # times as many cells along the domain, for the reference of the error
CHUNK = 50  # substeps by which a peer's seconds are extrapolated, five times


def job(sizes: Sizes) -> list[Job]:
    """Cost of a whole clip: ours with the automatic step, peers with the customary fixed one."""
    jobs = [
        Job(f"ours, {law.value}", partial(_measure_own_job, law, sizes)) for law in (DEFAULT, Material.JELLY)
    ]
    for code, law, threads in (
        ("warp_classical", Material.JELLY, 1),
        ("warp_classical", DEFAULT, 1),
        ("taichi_mls", Material.JELLY, sizes.most_threads),
    ):
        jobs.append(
            Job(f"{code}, {law.value}", partial(_measure_peer_job, Contender(code, law, threads), sizes))
        )
    return jobs


def error(sizes: Sizes) -> list[Job]:
    """Error of the same clip against a finer one: heights of the mass centre, every substep run, nothing timed.

    The reference is ours with `FINER` times the cells and as many particles in each.
    """
    finest = dict(particles=round(FINER**3 * sizes.main), cells=round(FINER * CELLS))
    label = f"ours, {finest['cells']} cells"
    return [
        Job("reference", partial(_measure_own_heights, sizes, label=label, **finest)),
        Job("ours", partial(_measure_own_heights, sizes, particles=sizes.main, cells=CELLS)),
        Job("warp_classical", partial(_measure_peer_heights, sizes, particles=sizes.main, cells=CELLS)),
    ]


@contextlib.contextmanager
def _open_child_with(
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


def _measure_own_job(law: Material, sizes: Sizes) -> Rows:
    contender = Contender("ours", law, sizes.most_threads)
    row = row_of("job", contender, sizes.main, seconds=None, extrapolated=False)
    with _open_child_with(row, contender, sizes.main, CELLS) as (child, scene):
        cold = child.ask("job", scene=scene, frames=sizes.frames)
        warm = child.ask("job", scene=scene, frames=sizes.frames)
        row |= warm | {"setup_seconds": cold["seconds"] - warm["seconds"]}
    say(f"job, ours, {law.value}: {row['message'] or row['seconds']} s")
    return [row]


def _measure_peer_job(contender: Contender, sizes: Sizes) -> Rows:
    """A peer's row, extrapolated from a part of the substeps."""
    row = row_of("job", contender, sizes.main, seconds=None, extrapolated=True)
    total = round(FRAME_DT / DT) * sizes.frames
    row |= {"substeps": total, "least_dt": DT, "largest_dt": DT, "measured_substeps": 5 * CHUNK}
    with _open_child_with(row, contender, sizes.main, CELLS) as (child, scene):
        row["setup_seconds"] = child.ask("load", scene=scene, dt=DT)["seconds"]
        took = [child.ask("run", steps=CHUNK)["seconds"] / CHUNK for _ in range(5)]
        row["seconds"] = total * statistics.median(took)
    say(f"job, {contender.label}, {contender.law.value}: {row['message'] or row['seconds']} s")
    return [row]


def _measure_own_heights(sizes: Sizes, particles: int, cells: int, label: str = "ours") -> Rows:
    contender = Contender("ours", Material.JELLY, sizes.most_threads)
    row = row_of("error", contender, particles, heights=None, error=None) | {"code": label, "cells": cells}
    with _open_child_with(row, contender, particles, cells) as (child, scene):
        found = child.ask("job", scene=scene, frames=sizes.frames)
        row |= {key: found[key] for key in ("substeps", "least_dt", "largest_dt", "heights")}
    say(f"error, {label}: {row['message'] or 'done'}")
    return [row]


def _measure_peer_heights(sizes: Sizes, particles: int, cells: int) -> Rows:
    contender, frame = Contender("warp_classical", Material.JELLY, 1), round(FRAME_DT / DT)
    row = row_of("error", contender, particles, heights=None, error=None) | {"cells": cells}
    row |= {"substeps": frame * sizes.frames, "least_dt": DT, "largest_dt": DT}
    with _open_child_with(row, contender, particles, cells) as (child, scene):
        child.ask("load", scene=scene, dt=DT)
        heights = [child.ask("height")["height"]]
        for index in range(sizes.frames):
            child.ask("run", steps=frame)
            heights.append(child.ask("height")["height"])
            say(f"error, {contender.label}: frame {index + 1} of {sizes.frames}")
        row["heights"] = heights
    return [row]


def errors(rows: Rows) -> Rows:
    """The rows of `error` with their root mean square and largest deviation from the first one's heights [m]."""
    reference, *others = rows
    found = [reference]
    for row in others:
        if row["heights"] and reference["heights"]:
            deviation = np.asarray(row["heights"]) - np.asarray(reference["heights"])
            rms, largest = float(np.sqrt((deviation**2).mean())), float(np.abs(deviation).max())
            row = row | {"error": rms, "largest_error": largest}
        found.append(row)
    return found


def ratios(rows: Rows) -> Rows:
    """The rows of a job with their time over ours: with the same law, and with our default jelly."""
    mine = {row["law"]: row["seconds"] for row in rows if row["code"] == "ours"}

    def over(row: Row, law: str) -> float | None:
        return round(row["seconds"] / mine[law], 2) if row["seconds"] and mine.get(law) else None

    return [
        row | {"over_ours": over(row, row["law"]), "over_default": over(row, DEFAULT.value)} for row in rows
    ]
