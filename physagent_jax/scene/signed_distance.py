"""Closed meshes as signed distances on a regular grid, for `mpm.SignedDistance`.

Near the surface the distances are those to the triangles, exact to round-off. Deep inside and far outside,
where an obstacle needs only the sign and a rough direction, they are those to one near triangle. The sign
comes from the winding number along vertical lines, so parts of the mesh may overlap; but deep inside such a
solid the distance is that to its inner faces.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import KDTree

from physagent_jax.core.errors import UserError
from physagent_jax.scene.mesh_files import read_mesh

MARGIN = 3  # cells around the mesh
BAND = 2.5  # cells to either side of the surface within which distances are exact
# What a mesh may cost, about a minute each: where many pieces are equally far, as in a ball, a sample takes 50 us.
_MOST_SAMPLES = 1_200_000
_MOST_PIECES = 20_000_000
_MOST_PAIRS = 1_000_000_000  # of lines or samples and the triangles near them
_FARTHEST = 1e9  # cells from the origin: float64 still places the surface to 1e-6 of a cell
_PAIRS = 2_000_000  # of points and triangles at once
# Vertical lines pass a little beside the samples, so as to miss vertices and edges that lie on them. The shift
# is far less than the distance at which a node counts as in contact.
_SHIFT = np.array([1.37e-6, 2.11e-6])  # in spacings


def load_solid(path: str | Path, place: str) -> np.ndarray:
    """Reads a mesh that bounds a solid.

    Args:
        path: .obj, .ply with faces, .glb, .gltf, .stl or .off.
        place: The field that names it, for messages.

    Returns:
        Corners of the triangles in the file's units, shape (m, 3, 3).

    Raises:
        UserError: The file cannot be read, or its surface is not closed and oriented.
    """
    try:
        mesh = read_mesh(path)
    except UserError as error:
        raise UserError(f"`{place}`: {error.what}", got=error.got, do=error.do) from None
    # Seams of a texture split vertices; a solid has one vertex at a place.
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=True)
    if not solid.is_watertight:
        faces_at_edge = np.unique(solid.edges_sorted, axis=0, return_counts=True)[1]
        raise UserError(
            f"`{place}`: {path} is not watertight, so that it has no inside",
            got=f"{(faces_at_edge != 2).sum()} edges that do not join two faces",
            do="Close its holes, or use a sphere, a box or a half_space",
        )
    if not solid.is_winding_consistent:
        raise UserError(
            f"`{place}`: the faces of {path} do not all wind the same way",
            do="Recalculate its normals in a mesh editor",
        )
    return np.asarray(solid.triangles, np.float64)


def sample(
    triangles: np.ndarray, spacing: float, low: float, high: float, place: str
) -> tuple[np.ndarray, np.ndarray]:
    """Signed distances to a closed mesh at multiples of ``spacing``.

    Args:
        triangles: Corners [m], shape (m, 3, 3).
        spacing: Between samples [m].
        low: Least coordinate at which they are needed [m]; may be -inf.
        high: Greatest such coordinate [m]. The samples cover what the mesh has between them, and `MARGIN`.
        place: The field that names the mesh, for messages.

    Returns:
        phi, negative inside [m], shape (a, b, c), and the position of its first sample [m], shape (3,).

    Raises:
        UserError: No part of the surface lies there, or it takes too many samples.
    """
    corners = triangles.reshape(-1, 3)
    least, greatest = corners.min(0), corners.max(0)
    span = f"{_round(least)} to {_round(greatest)} m"
    first = np.floor(np.maximum(least, low) / spacing) - MARGIN  # floats: they may be beyond any integer
    last = np.ceil(np.minimum(greatest, high) / spacing) + MARGIN
    pieces = np.zeros((0, 3, 3))
    if (last >= first).all():
        _check_cost(triangles, spacing, first, last, place, span)
        first, last = first.astype(int), last.astype(int)
        pieces = _split(triangles, spacing, spacing * first, spacing * last)
    if len(pieces) == 0:
        raise UserError(
            f"`{place}`: no part of the mesh's surface is in the domain",
            got=f"it spans {span}",
            do="Check its `scale` and `position`",
        )
    axes = [spacing * np.arange(a, b + 1) for a, b in zip(first, last)]
    distance = _measure_distance(axes, pieces, spacing, place)
    inside = winding_number(triangles, axes) != 0
    if not inside.any():
        warnings.warn(f"`{place}`: no grid node lies in the mesh, which stops nothing there", stacklevel=2)
    return np.where(inside, -distance, distance), spacing * first


def _check_cost(
    triangles: np.ndarray, spacing: float, first: np.ndarray, last: np.ndarray, place: str, span: str
) -> None:
    """Refuses what takes too many samples, pieces or crossings, or lies too far away, before any are made.

    Raises:
        UserError: It does; tells how many there would be.
    """
    with np.errstate(over="ignore"):  # what overflows is too many
        shape = last - first + 1
        box = spacing * np.stack([first, last])
        low, high = (np.clip(corner, *box) for corner in (triangles.min(1), triangles.max(1)))
        reaches = ((triangles.max(1) >= box[0]) & (triangles.min(1) <= box[1])).all(1)
        sides = np.sort((high - low)[reaches] / spacing, axis=1)
        areas = trimesh.triangles.area(triangles[reaches]) / spacing**2
        # Pieces have legs of half a cell to a cell, and lie in the box.
        counted = {
            "cells": (shape.prod(), _MOST_SAMPLES),
            "pieces of surface": ((1 + 8 * np.minimum(areas, sides[:, 1] * sides[:, 2])).sum(), _MOST_PIECES),
            "crossings": (((high - low)[reaches, :2] / spacing + 1).prod(1).sum(), _MOST_PAIRS),
            "cells from the origin": (np.abs(triangles).max() / spacing, _FARTHEST),
        }
    for what, (count, most) in counted.items():
        if not count <= most:
            raise UserError(
                f"`{place}`: the mesh spans too many grid cells to be sampled",
                got=f"{count:,.4g} {what}, at most {most:,.4g}; it reaches from {span}",
                do="Reduce its `scale`, or use fewer `domain.cells`",
            )


def _round(point: np.ndarray) -> str:
    return "[" + ", ".join(f"{c:.4g}" for c in point) + "]"


def winding_number(triangles: np.ndarray, axes: list[np.ndarray]) -> np.ndarray:
    """How often the mesh winds about each point of a regular grid, from the crossings above the point.

    Args:
        triangles: Corners, shape (m, 3, 3).
        axes: Coordinates along x, y and z, evenly spaced, shapes (a,), (b,), (c,).

    Returns:
        0 outside, 1 inside (-1 if the faces are inside out), more where parts overlap; int, shape (a, b, c).
    """
    x, y, z = axes
    start, spacing = np.array([x[0], y[0]]), z[1] - z[0]
    flat = (triangles[:, :, :2] - start) / spacing - _SHIFT  # in spacings from the first line
    counts = np.array([len(x), len(y)])
    first = np.clip(np.ceil(flat.min(1)).astype(int), 0, counts)
    last = np.clip(np.floor(flat.max(1)).astype(int), -1, counts - 1)
    sides = np.maximum(last - first + 1, 0)
    # crossings[i, j, k] = signed crossings of line (i, j) between samples k - 1 and k
    crossings = np.zeros((len(x), len(y), len(z) + 1), np.int32)
    for part in _split_chunks(sides.prod(1)):
        _count_crossings(crossings, flat[part], triangles[part, :, 2], first[part], sides[part], z)
    above = crossings[..., ::-1].cumsum(-1)[..., ::-1]
    return above[..., 1:]


def _count_crossings(crossings, flat, heights, first, sides, z) -> None:
    pairs = sides.prod(1)
    t = np.repeat(np.arange(len(flat)), pairs)
    within = np.arange(len(t)) - np.repeat(pairs.cumsum() - pairs, pairs)
    line = first[t] + np.stack([within // sides[t, 1], within % sides[t, 1]], axis=1)
    a, b, c = (flat[t, corner] - line for corner in range(3))
    parts = np.stack([_compute_areas(b, c), _compute_areas(c, a), _compute_areas(a, b)], axis=1)
    hit = (parts > 0).all(1) | (parts < 0).all(1)
    t, line, parts = t[hit], line[hit], parts[hit]
    height = (parts * heights[t]).sum(1) / parts.sum(1)
    k = np.clip(np.floor((height - z[0]) / (z[1] - z[0])).astype(int) + 1, 0, len(z))
    np.add.at(crossings, (line[:, 0], line[:, 1], k), np.where(parts[:, 0] > 0, 1, -1))


def _compute_areas(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _measure_distance(axes: list[np.ndarray], pieces: np.ndarray, spacing: float, place: str) -> np.ndarray:
    """Distances to small triangles at a grid's points [m], shape (a, b, c), exact where they are below `BAND`."""
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    shape, points = points.shape[:3], points.reshape(-1, 3)
    centres = pieces.mean(1)
    radius = float(np.linalg.norm(pieces - centres[:, None], axis=2).max())
    tree = KDTree(centres)
    to_centre, nearest = map(np.asarray, tree.query(points, workers=-1))
    result = np.empty(len(points))
    for part in _split_chunks(np.ones(len(points))):
        result[part] = _to_triangles(points[part], pieces[nearest[part]])
    band = BAND * spacing + radius
    near = np.flatnonzero(to_centre <= band)
    to_centre = to_centre[near]
    # The nearest piece of the surface has its centre within the nearest centre's distance plus its own radius.
    reach = to_centre + radius + 1e-9 * spacing
    counts = tree.query_ball_point(points[near], reach, return_length=True)
    if (pairs := int(np.sum(counts))) > _MOST_PAIRS:
        raise UserError(
            f"`{place}`: the mesh is too fine for the grid",
            got=f"{len(pieces):,} pieces of surface, {pairs:,} distances",
            do="Simplify the mesh, or enlarge its `scale`",
        )
    for part in _split_chunks(np.asarray(counts)):
        at = near[part]
        lists = tree.query_ball_point(points[at], reach[part])
        lengths = np.array([len(l) for l in lists])
        distances = _to_triangles(np.repeat(points[at], lengths, axis=0), pieces[np.concatenate(lists)])
        result[at] = np.minimum.reduceat(distances, lengths.cumsum() - lengths)
    return result.reshape(shape)


