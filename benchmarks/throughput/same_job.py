"""The whole job, strictly: one law, equal threads, one order of particles, and how far the end is from the truth.

Every code runs the clip of `benchmarks.peers.flight` at the customary step and at its own bound: the shortest step that
our automatic choice takes in the clip, times what the code's stress form allows. The truth is ours in float64 with
finer cells and the shorter steps that go with them, refined until that changes less than a tenth of the errors.
"""

from __future__ import annotations

import json
import math
import os
import statistics
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.harness import Job, Row, Rows, say
from benchmarks.peers.base import PEERS
from benchmarks.peers.drop import DT
from benchmarks.peers.flight import CELLS, FRAME_DT, FRAMES, block_means, flight
from benchmarks.peers.scene import Material
from benchmarks.throughput.measure import Child, ChildError, Contender, open_child
from benchmarks.throughput.parts import THREADS, Sizes
from physagent_jax.mpm import cell_order
from physagent_jax.mpm.timestep import CLASSICAL_SHARE

LAW = Material.NEO_HOOKEAN  # of those that all codes have, the one that gains us least
SHARES = {"warp_classical": CLASSICAL_SHARE}  # of the bound of the MLS form, which the others have
ENOUGH = 0.1  # of the errors compared, that the reference may change
GRANULE = 5  # Genesis advances by several substeps at a call: those of a frame are a multiple of this
SHORT = 5.0  # [s]; a shorter job is run three times, for the median
PEER_LEVELS = (2, 3)  # times as many cells, of the peer that is to tend to the same end
FIRST = "reference"  # the job that the others need


def jobs(sizes: Sizes, rows_file: Path) -> list[Job]:
    """The reference, a peer's own way towards it, and every code at its steps; later jobs read ``rows_file``."""
    found = [Job(FIRST, partial(_make_reference, sizes))]
    found += [
        Job(f"warp_classical, {finer} x finer", partial(_measure_finer_peer, finer, rows_file))
        for finer in PEER_LEVELS
        if finer < sizes.finer[-1]
    ]
    for threads in sizes.threads:
        for order in ("sorted", "random"):
            for code in ("ours", *PEERS):
                for step in ("customary", "bound", *(["automatic"] if code == "ours" else [])):
                    if threads in THREADS.get(code, sizes.threads):
                        contender = Contender(code, LAW, threads, order=order)
                        name = f"{code}, {threads} threads, {order}, {step}"
                        found.append(Job(name, partial(_time_contender, contender, step, rows_file)))
    return found


def _make_reference(sizes: Sizes) -> Rows:
    """Ours in float64, finer and finer, until that changes less than `ENOUGH` of the coarsest one's error."""
    rows, means = [], []
    for finer in sizes.finer:
        contender = Contender("ours", LAW, sizes.most_threads, double=True)
        row = _make_blank_row(contender, "automatic", finer)
        with tempfile.TemporaryDirectory() as folder, open_child(contender) as child:
            clip = _run_adaptive(child, contender, finer, Path(folder), np.float64)
            row |= clip[0]
            means.append(clip[1])
        row["change"] = _measure_distance(means[-1], means[-2]) if len(means) > 1 else None
        rows.append(row)
        say(f"reference, {row['cells']} cells: changes by {row['change']} m")
        if row["change"] and row["change"] < ENOUGH * _measure_distance(means[0], means[-1]):
            break
    for row, mean in zip(rows, means):
        row["error"] = _measure_distance(mean, means[-1])
    rows[-1] |= {"means": _pack(means[-1]), "error": None}
    return rows


def _measure_finer_peer(finer: int, rows_file: Path) -> Rows:
    """A peer with another stress form, which tends to the same end: the reference is not ours alone."""
    contender = Contender("warp_classical", LAW, 1, order="sorted")
    return _measure_row(contender, "bound", finer, rows_file, repeats=1)


def _time_contender(contender: Contender, step: str, rows_file: Path) -> Rows:
    return _measure_row(contender, step, 1, rows_file, repeats=3)


def _measure_row(contender: Contender, step: str, finer: int, rows_file: Path, repeats: int) -> Rows:
    """The row of one code and step; what fails keeps its row, with the reason."""
    row, seconds = _make_blank_row(contender, step, finer), []
    truth, bound = _read_reference(rows_file)
    with tempfile.TemporaryDirectory() as folder, open_child(contender) as child:
        try:
            while not seconds or (seconds[-1] < SHORT and len(seconds) < repeats):
                if step == "automatic":
                    found, means = _run_adaptive(child, contender, finer, Path(folder), np.float32)
                else:
                    share = SHARES.get(contender.code, 1.0)
                    dt = _fit_step(DT if step == "customary" else bound * share / finer)
                    found, means = _run_fixed(child, contender, finer, dt, Path(folder))
                row |= found
                seconds.append(found["seconds"])
            row |= {"seconds": statistics.median(seconds), "range": [min(seconds), max(seconds)]}
            row["error"] = _measure_distance(means, truth)
            if not math.isfinite(row["error"]):
                row |= {"error": None, "message": "breaks down: positions are not finite"}
        except ChildError as error:
            row["message"] = str(error)
    row["load_average"] = round(os.getloadavg()[0], 2)
    say(
        f"{row['code']}, {row['threads']} thread(s), {row['order']}, {step}, {row['cells']} cells: "
        + _describe(row)
    )
    return [row]


