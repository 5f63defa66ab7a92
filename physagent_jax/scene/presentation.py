"""The presentation of a simulated scene: its stage, and cameras that frame what really happened.

Perception looks from the scene's own camera, which knows nothing of that.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from physagent_jax.render.blocks import Block
from physagent_jax.render.camera import Camera
from physagent_jax.render.stage import Stage
from physagent_jax.scene.camera import LEAST_HEIGHT, frame_camera, make_reference_camera, measure_height
from physagent_jax.scene.config import Box, HalfSpace, Rendering, SceneConfig

MOST_POINTS = 2000  # of the object that are framed
TRIMMED = 0.005  # share of the points on each side, in each frame, that need not be in the picture
LEVEL = 0.999  # least upward part of the normal of what is a ground
PANEL, PANEL_THICKNESS = 1.0, 0.06  # [sizes] half side of what is drawn of a wall; [half sides]
SMOOTHING = 0.3  # [s] over which a camera that follows evens out its way


def find_stage(config: SceneConfig, centre: np.ndarray, size: float) -> Stage:
    """The stage of a scene: its level ground, the highest if there are several, and the walls and boxes around.

    Balls, meshes and what moves or is not there from the start on are not drawn.

    Args:
        config: The scene.
        centre: Centre of the object at first [m], shape (3,).
        size: Its longest side [m].
    """
    still = [
        each
        for each in config.boundaries
        if isinstance(each, HalfSpace | Box) and each.start <= 0 and not any(each.velocity)
    ]
    level = [each.point[2] for each in still if isinstance(each, HalfSpace) and each.normal[2] >= LEVEL]
    blocks = [
        _make_panel(each, centre, size) if isinstance(each, HalfSpace) else _make_block(each)
        for each in still
        if not (isinstance(each, Box) and each.container)
        and not (isinstance(each, HalfSpace) and each.normal[2] >= LEVEL)
    ]
    return Stage(max(level, default=None), size, tuple(blocks))


def _make_block(box: Box) -> Block:
    return Block(np.array(box.point), np.eye(3), np.array(box.half_size))


def _make_panel(plane: HalfSpace, centre: np.ndarray, size: float) -> Block:
    """The part of a plane that is nearest to the object, as a thin panel."""
    normal = np.asarray(plane.normal)
    aside = np.cross(normal, [0, 0, 1] if abs(normal[2]) < 0.9 else [1, 0, 0])
    aside = aside / np.linalg.norm(aside)
    foot = centre - ((centre - plane.point) @ normal) * normal
    half = PANEL * size * np.array([0.5 * PANEL_THICKNESS, 1, 1])
    return Block(foot - half[0] * normal, np.stack([normal, aside, np.cross(normal, aside)]), half)


def place_cameras(config: SceneConfig, x: np.ndarray, rendering: Rendering) -> list[Camera]:
    """Cameras of a video for people, one per frame: the scene's direction and lens, framing what moved.

    A camera that stands still shows the whole motion. If `CameraConfig.follow` asks for it, or if the object would be
    smaller than `scene.camera.LEAST_HEIGHT` at first, the camera goes along with the object instead.

    Args:
        config: The scene.
        x: Positions of the object's particles [m], shape (T, n, 3).
        rendering: Size of the pictures.
    """
    points = _choose_points(np.asarray(x, np.float64))
    start, follow = points[0], config.camera.follow
    seen = _trim(points)
    fixed = frame_camera(seen.reshape(-1, 3), config.camera, rendering, start=start)
    if follow is None:
        whole = frame_camera(seen.reshape(-1, 3), config.camera, rendering)
        follow = measure_height(start, whole) < LEAST_HEIGHT and measure_height(
            start, whole
        ) < measure_height(start, fixed)
    if not follow:
        return [make_reference_camera(fixed, rendering, config.domain)] * len(points)
    centres = 0.5 * (seen.min(1) + seen.max(1))
    way = _smooth(centres, SMOOTHING / config.timing.frame_dt)
    relative = (seen - way[:, None]).reshape(-1, 3)
    first = frame_camera(relative, config.camera, rendering, start=start)
    assert first.target is not None
    return [
        make_reference_camera(
            first.model_copy(update=dict(target=tuple(np.asarray(first.target) + step))),
            rendering,
            config.domain,
        )
        for step in way
    ]


def resize(rendering: Rendering, size: tuple[int, int]) -> Rendering:
    """``rendering`` at another width and height."""
    return rendering.model_copy(update=dict(width=size[0], height=size[1]))


def _smooth(path: np.ndarray, sigma: float) -> np.ndarray:
    """A path (T, 3) evened out over ``sigma`` frames, from its start; even motion is kept as it is up to both ends."""
    room = min(len(path) - 1, int(4 * sigma) + 1)
    longer = np.pad(path, ((room, room), (0, 0)), mode="reflect", reflect_type="odd")
    smooth = gaussian_filter1d(longer, sigma, axis=0, mode="nearest")[room : room + len(path)]
    return smooth - smooth[0]


def _choose_points(x: np.ndarray) -> np.ndarray:
    """Every few of the particles, shape (T, k, 3); what is not finite stays where it was at first."""
    chosen = x[:, :: -(-x.shape[1] // MOST_POINTS)]
    return np.where(np.isfinite(chosen).all(axis=2, keepdims=True), chosen, chosen[:1])


def _trim(points: np.ndarray) -> np.ndarray:
    """Points (T, k, 3) with those that have flown off, in each frame, brought back to the rest's bounding box."""
    low, high = np.quantile(points, [TRIMMED, 1 - TRIMMED], axis=1, keepdims=True)
    return np.clip(points, low, high)
