"""Playing a compiled scene: every frame is simulated, its Gaussians deformed and its picture taken, a few at a time.

Frames that an earlier scene has in common are taken over from its recording (`shared_past`). That works within one
process: nothing of it is written down, so a run that was stopped and is taken up plays its next round from the start.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterator

import jax
import numpy as np

from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.mpm import Frame, simulate
from physagent_jax.recording import Entry, Past, Recording, Shot, rest_centre
from physagent_jax.render import frames_at_once, render_all
from physagent_jax.scene.compile import Scene
from physagent_jax.shared_past import clock_is_right, last_shared_frame, restart_frames
from physagent_jax.stopwatch import Stopwatch

PAST_BYTES = 2**30  # of host memory for what a later scene may go on from

Progress = Callable[[int, int], None]
"""Called after every frame with (frames done, frames in all)."""


def play(
    scene: Scene, watch: Stopwatch, progress: Progress | None = None, past: Past | None = None
) -> Recording:
    """Simulates and renders all frames of ``scene``, except those that it shares with ``past``.

    Raises:
        UserError: The scene cannot be simulated (`mpm.simulate` says why).
    """
    begin = shared_restart(scene, past)
    shots, entries, restarts = _taken_over(past, begin)
    reused, total = len(shots), scene.config.timing.frame_count
    if progress and reused:
        progress(reused, total)
    wanted, centre = restart_frames(scene.config), rest_centre(scene)
    for batch in _batches(watch.timed("simulate", frames(scene, begin))):
        with watch("render"):
            shots += _shots(scene, batch)
        with watch("simulate"):
            for frame in batch:
                entries.append(Entry.of(scene, frame, centre))
                if frame.index in wanted and _worth_keeping(scene, frame, shots, restarts):
                    restarts[frame.index] = dataclasses.replace(frame, state=jax.device_get(frame.state))
        if progress:
            for frame in batch:
                progress(frame.index + 1, total)
    return Recording.of(scene, shots, entries, Past.of(scene, shots, entries, restarts), reused)


def _batches(frames: Iterator[Frame]) -> Iterator[list[Frame]]:
    """As many frames as are rendered at the same time, again and again."""
    while batch := list(itertools.islice(frames, frames_at_once())):
        yield batch


def _shots(scene: Scene, batch: list[Frame]) -> list[Shot]:
    splats = [splats_at(scene, frame) for frame in batch]
    background = scene.config.rendering.background
    pictures = render_all(splats, scene.camera, background=background, kernels=scene.model.kernels)
    shown = [np.asarray(each.means)[: scene.body.cloud.count] for each in splats]
    return [Shot.of(*parts) for parts in zip(pictures, shown, batch)]


def shared_restart(scene: Scene, past: Past | None) -> Frame | None:
    """The last frame of ``past`` that ``scene`` can go on from, its state on the device; None = begin at rest."""
    if past is None or past.body is not scene.body:
        return None
    shared = last_shared_frame(past.config, scene.config)
    fit = [index for index in past.restarts if shared is not None and index <= shared]
    if not fit:
        return None
    frame = past.restarts[max(fit)]
    return dataclasses.replace(frame, state=jax.device_put(frame.state))


def _taken_over(past: Past | None, begin: Frame | None) -> tuple[list[Shot], list[Entry], dict[int, Frame]]:
    if past is None or begin is None:
        return [], [], {}
    count = begin.index + 1
    restarts = {index: frame for index, frame in past.restarts.items() if index < count}
    return list(past.shots[:count]), list(past.entries[:count]), restarts


def _worth_keeping(scene: Scene, frame: Frame, shots: list[Shot], restarts: dict[int, Frame]) -> bool:
    """Whether a later scene may go on from ``frame``: memory allows it, and the clock is as `shared_past` assumes."""
    state_bytes = sum(leaf.nbytes for leaf in jax.tree.leaves(frame.state))
    needed = len(shots) * shots[0].nbytes + (len(restarts) + 1) * state_bytes
    timing = scene.config.timing
    return needed <= PAST_BYTES and clock_is_right(float(frame.state.time), frame.index, timing.frame_dt)


def frames(scene: Scene, begin: Frame | None = None) -> Iterator[Frame]:
    """The frames of ``scene`` after ``begin``, simulated one after another; from the rest pose on if None."""
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
    )


def splats_at(scene: Scene, frame: Frame) -> Splats:
    """The Gaussians of one frame; after those of the body, invisible ones (`Scene.gaussians`)."""
    return deform(*scene.gaussians, frame.state.x, frame.state.F, scene.body.placement.rotation)
