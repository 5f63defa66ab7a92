"""The SVD of `mpm.linalg.svd` on the CPU: the same Jacobi sweeps, eight particles at a time."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

from numba import njit, prange

from physagent_jax.mpm.kernels.lanes import (
    PARTICLES,
    collect,
    distribute,
    magnitude,
    root,
    same,
    where_greater,
)
from physagent_jax.mpm.kernels.numbers import INLINE, OPTIONS, like, share, smallest


@njit(parallel=True, **OPTIONS)
def svd(F, sweeps, U, s, V, parts):
    """U, s and V of F = U diag(s) V^T; flat arrays of at least `PARTICLES` matrices."""
    count = s.shape[0] // 3
    batches = (count + PARTICLES - 1) // PARTICLES
    for part in prange(parts):
        first, last = share(batches, part, parts)
        for batch in range(first, last):
            # The last batch overlaps the one before, and writes the same values there.
            start = min(batch * PARTICLES, count - PARTICLES)
            (u, v, w), (s0, s1, s2), (x, y, z) = _factors(F, 9 * start, sweeps)
            _write_columns(U, 9 * start, u, v, w)
            _write_columns(V, 9 * start, x, y, z)
            _write(s, 3 * start, 3, s0, s1, s2)


@njit(parallel=True, **OPTIONS)
def polar(F, sweeps, R, parts):
    """The orthogonal factor of F; flat arrays of at least `PARTICLES` matrices."""
    count = F.shape[0] // 9
    batches = (count + PARTICLES - 1) // PARTICLES
    for part in prange(parts):
        first, last = share(batches, part, parts)
        for batch in range(first, last):
            start = min(batch * PARTICLES, count - PARTICLES)
            (u, v, w), (_, _, s2), (x, y, z) = _factors(F, 9 * start, sweeps)
            zero = s2 - s2
            one = same(like(1, F[0]), s2)
            sign = where_greater(zero, s2, zero - one, one) + zero  # not finite where F is not
            w = (sign * w[0], sign * w[1], sign * w[2])
            first_column = _combined(u, v, w, x[0], y[0], z[0])
            second_column = _combined(u, v, w, x[1], y[1], z[1])
            _write_columns(R, 9 * start, first_column, second_column, _combined(u, v, w, x[2], y[2], z[2]))


@njit(**INLINE)
def _factors(F, o, sweeps):
    """Columns of U, singular values and columns of V, of the batch of matrices that starts at ``F[o]``."""
    zero = same(like(0, F[0]), collect(F, o, 9))
    one, half, tiny = same(like(1, F[0]), zero), same(like(0.5, F[0]), zero), same(smallest(F[0]), zero)
    a, b, c = _column(F, o), _column(F, o + 1), _column(F, o + 2)
    scale = _largest(_largest(_largest(zero, a), b), c)
    scale = where_greater(scale, zero, scale, one) + (scale - scale)  # not finite where F is not
    a, b, c = _over(a, scale), _over(b, scale), _over(c, scale)
    x, y, z = (one, zero, zero), (zero, one, zero), (zero, zero, one)
    for _ in range(sweeps):
        a, b, x, y = _orthogonal(a, b, x, y, zero, one)
        a, c, x, z = _orthogonal(a, c, x, z, zero, one)
        b, c, y, z = _orthogonal(b, c, y, z, zero, one)
    # U and s from orthogonal columns; for zero columns U gets directions that complete a rotation.
    aa, bb = _dot(a, a), _dot(b, b)
    u = _direction(a, aa, (one, zero, zero), tiny, half)
    along = _dot(u, b)
    rest = (b[0] - along * u[0], b[1] - along * u[1], b[2] - along * u[2])
    v = _direction(rest, bb, _perpendicular(u, zero, one), tiny, half)
    w = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    return (u, v, w), (root(aa) * scale, root(bb) * scale, _dot(w, c) * scale), (x, y, z)


@njit(**INLINE)
def _column(F, o):
    return collect(F, o, 9), collect(F, o + 3, 9), collect(F, o + 6, 9)


@njit(**INLINE)
def _write_columns(matrix, o, a, b, c):
    _write(matrix, o, 9, a[0], b[0], c[0])
    _write(matrix, o + 3, 9, a[1], b[1], c[1])
    _write(matrix, o + 6, 9, a[2], b[2], c[2])


@njit(**INLINE)
def _write(array, o, stride, first, second, third):
    distribute(array, o, stride, first)
    distribute(array, o + 1, stride, second)
    distribute(array, o + 2, stride, third)


@njit(**INLINE)
def _combined(u, v, w, x, y, z):
    """X u + y v + z w."""
    return x * u[0] + y * v[0] + z * w[0], x * u[1] + y * v[1] + z * w[1], x * u[2] + y * v[2] + z * w[2]


@njit(**INLINE)
def _largest(so_far, column):
    for k in range(3):
        size = magnitude(column[k])
        so_far = where_greater(so_far, size, so_far, size)
    return so_far


@njit(**INLINE)
def _over(column, scale):
    return column[0] / scale, column[1] / scale, column[2] / scale


@njit(**INLINE)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**INLINE)
def _mixed(c, a, s, b):
    """C a + s b."""
    return c * a[0] + s * b[0], c * a[1] + s * b[1], c * a[2] + s * b[2]


@njit(**INLINE)
def _orthogonal(a, b, x, y, zero, one):
    """Turns columns a and b of F V to a right angle, the longer one first, and columns x and y of V with them."""
    difference, product = _dot(b, b) - _dot(a, a), _dot(a, b)
    twice = where_greater(difference, zero, product + product, zero - product - product)
    denominator = magnitude(difference) + root(difference * difference + twice * twice)
    t = twice / where_greater(denominator, zero, denominator, one)
    t = where_greater(
        t, one, one, where_greater(zero - one, t, zero - one, t)
    )  # where squares have underflowed
    cosine = one / root(one + t * t)
    sine = cosine * t
    c = where_greater(difference, zero, sine, cosine)
    s = where_greater(difference, zero, zero - cosine, sine)
    minus = zero - s
    return _mixed(c, a, minus, b), _mixed(s, a, c, b), _mixed(c, x, minus, y), _mixed(s, x, c, y)


@njit(**INLINE)
def _direction(a, full, fallback, tiny, half):
    """The direction of a; the fallback for zero and for round-off, less than half of |original|^2 = ``full``."""
    square = _dot(a, a)
    least = full * half
    floor = where_greater(least, tiny, least, tiny)
    length = root(where_greater(square, floor, square, floor))
    d = (a[0] / length, a[1] / length, a[2] / length)
    return (
        where_greater(floor, square, fallback[0], d[0]),
        where_greater(floor, square, fallback[1], d[1]),
        where_greater(floor, square, fallback[2], d[2]),
    )


@njit(**INLINE)
def _perpendicular(u, zero, one):
    """A unit vector at right angles to the unit vector u (Duff et al. 2017, JCGT 6(1))."""
    sign = where_greater(zero, u[2], zero - one, one)
    k = (zero - one) / (sign + u[2])
    return one + sign * k * u[0] * u[0], sign * k * u[0] * u[1], zero - sign * u[0]
