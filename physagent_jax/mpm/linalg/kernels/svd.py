"""The SVD of `linalg.svd` on the CPU: the same Jacobi sweeps, two batches of particles at a time.

`decompose` leaves the frames as it has them, in batches, and `compose` takes them so: turning them into matrices and
back costs more than the SVD itself.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

from numba import njit

from physagent_jax.kernels.lanes import (
    BATCH,
    any_greater,
    concatenate,
    fabs,
    flatten,
    iota,
    load_batch,
    load_strided,
    select_greater,
    splat_like,
    split,
    sqrt,
    store,
    store_strided,
)
from physagent_jax.kernels.numbers import (
    INLINE,
    OPTIONS,
    SHARES_PER_THREAD,
    cast_like,
    extract,
    roundoff,
    smallest_normal,
    split_range,
)
from physagent_jax.kernels.team import share_loop, team_size

FRAME = 12  # numbers of U and V: their third columns are cross products, and memory is slower than arithmetic
_LEAST_SWEEPS = 2  # before it is asked whether more are needed; they also let what is not finite reach V


@njit(**OPTIONS)
def decompose(team, F, sweeps, s, basis):
    """Singular values and frames of F = U diag(s) V^T.

    Args:
        team: Who runs this.
        F: At least `BATCH` matrices, flat.
        sweeps: Jacobi sweeps.
        s: Result, shape (3, n).
        basis: Result, shape (batches, FRAME, BATCH): the first two columns of U and of V, of one batch of particles
            after the other. The last batch overlaps the one before, and has the same values there but for round-off.
    """
    pairs, shares = (basis.shape[0] + 1) // 2, team_size(team) * SHARES_PER_THREAD
    for share in share_loop(team, 0, shares):
        # The last pair belongs to whoever does the one before: the matrices that both have may get other sweeps in
        # it, and which s stays must not depend on who is faster.
        first, last = split_range(pairs - 1, share, shares)
        decompose_pairs(F, sweeps, s, basis, first, last + (share == shares - 1))


@njit(**INLINE)
def decompose_pairs(F, sweeps, s, basis, first, last):
    """The pairs of batches ``first`` to ``last``."""
    count, batches = s.shape[1], basis.shape[0]
    frames, values = flatten(basis), flatten(s)
    for pair in range(first, last):
        # Two batches at a time: a rotation is a chain of roots and quotients, and the second fills its pauses.
        one, other = 2 * pair, min(2 * pair + 1, batches - 1)
        start = batch_start(one, count), batch_start(other, count)
        (u, v), (s0, s1, s2), (x, y) = _factorise(F, (9 * start[0], 9 * start[1]), sweeps)
        _put(values, start, 0, s0)
        _put(values, start, count, s1)
        _put(values, start, 2 * count, s2)
        o = one * FRAME * BATCH, other * FRAME * BATCH
        _put_column(frames, o, 0, u)
        _put_column(frames, o, 3 * BATCH, v)
        _put_column(frames, o, 6 * BATCH, x)
        _put_column(frames, o, 9 * BATCH, y)


@njit(**OPTIONS)
def compose(team, basis, change, spatial, F, tau):
    """F + U diag(change) V^T and U diag(spatial) U^T, with the frames of `decompose`.

    Args:
        team: Who runs this.
        basis: As made by `decompose`.
        change: Shape (3, n), or (3, 0) = not wanted.
        spatial: Shape (3, n), or (3, 0) = not wanted.
        F: Matrices, flat, which the change is added to, if wanted.
        tau: Result, flat, if wanted.
    """
    batches, shares = basis.shape[0], team_size(team) * SHARES_PER_THREAD
    for share in share_loop(team, 0, shares):
        # The last batch belongs to whoever does the one before, whose matrices it must not change again.
        first, last = split_range(batches - 1, share, shares)
        compose_batches(basis, change, spatial, F, tau, first, last + (share == shares - 1))


@njit(**INLINE)
def compose_batches(basis, change, spatial, F, tau, first, last):
    """The batches ``first`` to ``last``, in order."""
    count = max(change.shape[1], spatial.shape[1])
    moves, stresses = change.shape[1] > 0, spatial.shape[1] > 0
    frames, g, t = flatten(basis), flatten(change), flatten(spatial)
    for number in range(first, last):
        start, o = batch_start(number, count), number * FRAME * BATCH
        u, v = _get_column(frames, o), _get_column(frames, o + 3 * BATCH)
        w = _cross(u, v)
        if moves:
            done = number * BATCH - start
            a, b, c = _scale_columns(g, start, count, done, u, v, w)
            x, y = _get_column(frames, o + 6 * BATCH), _get_column(frames, o + 9 * BATCH)
            z = _cross(x, y)
            for k in range(3):
                at = 9 * start + k
                xk, yk, zk = extract(x, k), extract(y, k), extract(z, k)
                for i in range(3):
                    moved = extract(a, i) * xk + extract(b, i) * yk + extract(c, i) * zk
                    store_strided(F, at + 3 * i, 9, load_strided(F, at + 3 * i, 9) + moved)
        if stresses:
            a, b, c = _scale_columns(t, start, count, 0, u, v, w)
            for i in range(3):
                ai, bi, ci = extract(a, i), extract(b, i), extract(c, i)
                for k in range(i, 3):
                    value = ai * extract(u, k) + bi * extract(v, k) + ci * extract(w, k)
                    store_strided(tau, 9 * start + 3 * i + k, 9, value)
                    if k > i:
                        store_strided(tau, 9 * start + 3 * k + i, 9, value)


@njit(**INLINE)
def batch_start(number, count):
    """Number of a batch's first particle; the last batch overlaps the one before rather than being short."""
    return min(number * BATCH, count - BATCH)


