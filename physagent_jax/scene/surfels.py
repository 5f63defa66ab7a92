"""Flat Gaussians on surfaces: the common ground of sampled meshes and procedural objects."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import KDTree

from physagent_jax.core.arrays import to_device
from physagent_jax.core.once import make_lock
from physagent_jax.gaussians.cloud import GaussianCloud

SH_DC = 0.28209479177387814  # Y_00; colour = SH_DC * sh[0] + 0.5
FLATNESS = 0.15  # thickness over radius
OPAQUE = 0.98  # opacity of a disc of a surface that lets nothing through
KEY_LIGHT = (-0.45, -0.65, 0.62)  # from the upper left front, in a z-up frame with the viewer at -y


def make_surfels(points, normals, radius, rgb, *, opacity: float | np.ndarray = OPAQUE) -> GaussianCloud:
    """Build discs that lie in the surface.

    Args:
        points: Centres [m], shape (n, 3).
        normals: Unit normals, shape (n, 3).
        radius: Standard deviation in the surface [m], scalar or shape (n,).
        rgb: Colours in [0, 1], shape (n, 3).
        opacity: In [0, 1], scalar or shape (n,).
    """
    count = len(points)
    radius = np.broadcast_to(np.asarray(radius, np.float64), (count,))
    scales = np.stack([radius, radius, FLATNESS * radius], axis=1)
    sh = (np.clip(rgb, 0, 1) - 0.5) / SH_DC
    return GaussianCloud(
        means=to_device(points, np.float32),
        quats=to_device(_find_rotations_to(np.asarray(normals, np.float64)), np.float32),
        scales=to_device(scales, np.float32),
        opacities=to_device(np.broadcast_to(opacity, (count,)), np.float32),
        sh=to_device(sh[:, None, :], np.float32),
    )


def _find_rotations_to(normals: np.ndarray) -> np.ndarray:
    """Shortest rotations from +z to the normals as quaternions wxyz, shape (n, 4)."""
    x, y, z = normals.T
    half = np.stack([1 + z, -y, x, np.zeros_like(x)], axis=1)  # (1 + e_z.n, e_z x n)
    half[z < -1 + 1e-9] = (0.0, 1.0, 0.0, 0.0)
    return half / np.linalg.norm(half, axis=1, keepdims=True)


_KEPT = 4  # sets of points whose thinning is remembered: a run reads its object up to four times
_thinned: dict[tuple[bytes, int], np.ndarray] = {}
_lock = make_lock()  # of `_thinned`


def place_evenly(points: np.ndarray, count: int) -> np.ndarray:
    """Indices of ``count`` well spread points out of a denser random set, in increasing order; read-only.

    Repeatedly thins the set: of every pair of mutual nearest neighbours the second goes, closest pairs
    first, which removes clumps and leaves the spacing of a blue-noise set. The last sets are remembered.
    """
    key = hashlib.sha256(np.ascontiguousarray(points).data).digest(), count
    if (known := _thinned.get(key)) is not None:
        return known
    found = _thin(points, count)
    found.setflags(write=False)
    with _lock:
        while len(_thinned) >= _KEPT:
            del _thinned[next(iter(_thinned))]
        _thinned[key] = found
    return found


def _thin(points: np.ndarray, count: int) -> np.ndarray:
    keep = np.arange(len(points))
    while len(keep) > count:
        tree: Any = KDTree(points[keep])  # scipy annotates `query` for a single neighbour only
        distance, neighbour = tree.query(points[keep], k=2)
        distance, neighbour = distance[:, 1], neighbour[:, 1]
        mutual = np.flatnonzero(
            (neighbour[neighbour] == np.arange(len(keep))) & (neighbour < np.arange(len(keep)))
        )
        if len(mutual) == 0:  # only exact duplicates lack mutual neighbours: drop the surplus
            return keep[:count]
        order = mutual[np.argsort(distance[mutual], kind="stable")]
        keep = np.delete(keep, order[: len(keep) - count])
    return keep


def value_noise(points: np.ndarray, frequency: float, seed: int, *, octaves: int = 3) -> np.ndarray:
    """Smooth noise in [0, 1]: cubic interpolation of a seeded, periodic lattice of random values.

    Args:
        points: Shape (n, 3) [m].
        frequency: Lattice points per metre of the first octave; each further one doubles it at half weight.
        seed: Seed of the lattice.
        octaves: Number of octaves.

    Returns:
        Shape (n,); roughly uniform over [0, 1].
    """
    rng = np.random.default_rng(seed)
    total = np.zeros(len(points))
    for octave in range(octaves):
        lattice = rng.uniform(-1, 1, (16, 16, 16))
        at = np.asarray(points, np.float64).T * frequency * 2**octave + rng.uniform(0, 16, (3, 1))
        total += 0.5**octave * map_coordinates(lattice, at, order=3, mode="grid-wrap")
    return np.clip(0.5 + 0.5 * total / 0.9, 0, 1)


def bake_light(normals: np.ndarray, *, ambient: float = 0.45, two_sided: bool = False) -> np.ndarray:
    """Brightness from a key light, a sky that is brighter from above, and a faint rim; shape (n,).

    Args:
        normals: Unit normals in a z-up frame, shape (n, 3).
        ambient: Brightness in full shade.
        two_sided: Whether thin sheets let light through from the back.
    """
    key = np.asarray(KEY_LIGHT) / np.linalg.norm(KEY_LIGHT)
    lambert = normals @ key
    lambert = np.where(lambert < 0, -0.6 * lambert, lambert) if two_sided else np.maximum(lambert, 0)
    sky = 0.5 + 0.5 * normals[:, 2]
    return ambient + 0.55 * lambert + 0.22 * sky
