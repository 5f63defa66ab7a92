"""Price of other inertia than lumped masses: a substep and a gradient with it, over those without, in turns."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import time
from collections.abc import Callable, Mapping

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks import harness
from benchmarks.cases.base import AGGREGATED
from benchmarks.harness import Row
from benchmarks.peers.drop import SIDE, SIZE, drop
from benchmarks.peers.gradient import draw_weight
from benchmarks.peers.ours import build
from benchmarks.peers.ours_gradient import find_loss
from benchmarks.peers.scene import Material
from physagent_jax.mpm import Lumped, Schedule, Sharpened, cell_order, simulate

DT = 1e-4  # [s]
CASES = ((20_000, 100), (200_000, 20))  # particles, substeps of a run
INERTIAS: Mapping[str, Lumped | Sharpened] = {
    "lumped": Lumped(),
    "aggregated": AGGREGATED,
    "sharpened": Sharpened(),
    "both": Sharpened(aggregation=AGGREGATED.aggregation),
}
_MEMORY = 2e9  # of a reverse pass [bytes]


def measure_price(particles: int, substeps: int, threads: int, repeats: int) -> list[Row]:
    """The rows of a case, measured in a process of its own with so many cores."""
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, context) as pool:
        rows = pool.submit(_measure, particles, substeps, threads, repeats).result()
    for row in rows:
        harness.say(str(row))
    return rows


def _measure(particles: int, substeps: int, threads: int, repeats: int) -> list[Row]:
    os.sched_setaffinity(
        0, sorted(os.sched_getaffinity(0))[:threads]
    )  # before JAX and the kernels count them
    cells = round(SIZE / (SIDE * (8 / particles) ** (1 / 3)))  # eight particles in a cell
    scene = drop(particles, Material.NEO_HOOKEAN, cells)
    model, state = build(scene.take(cell_order(scene.x, scene.dx)))
    run = dict(frame_count=2, frame_dt=substeps * DT, substep_dt=DT)
    ways: dict[str, Callable[[], None]] = {}
    for name, inertia in INERTIAS.items():
        chosen = model.replace(inertia=inertia)
        schedule = Schedule.of(chosen, list(simulate(chosen, state, **run)))
        loss = find_loss(chosen, state, schedule, draw_weight(particles), _MEMORY)
        gradient, at = jax.value_and_grad(loss), jnp.ones(3, state.x.dtype)

        def go_forward(chosen=chosen):
            for frame in simulate(chosen, state, **run):
                jax.block_until_ready(frame.state.x)

        ways[f"{name}, forward"] = go_forward
        ways[f"{name}, gradient"] = lambda gradient=gradient, at=at: jax.block_until_ready(gradient(at))
    for work in ways.values():  # compiled
        work()
    samples: dict[str, list[float]] = {way: [] for way in ways}
    for _ in range(repeats):
        for way, work in ways.items():
            begun = time.perf_counter()
            work()
            samples[way].append(1e3 * (time.perf_counter() - begun) / substeps)
    rows = []
    for name in list(INERTIAS)[1:]:
        row: Row = {"particles": particles, "threads": threads, "substeps": substeps, "inertia": name}
        for kind in ("forward", "gradient"):
            pairs = samples[f"lumped, {kind}"], samples[f"{name}, {kind}"]
            ratios = sorted(other / lumped for lumped, other in zip(*pairs))
            row[f"{kind}_ms"] = [float(np.median(each)) for each in pairs]
            row[f"{kind}_ratio"] = [float(np.median(ratios)), ratios[0], ratios[-1]]
        rows.append(row)
    return rows
