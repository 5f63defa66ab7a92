"""Random splats and single Gaussians in front of cameras."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.gaussians import Splats
from physagent_jax.render import Camera, look_at

BACKGROUND = np.array([0.2, 0.5, 0.9])
_C0 = 0.28209479177387814


def random_splats(count: int, *, seed=0, degree=0, scale=0.06, dtype=np.float64) -> Splats:
    """A ball of anisotropic Gaussians of radius about one at the origin."""
    rng = np.random.default_rng(seed)
    R = Rotation.random(count, random_state=seed).as_matrix()
    scales = scale * np.exp(rng.normal(size=(count, 3)) * 0.5)
    sigma = R @ (scales[:, :, None] ** 2 * np.eye(3)) @ R.transpose(0, 2, 1)
    return Splats(
        means=jnp.asarray(rng.normal(size=(count, 3)) * 0.5, dtype),
        covariances=jnp.asarray(sigma[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]], dtype),
        opacities=jnp.asarray(rng.uniform(0, 1, count), dtype),
        sh=jnp.asarray(rng.normal(size=(count, (degree + 1) ** 2, 3)) * 0.4, dtype),
        rotations=jnp.asarray(Rotation.random(count, random_state=seed + 1).as_matrix(), dtype),
    )


def one_splat(mean, *, sigma=0.1, opacity=0.8, color=(0.9, 0.4, 0.1)) -> Splats:
    """An isotropic Gaussian of one colour."""
    variance = sigma**2
    return Splats(
        means=jnp.asarray([mean], jnp.float32),
        covariances=jnp.asarray([[variance, 0, 0, variance, 0, variance]], jnp.float32),
        opacities=jnp.asarray([opacity], jnp.float32),
        sh=(jnp.asarray(color, jnp.float32) - 0.5)[None, None] / _C0,
        rotations=jnp.eye(3)[None],
    )


def camera(width=50, height=37, distance=3.0) -> Camera:
    """A camera off every axis; the size is no multiple of a tile."""
    eye = distance * np.array([0.5, -0.6, 0.62])
    return look_at(eye, [0.05, 0, 0], [0, 0, 1], fov_degrees=45, width=width, height=height)
