"""Measurements of our simulator alone: its stages and a whole job."""

from __future__ import annotations

import importlib
import time
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.peers.drop import FRAME_DT, FRAMES
from benchmarks.peers.ours import Ours, build
from benchmarks.peers.scene import PeerScene
from physagent_jax.mpm import cell_order, simulate
from physagent_jax.mpm.frame import advance
from physagent_jax.mpm.grid_update import update_grid

_TOGETHER = 20  # substeps that `stages` times as one call


def stages(ours: Ours, repeats: int) -> dict[str, float]:
    """Median milliseconds of each stage function of `mpm.step`, jitted alone, on the present state.

    A substep of a warm run is timed beside them. The stress comes with the return mapping, as in a substep, and alone.
    """
    stage: Any = importlib.import_module(
        "physagent_jax.mpm.step"
    )  # its name in the package is the function's
    model, state = ours.model, ours.state
    timed: dict[str, float] = {}

    def grid_update(model, state, nodes):
        return update_grid(model, state, nodes)[-1]

    def measure(name, function, *arguments, share=1):
        jitted = jax.jit(function)
        result = jax.block_until_ready(jitted(model, *arguments))
        samples = []
        for _ in range(repeats):
            begun = time.perf_counter()
            jax.block_until_ready(jitted(model, *arguments))
            samples.append(time.perf_counter() - begun)
        timed[name] = 1e3 * float(np.median(samples)) / share
        return result

    measure("stress alone", stage.kirchhoff_stress, state)
    nodes, _ = measure("p2g", stage.scatter, state, state, stage.kirchhoff_stress(model, state))
    velocity = measure("grid update", grid_update, state, nodes)
    moved = measure("g2p", stage.gather, state, velocity)
    measure("projection and stress", stage.respond, moved.F, state.history)
    measure("substep", advance, state, jnp.int32(_TOGETHER), share=_TOGETHER)
    return timed


def job(
    scene: PeerScene,
    frames: int = FRAMES,
    frame_dt: float | None = None,
    *,
    sort: bool = True,
    out: str | None = None,
) -> dict[str, Any]:
    """A clip of ``frames`` frames after the initial one, by `mpm.simulate` with its own choice of step.

    Args:
        scene: What is simulated, in the precision of its positions.
        frames: How many.
        frame_dt: [s]; None = that of the dropped cube.
        sort: Whether particles are sorted first, as compiling a scene does.
        out: A file for the positions of every frame, shape (frames + 1, n, 3), in the scene's order.

    Returns:
        Wall seconds, substeps, redone frames, the smallest and largest step [s], and the height of the mass
        centre at every frame [m].
    """
    order = cell_order(scene.x, scene.dx) if sort else np.arange(scene.particle_count)
    model, state = build(scene.take(order))
    begun = time.perf_counter()
    heights, substeps, steps, retries, paths = [], 0, [], 0, []
    for frame in simulate(model, state, frame_count=frames + 1, frame_dt=frame_dt or FRAME_DT):
        x = np.asarray(frame.state.x)
        heights.append(float(x[:, 2].mean(dtype=float)))
        paths += [x] if out else []
        substeps += frame.substeps
        retries += len(frame.retries)
        steps += [frame.dt] if frame.index else []
    seconds = time.perf_counter() - begun
    if out:
        np.save(out, np.stack(paths)[:, np.argsort(order)])
    found = dict(seconds=seconds, substeps=substeps, redone=retries)
    return found | dict(least_dt=min(steps), largest_dt=max(steps), heights=heights)
