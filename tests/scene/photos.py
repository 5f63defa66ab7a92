"""Photos of bodies whose outline and volume are known, drawn over a background with colours of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

WIDTH, HEIGHT = 160, 120
BALL_VOLUME = np.pi / 6  # of a ball whose longest side is 1


def draw_background() -> np.ndarray:
    """A bright wall with a gradient and grain, and a darker floor, in [0, 1]."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    wall = np.stack([0.55 + 0.002 * y, 0.65 + 0.001 * x, 0.8 - 0.001 * y], axis=2)
    wall[y > 0.75 * HEIGHT] = (0.45, 0.42, 0.38)
    return np.clip(wall + np.random.default_rng(0).normal(0, 0.015, wall.shape), 0, 1)


def make_ball_mask(radius: float = 34, centre: tuple[float, float] = (80, 62)) -> np.ndarray:
    """The outline of a ball [px]."""
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    return (x - centre[0]) ** 2 + (y - centre[1]) ** 2 < radius**2


def make_post_mask() -> np.ndarray:
    """The outline of an upright post with a flat foot."""
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    return (np.abs(x - 70) < 12) & (y > 20) & (y < 104)


def write_photo(path: Path, mask: np.ndarray, **options) -> np.ndarray:
    """Write a photo whose object has warm stripes and shade; return it, uint8, shape (h, w, 3)."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    stripes = np.where(((x + y) // 9 % 2 == 0)[..., None], (0.85, 0.25, 0.1), (0.7, 0.1, 0.15))
    shaded = stripes * (1 - 0.25 * (x / WIDTH))[..., None]
    rgb = np.rint(255 * np.where(mask[..., None], shaded, draw_background())).astype(np.uint8)
    Image.fromarray(rgb).save(path, **options)
    return rgb


def measure_overlap(first: np.ndarray, second: np.ndarray) -> float:
    """Intersection over union of two masks."""
    return float((first & second).sum() / (first | second).sum())
