"""Backgrounds of the object: nothing, a painted wall and floor, or a wall with a photo; with its depth."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Literal

import imageio.v3 as imageio
import numpy as np

from benchmarks.verdicts.recording import Recording
from physagent_jax.scene.surfels import value_noise

Background = Literal["plain", "painted", "photo"]
BACKGROUNDS: tuple[Background, ...] = ("plain", "painted", "photo")
WALL = 3.0  # [m] behind the object
LEAST_COVER = 0.5  # of a pixel, for the object's depth to be the pixel's
PHOTO = "coffee.png"
_PHOTO_HEIGHT = 4.0  # [m] of the photo on the wall; it goes on mirrored


def compose(clip: Recording, background: Background, data: Path | None) -> tuple[np.ndarray, np.ndarray]:
    """The clip before a background.

    Returns:
        Pictures, uint8, shape (T, H, W, 3), and z-depth [m], 0 where there is no surface, shape (T, H, W).
    """
    alpha = clip.alpha[..., None].astype(np.float32) / 255
    covered = clip.alpha >= LEAST_COVER * 255
    if background == "plain":  # as the product draws it for perception
        rgb = clip.rgb + (1 - alpha) * 255
        return np.clip(rgb + 0.5, 0, 255).astype(np.uint8), clip.depth
    colour, depth = _draw(clip, background, data)
    hidden = (clip.depth > depth + 0.05)[..., None] & covered[..., None]
    rgb = np.where(hidden, colour, clip.rgb + (1 - alpha) * colour)
    seen = covered & ~hidden[..., 0]
    return np.clip(rgb + 0.5, 0, 255).astype(np.uint8), np.where(seen, clip.depth, depth).astype(np.float32)


def _draw(clip: Recording, background: Background, data: Path | None) -> tuple[np.ndarray, np.ndarray]:
    """Colours in [0, 255], shape (H, W, 3), and depth [m], shape (H, W), of a wall and a floor."""
    camera = clip.camera
    view, K = np.asarray(camera.viewmat, float), np.asarray(camera.K, float)
    columns, rows = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    rays = np.stack([(columns - K[0, 2]) / K[0, 0], (rows - K[1, 2]) / K[1, 1], np.ones_like(rows)], -1)
    rays = rays @ view[:3, :3]  # into the world; a ray's parameter is its z-depth
    eye = camera.center
    away = camera.forward * [1, 1, 0]
    away = away / np.linalg.norm(away)
    right = camera.right
    to_wall = ((clip.middle - eye) @ away + WALL) / (rays @ away)
    with np.errstate(divide="ignore"):
        to_floor = np.where(rays[..., 2] < -1e-6, (clip.ground - eye[2]) / rays[..., 2], np.inf)
    floor = to_floor < to_wall
    depth = np.where(floor, to_floor, to_wall)
    points = eye + depth[..., None] * rays
    across, height, along = points @ right, points[..., 2] - clip.ground, points @ away
    flat = np.where(floor, along, height)
    if background == "photo" and (photo := _load_photo(data)) is not None:
        colour = _look_up(photo, across - clip.middle @ right, flat)
        colour = np.where(floor[..., None], 0.6 * colour + 50, colour)
    elif background == "photo":
        colour = _clutter(across, flat, floor)
    else:
        colour = _paint(across, flat, floor)
    return colour.astype(np.float32), depth


def _paint(across: np.ndarray, flat: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Wallpaper above floorboards, with stains."""
    points = np.stack([across, flat, floor * 5.0], -1).reshape(-1, 3)
    noise = value_noise(points, 1.5, 5).reshape(across.shape)
    grain = value_noise(points, 12.0, 6).reshape(across.shape)
    boards = 0.85 + 0.15 * (np.floor(across / 0.25) % 2)
    stripes = 0.9 + 0.1 * np.sign(np.sin(2 * np.pi * across / 0.5))
    tone = (0.6 + 0.35 * noise + 0.25 * (grain - 0.5)) * np.where(floor, boards, stripes)
    base = np.where(floor[..., None], [150, 112, 78], [150, 168, 176])
    return base * tone[..., None] * 1.15


def _clutter(across: np.ndarray, flat: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Painted wall in place of a photo: posters, discs and stains of many colours, as a full shelf has them."""
    rng = np.random.default_rng(8)
    colour = _paint(across, flat, floor)
    for _ in range(120):
        x, y, size = rng.uniform(-5, 5), rng.uniform(-0.5, 4), rng.uniform(0.1, 0.6)
        shade = rng.uniform(30, 225, 3)
        u, v = (across - 4 - x) / size, (flat - y) / (size * rng.uniform(0.5, 1.5))
        inside = (np.hypot(u, v) < 1) if rng.uniform() < 0.4 else (np.maximum(abs(u), abs(v)) < 1)
        colour = np.where(
            (inside & ~floor)[..., None], shade * (0.8 + 0.2 * np.clip(v, -1, 1))[..., None], colour
        )
    return colour


@cache
def _load_photo(data: Path | None) -> np.ndarray | None:
    if data is None or not (data / PHOTO).is_file():
        return None
    return np.asarray(imageio.imread(data / PHOTO))[..., :3].astype(np.float32)


def _look_up(photo: np.ndarray, across: np.ndarray, up: np.ndarray) -> np.ndarray:
    """The photo on a plane, mirrored at its edges."""
    rows, columns = photo.shape[:2]
    scale = rows / _PHOTO_HEIGHT

    def fold(at: np.ndarray, count: int) -> np.ndarray:
        at = np.floor(at).astype(int) % (2 * count)
        return np.where(at < count, at, 2 * count - 1 - at)

    return photo[fold(rows - 1 - up * scale, rows), fold(across * scale + columns / 2, columns)]