def _run_adaptive(
    child: Child, contender: Contender, finer: int, folder: Path, dtype: type
) -> tuple[Row, np.ndarray]:
    """Ours with its automatic step, warm where it was run before, and the block means of every frame."""
    scene, back = _write_scene(contender, finer, folder, dtype)
    request = dict(scene=scene, frames=FRAMES, frame_dt=FRAME_DT)
    cold = child.ask("job", **request) if finer == 1 else None
    warm = child.ask("job", **request, out=str(folder / "x.npy"))
    x = np.load(folder / "x.npy", mmap_mode="r")
    means = np.stack([block_means(frame[back]) for frame in x[1:]])
    found = {key: warm[key] for key in ("seconds", "substeps", "least_dt", "largest_dt")}
    return found | ({"setup_seconds": cold["seconds"] - warm["seconds"]} if cold else {}), means


def _run_fixed(
    child: Child, contender: Contender, finer: int, dt: float, folder: Path
) -> tuple[Row, np.ndarray]:
    """A code with a fixed step, from loading to the end of the clip."""
    scene, back = _write_scene(contender, finer, folder, np.float32)
    steps, seconds, means = round(FRAME_DT / dt), 0.0, []
    loaded = child.ask("load", scene=scene, dt=dt, granule=steps)
    setup = loaded["seconds"]
    for _ in range(FRAMES):
        took = child.ask("run", steps=steps)
        seconds += took["seconds"] - took["compile_seconds"]
        setup += took["compile_seconds"]
        child.ask("positions", out=str(folder / "x.npy"))
        means.append(block_means(np.load(folder / "x.npy")[back]))
    found = {"seconds": seconds, "substeps": FRAMES * steps, "setup_seconds": setup}
    return found | {"least_dt": dt, "largest_dt": dt, "version": loaded["version"]}, np.stack(means)


def _write_scene(contender: Contender, finer: int, folder: Path, dtype: type) -> tuple[str, np.ndarray]:
    """The file with the contender's scene, and the places of the lattice's particles in it."""
    scene, path = flight(finer, contender.law, dtype), folder / "scene.npz"
    order = np.arange(scene.particle_count)
    if contender.order == "sorted":
        order = cell_order(scene.x, scene.dx)
    elif contender.order == "random":
        order = np.random.default_rng(0).permutation(order)
    scene.take(order).save(path)
    return str(path), np.argsort(order)


def _fit_step(dt: float) -> float:
    """The longest step up to ``dt`` of which a multiple of `GRANULE` makes a frame [s]."""
    return FRAME_DT / (GRANULE * math.ceil(FRAME_DT / dt / GRANULE - 1e-9))


def _read_reference(rows_file: Path) -> tuple[np.ndarray, float]:
    """The reference's block means, and the shortest step that ours took on the coarsest grid [s].

    Raises:
        ValueError: There is no reference yet.
    """
    rows = json.loads(rows_file.read_text())["same_job"]["rows"]
    levels = [row for row in rows if row["job"] == FIRST]
    if not levels:
        raise ValueError(f"run the job {FIRST!r} first: without --only, or with --only {FIRST}")
    means = np.array(levels[-1]["means"].split(), float).reshape(FRAMES, -1, 3)
    return means, levels[0]["least_dt"]


def _pack(means: np.ndarray) -> str:
    """One line of JSON instead of hundreds."""
    return " ".join(f"{value:.9g}" for value in means.ravel())


def _measure_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square distance of the blocks over all frames but the initial one [m]."""
    return float(np.sqrt(((one - other) ** 2).sum(-1).mean()))


def _make_blank_row(contender: Contender, step: str, finer: int) -> Row:
    figures = ("seconds", "range", "substeps", "least_dt", "largest_dt", "setup_seconds", "error", "change")
    about = {"code": contender.code, "law": contender.law.value, "threads": contender.threads}
    about |= {"order": contender.order, "step": step, "double": contender.double}
    about |= {"cells": CELLS * finer, "particles": (24 * finer) ** 3}
    return about | dict.fromkeys(figures) | {"version": "", "message": "", "load_average": None}


def _describe(row: Row) -> str:
    return row["message"] or f"{row['seconds']:.3g} s, off by {1e3 * row['error']:.3g} mm"
