"""The straight edges of an object's foot, over which it tips: what has none tips over anywhere."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.strict import Vector

_STEP = 5  # [degrees] between the ways that are tried
_SOLE, _DEEP = (
    0.04,
    0.03,
)  # [L] over its lowest point, and behind the outermost one, that belong to foot and edge
_STRAIGHT = (
    0.6  # of the foot's breadth that an edge is long: of a round one, less than half borders on a line
)
_FEWEST = 12  # points of a foot


def find_foot_edges(points: np.ndarray) -> list[tuple[Vector, float]]:
    """The edges of the foot of points on an object's surface, z up, shape (n, 3); none where it is round.

    Each is the level unit vector across it, outwards, and how far it is from the middle of the object [L].
    """
    size = float(np.ptp(points, axis=0).max())
    foot = points[points[:, 2] <= points[:, 2].min() + _SOLE * size, :2]
    if len(foot) < _FEWEST:
        return []
    centre = 0.5 * (points[:, :2].min(0) + points[:, :2].max(0))
    angles = np.radians(np.arange(0, 360, _STEP))
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    found = [_measure(foot, centre, way, size) for way in ways]
    straight = np.array([share for share, _ in found])
    peaks = (straight >= np.roll(straight, 1)) & (straight > np.roll(straight, -1)) & (straight >= _STRAIGHT)
    return [
        ((float(ways[i, 0]), float(ways[i, 1]), 0.0), round(max(found[i][1], 0.0), 3))
        for i in np.flatnonzero(peaks)
    ]


def _measure(foot: np.ndarray, centre: np.ndarray, way: np.ndarray, size: float) -> tuple[float, float]:
    """The length of the foot's edge on one side over its breadth, and its distance from the middle [L]."""
    out, across = foot @ way, foot @ (-way[1], way[0])
    near = across[out >= out.max() - _DEEP * size]
    return float(np.ptp(near) / max(np.ptp(across), _DEEP * size)), float(out.max() - centre @ way) / size
