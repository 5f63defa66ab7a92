"""Distances from the nodes of a grid to triangles: exact in a band about the surface, to one near triangle beyond it.

Triangles larger than the cells are rasterised along the axis that their normal is nearest to: a row of nodes is cut
where the triangle, grown by the width of the band, leaves it; across the plane only nodes within that width are taken.
Small ones are found from the nodes by a tree, size by size. So the work goes with the area of the surface, whatever the
size of its triangles. Beyond the band each node takes over the nearest triangle of a neighbour while that is nearer.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from scipy import ndimage
from scipy.spatial import KDTree

from physagent_jax.core.errors import UserError
from physagent_jax.scene.closest_points import Surface

BAND = 2.5  # cells to either side of the surface within which distances are exact
MOST_PAIRS = 200_000_000  # of nodes and triangles, about a minute
_PAIRS = 500_000  # of them at once
_SIZES = (2.0, 1.0, 0.5, 0.25, 0.0)  # longest edges in cells between which small triangles share a tree
_GAIN = 1e-3  # share of a squared distance beyond the band that is worth another look
_ROUNDS = 4  # of looks at the neighbours; the first two change anything much


def measure_distances(triangles: np.ndarray, shape: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Distances from the nodes (i, j, k) of a grid to the nearest triangle.

    Args:
        triangles: Corners in cells from the first node, shape (m, 3, 3).
        shape: Nodes along each axis.

    Returns:
        Distances in cells, shape ``shape``, exact where they are at most `BAND`; and whether they are exact. Distances
        are infinite where no node lies in the band.

    Raises:
        UserError: There are more than `MOST_PAIRS` of nodes and triangles near them.
    """
    field = _Field(Surface(triangles), shape)
    size = np.sqrt((field.surface.edges**2).sum(2).max(1))
    large = np.flatnonzero(size > _SIZES[0])
    _check_pairs(_bound_pairs(field.surface, large, np.asarray(shape))[0].sum(), len(triangles))
    for t, nodes in _list_pairs(field.surface, large, np.asarray(shape)):
        field.update(t, np.asarray(np.ravel_multi_index(tuple(nodes.T), shape)))
    for most, least in zip(_SIZES, _SIZES[1:]):
        small = np.flatnonzero((size <= most) & (size > least if least else size >= 0))
        if len(small):
            _measure_small(field, small)
    exact = field.squared <= BAND**2
    if exact.any():
        _measure_far(field, exact)
    return np.sqrt(field.squared).reshape(shape), exact.reshape(shape)


def _check_pairs(count: float, triangle_count: int) -> None:
    if count > MOST_PAIRS:
        raise UserError(
            "the mesh is too fine or too large for the grid",
            got=f"{triangle_count:,} triangles, {count:,.4g} distances, at most {MOST_PAIRS:,.4g}",
            do="Simplify the mesh, or use fewer `domain.cells`",
        )


class _Field:
    """The nearest triangles found so far.

    Attributes:
        surface: The triangles.
        shape: Nodes along each axis.
        squared: Squared distances [cells^2], shape (nodes,).
        owner: Nearest triangles, shape (nodes,).
    """

    def __init__(self, surface: Surface, shape: tuple[int, int, int]):
        self.surface, self.shape = surface, shape
        self.squared = np.full(int(np.prod(shape)), np.inf)
        self.owner = np.zeros(len(self.squared), np.int32)

    def find_points(self, nodes: np.ndarray) -> np.ndarray:
        """Positions of nodes [cells], shape (k, 3)."""
        return np.stack(np.unravel_index(nodes, self.shape), axis=1).astype(float)

    def update(self, t: np.ndarray, nodes: np.ndarray) -> None:
        """Try the triangles ``t`` at ``nodes``, shapes (k,)."""
        points = self.find_points(nodes)
        found = ((points - self.surface.find_closest(t, points)) ** 2).sum(1)
        before = self.squared[nodes]
        np.minimum.at(self.squared, nodes, found)
        best = (found < before) & (found == self.squared[nodes])
        self.owner[nodes[best]] = t[best]


