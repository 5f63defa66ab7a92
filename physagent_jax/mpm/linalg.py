"""3x3 linear algebra for particle batches of shape (n, 3, 3).

Products are written as broadcast sums: XLA fuses them into the surrounding element-wise loop, where a
batched dot of 3x3 matrices becomes n calls of a matrix product (on CPU two to four times slower).
"""

from __future__ import annotations

import jax
import jax.numpy as jnp


def matmul(a: jax.Array, b: jax.Array) -> jax.Array:
    """Batched product a b, shapes (..., 3, 3)."""
    return (a[..., :, :, None] * b[..., None, :, :]).sum(-2)


def matvec(a: jax.Array, b: jax.Array) -> jax.Array:
    """Batched product a b, shapes (..., 3, 3) and (..., 3)."""
    return (a * b[..., None, :]).sum(-1)


def transpose(a: jax.Array) -> jax.Array:
    """Batched transpose."""
    return jnp.swapaxes(a, -1, -2)


def cofactor(a: jax.Array) -> jax.Array:
    """The matrix of cofactors K: the inverse of a is K^T / det a, and det a has the derivative K."""
    row0, row1, row2 = a[..., 0, :], a[..., 1, :], a[..., 2, :]
    return jnp.stack([cross(row1, row2), cross(row2, row0), cross(row0, row1)], axis=-2)


def cross(a: jax.Array, b: jax.Array) -> jax.Array:
    """Cross product along the last axis (jnp.cross moves axes about and fuses badly)."""
    return jnp.stack(
        [
            a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1],
            a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
            a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0],
        ],
        axis=-1,
    )


def determinant(a: jax.Array) -> jax.Array:
    """Batched determinant, shape (...,)."""
    return (a[..., 0, :] * cross(a[..., 1, :], a[..., 2, :])).sum(-1)


def skew(w: jax.Array) -> jax.Array:
    """The matrix W with W u = w x u, shapes (..., 3) -> (..., 3, 3)."""
    zero = jnp.zeros_like(w[..., 0])
    return jnp.stack(
        [
            jnp.stack([zero, -w[..., 2], w[..., 1]], -1),
            jnp.stack([w[..., 2], zero, -w[..., 0]], -1),
            jnp.stack([-w[..., 1], w[..., 0], zero], -1),
        ],
        axis=-2,
    )


_NEWTON_STEPS = 9  # f64 round-off from condition number 1e3 on; f32 is done after 7


@jax.custom_jvp
def polar_rotation(F: jax.Array) -> jax.Array:
    """The orthogonal factor R of F = R S by scaled Newton iteration (Higham 1986, SIAM J. Sci. Stat. Comput.).

    For det F > 0, R is the rotation. For det F < 0 the orthogonal factor is a reflection and is returned
    as such; for singular F the result is not finite. Rollouts stop such states before they are used
    (`mpm.rollout`).

    The derivative is the exact one, also at F = I and at repeated singular values, where differentiating
    an SVD fails: with dR = R W, (tr(S) I - S) w = axial(R^T dF - dF^T R), W = skew(w).
    """

    def improve(R, _):
        inverse_transpose = cofactor(R) / determinant(R)[..., None, None]
        # Frobenius-norm scaling brings large and small stretches together in the first steps.
        ratio = (inverse_transpose**2).sum((-1, -2)) / (R**2).sum((-1, -2))
        gamma = (ratio**0.25)[..., None, None]
        return 0.5 * (gamma * R + inverse_transpose / gamma), None

    return jax.lax.scan(improve, F, None, length=_NEWTON_STEPS)[0]


@polar_rotation.defjvp
def _polar_rotation_jvp(primals, tangents):
    (F,), (dF,) = primals, tangents
    R = polar_rotation(F)
    S = matmul(transpose(R), F)
    A = matmul(transpose(R), dF)
    axial = jnp.stack(
        [A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1]], -1
    )
    trace = (S[..., 0, 0] + S[..., 1, 1] + S[..., 2, 2])[..., None, None]
    M = trace * jnp.eye(3, dtype=F.dtype) - S
    w = matvec(cofactor(M), axial) / determinant(M)[..., None]  # M is symmetric: cofactor^T = cofactor
    return R, matmul(R, skew(w))
