"""Closed meshes as signed distances on a regular grid, for `mpm.SignedDistance`.

Within `BAND` of the surface the distances are those to the triangles, exact to round-off. Deep inside and far
outside, where an obstacle needs only the sign and a rough direction, they are those to one near triangle. The sign
comes from the winding number along vertical lines, so parts of the mesh may overlap; but deep inside such a
solid the distance is that to its inner faces. All of it is one compiled function (`kernels.triangles`).
"""

from __future__ import annotations

import warnings
from pathlib import Path
from types import ModuleType

import numpy as np
import trimesh
from scipy import ndimage

from physagent_jax.core.errors import UserError
from physagent_jax.kernels import import_kernels, numba_missing
from physagent_jax.scene.mesh_files import read_mesh

BAND = 2.5  # cells to either side of the surface within which distances are exact
MARGIN = 3  # cells around the mesh
# What a mesh may cost: a few seconds.
_MOST_SAMPLES = 4_000_000  # a domain of 150 cells
_MOST_PAIRS = 1_000_000_000  # of nodes and triangles near them, and of vertical lines and triangles
_THICKNESS_SAMPLES = 4000
_CLEAR = 0.95  # of the least thickness: distances between nodes are right to a tenth of a cell
_THIN_SHARE = 0.1  # of a surface from which on its walls count as thin; ears and horns alone do not
_FARTHEST = 1e9  # cells from the origin: float64 still places the surface to 1e-6 of a cell


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
    shape = (int(last[0] - first[0] + 1), int(last[1] - first[1] + 1), int(last[2] - first[2] + 1))
    distance, winding, _ = _import_kernel(place).measure(triangles / spacing - first, shape, BAND)
    if not np.isfinite(distance).all():
        raise _explain_absence(place, span)
    inside = winding != 0
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
    """Refuse what takes too many samples, crossings or distances, or lies too far away, before any are made.

    Raises:
        UserError: It does; tells how many there would be.
    """
    counted = {  # in this order: what lies far enough away cannot be counted
        "cells": (lambda: (last - first + 1).prod(), _MOST_SAMPLES),
        "cells from the origin": (lambda: np.abs(triangles).max() / spacing, _FARTHEST),
        "crossings": (lambda: _bound_crossings(triangles, spacing, first, last), _MOST_PAIRS),
        "distances": (lambda: _bound_pairs(reaching / spacing, first, last), _MOST_PAIRS),
    }
    for what, (measure, most) in counted.items():
        with np.errstate(over="ignore"):  # what overflows is too many
            count = measure()
        if not count <= most:
            raise UserError(
                f"`{place}`: the mesh spans too many grid cells to be sampled",
                got=f"{count:,.4g} {what}, at most {most:,.4g}; it reaches from {span}",
                do="Reduce its `scale`, simplify it, or use fewer `domain.cells`",
            )


def _bound_crossings(triangles: np.ndarray, spacing: float, first: np.ndarray, last: np.ndarray) -> float:
    low, high = (np.clip(c / spacing, first, last) for c in (triangles.min(1), triangles.max(1)))
    return float((high[:, :2] - low[:, :2] + 1).prod(1).sum())


def _bound_pairs(triangles: np.ndarray, first: np.ndarray, last: np.ndarray) -> float:
    """Most pairs of nodes and triangles [cells] as near as the band, as the kernel looks at them: in layers."""
    low, high = (np.clip(c, first, last) for c in (triangles.min(1) - BAND, triangles.max(1) + BAND))
    sides = high - low + 1
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    across = np.arange(3) == np.abs(normal).argmax(1)[:, None]
    return float(np.where(across, np.minimum(sides, 2 * np.sqrt(3) * BAND + 1), sides).prod(1).sum())


def _import_kernel(place: str) -> ModuleType:
    """The compiled function that samples.

    Raises:
        UserError: Numba, which compiles it, is missing.
    """
    if missing := numba_missing():
        raise UserError(
            f"`{place}`: a mesh cannot be sampled without Numba",
            got=missing,
            do="Install the package again, or use a sphere, a box or a half_space",
        )
    return import_kernels("physagent_jax.scene.kernels.triangles")


def _round(point: np.ndarray) -> str:
    return "[" + ", ".join(f"{c:.4g}" for c in point) + "]"
