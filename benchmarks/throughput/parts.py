"""What each part measures: every function yields rows, groups of contenders at a time."""

from __future__ import annotations

import dataclasses
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

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

Rows = list[dict[str, Any]]
Tell = Callable[[str], None]

DEFAULT = Material.NEO_HOOKEAN  # our default jelly; that of every peer is fixed corotated


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


def row_of(group: str, contender: Contender, particles: int, **rest: Any) -> dict[str, Any]:
    empty = {"milliseconds": None, "message": "", "note": "", "load_average": None}
    about = {"code": contender.label, "law": contender.law.value, "threads": contender.threads}
    return {"group": group, **about, "particles": particles, "cells": CELLS, **empty, **rest}
