"""Boxes that stand on a stage: what an object is thrown against must be seen."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.render.camera import Camera

OPACITY = 0.7  # what is behind can still be followed
COLOUR = np.array([0.60, 0.66, 0.72], np.float32)
ACTOR_OPACITY = 0.38  # of what acts: the object in its grip stays to be seen
ACTOR_COLOUR = np.array([0.36, 0.56, 0.86], np.float32)
LIGHT = np.array([0.3, -0.45, 0.84])  # from where the faces are lit (unit)
AMBIENT = 0.62  # share of the light that comes from everywhere


@dataclasses.dataclass(frozen=True)
class Block:
    """A solid box.

    Attributes:
        center: [m], shape (3,).
        axes: Its axes (unit) as rows, shape (3, 3).
        half_size: Along them [m], shape (3,).
    """

    center: np.ndarray
    axes: np.ndarray
    half_size: np.ndarray


def find_window(block: Block, camera: Camera) -> tuple[slice, slice]:
    """Rows and columns of the picture in which a block may be seen."""
    signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    corners = block.center + (signs * block.half_size) @ block.axes
    local = corners @ np.asarray(camera.viewmat, np.float64)[:3, :3].T + camera.viewmat[:3, 3]
    if (local[:, 2] < 1e-3).any():  # beside or behind the camera: it may reach anywhere
        return np.s_[: camera.height, : camera.width]
    pixels = local @ np.asarray(camera.K, np.float64).T
    places = pixels[:, :2] / pixels[:, 2:]
    bounds = np.array([camera.width, camera.height])
    first = np.clip(np.floor(places.min(0)), 0, bounds).astype(int)
    last = np.clip(np.ceil(places.max(0)) + 1, 0, bounds).astype(int)
    return np.s_[first[1] : last[1], first[0] : last[0]]


def cast_at_block(
    block: Block, camera: Camera, window: tuple[slice, slice] = np.s_[:, :]
) -> tuple[np.ndarray, np.ndarray]:
    """The entry points of rays through the pixels' centres into a block, by the slab method (Kay and Kajiya 1986).

    Args:
        block: The block.
        camera: The camera.
        window: Rows and columns of the picture.

    Returns:
        z-depth [m], inf where a ray misses it, shape (h, w); how bright what is met is, in [0, 1], shape (h, w).
    """
    rotation = np.asarray(camera.viewmat, np.float64)[:3, :3]
    u, v = np.meshgrid(np.arange(camera.width)[window[1]] + 0.5, np.arange(camera.height)[window[0]] + 0.5)
    pixels = np.stack([u, v, np.ones_like(u)], axis=-1)
    rays = pixels @ (block.axes @ rotation.T @ np.linalg.inv(np.asarray(camera.K, np.float64))).T
    rays = np.where(np.abs(rays) < 1e-9, 1e-9, rays)
    eye = block.axes @ (camera.center - block.center)
    first, second = (-block.half_size - eye) / rays, (block.half_size - eye) / rays
    near, far = np.minimum(first, second), np.maximum(first, second)
    depth, axis = near.max(axis=2), near.argmax(axis=2)
    hit_mask = (depth < far.min(axis=2)) & (depth > 0)
    side = -np.sign(np.take_along_axis(rays, axis[..., None], axis=2)[..., 0])
    brightness = AMBIENT + (1 - AMBIENT) * np.clip(side * (block.axes @ LIGHT)[axis], 0, 1)
    return np.where(hit_mask, depth, np.inf).astype(np.float32), brightness.astype(np.float32)
