"""Measurements of each part: every function yields rows, groups of contenders at a time."""

from __future__ import annotations

import dataclasses
import os
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.harness import Job, Rows, say
from benchmarks.peers.base import PEERS
from benchmarks.peers.drop import CELLS, DT, FRAMES
from benchmarks.peers.scene import Material
from benchmarks.throughput.measure import (
    ChildError,
    Contender,
    Effort,
    compare,
    interleaved,
    open_child,
    store,
)

THREADS = {"warp_classical": (1,)}  # codes that cannot have as many as one likes
DEFAULT = Material.NEO_HOOKEAN  # our default jelly; that of every peer is fixed corotated


@dataclasses.dataclass(frozen=True)
class Sizes:
    """Sizes of what is simulated.

    Attributes:
        main: Particles of most parts.
        strict: Particles of the part `same_law`.
        grids: Particles of the part `grids`.
        sizes: Particles of the part `sizes`.
        cells: Cells of the part `grids`.
        frames: Frames of the job.
        finer: Times as many cells, level by level, of the reference in the part `same_job`.
        effort: How long.
        laws: Beside the jellies, in the parts `materials` and `stages`.
        threads: Threads of the codes that can have several, ascending; () = one, and all.
    """

    main: int = 200_000
    strict: int = 100_000
    grids: int = 50_000
    sizes: tuple[int, ...] = (2_000, 20_000, 50_000, 200_000, 1_000_000)
    cells: tuple[int, ...] = (64, 100, 128)
    frames: int = FRAMES
    finer: tuple[int, ...] = (1, 2, 4, 6)
    effort: Effort = Effort()
    laws: tuple[Material, ...] = (Material.SAND, Material.METAL)
    threads: tuple[int, ...] = ()

    def __post_init__(self):
        if not self.threads:
            object.__setattr__(self, "threads", tuple(sorted({1, _count_cores()})))

    @property
    def most_threads(self) -> int:
        """Threads of what is measured with one number of them only."""
        return self.threads[-1]


def _count_cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


QUICK = Sizes(
    main=5_000,
    strict=5_000,
    grids=5_000,
    sizes=(2_000,),
    cells=(64,),
    frames=4,
    finer=(1, 2),
    effort=Effort(rounds=2, round_seconds=0.1, least=10, slowest=0.5),
    laws=(Material.METAL,),
    threads=(1,),
)


def same_law(sizes: Sizes) -> list[Job]:
    """One law that all codes have, equal threads, particles sorted by cell and in random order, for every code."""
    jobs = []
    for law in (Material.NEO_HOOKEAN, Material.JELLY):
        contenders = [
            Contender(code, law, n, order=order, floor="wall")
            for n in sizes.threads
            for order in ("sorted", "random")
            for code in ("ours", *PEERS)
            if n in THREADS.get(code, sizes.threads)
        ]
        effort = dataclasses.replace(sizes.effort, rounds=min(3, sizes.effort.rounds))
        jobs.append(Job(law.value, partial(_measure_group, law.value, contenders, sizes.strict, effort)))
    return jobs


def materials(sizes: Sizes) -> list[Job]:
    """Law by law at one size, with one thread and with all."""
    ours = [Contender("ours", law, n) for law in (DEFAULT, Material.JELLY) for n in sizes.threads]
    slow = [
        Contender("ours", DEFAULT, sizes.most_threads, "reference"),
        Contender("ours", DEFAULT, sizes.most_threads, order="random"),
    ]
    groups = {"jelly": [*ours, *slow, *_list_peers(Material.JELLY, sizes)]}
    for law in (DEFAULT, *sizes.laws):
        groups[law.value] = [*(Contender("ours", law, n) for n in sizes.threads), *_list_peers(law, sizes)]
    return [
        Job(name, partial(_measure_group, name, contenders, sizes.main, sizes.effort))
        for name, contenders in groups.items()
    ]


def growth(sizes: Sizes) -> list[Job]:
    """Each code's default jelly over the number of particles."""
    return [
        Job(
            f"{count} particles", partial(_measure_group, "sizes", _list_defaults(sizes), count, sizes.effort)
        )
        for count in sizes.sizes
    ]


def grids(sizes: Sizes) -> list[Job]:
    """Each code's default jelly over the cells of the domain, which dense codes visit all."""
    return [
        Job(
            f"{cells} cells",
            partial(_measure_group, "grids", _list_defaults(sizes), sizes.grids, sizes.effort, cells),
        )
        for cells in sizes.cells
    ]


def stages(sizes: Sizes) -> list[Job]:
    """Ours, stage by stage, each jitted alone."""
    return [
        Job(law.value, partial(_measure_stages, law, sizes)) for law in (DEFAULT, Material.JELLY, *sizes.laws)
    ]


def memory(sizes: Sizes) -> list[Job]:
    """Peak memory of a fresh process of each code, with its default jelly."""
    counts = sorted({sizes.grids, sizes.main})
    return [Job(f"{count} particles", partial(_measure_memory, count, sizes)) for count in counts]


def _measure_stages(law: Material, sizes: Sizes) -> Rows:
    contender = Contender("ours", law, sizes.most_threads)
    row = row_of("stages", contender, sizes.main)
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
    say(f"{row['law']}: {figures or row['message']}")
    return [row]


def _measure_memory(particles: int, sizes: Sizes) -> Rows:
    effort = dataclasses.replace(sizes.effort, rounds=1, round_seconds=0.0, least=10)
    rows = [
        row
        for contender in _list_defaults(sizes)
        for row in interleaved([contender], particles, effort, tell=say)
    ]
    for row in rows:
        row["group"] = "memory"
        say(f"{row['code']}, {particles}: {row['peak_mb']} MB {row['message']}")
    return rows


def _list_peers(law: Material, sizes: Sizes) -> list[Contender]:
    """Every peer; Taichi with each number of threads, plain JAX with the most, the others have one."""
    choice = {"taichi_mls": sizes.threads, "jax_naive": sizes.threads[-1:]}
    return [Contender(code, law, n) for code in PEERS for n in choice.get(code, (1,))]


def _list_defaults(sizes: Sizes) -> list[Contender]:
    """Every code with its default jelly."""
    return [*(Contender("ours", DEFAULT, n) for n in sizes.threads), *_list_peers(Material.JELLY, sizes)]


def _measure_group(
    name: str, contenders: list[Contender], particles: int, effort: Effort, cells: int = CELLS
) -> Rows:
    rows = interleaved(contenders, particles, effort, cells, say)
    compare(rows)
    for row in rows:
        row["group"] = name
        figure = row["message"] or f"{row['median_ms']:.3f} ms ({row['min_ms']:.3f} to {row['max_ms']:.3f})"
        over = row["over_default"] or row["over_ours"]
        ratio = f", {over:.2f} x ours" if over else ""
        say(
            f"{row['code']}, {row['law']}, {row['threads']} thread(s), {particles}, {cells}^3: {figure}{ratio}"
        )
    return rows


def row_of(group: str, contender: Contender, particles: int, **rest: Any) -> dict[str, Any]:
    empty = {"milliseconds": None, "message": "", "note": "", "load_average": None}
    about = {"code": contender.label, "law": contender.law.value, "threads": contender.threads}
    return {"group": group, **about, "particles": particles, "cells": CELLS, **empty, **rest}