def _bound_pairs(
    surface: Surface, t: np.ndarray, shape: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Most pairs of the triangles ``t``, their axes (that of the normal last), and first and last nodes along them."""
    low, high = surface.triangles[t].min(1), surface.triangles[t].max(1)
    along = np.where(surface.flat[t, None], low - high, np.abs(surface.normal[t])).argmax(1)
    axes = (along[:, None] + np.array([1, 2, 0])) % 3
    low, high = (np.take_along_axis(each, axes, axis=1) for each in (low, high))
    last = shape[axes] - 1
    low = np.clip(np.ceil(low - BAND), 0, last + 1).astype(int)
    high = np.clip(np.floor(high + BAND), -1, last).astype(int)
    sides = np.maximum(high - low + 1, 0)
    layers = np.minimum(sides[:, 2], 2 * np.ceil(BAND * np.sqrt(3)) + 1)
    return sides[:, 0] * sides[:, 1] * layers, axes, low, high


def _list_pairs(
    surface: Surface, t: np.ndarray, shape: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Some of the triangles ``t`` and nodes, shape (k, 3), that may be as near as `BAND`, some pairs at a time."""
    most, axes, low, high = _bound_pairs(surface, t, shape)
    for part in _split_chunks(most):
        yield _rasterise(surface, t[part], axes[part], low[part], high[part])


def _split_chunks(costs: np.ndarray) -> list[slice]:
    """Consecutive slices of about `_PAIRS` in cost each."""
    total = np.cumsum(costs)
    if len(total) == 0:
        return []
    bounds = np.searchsorted(total, np.arange(_PAIRS, total[-1], _PAIRS))
    edges = np.unique(np.concatenate([[0], bounds, [len(total)]])).astype(int)
    return [slice(a, b) for a, b in zip(edges[:-1], edges[1:])]


def _rasterise(
    surface: Surface, t: np.ndarray, axes: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of the triangles ``t``, shape (k,), and nodes, shape (k, 3)."""
    corners = np.take_along_axis(surface.triangles[t], axes[:, None], axis=2)
    normal = np.take_along_axis(surface.normal[t], axes, axis=1)
    # rows of each triangle, and what the grown triangle covers of them
    mine, v = _expand(low[:, 1], high[:, 1])
    left, right = _cut_strip(corners[mine][:, :, :2], v - BAND, v + BAND)
    beside = np.maximum(corners[mine, :, 1].min(1) - v, v - corners[mine, :, 1].max(1))
    width = np.sqrt(BAND**2 - np.maximum(beside, 0) ** 2)
    left = np.maximum(np.ceil(left - width), low[mine, 0]).astype(int)
    right = np.minimum(np.floor(right + width), high[mine, 0]).astype(int)
    row, u = _expand(left, right)
    mine, v = mine[row], v[row]
    # heights of the plane there, and the layers about it
    steep = surface.flat[t]
    slope = np.where(steep, 1.0, normal[:, 2])
    offset = np.stack([u, v], axis=1) - corners[mine, 0, :2]
    height = corners[mine, 0, 2] - (offset * normal[mine, :2]).sum(1) / slope[mine]
    reach = np.where(steep, np.inf, BAND * np.linalg.norm(normal, axis=1) / np.abs(slope))[mine]
    bottom = np.clip(np.ceil(height - reach), low[mine, 2], high[mine, 2] + 1).astype(int)
    top = np.clip(np.floor(height + reach), low[mine, 2] - 1, high[mine, 2]).astype(int)
    column, w = _expand(bottom, top)
    mine = mine[column]
    nodes = np.empty((len(w), 3), int)
    np.put_along_axis(nodes, axes[mine], np.stack([u[column], v[column], w], axis=1), axis=1)
    return t[mine], nodes


def _expand(first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All whole numbers from ``first`` to ``last``, and which of the pairs each is from."""
    counts = np.maximum(last - first + 1, 0)
    source = np.repeat(np.arange(len(first)), counts)
    within = np.arange(len(source)) - np.repeat(counts.cumsum() - counts, counts)
    return source, first[source] + within


def _cut_strip(corners: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest x of plane triangles, shape (k, 3, 2), where y lies in strips; inf and -inf outside."""
    x, y = corners[..., 0], corners[..., 1]
    inside = (y >= low[:, None]) & (y <= high[:, None])
    least, greatest = np.where(inside, x, np.inf).min(1), np.where(inside, x, -np.inf).max(1)
    for side in range(3):
        x0, y0, x1, y1 = x[:, side], y[:, side], x[:, side - 2], y[:, side - 2]
        for level in (low, high):
            crosses = (y0 - level) * (y1 - level) < 0
            share = (level - y0) / np.where(crosses, y1 - y0, 1.0)
            at = x0 + share * (x1 - x0)
            least = np.minimum(least, np.where(crosses, at, np.inf))
            greatest = np.maximum(greatest, np.where(crosses, at, -np.inf))
    empty = ~np.isfinite(least)
    return np.where(empty, 1.0, least), np.where(empty, -2 * BAND, greatest)


def _measure_small(field: _Field, t: np.ndarray) -> None:
    """Exact distances in the band to triangles ``t`` that are small against the cells."""
    corners = field.surface.triangles[t]
    centres = corners.mean(1)
    radius = float(np.linalg.norm(corners - centres[:, None], axis=2).max())
    nodes = _find_nodes_near(centres, BAND + radius, field.shape)
    if not len(nodes):
        return
    points, tree = field.find_points(nodes), KDTree(centres)
    to_centre = np.asarray(tree.query(points, distance_upper_bound=BAND + radius)[0])
    # The nearest triangle has its centre within what is known of the distance, plus its own radius.
    known = np.minimum(np.minimum(np.sqrt(field.squared[nodes]), to_centre), BAND)
    reach = known + radius + 1e-9
    near = to_centre <= reach
    nodes, points, reach = nodes[near], points[near], reach[near]
    counts = np.asarray(tree.query_ball_point(points, reach, return_length=True))
    _check_pairs(counts.sum(), len(t))
    for part in _split_chunks(counts):
        lists = tree.query_ball_point(points[part], reach[part])
        found = t[np.concatenate(lists).astype(int)]
        field.update(found, np.repeat(nodes[part], [len(each) for each in lists]))


def _find_nodes_near(centres: np.ndarray, reach: float, shape: tuple[int, int, int]) -> np.ndarray:
    """Nodes that may be as near as ``reach`` to any centre, and some more."""
    margin = int(np.ceil(reach)) + 1
    size = np.asarray(shape) + 2 * margin
    cells = np.round(centres).astype(int) + margin
    cells = cells[((cells >= 0) & (cells < size)).all(1)]
    free = np.ones(size, bool)
    free[tuple(cells.T)] = False
    if free.all():
        return np.zeros(0, int)
    away = ndimage.distance_transform_edt(free)
    inner = tuple(slice(margin, margin + count) for count in shape)
    return np.flatnonzero(np.asarray(away)[inner] <= reach + np.sqrt(3) / 2)


def _measure_far(field: _Field, exact: np.ndarray) -> None:
    """Distances beyond the band, to a triangle from which no neighbour knows a nearer one."""
    shape, owner = field.shape, field.owner
    source = np.asarray(
        ndimage.distance_transform_edt(~exact.reshape(shape), return_distances=False, return_indices=True)
    )
    owner[:] = owner[np.ravel_multi_index(tuple(source.reshape(3, -1)), shape)]
    closest = np.empty((len(owner), 3))
    everywhere = np.arange(len(owner))
    for part in _split_chunks(np.ones(len(owner))):
        closest[part] = field.surface.find_closest(owner[part], field.find_points(everywhere[part]))
    for _ in range(_ROUNDS):
        giver = _choose_neighbours(closest.reshape(*shape, 3))
        nodes = np.flatnonzero((giver != everywhere) & ~exact & (owner[giver] != owner))
        if not len(nodes):
            break
        theirs = owner[giver[nodes]]  # as they were before this round
        for part in _split_chunks(np.ones(len(nodes))):
            at, points = nodes[part], field.find_points(nodes[part])
            closest[at] = field.surface.find_closest(theirs[part], points)
            owner[at] = theirs[part]
    far = np.flatnonzero(~exact)
    for part in _split_chunks(np.ones(len(far))):
        at = far[part]
        field.squared[at] = ((field.find_points(at) - closest[at]) ** 2).sum(1)


def _choose_neighbours(closest: np.ndarray) -> np.ndarray:
    """Indices of the neighbours with the nearest closest points (a node may keep its own), shape (nodes,).

    A neighbour's point is no nearer than the point of the same triangle that is closest to the node itself, so that
    taking over its triangle never loses.
    """
    shape = closest.shape[:3]
    axes = np.ogrid[tuple(slice(count) for count in shape)]
    parts = [closest[..., axis] for axis in range(3)]
    least = (1 - _GAIN) * np.sum([(axis - part) ** 2 for axis, part in zip(axes, parts)], axis=0)
    index = np.arange(least.size).reshape(shape)
    giver = index.copy()
    for step in itertools.product((-1, 0, 1), repeat=3):
        if not any(step):
            continue
        here = tuple(slice(max(0, -s), n - max(0, s)) for s, n in zip(step, shape))
        there = tuple(slice(max(0, s), n - max(0, -s)) for s, n in zip(step, shape))
        squared = np.zeros(least[here].shape)
        for axis, (coordinate, part) in enumerate(zip(axes, parts)):
            own = [slice(None)] * 3  # the coordinate varies along its axis only
            own[axis] = here[axis]
            squared += (coordinate[tuple(own)] - part[there]) ** 2
        nearer = squared < least[here]
        least[here][nearer] = squared[nearer]
        giver[here][nearer] = index[there][nearer]
    return giver.reshape(-1)
