"""The solid that a particle cloud stands for, as cells of a lattice.

Particles lie densely on the surface and sparsely inside. What the surface encloses is solid, whatever lies in it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy import ndimage
from scipy.spatial import KDTree

_FEWEST_CELLS, _MOST_CELLS = 24, 64  # along the longest side
_CELLS_PER_SPACING = 1.3
_CLOSED = 0.95  # spacings within which a cell is closed up
_ERODED = 0.6  # spacings that closing has added around
_WIDER = (1.0, 1.5, 2.25)  # times that, within which it is closed up if the solid leaks
_LEAKED = 2.0  # times the cells, from which on closing up larger holes shows that it has
_SPECK = 0.01  # share of the solid
_PAD = 4  # empty cells around
_ALL = np.ones((3, 3, 3), bool)


@dataclasses.dataclass(frozen=True)
class Lattice:
    """The largest connected piece of a cloud, as solid cells.

    Attributes:
        solid: Whether a cell is solid, shape (nx, ny, nz).
        node: Place of each solid cell in ``places``; -1 = empty, shape (nx, ny, nz).
        places: Centres of the solid cells [m], shape (n, 3).
        spacing: Side of a cell [m].
    """

    solid: np.ndarray
    node: np.ndarray
    places: np.ndarray
    spacing: float

    def pick(self, mask: np.ndarray) -> np.ndarray:
        """The nodes of solid cells in a mask, shape (k,)."""
        return self.node[mask & self.solid]

    def make_mask(self, nodes: np.ndarray) -> np.ndarray:
        """The cells of nodes as a mask, shape (nx, ny, nz)."""
        chosen = np.zeros(len(self.places) + 1, bool)  # the last one stands for empty cells
        chosen[nodes] = True
        return chosen[self.node]

    def is_solid(self, place: np.ndarray) -> bool:
        """Return whether a place [m], shape (3,), is in a solid cell."""
        index = (
            np.floor((place - self.places[0]) / self.spacing + 0.5).astype(int) + np.argwhere(self.solid)[0]
        )
        inside = (index >= 0).all() and (index < self.solid.shape).all()
        return bool(inside and self.solid[tuple(index)])

    def complete(self, nodes: np.ndarray) -> np.ndarray:
        """The nodes of a part with the specks that it cuts off from the rest."""
        labels = find_pieces(self.solid & ~self.make_mask(nodes))
        sizes = np.bincount(labels.ravel())
        specks = (sizes < _SPECK * len(self.places)) & (np.arange(len(sizes)) > 0)
        return np.union1d(nodes, self.pick(specks[labels]))

    def find_necks(self, nodes: np.ndarray) -> list[np.ndarray]:
        """The connected sets of nodes where a part touches the rest, largest first."""
        part = self.make_mask(nodes)
        rim = part & _grow(self.solid & ~part)
        labels = find_pieces(rim)[self.solid]  # in the order of the nodes
        return sorted((np.flatnonzero(labels == k + 1) for k in range(labels.max())), key=len, reverse=True)

    def fill_vessels(self) -> np.ndarray:
        """The solid with what it could hold, walled in below and at four sides, as a mask of shape (nx, ny, nz)."""
        sides = [_shade(self.solid, axis, back) for axis in (0, 1) for back in (False, True)]
        return self.solid | np.logical_and.reduce([*sides, _shade(self.solid, 2, False)])


def find_depth(mask: np.ndarray) -> np.ndarray:
    """The distance of each cell of a mask from the nearest one outside [cells], of the mask's shape."""
    return np.asarray(ndimage.distance_transform_edt(mask), np.float64)


def find_pieces(mask: np.ndarray, *, corners: bool = True) -> np.ndarray:
    """The number of the connected piece that each cell of a mask belongs to, from 1; 0 outside it.

    Args:
        mask: Cells, shape (nx, ny, nz).
        corners: Whether cells that touch at an edge or a corner are connected too.
    """
    labels = np.zeros(mask.shape, np.int32)
    ndimage.label(mask, _ALL if corners else None, labels)
    return labels


def _grow(mask: np.ndarray) -> np.ndarray:
    """The cells of a mask and their 26 neighbours, of the mask's shape; nothing of it lies at the edge."""
    for axis in range(3):
        mask = mask | np.roll(mask, 1, axis) | np.roll(mask, -1, axis)
    return mask


def _shade(solid: np.ndarray, axis: int, back: bool) -> np.ndarray:
    """The cells that have a solid one before them along an axis (after them if ``back``)."""
    turned = np.flip(solid, axis) if back else solid
    seen = np.logical_or.accumulate(turned, axis)
    return np.flip(seen, axis) if back else seen


def _close(near: np.ndarray, reach: float, eroded: float, spacing: float) -> np.ndarray:
    """The solid of cells that lie within a reach of the nearest point [m], and of what they enclose."""
    closed = np.asarray(ndimage.binary_fill_holes(near <= reach))
    return find_depth(closed) > eroded / spacing + 0.5


def make_lattice(points: np.ndarray) -> Lattice:
    """The solid of a cloud.

    Args:
        points: Positions [m], shape (n, 3).
    """
    low, size = points.min(0), max(float(np.ptp(points, axis=0).max()), 1e-12)
    tree = KDTree(points)
    distances = np.asarray(tree.query(points, min(5, len(points)))[0]).reshape(len(points), -1)
    gap = max(float(np.median(distances[:, -1])), 1e-9 * size)
    spacing = size / float(np.clip(_CELLS_PER_SPACING * size / gap, _FEWEST_CELLS, _MOST_CELLS))
    shape = np.floor((points.max(0) - low) / spacing).astype(int) + 1 + 2 * _PAD
    grid = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1)
    centres = low + (grid - _PAD + 0.5) * spacing
    reach, eroded = max(_CLOSED * gap, 0.9 * spacing), max(_ERODED * gap, 0.5 * spacing)
    near = np.asarray(tree.query(centres.reshape(-1, 3), distance_upper_bound=_WIDER[-1] * reach)[0])
    solids = (_close(near.reshape(shape), k * reach, k * eroded, spacing) for k in _WIDER)
    solid = next(solids)
    for wider in solids:  # where a cloud is thin its surface has holes, by which what it encloses is lost
        if wider.sum() <= _LEAKED * solid.sum():
            break
        solid = wider
    solid[tuple(((points - low) / spacing).astype(int).T + _PAD)] = True
    labels = find_pieces(solid)
    solid = labels == np.bincount(labels[labels > 0]).argmax()
    node = np.full(shape, -1)
    node[solid] = np.arange(solid.sum())
    return Lattice(solid, node, centres[solid], spacing)