@njit(**INLINE)
def _put(array, o, offset, a):
    """Write two batches, each ``offset`` from its own place."""
    low, high = split(a)
    store(array, o[0] + offset, low)
    store(array, o[1] + offset, high)


@njit(**INLINE)
def _put_column(array, o, offset, a):
    for k in range(3):
        _put(array, o, offset + k * BATCH, extract(a, k))


@njit(**INLINE)
def _get_column(array, o):
    return load_batch(array, o), load_batch(array, o + BATCH), load_batch(array, o + 2 * BATCH)


@njit(**INLINE)
def _scale_columns(diagonal, start, count, done, u, v, w):
    """Columns u, v, w, each times its entry of ``diagonal``, which counts as zero in the first ``done`` lanes."""
    lane, _ = split(iota(diagonal[0]))
    first, zero = splat_like(cast_like(done, diagonal[0]), lane), splat_like(cast_like(0, diagonal[0]), lane)
    d0 = select_greater(first, lane, zero, load_batch(diagonal, start))
    d1 = select_greater(first, lane, zero, load_batch(diagonal, count + start))
    d2 = select_greater(first, lane, zero, load_batch(diagonal, 2 * count + start))
    return (
        (d0 * u[0], d0 * u[1], d0 * u[2]),
        (d1 * v[0], d1 * v[1], d1 * v[2]),
        (d2 * w[0], d2 * w[1], d2 * w[2]),
    )


@njit(**INLINE)
def _factorise(F, o, sweeps):
    """Two columns of U, singular values, two columns of V: of the batches that start at ``F[o[0]]`` and ``F[o[1]]``."""
    zero = splat_like(cast_like(0, F[0]), _collect(F, o, 0))
    one, half, tiny = (
        splat_like(cast_like(1, F[0]), zero),
        splat_like(cast_like(0.5, F[0]), zero),
        splat_like(smallest_normal(F[0]), zero),
    )
    last_place = splat_like(roundoff(F[0]) + roundoff(F[0]), zero)
    a, b, c = _load_column(F, o, 0), _load_column(F, o, 1), _load_column(F, o, 2)
    scale = _find_largest(_find_largest(_find_largest(zero, a), b), c)
    scale = select_greater(scale, zero, scale, one) + (scale - scale)  # not finite where F is not
    a, b, c = _divide(a, scale), _divide(b, scale), _divide(c, scale)
    x, y, z = (one, zero, zero), (zero, one, zero), (zero, zero, one)
    for sweep in range(sweeps):
        if sweep >= _LEAST_SWEEPS and _is_settled(a, b, c, last_place):
            break
        a, b, x, y = _rotate_pair(a, b, x, y, zero, one)
        a, c, x, z = _rotate_pair(a, c, x, z, zero, one)
        b, c, y, z = _rotate_pair(b, c, y, z, zero, one)
    # U and s from orthogonal columns; for zero columns U gets directions that complete a rotation.
    aa, bb = _dot(a, a), _dot(b, b)
    u = _find_direction(a, aa, (one, zero, zero), tiny, half)
    along = _dot(u, b)
    rest = (b[0] - along * u[0], b[1] - along * u[1], b[2] - along * u[2])
    v = _find_direction(rest, bb, _find_perpendicular(u, zero, one), tiny, half)
    return (u, v), (sqrt(aa) * scale, sqrt(bb) * scale, _dot(_cross(u, v), c) * scale), (x, y)