def _to_triangles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    return np.linalg.norm(trimesh.triangles.closest_point(triangles, points) - points, axis=1)


def _split(triangles: np.ndarray, longest: float, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The same surface in pieces with edges of at most ``longest``; only pieces that reach into a box are kept."""
    done, rest = [], triangles
    while len(rest):
        rest = rest[((rest.max(1) >= low) & (rest.min(1) <= high)).all(1)]
        edges = np.linalg.norm(np.roll(rest, -1, axis=1) - rest, axis=2)
        small = edges.max(1) <= longest
        done.append(rest[small])
        rest, edges = rest[~small], edges[~small]
        # Halve the longest edge, a to b.
        order = (edges.argmax(1)[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(rest, order[:, :, None], axis=1).transpose(1, 0, 2)
        middle = 0.5 * (a + b)
        rest = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done)


def _split_chunks(costs: np.ndarray) -> list[slice]:
    """Consecutive slices of about `_PAIRS` in cost each."""
    total = np.cumsum(costs)
    if len(total) == 0:
        return []
    bounds = np.searchsorted(total, np.arange(_PAIRS, total[-1], _PAIRS))
    edges = np.unique(np.concatenate([[0], bounds, [len(total)]]))
    return [slice(int(a), int(b)) for a, b in zip(edges[:-1], edges[1:])]
