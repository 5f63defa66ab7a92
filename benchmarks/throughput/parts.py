"""What each part measures: every function yields rows, groups of contenders at a time."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import statistics
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.base import PEERS
from benchmarks.peers.scene import Material
from benchmarks.throughput.measure import (
    Child,
    ChildError,
    Contender,
    Effort,
    compare,
    interleaved,
    open_child,
    store,
)
from benchmarks.throughput.scene import CELLS, DT, FRAME_DT, FRAMES

Rows = list[dict[str, Any]]
Tell = Callable[[str], None]

DEFAULT = Material.NEO_HOOKEAN  # our default jelly; that of every peer is fixed corotated
FINER = 1.5  # times as many cells along the domain, for the reference of a job
CHUNK = 50  # substeps by which a job is extrapolated, five times


@dataclasses.dataclass(frozen=True)
class Sizes:
    """How much is simulated.

    Attributes:
        main: Particles of most parts.
        grids: Particles of the part `grids`.
        sizes: Particles of the part `sizes`.
        cells: Of the part `grids`.
        frames: Of the job.
        effort: How long.
        laws: Beside the jellies, in the parts `materials` and `stages`.
        threads: Of the codes that can have several, ascending; () = one, and all.
    """

    main: int = 200_000
    grids: int = 50_000
    sizes: tuple[int, ...] = (2_000, 20_000, 50_000, 200_000, 1_000_000)
    cells: tuple[int, ...] = (64, 100, 128)
    frames: int = FRAMES
    effort: Effort = Effort()
    laws: tuple[Material, ...] = (Material.SAND, Material.METAL)
    threads: tuple[int, ...] = ()

    def __post_init__(self):
        if not self.threads:
            object.__setattr__(self, "threads", tuple(sorted({1, _cores()})))

    @property
    def most_threads(self) -> int:
        """Threads of what is measured with one number of them only."""
        return self.threads[-1]


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


QUICK = Sizes(
    main=5_000,
    grids=5_000,
    sizes=(2_000,),
    cells=(64,),
    frames=4,
    effort=Effort(rounds=2, round_seconds=0.1, least=10, slowest=0.5),
    laws=(Material.METAL,),
    threads=(1,),
)


def materials(sizes: Sizes, tell: Tell) -> Iterator[Rows]:
    """Law by law at one size, with one thread and with all."""
    ours = [Contender("ours", law, n) for law in (DEFAULT, Material.JELLY) for n in sizes.threads]
    slow = [
        Contender("ours", DEFAULT, sizes.most_threads, "reference"),
        Contender("ours", DEFAULT, sizes.most_threads, sort=False),
    ]
    yield _group("jelly", [*ours, *slow, *_peers(Material.JELLY, sizes)], sizes.main, sizes, tell)
    for law in (DEFAULT, *sizes.laws):
        mine = [Contender("ours", law, n) for n in sizes.threads]
        yield _group(law.value, [*mine, *_peers(law, sizes)], sizes.main, sizes, tell)


def growth(sizes: Sizes, tell: Tell) -> Iterator[Rows]:
    """Each code's default jelly over the number of particles."""
    for particles in sizes.sizes:
        yield _group("sizes", _defaults(sizes), particles, sizes, tell)


def grids(sizes: Sizes, tell: Tell) -> Iterator[Rows]:
    """Each code's default jelly over the cells of the domain, which dense codes visit all."""
    for cells in sizes.cells:
        yield _group("grids", _defaults(sizes), sizes.grids, sizes, tell, cells)


def stages(sizes: Sizes, tell: Tell) -> Iterator[Rows]:
    """Ours, stage by stage, each jitted alone."""
    for law in (DEFAULT, Material.JELLY, *sizes.laws):
        contender = Contender("ours", law, sizes.most_threads)
        row = _row("stages", contender, sizes.main)
        with tempfile.TemporaryDirectory() as folder, open_child(contender) as child:
            try:
                child.ask("load", scene=store(Path(folder), contender, sizes.main, CELLS)[0], dt=DT)
                child.ask("run", steps=20)  # the cube has reached the floor then
                row |= child.ask("stages", repeats=10 * sizes.effort.rounds)
            except ChildError as error:
                row["message"] = str(error)
        row["load_average"] = round(os.getloadavg()[0], 2)
        timed = (row["milliseconds"] or {}).items()
        figures = ", ".join(f"{name} {value:.3g} ms" for name, value in timed)
        tell(f"{row['law']}: {figures or row['message']}")
        yield [row]


