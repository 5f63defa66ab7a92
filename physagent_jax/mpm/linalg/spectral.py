"""Functions of a matrix through its singular values, with exact first derivatives.

An isotropic function G(F) = U diag(g(s)) V^T is smooth where g is, also where singular values meet and
the factors U and V are arbitrary. With A = U^T dF V and W = U^T dU, writing out F = U diag(s) V^T gives

    ds_i = A_ii,    W_ij = (s_j A_ij + s_i A_ji) / (s_j^2 - s_i^2)                      (i != j)

and the arbitrary factors drop out of

    (U^T dG V)_ij   = (a + b)/2 A_ij + (a - b)/2 A_ji,   a = (g_i - g_j) / (s_i - s_j), b = (g_i + g_j) / (s_i + s_j)
    (U^T dtau U)_ij = (t_i - t_j) / (s_i^2 - s_j^2) (s_j A_ij + s_i A_ji)   for   tau = U diag(t(s)) U^T.

Near s_i = s_j the divided differences become the derivatives of the symmetrised difference, whose error is
of second order in the distance: a = (d_i - d_j)(g_i - g_j) / 2, and likewise near s_i = -s_j.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from physagent_jax.kernels import use_cpu
from physagent_jax.mpm.linalg import kernels
from physagent_jax.mpm.linalg.algebra import matmul, transpose
from physagent_jax.mpm.linalg.svd import SWEEPS, svd


class Principal(NamedTuple):
    """A function of the singular values, which `spectral` turns into matrices.

    Attributes:
        two_point: g, shape (3, n), for U diag(g) V^T (as F); None = not wanted.
        change: c, shape (3, n), for F + U diag(c) V^T: where c is zero F stays as it is, to the last bit; None = not
            wanted. Only one of ``two_point`` and ``change``.
        spatial: t, shape (3, n), for U diag(t) U^T (as a stress); None = not wanted.
        scalar: Any pytree of arrays of shape (n,), returned as it is.
    """

    two_point: Any = None
    change: Any = None
    spatial: Any = None
    scalar: Any = None


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def spectral(function: Callable[[jax.Array, Any], Principal], F: jax.Array, parameters: Any) -> Principal:
    """Evaluate ``function(s, parameters)`` at the singular values of F, and set its results in F's frames.

    Singular values come one after the other, each of all particles: XLA makes vector code of that, and what is of
    shape (n,) applies to all three without ado. All results share one SVD. First derivatives with respect to F and the
    parameters are exact in both modes; second derivatives raise.

    Args:
        function: Maps s, shape (3, n), and the parameters to a `Principal`, particle by particle. Exchanging two
            singular values must exchange the two results. Must not close over traced arrays.
        F: Shape (n, 3, 3); the last of s carries the sign of det F (`svd`).
        parameters: Any pytree whose arrays have one entry per particle, or none.

    Returns:
        `Principal` with (n, 3, 3) matrices for ``two_point``, ``change`` and ``spatial``.
    """
    if F.size and use_cpu():
        return _run_kernels(function, F, parameters)
    U, s, V = svd(F)
    return _set_in_frames(_take_rows(function)(s, parameters), F, U, V)


@spectral.defjvp
def _spectral_jvp(function, primals, tangents):
    (F, parameters), (dF, dparameters) = primals, tangents
    function = _take_rows(function)
    U, s, V = svd(F)
    A = matmul(matmul(transpose(U), dF), V)
    ds = jnp.stack([A[..., i, i] for i in range(3)], -1)
    values, changes = jax.jvp(function, (s, parameters), (ds, dparameters))
    _, rates = jax.linearize(lambda s: function(s, parameters)._replace(scalar=None), s)
    columns = [rates(jnp.zeros_like(s).at[..., j].set(1)) for j in range(3)]

    def turned(field, tangent_of, right):
        """The tangent of one field's matrices, or None."""
        value = getattr(values, field)
        if value is None:
            return None
        jacobian = jnp.stack([getattr(column, field) for column in columns], -1)
        local = tangent_of(s, value, getattr(changes, field), jacobian, A)
        return matmul(matmul(U, local), transpose(right))

    two_point, change = (turned(field, _two_point_tangent, V) for field in ("two_point", "change"))
    spatial = turned("spatial", _spatial_tangent, U)
    tangents = Principal(two_point, None if change is None else dF + change, spatial, changes.scalar)
    return _set_in_frames(values, F, U, V), tangents


def isotropic(function: Callable[[jax.Array, Any], jax.Array], F: jax.Array, parameters: Any) -> jax.Array:
    """G(F) = U diag(g(s, parameters)) V^T with exact derivatives; see `spectral`.

    Args:
        function: g, from s of shape (3, n) and the parameters to shape (3, n), symmetric in s.
        F: Shape (n, 3, 3).
        parameters: Any pytree whose arrays have one entry per particle, or none.
    """
    return spectral(lambda s, p: Principal(two_point=function(s, p)), F, parameters).two_point


@jax.custom_jvp
def singular_values(F: jax.Array) -> jax.Array:
    """Singular values, shape (..., 3), |s| descending, with the sign of det F on the last.

    Their derivative ds_i = (U^T dF V)_ii is that of the sorted values; where two are equal, only symmetric
    functions of them are differentiable.
    """
    return svd(F)[1]


@singular_values.defjvp
def _singular_values_jvp(primals, tangents):
    (F,), (dF,) = primals, tangents
    U, s, V = svd(F)
    return s, (U * matmul(dF, V)).sum(-2)


