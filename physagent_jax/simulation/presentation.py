"""The pictures that people get: a simulated motion drawn on a stage, frame by frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.core.threads import map_ahead
from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.gaussians.elongation import cap_elongation
from physagent_jax.gaussians.specks import count_neighbours, hide_specks, shorten_needles
from physagent_jax.render import choose_batch_size, render
from physagent_jax.render.stage import compose, make_backdrop, put_picture
from physagent_jax.scene.actors import find_actors
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile.buckets import pad_gaussians, round_up
from physagent_jax.scene.config import SceneConfig
from physagent_jax.scene.insides import add_inside, comes_apart
from physagent_jax.scene.presentation import find_stage, place_cameras, resize, settle_ground
from physagent_jax.simulation.annotation import draw_arrows, find_arrows, write_caption
from physagent_jax.simulation.notes import Notes

BLACK = (0.0, 0.0, 0.0)
PLAIN = Notes()


def draw_presentation(
    config: SceneConfig,
    body: Body,
    x: np.ndarray,
    F: np.ndarray,
    size: tuple[int, int],
    notes: Notes = PLAIN,
) -> Iterator[np.ndarray]:
    """Draw a motion for people: with ground, contact shadow and horizon, without needles or hollows.

    What was lifted from a photo is drawn into the photo, from its own camera, unless the scene's looks from elsewhere.

    Args:
        config: The scene.
        body: Its object.
        x: Positions of the body's particles [m], shape (T, n, 3).
        F: Their deformation gradients, shape (T, n, 3, 3).
        size: Width and height [px]; a photo keeps its shape within.
        notes: What is drawn over the pictures.

    Returns:
        Pictures, one after another; a few are drawn ahead; uint8, shape (height, width, 3).

    Raises:
        UserError: A picture does not fit into memory.
    """
    photo = body.photo if body.photo is not None and body.photo.is_of(config.camera) else None
    if photo is None:
        cameras = place_cameras(config, x, resize(config.rendering, size))
    else:
        cameras = [photo.make_camera(size)] * len(x)
    stage = settle_ground(find_stage(config, 0.5 * (body.low + body.high), body.extent), x, config.domain.dx)
    actors = find_actors(config, body, x)
    # Sizes as `CompiledScene.gaussians` and its model have them, so that the simulation's program deforms these too.
    shown = shorten_needles(body.plain or body.cloud, body.extent)
    skin = shown.of_least_degree()
    seen, follows = add_inside(skin, body) if comes_apart(x) else (skin, body.binding)
    cloud, binding = pad_gaussians(seen, follows)
    neighbours = count_neighbours(np.asarray(seen.means), body.extent)
    missing = round_up(x.shape[1]) - x.shape[1]
    scales = np.asarray(cloud.scales)
    still = make_backdrop(stage, cameras[0])

    def pose(index: int) -> Splats:
        moved = (
            to_device(np.concatenate([each[index], each[index, -1:].repeat(missing, axis=0)]), np.float32)
            for each in (x, F)
        )
        deformed = deform(cloud, binding, *moved, body.placement.rotation)
        return hide_specks(cap_elongation(deformed, scales, body.extent), neighbours, body.extent)

    if photo is not None:
        still = put_picture(still, photo.draw_plate(cameras[0]), pose(0))

    def draw(index: int) -> np.ndarray:
        splats = pose(index)
        image = render(splats, cameras[index], background=BLACK)
        backdrop = still if cameras[index] is cameras[0] else make_backdrop(stage, cameras[index])
        picture = compose(image, splats, backdrop, actors[index])
        if notes.arrows:
            picture = draw_arrows(picture, find_arrows(config, body, x[index], index), cameras[index])
        return write_caption(picture, config.prompt) if notes.caption else picture

    return map_ahead(draw, range(len(x)), choose_batch_size())
