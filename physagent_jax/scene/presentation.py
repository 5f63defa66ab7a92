"""The presentation of a simulated scene: its stage, and cameras that frame what really happened.

Perception looks from the scene's own camera, which knows nothing of that.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.ndimage import gaussian_filter1d

from physagent_jax.render.blocks import Block
from physagent_jax.render.camera import Camera
from physagent_jax.render.stage import Stage
from physagent_jax.scene.camera import (
    find_view_direction,
    frame_camera,
    make_reference_camera,
    measure_share,
)
from physagent_jax.scene.config import Box, CameraConfig, HalfSpace, Rendering, SceneConfig

MOST_POINTS = 2000  # of the object that are framed
TRIMMED = 0.005  # share of the points on each side, in each frame, that may have flown off
NEAR = 0.3  # [sizes of the rest in each direction] off the rest's box within which they have not
LOWEST, CONTACT = 0.002, 1.0  # quantile that counts as its lowest point; [cells] off the ground in contact
LEVEL = 0.999  # least upward part of the normal of what is a ground
PANEL, PANEL_THICKNESS = 1.0, 0.06  # [sizes] half side of what is drawn of a wall; [half sides]
SMOOTHING = 0.3  # [s] over which a camera that follows evens out its way
LARGE = 0.3  # share of the picture's height or width from which on the object is large enough
FOLLOWED = (0.0, 0.2, 0.4, 0.6, 0.8)  # shares of its way that a camera goes along
SEEN_WAY = 0.06  # [sizes] that it moves at least for the camera to stand aside
NEITHER = 15.0  # [degrees] from the line of sight up to which a motion goes to neither side
ASIDE = 40.0  # [degrees] at least between a motion over the ground and the line of sight
BEFORE_WALL = (
    90.0,
    110.0,
)  # [degrees] between the line of sight and the way that a wall faces: it hides nothing


def find_stage(config: SceneConfig, centre: np.ndarray, size: float) -> Stage:
    """The stage of a scene: its level ground, the highest if there are several, and the walls and boxes around.

    Balls, meshes and what moves or is not there from the start on are not drawn.

    Args:
        config: The scene.
        centre: Centre of the object at first [m], shape (3,).
        size: Its longest side [m].
    """
    still = _list_still(config)
    level = [each.point[2] for each in still if isinstance(each, HalfSpace) and each.normal[2] >= LEVEL]
    boxes = [_make_block(each) for each in still if isinstance(each, Box) and not each.container]
    panels = [_make_panel(each, centre, size) for each in _list_walls(config)]
    return Stage(max(level, default=None), size, (*panels, *boxes))


def _list_still(config: SceneConfig) -> list[HalfSpace | Box]:
    """The planes and boxes that stand there from the start on."""
    solids = [each for each in config.boundaries if isinstance(each, HalfSpace | Box)]
    return [each for each in solids if each.start <= 0 and not any(each.velocity)]


def _list_walls(config: SceneConfig) -> list[HalfSpace]:
    """Those of them that are planes, and no ground."""
    planes = [each for each in _list_still(config) if isinstance(each, HalfSpace)]
    return [each for each in planes if each.normal[2] < LEVEL]


def settle_ground(stage: Stage, x: np.ndarray, dx: float) -> Stage:
    """The stage with its ground where the object really stands: contact on a grid keeps it off by part of a cell.

    Args:
        stage: The stage.
        x: Positions of the object's particles [m], shape (T, n, 3).
        dx: Side of a cell [m].
    """
    if stage.ground is None:
        return stage
    heights = np.asarray(x)[:, :: -(-x.shape[1] // MOST_POINTS), 2]
    gap = float(np.nanquantile(heights, LOWEST, axis=1).min()) - stage.ground
    if not 0 < gap < CONTACT * dx:
        return stage
    return dataclasses.replace(stage, ground=stage.ground + gap)


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
    """Cameras of a video for people, one per frame: the scene's lens, framing what moved.

    A camera that stands still shows the whole motion. Where the object would be small in that picture, the camera goes
    along with it, as little as is needed; `CameraConfig.follow` asks for all of its way, or for none. Nothing of the
    object is cut off, unless it would be tiny otherwise. What moves along the line of sight is seen from aside.

    Args:
        config: The scene.
        x: Positions of the object's particles [m], shape (T, n, 3).
        rendering: Size of the pictures.
    """
    points = _choose_points(np.asarray(x, np.float64))
    upright = [each for each in _list_walls(config) if abs(each.normal[2]) < LEVEL]
    camera = config.camera
    if camera.turn:
        camera = stand_before(camera, upright[0]) if upright else turn_aside(camera, points)
    start, seen = points[0], _trim(points)
    centres = 0.5 * (seen.min(1) + seen.max(1))
    way = _smooth(centres, SMOOTHING / config.timing.frame_dt)
    share = {None: None, True: 1.0, False: 0.0}[camera.follow]
    if share is None:
        share = next((each for each in FOLLOWED if _is_large(each, camera, rendering, start, seen, way)), 1.0)
    relative = (seen - share * way[:, None]).reshape(-1, 3)
    first = frame_camera(relative, camera, rendering, start=start, least=LARGE)
    if not share:
        return [make_reference_camera(first, rendering, config.domain)] * len(points)
    assert first.target is not None
    return [
        make_reference_camera(
            first.model_copy(update=dict(target=tuple(np.asarray(first.target) + share * step))),
            rendering,
            config.domain,
        )
        for step in way
    ]


def _is_large(
    share: float,
    camera: CameraConfig,
    rendering: Rendering,
    start: np.ndarray,
    seen: np.ndarray,
    way: np.ndarray,
) -> bool:
    """Return whether the object as it is at first would be large enough all along its way, and as it is at last there.

    Args:
        share: Share of the way that the camera goes along.
        camera: Its direction and lens.
        rendering: Size of the pictures.
        start: Points of the object at first [m], shape (k, 3).
        seen: Points to be shown [m], shape (T, k, 3).
        way: Way of the object [m], shape (T, 3).
    """
    placed = frame_camera((seen - share * way[:, None]).reshape(-1, 3), camera, rendering)
    away = (1 - share) * way @ find_view_direction(camera)
    moved = start + (1 - share) * way[away.argmax()]
    last = seen[-1] - share * way[-1]  # what stood may lie
    return min(measure_share(each, placed, rendering) for each in (start, moved, last)) >= LARGE


def stand_before(camera: CameraConfig, wall: HalfSpace) -> CameraConfig:
    """The camera about the vertical until a wall stands beside what it looks at, and never before it.

    A wall on the left stays on the left. One that is straight ahead, or behind the camera, comes to stand on the right.
    """
    faces = camera.azimuth_degrees + 90 - np.degrees(np.arctan2(wall.normal[1], wall.normal[0]))
    faces = 180 - (180 - faces) % 360  # clockwise from the line of sight
    wanted = np.copysign(np.clip(abs(faces), *BEFORE_WALL), -1.0 if faces % 180 == 0 else faces)
    azimuth = 180 - (180 - camera.azimuth_degrees - (wanted - faces)) % 360
    return camera.model_copy(update=dict(azimuth_degrees=float(azimuth)))


def turn_aside(camera: CameraConfig, points: np.ndarray) -> CameraConfig:
    """The camera about the vertical until what moves does so clearly sideways, or as it is if it does already.

    To the left stays to the left, and toward stays toward. Where it goes to neither side, the camera stands on the
    left: light that is baked into meshes comes from there (`surfels.KEY_LIGHT`).

    Args:
        camera: Where it looks from.
        points: Points of the object [m], shape (T, k, 3).
    """
    moved = (points - points[:1]).mean(axis=1)[:, :2]
    length = np.linalg.norm(moved, axis=1)
    far = length.argmax()
    if length[far] < SEEN_WAY * np.ptp(points[0], axis=0).max():
        return camera
    angle = np.radians(camera.azimuth_degrees)
    right, away = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    sideways, along = moved[far] @ right, moved[far] @ away
    angle = np.degrees(np.arctan2(abs(sideways), abs(along)))
    if angle >= ASIDE:
        return camera
    side = 1 if (sideways >= 0) == (along >= 0) else -1
    turn = side * (ASIDE - angle) if angle > NEITHER else -ASIDE - side * angle
    azimuth = 180 - (180 - camera.azimuth_degrees - turn) % 360
    return camera.model_copy(update=dict(azimuth_degrees=azimuth))


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
    """Points (T, k, 3) with those that have flown off, in each frame, brought back to near the rest's bounding box."""
    low, high = np.quantile(points, [TRIMMED, 1 - TRIMMED], axis=1, keepdims=True)
    room = NEAR * (high - low)
    return np.clip(points, low - room, high + room)
