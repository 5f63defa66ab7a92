"""Clouds whose volume and inside are known from geometry."""

from __future__ import annotations

import numpy as np

from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.surfels import make_surfels, place_evenly


def cloud_of(means, *, scale=0.01, opacity=0.9, quats=None) -> GaussianCloud:
    """Isotropic grey Gaussians at ``means``."""
    n = len(means)
    return GaussianCloud(
        means=np.asarray(means, np.float32),
        quats=np.tile(np.float32([1, 0, 0, 0]), (n, 1)) if quats is None else np.asarray(quats, np.float32),
        scales=np.full((n, 3), scale, np.float32),
        opacities=np.full(n, opacity, np.float32),
        sh=np.zeros((n, 1, 3), np.float32),
    )


def box_shell(size, count: int, *, seed: int = 0, skip: tuple[int, ...] = ()) -> GaussianCloud:
    """Discs on the faces of a box centred at the origin; faces 0..5 = +x, -x, +y, -y, +z, -z may be left out."""
    size = np.asarray(size, float)
    rng = np.random.default_rng(seed)
    faces = [f for f in range(6) if f not in skip]
    areas = np.array([np.prod(np.delete(size, f // 2)) for f in faces])
    points, normals = [], []
    for face, share in zip(faces, areas / areas.sum()):
        n = round(count * share)
        p = rng.uniform(-0.5, 0.5, (3 * n, 3)) * size
        p[:, face // 2] = (0.5 - face % 2) * size[face // 2]
        p = p[place_evenly(p, n)]
        normal = np.zeros(3)
        normal[face // 2] = 1 - 2 * (face % 2)
        points.append(p)
        normals.append(np.tile(normal, (n, 1)))
    points, normals = np.concatenate(points), np.concatenate(normals)
    return make_surfels(points, normals, 0.65 * np.sqrt(areas.sum() / count), np.full((len(points), 3), 0.5))


def sphere_shell(radius: float, count: int, *, opening: float = 0.0) -> GaussianCloud:
    """Discs on a sphere at the origin (Fibonacci lattice); ``opening`` leaves out a cap of that share at +y."""
    k = np.arange(count) + 0.5
    y = 1 - 2 * k / count
    angle = np.pi * (1 + 5**0.5) * k
    ring = np.sqrt(1 - y**2)
    normals = np.stack([ring * np.cos(angle), y, ring * np.sin(angle)], axis=1)
    normals = normals[y < 1 - 2 * opening]
    spacing = np.sqrt(4 * np.pi * radius**2 / count)
    return make_surfels(radius * normals, normals, 0.65 * spacing, np.full((len(normals), 3), 0.5))
