"""Pictures of what has been simulated, from any camera."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.binding import deform
from physagent_jax.render import Camera, choose_batch_size, render_all, to_uint8
from physagent_jax.simulation.recording import Recording


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
    cloud, binding = scene.gaussians
    rendered: list[np.ndarray] = []
    at_once = choose_batch_size()
    for first in range(0, len(wanted), at_once):
        splats = [
            deform(cloud, binding, recording.x[index], recording.F[index], scene.body.placement.rotation)
            for index in wanted[first : first + at_once]
        ]
        images = render_all(splats, camera, background=colour, kernels=scene.model.kernels)
        rendered += [to_uint8(image.rgb) for image in images]
    return np.stack(rendered) if rendered else np.zeros((0, camera.height, camera.width, 3), np.uint8)
