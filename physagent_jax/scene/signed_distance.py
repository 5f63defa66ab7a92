"""Closed meshes as signed distances on a regular grid, for `mpm.SignedDistance`.

Near the surface the distances are those to the triangles, exact to round-off (`narrow_band`). Deep inside and far
outside, where an obstacle needs only the sign and a rough direction, they are those to one near triangle. The sign
comes from the winding number along vertical lines, so parts of the mesh may overlap; but deep inside such a
solid the distance is that to its inner faces.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import trimesh
from scipy import ndimage

from physagent_jax.core.errors import UserError
from physagent_jax.scene.mesh_files import read_mesh
from physagent_jax.scene.narrow_band import BAND as BAND
from physagent_jax.scene.narrow_band import MOST_PAIRS, measure_distances

MARGIN = 3  # cells around the mesh
# What a mesh may cost: about half a minute.
_MOST_SAMPLES = 4_000_000  # a domain of 150 cells
_THICKNESS_SAMPLES = 4000
_CLEAR = 0.95  # of the least thickness: distances between nodes are right to a tenth of a cell
_THIN_SHARE = 0.1  # of a surface from which on its walls count as thin; ears and horns alone do not
_FARTHEST = 1e9  # cells from the origin: float64 still places the surface to 1e-6 of a cell
_PAIRS = 2_000_000  # of lines and triangles at once
# Vertical lines pass a little beside the samples, so as to miss vertices and edges that lie on them. The shift
# is far less than the distance at which a node counts as in contact.
_SHIFT = np.array([1.37e-6, 2.11e-6])  # in spacings


def load_solid(path: str | Path, place: str) -> np.ndarray:
    """Read a mesh that bounds a solid.

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
    reaching = np.zeros((0, 3, 3))
    if (last >= first).all():
        reaching = triangles[_reach(triangles, spacing * first, spacing * last)]
        _check_cost(triangles, reaching, spacing, first, last, place, span)
    if len(reaching) == 0:
        raise _explain_absence(place, span)
    first, last = first.astype(int), last.astype(int)
    shape = tuple(int(count) for count in last - first + 1)
    try:
        distance, exact = measure_distances(reaching / spacing - first, (shape[0], shape[1], shape[2]))
    except UserError as error:
        raise UserError(f"`{place}`: {error.what}", got=error.got, do=error.do) from None
    if not exact.any():
        raise _explain_absence(place, span)
    axes = [spacing * np.arange(a, b + 1) for a, b in zip(first, last)]
    inside = winding_number(triangles, axes) != 0
    if not inside.any():
        warnings.warn(f"`{place}`: no grid node lies in the mesh, which stops nothing there", stacklevel=2)
    return spacing * np.where(inside, -distance, distance), spacing * first


def measure_thickness(
    triangles: np.ndarray, phi: np.ndarray, origin: np.ndarray, spacing: float, most: float
) -> float | None:
    """Thickness of the walls of a solid where they are thinner than ``most`` [m]; None = hardly anywhere.

    Points are drawn on the surface and moved inwards by two thirds of ``most``. Where the nearest surface then is the
    opposite one, which faces the other way, its distance tells the thickness. Edges and corners, where the nearest
    surface stands across, do not count.

    Args:
        triangles: Corners of the closed mesh [m], shape (m, 3, 3).
        phi: Its signed distances [m], shape (a, b, c).
        origin: Position of the first of them [m], shape (3,).
        spacing: Between them [m]; two thirds of ``most`` lie in the band in which they are exact.
        most: Greatest thickness that is looked for [m].
    """
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(cross, axis=1)
    rng = np.random.default_rng(0)
    chosen = rng.choice(len(triangles), _THICKNESS_SAMPLES, p=area / area.sum())
    share = rng.dirichlet((1, 1, 1), _THICKNESS_SAMPLES)
    normal = cross[chosen] / area[chosen, None]
    depth = 2 / 3 * most
    inside = (share[:, :, None] * triangles[chosen]).sum(1) - depth * normal
    at = ((inside - origin) / spacing).T
    within = ((at >= 1) & (at <= np.array(phi.shape)[:, None] - 2)).all(0)
    if not within.any():
        return None
    at, normal = at[:, within], normal[within]
    steps = 0.5 * np.eye(3)[:, :, None]
    slope = np.stack([_interpolate(phi, at + step) - _interpolate(phi, at - step) for step in steps], axis=1)
    opposite = (slope * normal).sum(1) < -0.5 * np.linalg.norm(slope, axis=1)
    thickness = depth - _interpolate(phi, at)
    thin = thickness[opposite & (thickness < _CLEAR * most) & (thickness > 0)]
    return float(np.median(thin)) if len(thin) > _THIN_SHARE * within.sum() else None


def _interpolate(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    return ndimage.map_coordinates(values, at, order=1, mode="nearest")


def _reach(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return whether triangles reach into a box."""
    return ((triangles.max(1) >= low) & (triangles.min(1) <= high)).all(1)


def _explain_absence(place: str, span: str) -> UserError:
    return UserError(
        f"`{place}`: no part of the mesh's surface is in the domain",
        got=f"it spans {span}",
        do="Check its `scale` and `position`",
    )


def _check_cost(
    triangles: np.ndarray,
    reaching: np.ndarray,
    spacing: float,
    first: np.ndarray,
    last: np.ndarray,
    place: str,
    span: str,
) -> None:
    """Refuse what takes too many samples or crossings, or lies too far away, before any are made.

    Raises:
        UserError: It does; tells how many there would be.
    """
    with np.errstate(over="ignore"):  # what overflows is too many
        counted = {
            "cells": ((last - first + 1).prod(), _MOST_SAMPLES),
            "crossings": (_bound_crossings(reaching, spacing, first, last), MOST_PAIRS),
            "cells from the origin": (np.abs(triangles).max() / spacing, _FARTHEST),
        }
    for what, (count, most) in counted.items():
        if not count <= most:
            raise UserError(
                f"`{place}`: the mesh spans too many grid cells to be sampled",
                got=f"{count:,.4g} {what}, at most {most:,.4g}; it reaches from {span}",
                do="Reduce its `scale`, or use fewer `domain.cells`",
            )


def _bound_crossings(triangles: np.ndarray, spacing: float, first: np.ndarray, last: np.ndarray) -> float:
    low, high = (np.clip(c / spacing, first, last) for c in (triangles.min(1), triangles.max(1)))
    return float((high[:, :2] - low[:, :2] + 1).prod(1).sum())


def _round(point: np.ndarray) -> str:
    return "[" + ", ".join(f"{c:.4g}" for c in point) + "]"


def winding_number(triangles: np.ndarray, axes: list[np.ndarray]) -> np.ndarray:
    """The winding number of the mesh at each point of a regular grid, from the crossings above the point.

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


def _split_chunks(costs: np.ndarray) -> list[slice]:
    """Consecutive slices of about `_PAIRS` in cost each."""
    total = np.cumsum(costs)
    if len(total) == 0:
        return []
    bounds = np.searchsorted(total, np.arange(_PAIRS, total[-1], _PAIRS))
    edges = np.unique(np.concatenate([[0], bounds, [len(total)]]))
    return [slice(int(a), int(b)) for a, b in zip(edges[:-1], edges[1:])]
