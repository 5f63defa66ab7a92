"""The rotation of a deformation gradient, without an SVD."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.mpm import kernels
from physagent_jax.mpm.linalg.algebra import cofactor, determinant, matmul, matvec, skew, transpose

_NEWTON_STEPS = 9  # f64 round-off from condition number 1e3 on; f32 is done after 7


@jax.custom_jvp
def polar_rotation(F: jax.Array) -> jax.Array:
    """The orthogonal factor R of F = R S by scaled Newton iteration (Higham 1986, SIAM J. Sci. Stat. Comput.).

    For det F > 0, R is the rotation. For det F < 0 the orthogonal factor is a reflection and is returned
    as such; for singular F the result is arbitrary or not finite. Rollouts stop such states before they are used
    (`mpm.rollout`). The CPU kernel takes R from an SVD instead, which is as fast there.

    The derivative is the exact one, also at F = I and at repeated singular values, where differentiating
    an SVD fails: with dR = R W, (tr(S) I - S) w = axial(R^T dF - dF^T R), W = skew(w).
    """
    if F.size and kernels.use_cpu():
        return kernels.compiled().polar(F)
    return _newton(F)


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


@jax.jit  # so that code outside a jit does not run it operation by operation
def _newton(F: jax.Array) -> jax.Array:
    def improve(R, _):
        inverse_transpose = cofactor(R) / determinant(R)[..., None, None]
        # Frobenius-norm scaling brings large and small stretches together in the first steps.
        ratio = (inverse_transpose**2).sum((-1, -2)) / (R**2).sum((-1, -2))
        gamma = (ratio**0.25)[..., None, None]
        return 0.5 * (gamma * R + inverse_transpose / gamma), None

    return jax.lax.scan(improve, F, None, length=_NEWTON_STEPS)[0]
