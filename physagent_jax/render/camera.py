"""Pinhole camera in the OpenCV / COLMAP convention."""

from __future__ import annotations

import dataclasses
import math

import jax
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.core.strict import LARGEST


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Camera:
    """Pinhole camera: x right, y down, z forward; pixel centres at +0.5; depth is z, not ray length.

    Attributes:
        viewmat: World-to-camera transform, shape (4, 4).
        K: Intrinsics [px], shape (3, 3).
        width: Image width [px].
        height: Image height [px].
    """

    viewmat: np.ndarray | jax.Array
    K: np.ndarray | jax.Array
    width: int = dataclasses.field(metadata=dict(static=True))
    height: int = dataclasses.field(metadata=dict(static=True))

    @property
    def center(self) -> np.ndarray:
        """Camera centre in the world [m], shape (3,)."""
        view = np.asarray(self.viewmat)
        return -view[:3, :3].T @ view[:3, 3]

    @property
    def right(self) -> np.ndarray:
        """The image's horizontal axis in the world (unit), shape (3,)."""
        return np.asarray(self.viewmat)[0, :3]

    @property
    def forward(self) -> np.ndarray:
        """The viewing direction in the world (unit), shape (3,)."""
        return np.asarray(self.viewmat)[2, :3]


def look_at(eye, target, up, *, fov_degrees: float, width: int, height: int) -> Camera:
    """Camera at ``eye`` that looks at ``target`` with ``up`` upwards in the image.

    Args:
        eye: Camera centre [m], shape (3,).
        target: Point at the image centre [m], shape (3,).
        up: World up direction, not parallel to the view, shape (3,).
        fov_degrees: Vertical field of view [deg].
        width: Image width [px].
        height: Image height [px].

    Raises:
        UserError: Something is not three finite numbers of some size, ``eye`` equals ``target``, ``up`` is parallel to
            the view, or the field of view is not in (0, 180).
    """
    eye, target, up = (np.asarray(a, np.float64) for a in (eye, target, up))
    for name, value in (("eye", eye), ("target", target), ("up", up)):
        if value.shape != (3,) or not (np.abs(value) <= LARGEST).all():
            what = f"the camera's `{name}` must be three finite numbers of at most {LARGEST:g}"
            raise UserError(what, got=value.tolist())
    if not 0 < fov_degrees < 180:
        raise UserError("the camera's `fov_degrees` must lie between 0 and 180", got=fov_degrees)
    forward = target - eye
    if np.linalg.norm(forward) < 1e-12:
        raise UserError("the camera's `eye` and `target` coincide", got=eye.tolist(), do="Move one of them")
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    if np.linalg.norm(right) <= 1e-9 * np.linalg.norm(up):
        raise UserError(
            "the camera's `up` is parallel to the viewing direction", got=up.tolist(), do="Choose another"
        )
    right = right / np.linalg.norm(right)
    down = np.cross(forward, right)
    view = np.eye(4)
    view[:3, :3] = np.stack([right, down, forward])
    view[:3, 3] = -view[:3, :3] @ eye
    focal = 0.5 * height / math.tan(0.5 * math.radians(fov_degrees))
    K = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    return Camera(view, K, width, height)