@njit(**INLINE)
def _is_settled(a, b, c, tolerance):
    """Return whether the columns are at right angles, the longest first, in all lanes: a sweep would gain nothing."""
    aa, bb, cc = sqrt(_dot(a, a)), sqrt(_dot(b, b)), sqrt(_dot(c, c))
    askew = any_greater(fabs(_dot(a, b)), tolerance * aa * bb)
    askew |= any_greater(fabs(_dot(a, c)), tolerance * aa * cc)
    askew |= any_greater(fabs(_dot(b, c)), tolerance * bb * cc)
    return not (askew or any_greater(bb, aa) or any_greater(cc, bb))


@njit(**INLINE)
def _collect(F, o, offset):
    return concatenate(load_strided(F, o[0] + offset, 9), load_strided(F, o[1] + offset, 9))


@njit(**INLINE)
def _load_column(F, o, k):
    return _collect(F, o, k), _collect(F, o, k + 3), _collect(F, o, k + 6)


@njit(**INLINE)
def _find_largest(so_far, column):
    for k in range(3):
        size = fabs(column[k])
        so_far = select_greater(so_far, size, so_far, size)
    return so_far


@njit(**INLINE)
def _divide(column, scale):
    return column[0] / scale, column[1] / scale, column[2] / scale


@njit(**INLINE)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**INLINE)
def _cross(u, v):
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


@njit(**INLINE)
def _mix(c, a, s, b):
    """c a + s b."""
    return c * a[0] + s * b[0], c * a[1] + s * b[1], c * a[2] + s * b[2]


@njit(**INLINE)
def _rotate_pair(a, b, x, y, zero, one):
    """Turns columns a and b of F V to a right angle, the longer one first, and columns x and y of V with them."""
    difference, product = _dot(b, b) - _dot(a, a), _dot(a, b)
    twice = select_greater(difference, zero, product + product, zero - product - product)
    denominator = fabs(difference) + sqrt(difference * difference + twice * twice)
    t = twice / select_greater(denominator, zero, denominator, one)
    t = select_greater(
        t, one, one, select_greater(zero - one, t, zero - one, t)
    )  # where squares have underflowed
    cosine = one / sqrt(one + t * t)
    sine = cosine * t
    c = select_greater(difference, zero, sine, cosine)
    s = select_greater(difference, zero, zero - cosine, sine)
    minus = zero - s
    return _mix(c, a, minus, b), _mix(s, a, c, b), _mix(c, x, minus, y), _mix(s, x, c, y)


@njit(**INLINE)
def _find_direction(a, full, fallback, tiny, half):
    """The direction of a; the fallback for zero and for round-off, less than half of |original|^2 = ``full``."""
    square = _dot(a, a)
    least = full * half
    floor = select_greater(least, tiny, least, tiny)
    length = sqrt(select_greater(square, floor, square, floor))
    d = (a[0] / length, a[1] / length, a[2] / length)
    return (
        select_greater(floor, square, fallback[0], d[0]),
        select_greater(floor, square, fallback[1], d[1]),
        select_greater(floor, square, fallback[2], d[2]),
    )


@njit(**INLINE)
def _find_perpendicular(u, zero, one):
    """A unit vector at right angles to the unit vector u (Duff et al. 2017, JCGT 6(1))."""
    sign = select_greater(zero, u[2], zero - one, one)
    k = (zero - one) / (sign + u[2])
    return one + sign * k * u[0] * u[0], sign * k * u[0] * u[1], zero - sign * u[0]
