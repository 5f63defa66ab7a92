"""The reference camera: where it stands, what the viewer's words mean in the world, what it must show."""

from __future__ import annotations

import numpy as np

from physagent_jax.render.camera import Camera, look_at
from physagent_jax.scene.config import CameraConfig, Domain, Rendering

UP = np.array([0.0, 0.0, 1.0])
MARGIN = 0.88  # share of the half picture that the framed points may fill
LEAST_SHARE = 0.15  # of the picture's height or width that the object fills in the first frame
MOST_HEIGHT = 0.60  # share of the picture's height that it fills then


def make_reference_camera(config: CameraConfig, rendering: Rendering, domain: Domain) -> Camera:
    """The pinhole camera that ``config`` describes."""
    target = np.full(3, 0.5 * domain.size) if config.target is None else np.asarray(config.target)
    eye = target - config.distance * find_view_direction(config)
    return look_at(
        eye, target, UP, fov_degrees=config.fov_degrees, width=rendering.width, height=rendering.height
    )


def find_view_direction(config: CameraConfig) -> np.ndarray:
    """From the camera to its target (unit), shape (3,)."""
    azimuth, elevation = np.radians([config.azimuth_degrees, config.elevation_degrees])
    horizontal = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return np.cos(elevation) * horizontal - np.sin(elevation) * UP


def find_viewer_directions(config: CameraConfig) -> dict[str, tuple[float, float, float]]:
    """The viewer's words as unit world vectors: right, left, up, down, toward, away.

    Right and left run along the picture's horizontal axis, up and down along the world's vertical,
    toward and away horizontally to and from the camera.
    """
    away = find_view_direction(config) * [1, 1, 0]
    away = away / np.linalg.norm(away)
    right = np.cross(away, UP)
    table = {"right": right, "left": -right, "up": UP, "down": -UP, "toward": -away, "away": away}
    return {
        word: tuple(float(c) for c in np.round(v, 12) + 0.0)  # + 0.0 turns -0.0 into 0.0
        for word, v in table.items()
    }  # type: ignore[return-value]


def frame_camera(
    points: np.ndarray,
    camera: CameraConfig,
    rendering: Rendering,
    *,
    start: np.ndarray | None = None,
    least: float = LEAST_SHARE,
) -> CameraConfig:
    """Move ``camera`` (along its direction, and sideways) until it just shows ``points``.

    With ``start``, it goes no nearer than that the object fills `MOST_HEIGHT` of the picture's height at first, and no
    farther than that it fills the share ``least``: what then does not fit is cut off, but never the object at first.

    Args:
        points: World points that should be visible [m], shape (m, 3).
        camera: Its direction and field of view are kept.
        rendering: For the aspect ratio.
        start: The object's points in the first frame [m], shape (k, 3); None = it may be of any size.
        least: Share of the picture's height or width that they fill at least.
    """
    centre = 0.5 * (points.min(0) + points.max(0))
    axes, half = _find_axes(camera), _find_half_picture(camera, rendering)
    distance = _find_distance((points - centre) @ axes, MARGIN * half)
    if start is not None:
        local = (start - centre) @ axes
        centred = local - 0.5 * (local.min(0) + local.max(0)) * [1, 1, 0]
        distance = max(distance, _find_distance_of_share(centred[:, 1:], MOST_HEIGHT, half[1:]))
        farthest = _find_distance_of_share(centred, least, half)
        distance = min(distance, max(farthest, _find_distance(centred, MARGIN * half)))
        centre = centre + axes[:, :2] @ _find_shift(local, distance, MARGIN * half)
    return camera.model_copy(
        update=dict(target=tuple(round(float(c), 4) for c in centre), distance=round(distance, 4))
    )


def shows_points(
    points: np.ndarray, camera: CameraConfig, rendering: Rendering, *, share: float = 1.0
) -> bool:
    """Return whether ``points``, shape (m, 3) [m], all lie in the picture of a camera that has been placed.

    ``share`` is that of its width and height which they lie in.
    """
    assert camera.target is not None
    local = (points - np.asarray(camera.target)) @ _find_axes(camera)
    reach = share * _find_half_picture(camera, rendering) * (camera.distance + local[:, 2:])
    return bool((np.abs(local[:, :2]) <= reach).all())


def measure_share(points: np.ndarray, camera: CameraConfig, rendering: Rendering) -> float:
    """The share of the picture's height or width that ``points``, shape (m, 3), span, whichever is more."""
    assert camera.target is not None
    local = (points - np.asarray(camera.target)) @ _find_axes(camera)
    places = local[:, :2] / np.maximum(camera.distance + local[:, 2:], 1e-6)
    return float((np.ptp(places, axis=0) / (2 * _find_half_picture(camera, rendering))).max())


def _find_axes(camera: CameraConfig) -> np.ndarray:
    """The picture's right and up, and the view direction, as columns, shape (3, 3)."""
    forward = find_view_direction(camera)
    right = np.cross(forward, UP)
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward], axis=1)


def _find_half_picture(camera: CameraConfig, rendering: Rendering) -> np.ndarray:
    """Half width and half height of the picture at depth 1, shape (2,)."""
    height = np.tan(0.5 * np.radians(camera.fov_degrees))
    return np.array([height * rendering.width / rendering.height, height])


def _find_distance(local: np.ndarray, half: np.ndarray) -> float:
    """From how far points (right, up, forward) fit into ``half``: |x| <= half (distance + z), and likewise y [m]."""
    return float((np.abs(local[:, :2]) / half - local[:, 2:]).max())


def _find_shift(local: np.ndarray, distance: float, half: np.ndarray) -> np.ndarray:
    """The least step to the right and up after which points (right, up, forward) fit into ``half`` [m], shape (2,)."""
    reach = half * (distance + local[:, 2:])
    return np.maximum((local[:, :2] - reach).max(0), 0) + np.minimum((local[:, :2] + reach).min(0), 0)


def _find_distance_of_share(local: np.ndarray, share: float, half: np.ndarray) -> float:
    """From how far points (across, ..., forward) span ``share`` of the picture, across or upwards [m].

    Args:
        local: The points [m], shape (m, k + 1).
        share: That share [1].
        half: Half of the picture in each direction at depth 1, shape (k,).
    """
    depth = local[:, -1:]
    near = 1e-6 - depth.min()
    far = near + max(float((np.ptp(local[:, :-1], axis=0) / half).max()), 1e-3) / share + np.ptp(depth)
    for _ in range(50):
        middle = 0.5 * (near + far)
        span = (np.ptp(local[:, :-1] / (middle + depth), axis=0) / (2 * half)).max()
        near, far = (middle, far) if span > share else (near, middle)
    return far
