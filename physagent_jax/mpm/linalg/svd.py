"""Singular value decomposition of many 3x3 matrices at once."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.kernels import use_cpu
from physagent_jax.mpm.linalg import kernels

_PAIRS = ((0, 1), (0, 2), (1, 2))
SWEEPS = {4: 4, 8: 5}  # by bytes per number; more change no error, also at condition numbers beyond 1e6


@jax.custom_jvp
def svd(F: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """F = U diag(s) V^T with proper rotations U and V, by one-sided Jacobi sweeps (Demmel & Veselic 1992).

    The sign of det F sits on the last singular value, and |s| descends. Rotating the columns of F itself,
    not F^T F, keeps the accuracy of small singular values. Every matrix takes the same element-wise
    operations, so that a batch costs a few fused loops per sweep.

    An SVD has no derivative where singular values meet, which includes F = I. Asking for it is an error;
    `spectral` and `isotropic` have the exact derivative of what is well defined.

    Args:
        F: Any matrices, shape (..., 3, 3).

    Returns:
        U, shape (..., 3, 3); s, shape (..., 3); V, shape (..., 3, 3). Not finite where F is not.
    """
    if F.size and use_cpu():
        return kernels.load_cpu_kernels().svd(F, SWEEPS[F.dtype.itemsize])
    return _sweep_jacobi(F)


@svd.defjvp
def _svd_jvp(primals, tangents):
    raise NotImplementedError(
        "`svd` has no derivative where singular values are equal, as they are at F = I. "
        "Write the result as an isotropic function of F: `mpm.linalg.spectral` or `mpm.linalg.isotropic` "
        "(first derivatives only), or `singular_values`."
    )


@jax.jit  # so that code outside a jit does not run it operation by operation
def _sweep_jacobi(F: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    largest = jnp.abs(F).max((-1, -2))
    scale = jnp.where(largest == 0, 1, largest)
    scaled = jnp.moveaxis(F / scale[..., None, None], (-2, -1), (0, 1))
    unit = jnp.moveaxis(jnp.broadcast_to(jnp.eye(3, dtype=F.dtype), F.shape), (-2, -1), (0, 1))
    # Column j of F V and of V as one array (6, ...): the particles lie in the fast axis.
    columns = jnp.moveaxis(jnp.concatenate([scaled, unit]), 1, 0)
    start = columns, *_measure_angle(columns, 0)
    columns = jax.lax.fori_loop(0, len(_PAIRS) * SWEEPS[F.dtype.itemsize], _rotate_pair, start)[0]
    U, s = _find_left_factor(*(column[:3] for column in columns))
    return (
        _join_columns(U),
        jnp.stack(s, -1) * scale[..., None],
        _join_columns(tuple(column[3:] for column in columns)),
    )


def _rotate_pair(turn: jax.Array, carry: tuple[jax.Array, ...]) -> tuple[jax.Array, ...]:
    """Make one pair of columns of F V orthogonal, by a rotation that V collects; three turns are a sweep.

    The angle's two numbers come from the turn before: where both are nothing but round-off any angle will do, but only
    one. XLA computes what is cheap again in each of its loops, and not always to the last bit, and two columns turned
    by two angles are not orthogonal; what a turn hands to the next is computed once.
    """
    columns, difference, product = carry
    p, q = _take_pair(turn)
    a, b = columns[p], columns[q]
    c, s = _find_rotation(difference, product)
    columns = columns.at[p].set(c * a - s * b).at[q].set(s * a + c * b)
    return columns, *_measure_angle(columns, turn + 1)


def _take_pair(turn: jax.Array | int) -> tuple[jax.Array, jax.Array]:
    pair = jnp.asarray(_PAIRS)[turn % len(_PAIRS)]
    return pair[0], pair[1]


def _measure_angle(columns: jax.Array, turn: jax.Array | int) -> tuple[jax.Array, jax.Array]:
    """|b|^2 - |a|^2 and a . b of the pair (a, b) of columns of F V that it is the turn of, shapes (...)."""
    p, q = _take_pair(turn)
    a, b = columns[p, :3], columns[q, :3]
    return _dot(b, b) - _dot(a, a), _dot(a, b)


def _find_rotation(difference: jax.Array, product: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Cosine and sine of the angle that makes vectors a and b orthogonal, the longer one the first.

    It is the smaller angle, at most 45 degrees, where a is the longer; else that less a right angle, which
    exchanges the two. ``difference`` and ``product`` are those of `_measure_angle`.
    """
    exchange = difference > 0
    twice = 2 * jnp.where(exchange, product, -product)
    denominator = jnp.abs(difference) + jnp.sqrt(difference**2 + twice**2)
    t = jnp.where(twice == 0, 0, twice / jnp.where(denominator == 0, 1, denominator))
    t = jnp.clip(t, -1, 1)  # for where the squares have underflowed
    c = 1 / jnp.sqrt(1 + t**2)
    s = c * t
    return jnp.where(exchange, s, c), jnp.where(exchange, -c, s)


def _find_left_factor(a1: jax.Array, a2: jax.Array, a3: jax.Array):
    """U and s from orthogonal a_j = s_j u_j; for zero columns U gets directions that complete a rotation."""
    x_axis = jnp.zeros_like(a1).at[0].set(1)
    u1 = _normalise(a1, _dot(a1, a1), x_axis)
    u2 = _normalise(a2 - _dot(u1, a2) * u1, _dot(a2, a2), _find_perpendicular(u1))
    u3 = _cross(u1, u2)
    return (u1, u2, u3), (jnp.sqrt(_dot(a1, a1)), jnp.sqrt(_dot(a2, a2)), _dot(u3, a3))


def _normalise(a: jax.Array, full: jax.Array, fallback: jax.Array) -> jax.Array:
    """The direction of a; the fallback for zero and for round-off, less than half of |original|^2 = ``full``."""
    square = _dot(a, a)
    negligible = (square <= jnp.finfo(square.dtype).tiny) | (square < 0.5 * full)
    return jnp.where(negligible, fallback, a / jnp.sqrt(jnp.where(negligible, 1, square)))


def _find_perpendicular(u: jax.Array) -> jax.Array:
    """A unit vector at right angles to the unit vector u (Duff et al. 2017, JCGT 6(1))."""
    x, y, z = u
    sign = jnp.where(z < 0, -1, 1).astype(z.dtype)
    k = -1 / (sign + z)
    return jnp.stack([1 + sign * k * x**2, sign * k * x * y, -sign * x])


def _dot(a: jax.Array, b: jax.Array) -> jax.Array:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: jax.Array, b: jax.Array) -> jax.Array:
    return jnp.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _join_columns(columns: tuple[jax.Array, ...]) -> jax.Array:
    return jnp.moveaxis(jnp.stack(columns, -1), 0, -2)
