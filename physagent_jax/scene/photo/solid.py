"""A solid behind an outline: inflated, and its surface as evenly spaced points.

Positions are in steps of a grid that lies over the photo: column, row, and depth away from the camera. A solid is all
places whose depth is within ``half`` of ``middle``.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy import ndimage, sparse
from scipy.sparse.linalg import spsolve

ROUNDNESS = 3.0  # of the equation's right side: a ball needs 4, a long rod 2
BASE = 0.025  # of the height, in which the foot of the outline is cut flat
STEEP = 0.4  # cosine of the slope from which on lines along columns and rows fill in what the front leaves
COARSER = 2  # times the spacing of points that the camera does not see


@dataclasses.dataclass(frozen=True)
class Solid:
    """A solid that has one front and one back in each cell of a grid.

    Attributes:
        mask: Cells that hold some of it, bool, shape (h, w).
        square: Square of half its thickness, also where it is cut off by the mask [steps^2], shape (h, w).
        middle: Depth midway between front and back [steps], shape (h, w).
    """

    mask: np.ndarray
    square: np.ndarray
    middle: np.ndarray


@dataclasses.dataclass(frozen=True)
class Surface:
    """Points on the surface of a solid.

    Attributes:
        places: Column, row and depth [steps], shape (n, 3).
        normals: Outward unit normals, shape (n, 3).
        spacing: Distance from one to the next [steps], shape (n,).
        front: Whether it is the front of its cell, shape (n,).
    """

    places: np.ndarray
    normals: np.ndarray
    spacing: np.ndarray
    front: np.ndarray


def inflate(mask: np.ndarray) -> np.ndarray:
    """The square of half the thickness of an inflated outline [steps^2], shape (h, w).

    It solves the Poisson equation with a constant right side, zero along the outline (Baran and Lehtinen, "Notes on
    inflating curves", 2009): a circle becomes a ball, as 4 (R^2 - r^2) / 4 is the square of its depth. The foot is not
    rounded off: the solid is half of one that is its own image in a plane through the foot.
    """
    rows = np.flatnonzero(mask.any(axis=1))
    foot = rows[-1]
    plane = foot - round(BASE * (rows[-1] - rows[0] + 1))  # its image has row 2 * plane + 1 - row
    whole = np.zeros((max(2 * plane + 2 - rows[0], foot + 1) + 1, mask.shape[1]), bool)
    whole[: foot + 1] = mask[: foot + 1]
    own = np.arange(rows[0], plane + 1)
    whole[2 * plane + 1 - own] |= mask[own]
    padded = np.pad(whole, 1)
    index = np.full(padded.shape, -1)
    index[padded] = np.arange(padded.sum())
    at = np.argwhere(padded)
    first, second = [], []
    for step in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        beside = index[tuple((at + step).T)]
        first.append(np.flatnonzero(beside >= 0))
        second.append(beside[beside >= 0])
    row, column = np.concatenate(first), np.concatenate(second)
    count = len(at)
    matrix = sparse.diags(np.full(count, 4.0)) - sparse.coo_matrix(
        (np.ones(len(row)), (row, column)), shape=(count, count)
    )
    square = np.zeros(padded.shape)
    square[padded] = np.asarray(spsolve(matrix.tocsc(), np.full(count, ROUNDNESS)))
    inner = square[1:-1, 1:-1]
    fitted = np.zeros(mask.shape)
    height = min(len(fitted), len(inner))
    fitted[:height] = inner[:height]
    return np.maximum(fitted, 0.0)


def find_surface(solid: Solid) -> Surface:
    """Points where lines along the axes of the grid pass through the surface.

    Along depth each cell of the front has one, so that the photo is kept pixel by pixel. Lines along columns and rows
    fill in what is steep: those count where the normal points along them most. Behind, they are `COARSER`.
    """
    # One more cell all around: a solid that the picture cuts off is closed at its edge.
    square, middle = (np.pad(each, 1, mode="edge") for each in (solid.square, solid.middle))
    solid = Solid(np.pad(solid.mask, 1), square, middle)
    mask = solid.mask
    half = np.sqrt(np.where(mask, square, 0.0))
    slopes = [np.gradient(each) for each in (square, _extend(middle, mask))]
    low, high = np.where(mask, middle - half, np.inf), np.where(mask, middle + half, -np.inf)

    def find_normals(row, column, depth):
        """Outward normals at cells (nearest) and depths: minus the gradient of square - (depth - middle)^2."""
        off = depth - middle[row, column]
        gradient = [slopes[0][axis][row, column] + 2 * off * slopes[1][axis][row, column] for axis in (1, 0)]
        normal = np.stack([-gradient[0], -gradient[1], 2 * off], axis=1)
        return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)

    parts = []
    for depths, seen in ((low, True), (high, False)):
        row, column = np.nonzero(mask)
        depth = depths[row, column]
        normal = find_normals(row, column, depth)
        keep = np.full(len(row), True)
        if not seen:
            keep = (row % COARSER == 0) & (column % COARSER == 0)
            keep &= np.abs(normal[:, 2]) >= np.abs(normal[:, :2]).max(axis=1)
        places = np.stack([column, row, depth], axis=1)[keep]
        parts.append((places, normal[keep], 1 if seen else COARSER, seen))
    for level in range(int(np.floor(low.min())), int(np.ceil(high.max())) + 1):
        inside = (low <= level) & (level <= high)
        for axis in (0, 1):
            parts += _cross(solid, inside, level, axis, find_normals)
    return Surface(
        np.concatenate([places for places, *_ in parts]) - [1, 1, 0],
        np.concatenate([normal for _, normal, *_ in parts]),
        np.concatenate([np.full(len(places), float(spacing)) for places, _, spacing, _ in parts]),
        np.concatenate([np.full(len(places), seen) for places, *_, seen in parts]),
    )


def _extend(values: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Values with those of the nearest cell of the mask outside of it."""
    at = ndimage.distance_transform_edt(~mask, return_distances=False, return_indices=True)
    return values[tuple(np.asarray(at))]


def _cross(solid: Solid, inside: np.ndarray, level: int, axis: int, find_normals) -> list[tuple]:
    """Points at one depth where lines along rows (0) or columns (1) enter or leave the solid."""
    change = np.diff(inside.astype(np.int8), axis=axis)
    row, column = np.nonzero(change)
    if not len(row):
        return []
    beyond = (row + (axis == 0), column + (axis == 1))
    leaves = change[row, column] < 0
    within = tuple(np.where(leaves, each, other) for each, other in zip((row, column), beyond))
    without = tuple(np.where(leaves, other, each) for each, other in zip((row, column), beyond))
    sign = np.where(leaves, 1.0, -1.0)
    room = [solid.square[at] - (level - solid.middle[at]) ** 2 for at in (within, without)]
    both = solid.mask[without]
    # Where the mask cuts the solid off, as at its foot, the surface runs midway between two cells.
    share = np.where(both, room[0] / np.maximum(room[0] - room[1], 1e-9), 0.5)
    normal = find_normals(*within, np.full(len(row), float(level)))
    cut = ~both & (room[1] > 0)
    along = 1 - axis
    normal[cut] = np.eye(3)[along]
    normal[cut] *= sign[cut][:, None]
    places = np.stack([within[1], within[0], np.full(len(row), level)], axis=1).astype(float)
    places[:, along] += sign * np.clip(share, 0, 1)
    keep = np.abs(normal[:, along]) >= np.delete(np.abs(normal), along, axis=1).max(axis=1) - 1e-9
    steep = np.abs(normal[:, 2]) < STEEP
    hidden = level > solid.middle[within]
    other = within[0] if axis == 1 else within[1]
    thinned = (other % COARSER == 0) & (level % COARSER == 0)
    seen, behind = keep & steep & ~hidden, keep & hidden & thinned
    return [(places[seen], normal[seen], 1, False), (places[behind], normal[behind], COARSER, False)]
