"""The way in which something looks: a vehicle by its named ends or its low one, a figure by what overhangs.

A car has a hood in front of the cab, and is lower there. The head of a horse, a duck or a dragon juts out high up, over
nothing. What is as high at both ends, or overhangs all around, is not told.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from physagent_jax.forces.part import FRONT, REAR, Part, list_end_words

_FRONT = FRONT | frozenset(
    "hood bonnet headlight windshield windscreen grill grille steering bow nose".split()
)
_REAR = REAR | frozenset("tail taillight trunk exhaust stern spare".split())
_SLICES = 20  # along its length
_LOW = 0.72  # of the height, below which a slice is low
_MORE = 2  # slices by which the low part in front is longer than that at the back, at least
_LONG = 1.15  # length over breadth, at least
_SHOWN, _LOWER = 0.8, 0.7  # chances that a nose or a tail, or a low end, tells the front
_FIRST, _RISE = 3, 1.12  # slices in front that tell the height of a hood, and how much higher it may get
_CELLS, _HIGH, _JUTS, _ROOM = 32, 0.55, 0.12, 0.04  # cells of the longest side; of the height, above which an
# underside is high; of the length, by which such places are off the middle, and share of all places, at least
_STANDS = 0.3  # height over length of what has a front, at least
_APART = 0.1  # of the length, between the middles of what is named in front and behind


def find_heading(points: np.ndarray, parts: Sequence[Part]) -> tuple[np.ndarray, float] | None:
    """The level way in which a vehicle looks, and the chance that it is so; None if nothing tells it.

    Args:
        points: Particles at rest, z up [m], shape (n, 3).
        parts: Parts of it; names tell for certain.

    Returns:
        A unit vector along an axis, shape (3,), and the chance.
    """
    size, names = np.ptp(points, axis=0), list_end_words(parts)
    sides = [
        np.mean(
            [p.side for p, words in zip(parts, names) if told & {*words, *p.roles[:1]}] or [np.zeros(3)], 0
        )
        for told in (_FRONT, _REAR)
    ]
    told = sides[0] - sides[1]
    if float(np.hypot(*told[:2])) > _APART:
        axis = int(np.abs(told[:2]).argmax())
        return np.eye(3)[axis] * np.sign(told[axis]), 1.0 if any(
            (_FRONT | _REAR) & words for words in names
        ) else _SHOWN
    axis = int(size[:2].argmax())
    if size[axis] < _LONG * size[1 - axis]:
        return None
    tops = _measure_tops(points, np.eye(3)[axis])
    low = tops < _LOW
    if low.all():
        return None
    before, behind = int(low[::-1].argmin()), int(low.argmin())  # slices that are low at either end
    if abs(before - behind) < _MORE:
        return None
    return np.eye(3)[axis] * np.sign(before - behind), _LOWER


def find_overhang(points: np.ndarray) -> np.ndarray | None:
    """The level way to where something juts out high up, over nothing; None if it does so nowhere, or all around.

    Args:
        points: Particles at rest, z up [m], shape (n, 3).

    Returns:
        A unit vector, shape (3,).
    """
    low, size = points.min(0), np.ptp(points, axis=0)
    step = max(float(size.max()), 1e-12) / _CELLS
    index = np.floor((points - low) / step).astype(int)
    solid = np.zeros(index.max(0) + 1, bool)
    solid[tuple(index.T)] = True
    closed = ndimage.binary_closing(np.pad(solid, 2), np.ones((1, 1, 3), bool))
    solid = np.asarray(closed, bool)[2:-2, 2:-2, 2:-2]
    depth = solid.shape[2]
    top = np.where(solid.any(2), depth - 1 - solid[:, :, ::-1].argmax(2), 0)
    gap = ~solid & (np.arange(depth) < top[..., None])
    under = np.where(gap.any(2), depth - gap[:, :, ::-1].argmax(2), 0)  # of the topmost run
    places = np.argwhere(under + 0.5 > _HIGH * depth)
    if len(places) < _ROOM * solid.any(2).sum() or size[2] < _STANDS * size.max():
        return None
    off = (low[:2] + (places + 0.5) * step - points[:, :2].mean(0)).mean(0)
    away = float(np.hypot(*off))
    return np.array([*off, 0.0]) / away if away > _JUTS * size.max() else None


def find_hood(points: np.ndarray, way: np.ndarray) -> tuple[float, float]:
    """The place where a vehicle's low front begins, from back to front, and its height; both 0 .. 1 of the whole.

    Args:
        points: Particles at rest, z up [m], shape (n, 3).
        way: The level way in which it looks, a unit vector of shape (3,).
    """
    tops = _measure_tops(points, way)[::-1]  # the front first
    height = _RISE * float(np.median(tops[:_FIRST]))
    rises = np.flatnonzero(tops > height)
    return 1 - float(rises[0] if len(rises) else _SLICES) / _SLICES, min(height, 1.0)


def _measure_tops(points: np.ndarray, way: np.ndarray) -> np.ndarray:
    """The height of each slice along a way over the whole's, shape (slices,)."""
    along, height = points @ way, points[:, 2] - points[:, 2].min()
    place = (along - along.min()) / max(float(np.ptp(along)), 1e-12)
    tops = np.zeros(_SLICES)
    np.maximum.at(tops, np.minimum((place * _SLICES).astype(int), _SLICES - 1), height)
    return tops / max(float(height.max()), 1e-12)
