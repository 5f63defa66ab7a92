"""Gaussians to draw: what pictures are timed and tested with."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from physagent_jax.gaussians.cloud import Splats


def sphere(count: int, seed: int = 0) -> Splats:
    """Gaussians on the unit sphere, wide enough to overlap; random colours and opacities."""
    rng = np.random.default_rng(seed)
    means = rng.normal(size=(count, 3))
    means /= np.linalg.norm(means, axis=1, keepdims=True)
    width = 0.8 * np.sqrt(4 * np.pi / count) * rng.uniform(0.5, 1.5, size=(count, 3))
    turn = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    covariance = np.einsum("nij,nj,nkj->nik", turn, width**2, turn)
    upper = covariance[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    arrays = (means, upper, rng.uniform(0.3, 1.0, count), rng.normal(size=(count, 1, 3)))
    rotations = np.broadcast_to(np.eye(3), (count, 3, 3))
    return Splats(*(jnp.asarray(array, jnp.float32) for array in (*arrays, rotations)))
