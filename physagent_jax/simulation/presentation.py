"""The pictures that people get: a simulated motion drawn on a stage, frame by frame."""

from __future__ import annotations

from collections.abc import Iterator

import jax.numpy as jnp
import numpy as np

from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.elongation import cap_elongation
from physagent_jax.render import choose_batch_size, render_all
from physagent_jax.render.stage import compose, make_backdrop
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import SceneConfig
from physagent_jax.scene.presentation import find_stage, place_cameras, resize

BLACK = (0.0, 0.0, 0.0)


def draw_presentation(
    config: SceneConfig, body: Body, x: np.ndarray, F: np.ndarray, size: tuple[int, int]
) -> Iterator[np.ndarray]:
    """Draws a motion for people: with ground, contact shadow and horizon, and without needles.

    Args:
        config: The scene.
        body: Its object.
        x: Positions of the body's particles [m], shape (T, n, 3).
        F: Their deformation gradients, shape (T, n, 3, 3).
        size: Width and height [px].

    Yields:
        Pictures, uint8, shape (height, width, 3).

    Raises:
        UserError: A picture does not fit into memory.
    """
    rendering = resize(config.rendering, size)
    cameras = place_cameras(config, x, rendering)
    stage = find_stage(config, 0.5 * (body.low + body.high), body.extent)
    scales = np.asarray(body.cloud.scales)
    backdrop = make_backdrop(stage, cameras[0])
    at_once = choose_batch_size()
    for first in range(0, len(x), at_once):
        part = range(first, min(first + at_once, len(x)))
        deformed = [
            deform(
                body.cloud,
                body.binding,
                jnp.asarray(x[index], jnp.float32),
                jnp.asarray(F[index], jnp.float32),
                body.placement.rotation,
            )
            for index in part
        ]
        splats = [cap_elongation(each, scales, body.extent) for each in deformed]
        images = render_all(splats, [cameras[index] for index in part], background=BLACK)
        for index, image, drawn in zip(part, images, splats, strict=True):
            if backdrop.camera is not cameras[index]:
                backdrop = make_backdrop(stage, cameras[index])
            yield compose(image, drawn, backdrop)
