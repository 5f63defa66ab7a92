"""The way in which a vehicle looks: by the ends that its file names or its shape shows, else by where it is low.

A car has a hood in front of the cab, and is lower there. What is as high at both ends is not told.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physagent_jax.forces.part import Part, split_name

_FRONT = frozenset("front hood bonnet headlight windshield windscreen grill grille steering bow nose".split())
_REAR = frozenset("rear back tail taillight trunk exhaust stern spare".split())
_SLICES = 20  # along its length
_LOW = 0.72  # of the height, below which a slice is low
_MORE = 2  # slices by which the low part in front is longer than that at the back, at least
_LONG = 1.15  # length over breadth, at least
_SHOWN, _LOWER = 0.8, 0.7  # chances that a nose or a tail, or a low end, tells the front
_FIRST, _RISE = 3, 1.12  # slices in front that tell the height of a hood, and how much higher it may get
_APART = 0.1  # of the length, between the middles of what is named in front and behind


def find_heading(points: np.ndarray, parts: Sequence[Part]) -> tuple[np.ndarray, float] | None:
    """The level way in which a vehicle looks, and the chance that it is so; None if nothing tells it.

    Args:
        points: Particles at rest, z up [m], shape (n, 3).
        parts: Parts of it; names tell for certain.

    Returns:
        A unit vector along an axis, shape (3,), and the chance.
    """
    size = np.ptp(points, axis=0)
    sides = [
        np.mean([p.side for p in parts if words & {*split_name(p.name), *p.roles[:1]}] or [np.zeros(3)], 0)
        for words in (_FRONT, _REAR)
    ]
    told = sides[0] - sides[1]
    if float(np.hypot(*told[:2])) > _APART:
        axis, ends = int(np.abs(told[:2]).argmax()), _FRONT | _REAR
        named = any(ends & {*split_name(part.name)} for part in parts)
        return np.eye(3)[axis] * np.sign(told[axis]), 1.0 if named else _SHOWN
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
