"""The rotation nearest to a deformation gradient, without an SVD."""

from __future__ import annotations

import jax
import jax.numpy as jnp

# Newton's method for the largest root of the quartic below converges monotonically from above; the slowest
# start (two vanishing singular values) takes about a dozen steps to float32 accuracy, a rotation takes one.
_NEWTON_STEPS = 14


@jax.custom_jvp
@jax.jit
def polar_rotation(F: jax.Array) -> jax.Array:
    """Proper rotations R that maximise tr(R^T F): the polar factor of F where det F > 0.

    For det F < 0 (an inverted element) the polar factor U V^T is a reflection; the result is then
    U diag(1, 1, -1) V^T, the rotation nearest to F, as in PhysGaussian (Xie et al. 2024). A rank-two F is
    fine. Where the rotation is not unique (rank one or less, or an inversion with equal smallest singular
    values) some rotation is returned, the identity for F = 0.

    Davenport's q-method: the quaternion of R is the dominant eigenvector of a symmetric traceless 4x4 matrix
    K (Horn 1987, "Closed-form solution of absolute orientation using unit quaternions"). The eigenvalue is
    found by Newton's method on the characteristic polynomial, from above, the eigenvector from the adjugate.
    The derivative is the exact one of the polar factor, not that of the iteration.

    Args:
        F: Deformation gradients, shape (n, 3, 3).

    Returns:
        Rotations, shape (n, 3, 3).
    """
    size = jnp.sqrt(jnp.sum(F * F, axis=(1, 2), keepdims=True))
    tiny = jnp.finfo(F.dtype).tiny
    M = F / jnp.maximum(size, tiny)  # unit Frobenius norm: the polynomial's coefficients are of order one
    K = _build_davenport(M)
    w, x, y, z = _find_dominant_eigenvector(K, _find_largest_eigenvalue(M))
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return jnp.stack([jnp.stack(row, axis=-1) for row in rows], axis=-2)


@polar_rotation.defjvp
def _polar_rotation_jvp(primals, tangents):
    """The tangent dR = R [omega]x with (tr(S) I - S) omega = axial(R^T dF - dF^T R), where F = R S.

    From R^T dF = [omega]x S + dS and the symmetry of S. The matrix is singular exactly where R jumps;
    a relative damping of 1e-6 keeps the derivative finite there.
    """
    (F,), (dF,) = primals, tangents
    R = polar_rotation(F)
    S = jnp.einsum("nki,nkj->nij", R, F, precision="highest")
    W = jnp.einsum("nki,nkj->nij", R, dF, precision="highest")
    a = jnp.stack([W[:, 2, 1] - W[:, 1, 2], W[:, 0, 2] - W[:, 2, 0], W[:, 1, 0] - W[:, 0, 1]], axis=-1)
    S = 0.5 * (S + S.transpose(0, 2, 1))
    identity = jnp.eye(3, dtype=F.dtype)
    A = jnp.trace(S, axis1=1, axis2=2)[:, None, None] * identity - S
    omega = _solve_damped(A, a)
    zero = jnp.zeros_like(omega[:, 0])
    x, y, z = (omega[:, i] for i in range(3))
    skew = jnp.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
    return R, jnp.einsum("nik,nkj->nij", R, skew, precision="highest")


def _solve_damped(A: jax.Array, a: jax.Array) -> jax.Array:
    """Solve symmetric 3x3 systems by the adjugate, damped where the matrix is nearly singular."""
    r0, r1, r2 = A[:, 0], A[:, 1], A[:, 2]
    adjugate = jnp.stack([jnp.cross(r1, r2), jnp.cross(r2, r0), jnp.cross(r0, r1)], axis=-1)
    det = jnp.sum(r0 * adjugate[:, :, 0], axis=-1)
    scale = jnp.sqrt(jnp.sum(A * A, axis=(1, 2))) ** 3
    inverse = det / (det * det + (1e-6 * scale) ** 2 + jnp.finfo(A.dtype).tiny)
    return jnp.einsum("nij,nj->ni", adjugate, a, precision="highest") * inverse[:, None]


def _build_davenport(M: jax.Array) -> tuple[tuple[jax.Array, ...], ...]:
    """The symmetric 4x4 matrices K with q^T K q = tr(R(q)^T M), as scalars."""
    m = [[M[:, i, j] for j in range(3)] for i in range(3)]
    p, q, r = m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]
    s, t, u = m[0][1] + m[1][0], m[0][2] + m[2][0], m[1][2] + m[2][1]
    return (
        (m[0][0] + m[1][1] + m[2][2], p, q, r),
        (p, m[0][0] - m[1][1] - m[2][2], s, t),
        (q, s, m[1][1] - m[0][0] - m[2][2], u),
        (r, t, u, m[2][2] - m[0][0] - m[1][1]),
    )


def _find_largest_eigenvalue(M: jax.Array) -> jax.Array:
    """Largest eigenvalue of Davenport's K for M of unit norm, shape (n,).

    It equals s1 + s2 + sign(det M) s3 in singular values, and K has the characteristic polynomial
    z^4 - 2 |M|^2 z^2 - 8 det(M) z + |M|^4 - 4 |cof M|^2.
    """
    r0, r1, r2 = M[:, 0], M[:, 1], M[:, 2]
    c0, c1, c2 = jnp.cross(r1, r2), jnp.cross(r2, r0), jnp.cross(r0, r1)
    d = 8 * jnp.sum(r0 * c0, axis=-1)
    e = 1 - 4 * jnp.sum(c0 * c0 + c1 * c1 + c2 * c2, axis=-1)

    def newton(_, z):
        value = ((z * z - 2) * z - d) * z + e
        slope = (4 * z * z - 4) * z - d
        return z - value / jnp.where(slope > 1e-6, slope, jnp.inf)

    upper_bound = jnp.full_like(d, 3**0.5)
    return jax.lax.fori_loop(0, _NEWTON_STEPS, newton, upper_bound)


def _find_dominant_eigenvector(
    K: tuple[tuple[jax.Array, ...], ...], eigenvalue: jax.Array
) -> tuple[jax.Array, ...]:
    """Unit eigenvector of K: the largest column of the adjugate of K - eigenvalue I, as scalars."""
    A = [[K[i][j] - eigenvalue if i == j else K[i][j] for j in range(4)] for i in range(4)]

    def cofactor(i: int, j: int) -> jax.Array:
        rows = [r for r in range(4) if r != i]
        a, b, c = ([A[r][k] for k in range(4) if k != j] for r in rows)
        minor = (
            a[0] * (b[1] * c[2] - b[2] * c[1])
            - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        return minor if (i + j) % 2 == 0 else -minor

    # The adjugate is symmetric and of rank one, so the column of its largest diagonal entry is the largest.
    best = [cofactor(i, 0) for i in range(4)]
    largest = jnp.abs(best[0])
    for j in range(1, 4):
        column = [cofactor(i, j) for i in range(4)]
        better = jnp.abs(column[j]) > largest
        best = [jnp.where(better, new, old) for new, old in zip(column, best)]
        largest = jnp.maximum(largest, jnp.abs(column[j]))
    norm = jnp.sqrt(sum(component * component for component in best))
    degenerate = norm < jnp.finfo(eigenvalue.dtype).tiny
    unit = [component / jnp.where(degenerate, 1, norm) for component in best]
    return (jnp.where(degenerate, 1, unit[0]), *unit[1:])
