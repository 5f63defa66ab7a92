"""The level face of a thing that bears something, and what stands up beside it: a seat, its back and its arms.

Seen from above, a seat or a table top is the largest area at about one height (PartNet's chairs, beds, benches and
tables: Mo et al., CVPR 2019). What stands higher on one side of it alone is its back; what does on the two sides
across from that are its arms.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy import ndimage

_COLUMNS = 48  # along the longer level side
_BAND = 0.05  # of the height, by which a level face may be off its level
_LEAST = 0.15  # share of what is seen from above
_LOWEST = 0.15  # of the height, below which a level face is the floor
_RIVAL = 0.8  # share of the largest from which on another face is as likely
_GAP = 0.06  # of the height without anything below the face, where it ends
_SLAB = 0.3  # of the height, that it is thick, at most
_MARGIN = 3  # columns beside what stands there, that what presses the face leaves out
_SPARSE = 0.15  # points per column, below which there is hardly anything
_RISE = 0.08  # of the height, above which something stands beside the face
_LINED = 0.5  # share of a side of the face, along which something stands there


@dataclasses.dataclass(frozen=True)
class Deck:
    """A level face and what stands beside it.

    Attributes:
        face: Which particles are its slab, shape (n,).
        back: Which ones stand up behind it, shape (n,); none = there is no back.
        arms: Which ones stand up on either side of it, shape (n,); none = there are none.
        front: The level way in which it is open, a unit vector of shape (3,); None = not told.
    """

    face: np.ndarray
    back: np.ndarray
    arms: np.ndarray
    front: np.ndarray | None


def find_deck(points: np.ndarray) -> Deck | None:
    """The level face of an object that lies along the axes; None if it has none, or two that are as large.

    Args:
        points: Its particles at rest, z up [m], shape (n, 3).
    """
    low, size = points.min(0), np.ptp(points, axis=0)
    cell = max(float(size[:2].max()) / _COLUMNS, 1e-12)
    column = ((points[:, :2] - low[:2]) / cell).astype(int)
    tops = np.full(column.max(0) + 1, -np.inf)
    np.maximum.at(tops, tuple(column.T), (points[:, 2] - low[2]) / max(float(size[2]), 1e-12))
    faces = _list_faces(tops)
    if not faces or len(faces) > 1 and faces[1][1].sum() > _RIVAL * faces[0][1].sum():
        return None
    level, area = faces[0]
    place, above = tuple(column.T), (points[:, 2] - low[2]) / size[2] - level
    open_air = np.asarray(ndimage.binary_fill_holes(area)) | (tops < level)
    inner = area & np.asarray(ndimage.binary_erosion(open_air, iterations=_MARGIN, border_value=1))
    face = inner[place] & (above > -_find_depth(above[inner[place]], int(inner.sum()))) & (above < 2 * _BAND)
    sides = _find_sides(tops, area, level)
    lined = [key for key, (share, _) in sides.items() if share > _LINED]
    backs = [key for key in lined if (key[0], -key[1]) not in lined]
    back, front = np.zeros(len(points), bool), None
    stands = (above > 0) & ~face
    first, last = (np.argwhere(area).min(0), np.argwhere(area).max(0))

    def pick(axis: int, sign: int) -> np.ndarray:
        beyond = column[:, axis] > last[axis] if sign > 0 else column[:, axis] < first[axis]
        return stands & beyond

    if backs:
        axis, sign = max(backs, key=lambda key: sides[key][0] * sides[key][1])
        front = np.eye(3)[axis] * -sign
        back = pick(axis, sign)
    else:
        axis = next((1 - key[0] for key in lined), 1)
    both = all((1 - axis, sign) in lined for sign in (-1, 1))
    arms = (pick(1 - axis, -1) | pick(1 - axis, 1)) & ~back if both else np.zeros(len(points), bool)
    return Deck(face, back, arms, front)


def _find_depth(above: np.ndarray, columns: int) -> float:
    """The thickness of a face over the height: down to where hardly anything is below it."""
    edges = np.arange(-_SLAB, 0.5 * _GAP, _GAP)
    sparse = np.flatnonzero(np.histogram(above, edges)[0] < _SPARSE * columns)
    return float(-edges[sparse.max() + 1]) if len(sparse) else _SLAB


def _list_faces(tops: np.ndarray) -> list[tuple[float, np.ndarray]]:
    """Level areas with their heights, largest first, each at another height than those before it."""
    seen = np.isfinite(tops)
    found: list[tuple[float, np.ndarray]] = []
    for level in np.arange(_LOWEST, 1.0, 0.5 * _BAND):
        labels = np.zeros(tops.shape, np.int32)
        ndimage.label(np.abs(tops - level) < _BAND, None, labels)
        sizes = np.bincount(labels.ravel())[1:]
        if len(sizes) and sizes.max() > _LEAST * seen.sum():
            found.append((float(level), labels == sizes.argmax() + 1))
    found.sort(key=lambda each: -each[1].sum())
    apart: list[tuple[float, np.ndarray]] = []
    for level, area in found:
        if all(abs(level - other) > 2 * _BAND for other, _ in apart):
            apart.append((float(np.median(tops[area])), area))
    return apart


def _find_sides(
    tops: np.ndarray, area: np.ndarray, level: float
) -> dict[tuple[int, int], tuple[float, float]]:
    """By axis and sign, the share of a side of the face along which something stands, and how high that is."""
    first, last = np.argwhere(area).min(0), np.argwhere(area).max(0)
    found = {}
    for axis in (0, 1):
        across = tops if axis == 0 else tops.T
        rows = slice(first[1 - axis], last[1 - axis] + 1)
        for sign in (-1, 1):
            beyond = across[last[axis] + 1 :, rows] if sign > 0 else across[: first[axis], rows]
            highest = beyond.max(0) if len(beyond) else np.full(last[1 - axis] - first[1 - axis] + 1, -np.inf)
            high = highest > level + _RISE
            found[axis, sign] = float(high.mean()), float(highest[high].mean() - level) if high.any() else 0.0
    return found