def _take_rows(function):
    """``function`` from and to a row for each particle, shape (n, 3)."""

    def row(diagonal):
        return None if diagonal is None else jnp.moveaxis(diagonal, 0, -1)

    def by_rows(s, parameters):
        found = function(jnp.moveaxis(s, -1, 0), parameters)
        return Principal(row(found.two_point), row(found.change), row(found.spatial), found.scalar)

    return by_rows


def _set_in_frames(values: Principal, F: jax.Array, U: jax.Array, V: jax.Array) -> Principal:
    def between(diagonal, right):
        return None if diagonal is None else matmul(U * diagonal[..., None, :], transpose(right))

    change = between(values.change, V)
    change = None if change is None else F + change
    return Principal(between(values.two_point, V), change, between(values.spatial, U), values.scalar)


def _run_kernels(function, F: jax.Array, parameters: Any) -> Principal:
    """`spectral` where there are kernels, to which the frames are not matrices."""
    count, kernel = F.shape[0], kernels.load_cpu_kernels()
    s, basis = kernel.decompose(F, SWEEPS[F.dtype.itemsize])
    two_point, change, spatial, scalar = function(s[:, :count], parameters)
    start, added = (F, change) if two_point is None else (jnp.zeros_like(F), two_point)
    changed, stress = kernel.compose(basis, start, added, spatial)
    return Principal(
        None if two_point is None else changed,
        None if change is None else changed,
        None if spatial is None else stress,
        scalar,
    )


def _two_point_tangent(s, g, dg, jacobian, A):
    """U^T dG V of the module's docstring, shape (..., 3, 3)."""
    pairs = _Pairs(s, jacobian)
    a, b = (
        pairs.over_difference(_take_first(g) - _take_second(g)),
        pairs.over_sum(_take_first(g) + _take_second(g)),
    )
    even, odd = (a + b) / 2, (a - b) / 2
    upper, lower = _take_upper(A), _take_upper(transpose(A))
    return _assemble(dg, even * upper + odd * lower, even * lower + odd * upper)


def _spatial_tangent(s, t, dt, jacobian, A):
    """U^T dtau U of the module's docstring, shape (..., 3, 3)."""
    c = _Pairs(s, jacobian).over_square_difference(_take_first(t) - _take_second(t))
    off_diagonal = c * (_take_second(s) * _take_upper(A) + _take_first(s) * _take_upper(transpose(A)))
    return _assemble(dt, off_diagonal, off_diagonal)


class _Pairs:
    """Divided differences over the pairs (i, j) of singular values, shape (..., 3), with their limits.

    "Near" is relative to the two values, so that a pair of small ones is treated as any other. The
    tolerance balances the limit's error, its square, against the round-off of the difference.
    """

    def __init__(self, s, jacobian):
        self.difference, self.sum = _take_first(s) - _take_second(s), _take_first(s) + _take_second(s)
        near = jnp.finfo(s.dtype).eps ** (1 / 3) * (jnp.abs(_take_first(s)) + jnp.abs(_take_second(s)))
        self.equal = jnp.abs(self.difference) <= near
        self.opposite = jnp.abs(self.sum) <= near
        self.safe_difference = jnp.where(self.equal, 1, self.difference)
        self.safe_sum = jnp.where(self.opposite, 1, self.sum)
        diagonal = jnp.stack([jacobian[..., i, i] for i in range(3)], -1)
        self.own_i, self.own_j = _take_first(diagonal), _take_second(diagonal)  # d_i g_i, d_j g_j
        self.cross_ij, self.cross_ji = (
            _take_upper(jacobian),
            _take_upper(transpose(jacobian)),
        )  # d_j g_i, d_i g_j

    def over_difference(self, numerator):
        """(g_i - g_j) / (s_i - s_j)."""
        return jnp.where(self.equal, self._take_limit(), numerator / self.safe_difference)

    def over_sum(self, numerator):
        """(g_i + g_j) / (s_i + s_j)."""
        limit = (self.own_i + self.cross_ji + self.cross_ij + self.own_j) / 2
        return jnp.where(self.opposite, limit, numerator / self.safe_sum)

    def over_square_difference(self, numerator):
        """(t_i - t_j) / (s_i^2 - s_j^2); zero for a pair of zeros, where tau's derivative vanishes with s."""
        at_opposite = (self.own_i - self.cross_ji + self.cross_ij - self.own_j) / 2
        apart = numerator / (self.safe_difference * self.safe_sum)
        value = jnp.where(self.opposite, at_opposite / self.safe_difference, apart)
        value = jnp.where(self.equal, self._take_limit() / self.safe_sum, value)
        return jnp.where(self.equal & self.opposite, 0, value)

    def _take_limit(self):
        return (self.own_i - self.cross_ij + self.own_j - self.cross_ji) / 2


def _take_first(v):
    """Entry i of each pair (i, j) = (0, 1), (0, 2), (1, 2)."""
    return jnp.stack([v[..., 0], v[..., 0], v[..., 1]], -1)


def _take_second(v):
    """Entry j of each pair."""
    return jnp.stack([v[..., 1], v[..., 2], v[..., 2]], -1)


def _take_upper(a):
    """Entry (i, j) of each pair."""
    return jnp.stack([a[..., 0, 1], a[..., 0, 2], a[..., 1, 2]], -1)


def _assemble(diagonal, upper, lower):
    """The matrix with these entries at (i, i), (i, j) and (j, i)."""
    d, u, l = diagonal, upper, lower
    rows = (
        (d[..., 0], u[..., 0], u[..., 1]),
        (l[..., 0], d[..., 1], u[..., 2]),
        (l[..., 1], l[..., 2], d[..., 2]),
    )
    return jnp.stack([jnp.stack(row, -1) for row in rows], -2)