def memory(sizes: Sizes, tell: Tell) -> Iterator[Rows]:
    """Peak memory of a fresh process of each code, with its default jelly."""
    for particles in sorted({sizes.grids, sizes.main}):
        rows = []
        for contender in _defaults(sizes):
            effort = dataclasses.replace(sizes.effort, rounds=1, round_seconds=0.0, least=10)
            rows += interleaved([contender], particles, effort, tell=tell)
        for row in rows:
            row["group"] = "memory"
            tell(f"{row['code']}, {particles}: {row['peak_mb']} MB {row['message']}")
        yield rows


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


def _peers(law: Material, sizes: Sizes) -> list[Contender]:
    """Every peer; Taichi with each number of threads, plain JAX with the most, the others have one."""
    choice = {"taichi_mls": sizes.threads, "jax_naive": sizes.threads[-1:]}
    return [Contender(code, law, n) for code in PEERS for n in choice.get(code, (1,))]


def _defaults(sizes: Sizes) -> list[Contender]:
    """Every code with its default jelly."""
    return [*(Contender("ours", DEFAULT, n) for n in sizes.threads), *_peers(Material.JELLY, sizes)]


def _group(
    name: str, contenders: list[Contender], particles: int, sizes: Sizes, tell: Tell, cells: int = CELLS
) -> Rows:
    rows = interleaved(contenders, particles, sizes.effort, cells, tell)
    compare(rows)
    for row in rows:
        row["group"] = name
        figure = row["message"] or f"{row['median_ms']:.3f} ms ({row['min_ms']:.3f} to {row['max_ms']:.3f})"
        over = row["over_default"] or row["over_ours"]
        ratio = f", {over:.2f} x ours" if over else ""
        tell(
            f"{row['code']}, {row['law']}, {row['threads']} thread(s), {particles}, {cells}^3: {figure}{ratio}"
        )
    return rows


def _row(group: str, contender: Contender, particles: int, **rest: Any) -> dict[str, Any]:
    empty = {"milliseconds": None, "message": "", "note": "", "load_average": None}
    about = {"code": contender.label, "law": contender.law.value, "threads": contender.threads}
    return {"group": group, **about, "particles": particles, "cells": CELLS, **empty, **rest}


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
    row = _row("job", contender, sizes.main, seconds=None, extrapolated=False)
    with _child_with(row, contender, sizes.main, CELLS) as (child, scene):
        cold = child.ask("job", scene=scene, frames=sizes.frames)
        warm = child.ask("job", scene=scene, frames=sizes.frames)
        row |= warm | {"setup_seconds": cold["seconds"] - warm["seconds"]}
    tell(f"job, ours, {law.value}: {row['message'] or row['seconds']} s")
    return row


def _peer_job(contender: Contender, sizes: Sizes, tell: Tell) -> dict[str, Any]:
    """A peer's row, extrapolated from a part of the substeps."""
    row = _row("job", contender, sizes.main, seconds=None, extrapolated=True)
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
    row = _row("error", contender, particles, heights=None, error=None) | {"code": label, "cells": cells}
    with _child_with(row, contender, particles, cells) as (child, scene):
        found = child.ask("job", scene=scene, frames=sizes.frames)
        row |= {key: found[key] for key in ("substeps", "least_dt", "largest_dt", "heights")}
    tell(f"error, {label}: {row['message'] or 'done'}")
    return row


def _peer_heights(sizes: Sizes, tell: Tell, particles: int, cells: int) -> dict[str, Any]:
    contender, frame = Contender("warp_classical", Material.JELLY, 1), round(FRAME_DT / DT)
    row = _row("error", contender, particles, heights=None, error=None) | {"cells": cells}
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


def job_ratios(rows: Rows) -> None:
    """Adds to the rows of a job their time over ours: with the same law, and with our default jelly."""
    mine = {row["law"]: row["seconds"] for row in rows if row["code"] == "ours"}
    for row in rows:
        for name, law in (("over_ours", row["law"]), ("over_default", DEFAULT.value)):
            known = row["seconds"] and mine.get(law)
            row[name] = round(row["seconds"] / mine[law], 2) if known else None
