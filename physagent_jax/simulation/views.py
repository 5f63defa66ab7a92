"""Pictures of what has been simulated, from any camera."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.binding import deform
from physagent_jax.render import Camera, RenderedImage, choose_batch_size, render_all, to_uint8
from physagent_jax.scene.camera import frame_camera, make_reference_camera, shows_points
from physagent_jax.simulation.recording import Recording

_INSIDE = 0.94  # of the picture, within which its middles lie: a Gaussian is seen beyond its middle
OUTERMOST = 0.0005  # share of the Gaussians on each side that need not be in the picture


def render_recording(
    recording: Recording,
    camera: Camera | None = None,
    *,
    frames: Sequence[int] | None = None,
    background: tuple[float, float, float] | None = None,
) -> np.ndarray:
    """Render a recording's Gaussians again.

    Args:
        recording: What was simulated.
        camera: From where; None = the scene's own.
        frames: Which frames; None = all.
        background: RGB in [0, 1]; None = the scene's.

    Returns:
        Pictures, uint8, shape (frames, height, width, 3).

    Raises:
        UserError: There is no such frame, or the view does not fit into memory.
    """
    scene, count = recording.scene, len(recording.x)
    wanted = list(range(count) if frames is None else frames)
    if outside := [index for index in wanted if not -count <= index < count]:
        raise UserError(
            "`frames` names frames that there are not", got=outside[:8], do=f"Give some of {count}"
        )
    colour = scene.config.rendering.background if background is None else background
    camera = scene.camera if camera is None else camera
    rendered = [to_uint8(image.rgb) for image in _draw(recording, camera, wanted, colour)]
    return np.stack(rendered) if rendered else np.zeros((0, camera.height, camera.width, 3), np.uint8)


def reframe(recording: Recording) -> Recording:
    """The recording from a camera that shows all of its motion, in the same direction; itself where its own does.

    A scene's camera is placed before anything is simulated, by where a free body would go (`scene.fuse`). What tips
    over or rebounds goes elsewhere, and what is not in the picture cannot be measured.
    """
    config, gaussians = recording.scene.config, recording.gaussians.astype(np.float64)
    ends = np.quantile(gaussians, (OUTERMOST, 1 - OUTERMOST), axis=1)  # (2, T, 3)
    boxes = np.concatenate([ends[corner, :, (0, 1, 2)].T for corner in np.ndindex(2, 2, 2)])
    if shows_points(boxes, config.camera, config.rendering, share=_INSIDE):
        return recording
    wider = frame_camera(boxes, config.camera, config.rendering, start=gaussians[0])
    config = config.model_copy(update=dict(camera=wider))
    camera = make_reference_camera(wider, config.rendering, config.domain)
    scene = dataclasses.replace(recording.scene, config=config, camera=camera)
    images = list(_draw(recording, camera, range(len(gaussians)), config.rendering.background))
    rgb = np.stack([to_uint8(image.rgb) for image in images])
    depth = np.stack([np.asarray(image.depth, np.float32) for image in images])
    cache = recording.restart_cache
    shared = [dataclasses.replace(each, rgb=rgb[k], depth=depth[k]) for k, each in enumerate(cache.outputs)]
    cache = dataclasses.replace(cache, config=config, outputs=tuple(shared))
    return dataclasses.replace(recording, scene=scene, rgb=rgb, depth=depth, restart_cache=cache)


def draw_ending(recording: Recording, x: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pictures, uint8, and z-depths [m] from the last planned frame to the end of ``x`` and ``F`` (`ending.go_on`).

    Those of the recording's camera, as perception gets them.
    """
    frames, colour = range(len(recording.x) - 1, len(x)), recording.scene.config.rendering.background
    images = list(_draw(dataclasses.replace(recording, x=x, F=F), recording.scene.camera, frames, colour))
    rgb = np.stack([to_uint8(image.rgb) for image in images])
    return rgb, np.stack([np.asarray(image.depth, np.float32) for image in images])


def _draw(
    recording: Recording, camera: Camera, frames: Sequence[int], background: tuple[float, float, float]
) -> Iterator[RenderedImage]:
    """The pictures of some frames, a few at the same time."""
    scene, at_once = recording.scene, choose_batch_size()
    cloud, binding = scene.gaussians
    for first in range(0, len(frames), at_once):
        splats = [
            deform(cloud, binding, recording.x[index], recording.F[index], scene.body.placement.rotation)
            for index in frames[first : first + at_once]
        ]
        yield from render_all(splats, camera, background=background, kernels=scene.model.kernels)
