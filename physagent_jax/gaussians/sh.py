"""Real spherical harmonics in the sign convention of 3DGS, degree 0 to 3."""

from __future__ import annotations

import functools

import jax
import jax.numpy as jnp
import numpy as np

# Constants of the real spherical harmonics (Sloan 2008, "Stupid Spherical Harmonics Tricks", appendix A2);
# the signs below are those of the original 3DGS code, with the Condon-Shortley phase.
_C0 = 0.28209479177387814
_C1 = 0.4886025119029199
_C2 = (1.0925484305920792, 0.31539156525252005, 0.5462742152960396)
_C3 = (0.5900435899266435, 2.890611442640554, 0.4570457994644658, 0.3731763325901154, 1.445305721320277)


def sh_basis(directions: jax.Array, degree: int) -> jax.Array:
    """Basis functions at unit directions.

    Args:
        directions: Unit vectors, shape (..., 3).
        degree: 0 to 3.

    Returns:
        Shape (..., (degree + 1)**2).
    """
    x, y, z = (directions[..., i] for i in range(3))
    basis = [jnp.full_like(x, _C0)]
    if degree >= 1:
        basis += [-_C1 * y, _C1 * z, -_C1 * x]
    if degree >= 2:
        basis += [
            _C2[0] * x * y,
            -_C2[0] * y * z,
            _C2[1] * (2 * z * z - x * x - y * y),
            -_C2[0] * x * z,
            _C2[2] * (x * x - y * y),
        ]
    if degree >= 3:
        basis += [
            -_C3[0] * y * (3 * x * x - y * y),
            _C3[1] * x * y * z,
            -_C3[2] * y * (4 * z * z - x * x - y * y),
            _C3[3] * z * (2 * z * z - 3 * x * x - 3 * y * y),
            -_C3[2] * x * (4 * z * z - x * x - y * y),
            _C3[4] * z * (x * x - y * y),
            -_C3[0] * x * (x * x - 3 * y * y),
        ]
    return jnp.stack(basis, axis=-1)


def eval_sh(sh: jax.Array, directions: jax.Array) -> jax.Array:
    """Sums of the harmonics; a colour is this + 0.5, clipped at 0 from below.

    Args:
        sh: Coefficients, shape (n, (degree + 1)**2, 3).
        directions: Unit vectors from the camera to the Gaussian, shape (n, 3).

    Returns:
        Shape (n, 3).
    """
    basis = sh_basis(directions, round(sh.shape[-2] ** 0.5) - 1)
    return jnp.einsum("...k,...kc->...c", basis, sh, precision="highest")


@jax.jit
def rotate_sh(sh: jax.Array, R: jax.Array) -> jax.Array:
    """Coefficients of rotated functions: eval_sh(rotate_sh(sh, R), d) == eval_sh(sh, R^T d).

    A rotation maps the harmonics of one degree onto each other, so that the new coefficients follow exactly
    from the values of the rotated function at as many directions as there are coefficients.

    Args:
        sh: Coefficients, shape (n, (degree + 1)**2, 3).
        R: Rotations, shape (n, 3, 3) or (3, 3).
    """
    degree = round(sh.shape[-2] ** 0.5) - 1
    directions, inverse = _sample_directions(degree)
    rotated = jnp.einsum(
        "...ji,mj->...mi", R, jnp.asarray(directions, sh.dtype), precision="highest"
    )  # R^T d
    values = sh_basis(rotated, degree)
    bands = []
    for l in range(degree + 1):
        band = slice(l * l, (l + 1) ** 2)
        matrix = jnp.matmul(jnp.asarray(inverse[band], sh.dtype), values[..., band], precision="highest")
        bands.append(jnp.einsum("...ij,...jc->...ic", matrix, sh[:, band], precision="highest"))
    return jnp.concatenate(bands, axis=-2)


@functools.cache
def _sample_directions(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions, shape (m, 3), and the matrix from a function's values there to its coefficients."""
    count = 32  # more than the 16 coefficients and evenly spread, so that the inverse is well conditioned
    z = 1 - (2 * np.arange(count) + 1) / count
    angle = np.pi * (3 - 5**0.5) * np.arange(count)
    radius = np.sqrt(1 - z * z)
    directions = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=-1)
    with jax.enable_x64(True), jax.ensure_compile_time_eval():
        basis = np.asarray(sh_basis(jnp.asarray(directions), degree))
    return directions, np.linalg.pinv(basis)
