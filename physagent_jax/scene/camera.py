"""The reference camera: where it stands, what the viewer's words mean in the world, what it must show."""

from __future__ import annotations

import numpy as np

from physagent_jax.render.camera import Camera, look_at
from physagent_jax.scene.config import CameraConfig, Domain, Rendering

UP = np.array([0.0, 0.0, 1.0])
MARGIN = 0.88  # share of the half picture that the framed points may fill


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


def frame_camera(points: np.ndarray, camera: CameraConfig, rendering: Rendering) -> CameraConfig:
    """Moves ``camera`` (along its direction, and sideways) until it just shows ``points``.

    Args:
        points: World points that must be visible [m], shape (m, 3).
        camera: Its direction and field of view are kept.
        rendering: For the aspect ratio.
    """
    forward = find_view_direction(camera)
    right = np.cross(forward, UP)
    right = right / np.linalg.norm(right)
    up = np.cross(right, forward)
    centre = 0.5 * (points.min(0) + points.max(0))
    local = (points - centre) @ np.stack([right, up, forward], axis=1)
    half_height = MARGIN * np.tan(0.5 * np.radians(camera.fov_degrees))
    half_width = half_height * rendering.width / rendering.height
    # A point (x, y, z) is inside if |x| <= half_width (distance + z), and likewise for y.
    distance = np.maximum(np.abs(local[:, 0]) / half_width, np.abs(local[:, 1]) / half_height) - local[:, 2]
    return camera.model_copy(
        update=dict(
            target=tuple(round(float(c), 4) for c in centre), distance=round(float(distance.max()), 4)
        )
    )
