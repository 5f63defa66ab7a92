"""Quaternions, rotations and covariances of Gaussians; and back, for export."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation


def quat_to_matrix(quats: jax.Array) -> jax.Array:
    """Rotation matrices of unit quaternions.

    Args:
        quats: Unit quaternions wxyz, shape (..., 4).

    Returns:
        Shape (..., 3, 3).
    """
    w, x, y, z = (quats[..., i] for i in range(4))
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return jnp.stack([jnp.stack(row, axis=-1) for row in rows], axis=-2)


def matrix_to_quat(matrices: np.ndarray | jax.Array) -> np.ndarray:
    """Unit quaternions wxyz (w >= 0) of rotation matrices. Runs on the host.

    Args:
        matrices: Rotations, shape (..., 3, 3).

    Returns:
        Shape (..., 4), float64.
    """
    matrices = np.asarray(matrices, np.float64)
    rotation = Rotation.from_matrix(matrices.reshape(-1, 3, 3))
    return rotation.as_quat(canonical=True, scalar_first=True).reshape(*matrices.shape[:-2], 4)


@partial(jax.jit, inline=True)  # on its own, one program and not twelve
def quats_scales_to_covariances(quats: jax.Array, scales: jax.Array) -> jax.Array:
    """Covariances R diag(scales^2) R^T (3DGS, Kerbl et al. 2023, eq. 6).

    Args:
        quats: Unit quaternions wxyz, shape (n, 4).
        scales: Standard deviations along the local axes [m], shape (n, 3).

    Returns:
        Upper triangles (xx, xy, xz, yy, yz, zz) [m^2], shape (n, 6).
    """
    M = quat_to_matrix(quats) * scales[:, None, :]
    return _multiply_upper(M, M)


def transform_covariances(F: jax.Array, covariances: jax.Array) -> jax.Array:
    """Covariances under an affine map: F Sigma F^T.

    Written out in scalars: XLA turns batches of 3x3 products into one small call per matrix on the CPU.

    Args:
        F: Deformation gradients, shape (n, 3, 3).
        covariances: Upper triangles [m^2], shape (n, 6).

    Returns:
        Upper triangles [m^2], shape (n, 6).
    """
    xx, xy, xz, yy, yz, zz = (covariances[:, i] for i in range(6))
    sigma = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    FS = jnp.stack(
        [
            jnp.stack([sum(F[:, i, k] * sigma[k][j] for k in range(3)) for j in range(3)], axis=-1)
            for i in range(3)
        ],
        axis=-2,
    )
    return _multiply_upper(FS, F)


def covariance_matrices(covariances: np.ndarray | jax.Array) -> np.ndarray:
    """Full symmetric matrices of upper triangles. Runs on the host.

    Args:
        covariances: Upper triangles [m^2], shape (n, 6).

    Returns:
        Shape (n, 3, 3), float64.
    """
    return np.asarray(covariances, np.float64)[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)


def decompose_covariances(covariances: np.ndarray | jax.Array) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions and scales whose covariances are the given ones. Runs on the host, for export.

    The decomposition is unique only up to the order and the signs of the axes. Rounding can make an
    eigenvalue of a very flat Gaussian negative: eigenvalues are raised to 1e-12 of the largest one, which
    is far below what float32 covariances resolve.

    Args:
        covariances: Upper triangles [m^2], shape (n, 6).

    Returns:
        Unit quaternions wxyz, shape (n, 4), and standard deviations [m], shape (n, 3); float64.
    """
    eigenvalues, axes = np.linalg.eigh(covariance_matrices(covariances))
    axes[:, :, 0] *= np.sign(np.linalg.det(axes))[:, None]  # a right-handed frame
    scales = np.sqrt(np.maximum(eigenvalues, 1e-12 * eigenvalues[:, -1:].clip(0.0)))
    return matrix_to_quat(axes), scales


def _multiply_upper(A: jax.Array, B: jax.Array) -> jax.Array:
    """Upper triangles of the symmetric products A B^T, shape (n, 6)."""
    pairs = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    return jnp.stack([sum(A[:, i, k] * B[:, j, k] for k in range(3)) for i, j in pairs], axis=-1)
