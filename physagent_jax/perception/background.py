"""The still background in depth: flat surfaces, like a floor and walls, that reach the picture's border.

All in inverse depth: a plane is linear in it over the picture, "no surface" is 0, and the noise of a depth camera,
which grows with the square of depth, is the same everywhere.
"""

from __future__ import annotations

import dataclasses

import numpy as np

RING = 0.05
"""Width of the border that shows the background [share of the picture's shorter side]."""
LEAST_SUPPORT = 0.08
"""Share of the border that a plane must explain to count."""
MOST_PLANES = 4
TRIALS = 300
MOST_HIDDEN = 0.05
"""A plane that would hide more of what is seen than this ends somewhere [share of the picture]."""
CLOSE = 0.006
"""Inverse depths that differ by less than this share are the same surface, however low the noise."""
OPEN = 0.5
"""Share of the border with depth below which "no depth" is the background."""


@dataclasses.dataclass(frozen=True)
class Background:
    """The place of the background.

    Attributes:
        inverse: Inverse depth of the nearest background surface, 0 where there is none [1/m], shape (H, W).
        tolerance: What stands out by more is in front [1/m].
        open: Whether "no depth" is background; otherwise it is a dropped pixel.
        explained: Share of the border that belongs to the surfaces found.
    """

    inverse: np.ndarray
    tolerance: float
    open: bool
    explained: float


def find_background(inverse: np.ndarray) -> Background:
    """Find flat surfaces by RANSAC over the border, then fit each to all its pixels.

    Args:
        inverse: Inverse depth, nan where unknown, shape (T, H, W).
    """
    count, height, width = inverse.shape
    ring = max(2, round(RING * min(height, width)))
    on_ring = np.ones((height, width), bool)
    on_ring[ring:-ring, ring:-ring] = False
    few = inverse[:: max(1, count // 6)]
    known = np.isfinite(few)
    if known[:, on_ring].mean() < OPEN:
        return Background(np.zeros((height, width)), 0.0, True, 1.0)
    with np.errstate(all="ignore"):
        typical = np.where(known.any(0), np.nanmedian(np.where(known.any(0), few, 0.0), axis=0), np.nan)
    noise = estimate_noise(inverse[0])
    level = float(np.nanmedian(typical[on_ring]))
    close = 3 * noise + CLOSE * level
    y, x = np.mgrid[:height, :width]
    grid = np.stack([x / width - 0.5, y / width - 0.5, np.ones_like(x)], -1)
    left = on_ring & np.isfinite(typical)
    total, rng, planes, explained = left.sum(), np.random.default_rng(0), [], 0
    while len(planes) < MOST_PLANES and left.sum() > LEAST_SUPPORT * total:
        plane = _fit_plane(grid[left], typical[left], close, rng)
        for _ in range(2):  # with what lies inside the picture as well
            own = np.abs(grid @ plane - typical) < close
            if own.sum() < 3:
                break
            plane = np.linalg.lstsq(grid[own], typical[own], rcond=None)[0]
        own = left & (np.abs(grid @ plane - typical) < close)
        if own.sum() < LEAST_SUPPORT * total:
            break
        planes.append(plane)
        explained += int(own.sum())
        left &= ~own
    surfaces = [_extend(grid @ plane, typical, close) for plane in planes]
    surface = np.max([np.zeros((height, width)), *surfaces], axis=0)
    return Background(surface, 2.5 * noise + CLOSE * level, False, explained / max(int(total), 1))


def _extend(surface: np.ndarray, typical: np.ndarray, close: float) -> np.ndarray:
    """A plane behind all that is seen goes on behind the object; one in front of much is only where it is seen."""
    with np.errstate(invalid="ignore"):
        hidden = typical < surface - close
        own = np.abs(typical - surface) < close
    return surface if hidden.mean() < MOST_HIDDEN else np.where(own, surface, 0.0)


def estimate_noise(inverse: np.ndarray) -> float:
    """Standard deviation of the noise, from second differences along rows: planes have none [1/m]."""
    second = np.abs(inverse[:, 2:] - 2 * inverse[:, 1:-1] + inverse[:, :-2])
    second = second[np.isfinite(second)]
    return float(np.median(second) / (0.6745 * np.sqrt(6))) if len(second) else 0.0


def _fit_plane(grid: np.ndarray, inverse: np.ndarray, close: float, rng: np.random.Generator) -> np.ndarray:
    """The plane through three points that most points are close to, fitted to these; shape (3,)."""
    thin = slice(None, None, max(1, len(grid) // 1500))
    g, w = grid[thin], inverse[thin]
    chosen = rng.integers(0, len(g), (TRIALS, 3))
    systems = g[chosen] + 1e-9 * np.eye(3)
    good = np.abs(np.linalg.det(systems)) > 1e-6
    planes = (
        np.linalg.solve(systems[good], w[chosen[good]][..., None])[..., 0] if good.any() else np.zeros((1, 3))
    )
    near = np.abs(planes @ g.T - w) < close
    own = near[near.sum(1).argmax()]
    if own.sum() < 3:
        return np.array([0.0, 0.0, float(np.median(w))])
    return np.linalg.lstsq(g[own], w[own], rcond=None)[0]
