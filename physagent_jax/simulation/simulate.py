"""Simulating a compiled scene: every frame is computed, its Gaussians deformed and rendered, a few at a time.

Frames that an earlier scene has in common are taken over from its recording (`shared_frames`). That works within one
process: nothing of it is written down, so a run that was stopped and is taken up plays its next round from the start.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator

import jax
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.mpm import Frame, find_acting, simulate
from physagent_jax.render import choose_batch_size, render_all
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.simulation.recording import (
    FrameOutput,
    FrameStatistics,
    Recording,
    RestartCache,
    find_rest_centre,
)
from physagent_jax.simulation.rolling import Rolling
from physagent_jax.simulation.shared_frames import find_last_shared_frame, find_restart_frames, is_clock_right
from physagent_jax.simulation.stopwatch import Stopwatch

RESTART_BYTES = 2**30  # of host memory for what a later scene may go on from
PACE = 4  # frames by which the rest of a clip is forecast

Progress = Callable[[int, int], None]
"""Called after every frame with (frames done, frames in all)."""


def simulate_scene(
    scene: CompiledScene,
    *,
    watch: Stopwatch | None = None,
    progress: Progress | None = None,
    restart_cache: RestartCache | None = None,
    most_substeps: float = math.inf,
    foresee: bool = True,
) -> Recording:
    """Simulate and render all frames of ``scene``, except those that it shares with an earlier one.

    Args:
        scene: What to simulate.
        watch: Charged with the time that simulating and rendering take.
        progress: Called after every frame.
        restart_cache: Restart cache of the earlier scene's `Recording`.
        most_substeps: Substeps of all frames that may be taken.
        foresee: Whether it is given up as soon as the last `PACE` frames forecast more; else once they are taken.

    Raises:
        UserError: The scene cannot be simulated (`mpm.simulate` says why), or would take more substeps than it may.
    """
    watch = watch or Stopwatch()
    begin = find_shared_restart(scene, restart_cache)
    outputs, statistics, restarts = _share_frames(restart_cache, begin)
    reused, total = len(outputs), scene.config.timing.frame_count
    if progress and reused:
        progress(reused, total)
    wanted, centre = find_restart_frames(scene.config), find_rest_centre(scene)
    last, rolling = begin, Rolling.of(scene)
    for output in outputs[1:]:
        rolling.advance(output.x)
    frames = simulate_frames(scene, begin, most_substeps)
    frames = check_pace(frames, total, most_substeps) if foresee else frames
    for batch in _split_batches(watch.timed("simulate", frames)):
        with watch("render"):
            outputs += _compute_outputs(scene, batch, rolling)
        with watch("simulate"):
            for frame in batch:
                statistics.append(FrameStatistics.of(scene, frame, centre))
                if frame.index in wanted and _is_worth_keeping(scene, frame, outputs, restarts):
                    restarts[frame.index] = dataclasses.replace(frame, state=jax.device_get(frame.state))
        last = batch[-1]
        if progress:
            for frame in batch:
                progress(frame.index + 1, total)
    cache = RestartCache.of(scene, outputs, statistics, restarts)
    assert last is not None
    return Recording.of(scene, outputs, statistics, cache, last, reused)


def check_pace(frames: Iterator[Frame], total: int, most: float) -> Iterator[Frame]:
    """``frames``, until they are so slow that all ``total`` of them would take more than ``most`` substeps."""
    taken: list[int] = []
    for frame in frames:
        taken.append(frame.substeps)
        recent = taken[-PACE:]
        expected = sum(taken) + (total - 1 - frame.index) * sum(recent) / len(recent)
        if len(taken) >= PACE and expected > most:
            raise UserError(
                f"it would take some {expected:,.0f} substeps, as its matter is strained so far",
                got=f"more than {most:,.0f} at frame {frame.index}",
                do="Use a softer material or weaker forces",
            )
        yield frame


def _split_batches(frames: Iterator[Frame]) -> Iterator[list[Frame]]:
    """As many frames as are rendered at the same time, again and again."""
    while batch := list(itertools.islice(frames, choose_batch_size())):
        yield batch


def _compute_outputs(scene: CompiledScene, batch: list[Frame], rolling: Rolling) -> list[FrameOutput]:
    batch = [rolling.show(frame) for frame in batch]
    splats = [deform_splats(scene, frame) for frame in batch]
    background = scene.config.rendering.background
    rgb_frames = render_all(splats, scene.camera, background=background, kernels=scene.model.kernels)
    shown = [np.asarray(each.means)[: scene.body.cloud.count] for each in splats]
    return [FrameOutput.of(*parts) for parts in zip(rgb_frames, shown, batch)]


def find_shared_restart(scene: CompiledScene, cache: RestartCache | None) -> Frame | None:
    """The last frame in ``cache`` that ``scene`` can go on from, its state on the device; None = begin at rest."""
    if cache is None or cache.body is not scene.body or scene.changed or cache.changed:
        return None
    shared = find_last_shared_frame(cache.config, scene.config)
    fit = [index for index in cache.restarts if shared is not None and index <= shared]
    if not fit:
        return None
    frame, frame_dt = cache.restarts[max(fit)], scene.config.timing.frame_dt
    end = frame.index * frame_dt
    acting = find_acting(
        scene.model, end - frame_dt, end
    )  # the earlier model may have fewer parts, or others
    return dataclasses.replace(
        frame, state=jax.device_put(frame.state), acting=acting if frame.index else None
    )


def _share_frames(
    cache: RestartCache | None, begin: Frame | None
) -> tuple[list[FrameOutput], list[FrameStatistics], dict[int, Frame]]:
    """The known frames up to ``begin``."""
    if cache is None or begin is None:
        return [], [], {}
    count = begin.index + 1
    restarts = {index: frame for index, frame in cache.restarts.items() if index < count}
    return list(cache.outputs[:count]), list(cache.statistics[:count]), restarts


def _is_worth_keeping(
    scene: CompiledScene, frame: Frame, outputs: list[FrameOutput], restarts: dict[int, Frame]
) -> bool:
    """Return whether a later scene may go on from ``frame``: memory allows it, the clock is that of `shared_frames`."""
    state_bytes = sum(leaf.nbytes for leaf in jax.tree.leaves(frame.state))
    needed = len(outputs) * outputs[0].nbytes + (len(restarts) + 1) * state_bytes
    timing = scene.config.timing
    return needed <= RESTART_BYTES and is_clock_right(float(frame.state.time), frame.index, timing.frame_dt)


def simulate_frames(
    scene: CompiledScene, begin: Frame | None = None, most_substeps: float = math.inf
) -> Iterator[Frame]:
    """The frames of ``scene`` after ``begin``, simulated one after another; from the rest pose on if None.

    Those that take more than ``most_substeps`` are refused (`mpm.simulate`).
    """
    timing = scene.config.timing
    return simulate(
        scene.windowed,
        scene.state,
        frame_count=timing.frame_count,
        frame_dt=timing.frame_dt,
        substep_dt=None if timing.substep_dt == "auto" else timing.substep_dt,
        safety=timing.safety,
        force_substep=timing.force_substep,
        ledger=scene.config.ledger,
        begin=begin,
        tell_limits=False,  # `compile_scene` has told them
        most_substeps=most_substeps,
    )


def deform_splats(scene: CompiledScene, frame: Frame) -> Splats:
    """The Gaussians of one frame; after those of the body, invisible ones (`CompiledScene.gaussians`)."""
    return deform(*scene.gaussians, frame.state.x, frame.state.F, scene.body.placement.rotation)
