"""Gaussians under an affine map, before they are a cloud: for nodes of scene files and for axes of formats."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.core.rotations import polar
from physagent_jax.gaussians.covariance import matrix_to_quat
from physagent_jax.gaussians.sh import rotate_sh

_EVEN = 1e-5  # relative difference of axes that are taken as equally long; files hold seven digits


def move_gaussians(
    means: np.ndarray,
    quats: np.ndarray,
    scales: np.ndarray,
    sh: np.ndarray,
    linear: np.ndarray,
    offset: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Gaussians under x -> linear @ x + offset; harmonics turn by the rotation in it.

    Args:
        means: Centres, shape (n, 3).
        quats: Rotations wxyz of any norm, shape (n, 4).
        scales: Standard deviations, shape (n, 3).
        sh: Coefficients, shape (n, k, 3).
        linear: Map of positive determinant, shape (3, 3).
        offset: Shape (3,).

    Returns:
        The same four, moved, float64.
    """
    turn, stretch = polar(linear)
    size = np.cbrt(np.linalg.det(linear))
    with np.errstate(over="ignore", invalid="ignore"):  # such Gaussians are dropped
        means = means @ linear.T + offset
        if np.abs(stretch - size * np.eye(3)).max() <= _EVEN * size:
            quats, scales = multiply_quats(matrix_to_quat(turn), quats), scales * size
        else:
            quats, scales = _stretch(quats, scales, linear)
        if sh.shape[1] > 1 and np.abs(turn - np.eye(3)).max() > 1e-9:
            turned = rotate_sh(jnp.asarray(sh, jnp.float32), jnp.asarray(turn, jnp.float32))
            sh = np.concatenate([sh[:, :1], np.asarray(turned, np.float64)[:, 1:]], axis=1)
    return means, quats, scales, sh


def multiply_quats(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Hamilton products wxyz: the rotation ``second``, then ``first``.

    Args:
        first: Shape (4,) or (n, 4).
        second: Shape (n, 4).
    """
    a, b, c, d = np.moveaxis(first, -1, 0)
    w, x, y, z = np.moveaxis(second, -1, 0)
    rows = (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
    return np.stack(rows, axis=-1)


def _stretch(quats: np.ndarray, scales: np.ndarray, linear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions and scales whose covariances are those under ``linear``; what is no number stays none."""
    norms = np.linalg.norm(quats, axis=1, keepdims=True)
    usable = np.isfinite(norms[:, 0]) & (norms[:, 0] > 0) & (np.abs(scales) < 1e30).all(axis=1)
    unit = np.where(usable[:, None], quats / np.where(norms > 0, norms, 1.0), [1.0, 0.0, 0.0, 0.0])
    sizes = np.where(usable[:, None], scales, 1.0)
    axes, lengths, _ = np.linalg.svd(
        linear @ (Rotation.from_quat(unit, scalar_first=True).as_matrix() * sizes[:, None, :])
    )
    axes[:, :, 2] *= np.sign(np.linalg.det(axes))[:, None]  # a right-handed frame
    return (
        np.where(usable[:, None], matrix_to_quat(axes), quats),
        np.where(usable[:, None], lengths, scales),
    )
