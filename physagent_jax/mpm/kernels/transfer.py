"""P2G and G2P on the CPU: compiled by Numba, run by a team of threads, sixteen numbers at once.

P2G cuts the particles into as many contiguous shares as there are threads. Each is scattered into a grid of its own, of
which only the planes that its particles touch are cleared and added up: sorted particles touch few. The order of all
sums is fixed by the number of shares, so that results repeat bit by bit. G2P sums nothing over particles: its shares
are smaller, and a thread that is done takes the next one.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels.lanes import (
    BATCH,
    ROW,
    broadcast_each,
    clear,
    deinterleave,
    flatten,
    interleave,
    load,
    load_batch,
    load_rows,
    pack,
    reduce_add_nodes,
    repeat,
    rotate,
    select_greater,
    splat,
    splat_like,
    store,
    store_rows,
    tile,
    transpose,
    unpack,
)
from physagent_jax.kernels.numbers import (
    INLINE,
    OPTIONS,
    cast_like,
    determinant,
    dot,
    extract,
    load_columns,
    load_row,
    log,
    lowest_node,
    scale,
    spline,
    spline_derivative,
    split_range,
    store_vector,
)
from physagent_jax.kernels.team import share_loop

NUMBERS = 4  # per node: momentum and mass
PADDING = 16  # numbers by which a row's unused fourth node may reach beyond a grid's end
BLOCK = 64  # particles of which the logarithms of J are computed at a time
HEALTH_FIELDS = 7  # as `mpm.health.Health`, in its order


@njit(**OPTIONS)
def p2g(team, x, v, C, tau, law, mass, volume, dv, origin, dt, dx, options, nodes, private, touched):
    """Fill ``nodes`` with momentum and mass.

    ``private`` has room for a grid and `PADDING` per share of the particles, and ``touched`` for two numbers.

    All nodes' first numbers come first in ``nodes``, then the second ones, and so on: what XLA does with them it can
    vectorise then. Particles want them side by side.

    ``options`` are whether the stress form is the classical one, and whether every material is neo-Hookean: then
    ``tau`` is F and the stress is made on the way, so that it never goes through memory; and whether it is viscous as
    well. ``law`` is mu, lam, viscosity and the velocity gradient on which that acts. ``dv`` is added to all velocities
    on the way.
    """
    shape, parts = nodes.shape, private.shape[0]
    plane, numbers = NUMBERS * shape[1] * shape[2], flatten(nodes)
    for part in share_loop(team, 0, parts):
        first, last = split_range(x.shape[0], part, parts)
        low, high = find_planes(x, first, last, origin[0], dx, shape[0])
        touched[part, 0], touched[part, 1] = low, high
        own = private[part]
        clear(own, low * plane, max(low, high) * plane + PADDING)
        scatter(x, v, C, tau, law, mass, volume, dv, origin, dt, dx, options, own, shape, first, last)
    for i in share_loop(team, 1, shape[0]):
        sum_plane(private, touched, numbers, i, shape)


@njit(**OPTIONS)
def find_planes(x, first, last, origin, dx, count):
    """First and last + 1 of the planes that the particles ``first`` to ``last`` touch."""
    near, far, nonfinite = cast_like(np.inf, dx), cast_like(-np.inf, dx), False
    for p in range(first, last):
        near, far = min(near, x[p, 0]), max(far, x[p, 0])
        nonfinite |= x[p, 0] != x[p, 0]
    if first >= last:
        return 0, 0
    low, _ = lowest_node(near / dx - cast_like(origin, dx), count)
    high, _ = lowest_node(far / dx - cast_like(origin, dx), count)
    return (0, max(high, 0) + 3) if nonfinite else (low, high + 3)  # what is not a number counts as zero


@njit(**OPTIONS)
def sum_plane(private, touched, nodes, i, shape):
    """Plane i of the sum of the shares' grids; ``nodes`` has one number of all nodes after the other."""
    count, total = shape[1] * shape[2], shape[0] * shape[1] * shape[2]
    zero = splat_like(cast_like(0, nodes[0]), load(private[0], 0))
    for k in range(i * count, (i + 1) * count, BATCH):
        o = min(k, (i + 1) * count - BATCH)  # the last batch overlaps; a plane has nine nodes or more
        first, second = zero, zero
        for part in range(private.shape[0]):
            if touched[part, 0] <= i < touched[part, 1]:
                own = private[part]
                first, second = first + load(own, NUMBERS * o), second + load(own, NUMBERS * o + ROW)
        a, b, c, d = deinterleave(first, second)
        store(nodes, o, a)
        store(nodes, o + total, b)
        store(nodes, o + 2 * total, c)
        store(nodes, o + 3 * total, d)


@njit(**OPTIONS)
def scatter(x, v, C, tau, law, mass, volume, dv, origin, dt, dx, options, nodes, shape, first, last):
    """Add the particles ``first`` to ``last`` to ``nodes``, a flat array with four numbers per node."""
    zero, (classical, neo_hookean, viscous) = cast_like(0, dx), options
    mu, lam, viscosity, rate = law
    kick, logs = (dv[0], dv[1], dv[2]), np.empty(BLOCK, x.dtype)
    for begin in range(first, last, BLOCK):
        end = min(begin + BLOCK, last)
        if neo_hookean:
            compute_log_J(tau, begin, end, logs)
        for p in range(begin, end):
            start, f0, f1, f2 = locate_stencil(x, p, origin, dx, shape)
            X, Y, Z = spline(f0), spline(f1), spline(f2)
            along = repeat(Z)
            # Node (i, j, k) of the stencil gets w_i (q + A (i, j, k)), with q the momentum at the lowest node.
            m, impulse = mass[p], -dt * volume[p] / dx
            k = zero if classical else cast_like(4, dx) * impulse
            if neo_hookean:
                t0, t1, t2 = neo_hookean_stress(tau, mu[p], lam[p], logs[p - begin], p)
            else:
                t0, t1, t2 = load_columns(tau, p)
            if viscous:
                t0, t1, t2 = add_viscous_stress(t0, t1, t2, tau, rate, viscosity[p], p)
            a0, a1, a2 = affine(t0, t1, t2, k, C, m * dx, p)
            q = momentum(v, kick, m, a0, a1, a2, p, f0, f1, f2)
            row = tile(q, m) * along + tile(a2, zero) * repeat((zero, Z[1], Z[2] + Z[2]))
            scatter_rows(nodes, start, shape, X, Y, row, tile(a0, zero) * along, tile(a1, zero) * along)
            if classical:
                dX, dY, dZ = spline_derivative(f0), spline_derivative(f1), spline_derivative(f2)
                scatter_force(t0, t1, t2, impulse, X, Y, Z, dX, dY, dZ, nodes, start, shape)


@njit(**INLINE)
def scatter_rows(nodes, start, shape, X, Y, row0, next_x, next_y):
    """Add w_x w_y times a row of values along z to each of a stencil's nine rows of nodes.

    The rows' values are affine in the place: ``row0`` is the lowest one's, ``next_x`` and ``next_y`` are what the next
    one along x and along y adds. All three have the weights along z in them.
    """
    rows = NUMBERS * shape[2]
    row1 = row0 + next_y
    row2 = row1 + next_y
    for i in range(3):
        w = extract(X, i)
        o0 = start + i * shape[1] * rows
        o1, o2 = o0 + rows, o0 + 2 * rows
        store(nodes, o0, load(nodes, o0) + splat(w * Y[0]) * row0)
        store(nodes, o1, load(nodes, o1) + splat(w * Y[1]) * row1)
        store(nodes, o2, load(nodes, o2) + splat(w * Y[2]) * row2)
        row0, row1, row2 = row0 + next_x, row1 + next_x, row2 + next_x


@njit(**INLINE)
def scatter_force(t0, t1, t2, impulse, X, Y, Z, dX, dY, dZ, nodes, start, shape):
    """Add the classical form's impulse times tau grad w."""
    zero, rows = cast_like(0, impulse), NUMBERS * shape[2]
    by_x = tile(scale(impulse, t0), zero) * repeat(Z)
    by_y = tile(scale(impulse, t1), zero) * repeat(Z)
    by_z = tile(scale(impulse, t2), zero) * repeat(dZ)
    for i in range(3):
        w = extract(X, i)
        level, steep = splat(extract(dX, i)) * by_x + splat(w) * by_z, splat(w) * by_y
        for j in range(3):
            o = start + (i * shape[1] + j) * rows
            store(nodes, o, load(nodes, o) + splat(extract(Y, j)) * level + splat(extract(dY, j)) * steep)


@njit(**OPTIONS)
def g2p(team, old, velocity, origin, dt, dx, classical, low, high, new, health, padded):
    """Fill the arrays of ``new``, and a row of ``health`` per share of the particles; see `gather`.

    ``velocity`` is ordered as the nodes of `p2g`; ``padded`` has room for a grid and `PADDING`.
    """
    shape, shares, numbers = velocity.shape, health.shape[0], flatten(velocity)
    for i in share_loop(team, 0, shape[0]):
        interleave_plane(numbers, padded, i, shape, False)
    for share in share_loop(team, 1, shares):
        first, last = split_range(old[0].shape[0], share, shares)
        own = health[share]
        gather(old, padded, origin, dt, dx, classical, low, high, shape, new, own, first, last)


@njit(**OPTIONS)
def interleave_plane(fields, padded, i, shape, fourth):
    """Put the numbers of each node of plane i side by side: three and a zero, or all four; clear the padding."""
    count, total = shape[1] * shape[2], shape[0] * shape[1] * shape[2]
    if i == shape[0] - 1:
        clear(padded, NUMBERS * total, padded.size)
    for k in range(i * count, (i + 1) * count, BATCH):
        o = min(k, (i + 1) * count - BATCH)  # as in `sum_plane`
        a, b, c = load_batch(fields, o), load_batch(fields, o + total), load_batch(fields, o + 2 * total)
        d = splat_like(cast_like(0, padded[0]), a)
        if fourth:
            d = load_batch(fields, o + 3 * total)
        first, second = interleave(a, b, c, d)
        store(padded, NUMBERS * o, first)
        store(padded, NUMBERS * o + ROW, second)


@njit(**OPTIONS)
def gather(old, velocity, origin, dt, dx, classical, low, high, shape, new, health, first, last):
    """Move the particles ``first`` to ``last``: (x, F) ``old`` give (x, v, C, F) ``new``.

    ``velocity`` is flat, with four numbers per node; ``health`` gets what happened.
    """
    one, zero, inf = cast_like(1, dx), cast_like(0, dx), cast_like(np.inf, dx)
    least_J, most_J, least_increment, fastest, nonfinite = inf, -inf, inf, zero, 0
    near, far = pack((inf, inf, inf)), pack((-inf, -inf, -inf))
    e0, e1, e2 = pack((one, zero, zero)), pack((zero, one, zero)), pack((zero, zero, one))
    k, step = splat_like(cast_like(4, dx) / dx, near), splat_like(dt, near)
    (x, F), (new_x, new_v, new_C, new_F) = old, new
    old_F, flat_F, affine = flatten(F), flatten(new_F), flatten(new_C)
    for p in range(first, last):
        start, f0, f1, f2 = locate_stencil(x, p, origin, dx, shape)
        X, Y, Z = spline(f0), spline(f1), spline(f2)
        v, g0, g1, g2 = moments(velocity, start, shape, f0, f1, f2, X, Y, Z)
        end = pack((x[p, 0], x[p, 1], x[p, 2])) + step * v
        near, far = select_greater(near, end, end, near), select_greater(end, far, end, far)
        store_vector(new_x, p, unpack(end))
        store_vector(new_v, p, unpack(v))
        c0, c1, c2 = transpose(k * g0, k * g1, k * g2)
        store_rows(affine, 9 * p, c0, c1, c2)
        if classical:
            dX, dY, dZ = spline_derivative(f0), spline_derivative(f1), spline_derivative(f2)
            g0, g1, g2 = gradient(velocity, start, shape, X, Y, Z, dX, dY, dZ)
            s = splat_like(one / dx, v)
            c0, c1, c2 = transpose(s * g0, s * g1, s * g2)
        c0, c1, c2 = step * c0, step * c1, step * c2  # dt grad v
        # All of F before the first entry of the new one, which may lie in its place.
        a, b, c = load_rows(old_F, 9 * p)
        a, b, c = a + product(c0, a, b, c), b + product(c1, a, b, c), c + product(c2, a, b, c)
        store_rows(flat_F, 9 * p, a, b, c)
        increment, J = triple(e0 + c0, e1 + c1, e2 + c2), triple(a, b, c)
        square = inner(v, v)
        if np.isfinite(J + increment + square):
            least_J, most_J = min(least_J, J), max(most_J, J)
            least_increment, fastest = min(least_increment, increment), max(fastest, square)
        else:
            nonfinite += 1
    outside, beyond = 0, 0
    if first < last and (nonfinite > 0 or may_leave(unpack(near), unpack(far), origin, dx, low, high, shape)):
        for p in range(first, last):
            outside += leaves_window(new_x, p, origin, dx, low, high, shape)
            beyond += passes_walls(new_x, p, low, high)
    health[0], health[1], health[2], health[3] = least_J, most_J, least_increment, np.sqrt(fastest)
    health[4], health[5], health[6] = cast_like(nonfinite, dx), cast_like(outside, dx), cast_like(beyond, dx)


@njit(**INLINE)
def product(a, b0, b1, b2):
    """A row a times the matrix with rows b0, b1, b2."""
    first, second, third = broadcast_each(a)
    return first * b0 + second * b1 + third * b2


@njit(**INLINE)
def inner(a, b):
    """A . b."""
    first, second, third = unpack(a * b)
    return first + second + third


@njit(**INLINE)
def triple(a, b, c):
    """A . (b x c): the determinant of the matrix with rows a, b, c."""
    return inner(a, rotate(b * rotate(c) - rotate(b) * c))


@njit(**INLINE)
def moments(velocity, start, shape, f0, f1, f2, X, Y, Z):
    """Sums over the stencil: of w v, and of w v (i - f) along each axis, with i the node's number."""
    rows = NUMBERS * shape[2]
    y0, y1, y2, two = splat(Y[0]), splat(Y[1]), splat(Y[2]), splat(cast_like(2, f0))
    mean = by_x = by_y = splat(cast_like(0, f0))
    for i in range(3):
        o = start + i * shape[1] * rows
        second, third = y1 * load(velocity, o + rows), y2 * load(velocity, o + 2 * rows)
        plane, w = y0 * load(velocity, o) + (second + third), splat(extract(X, i))
        mean = mean + w * plane
        by_y = by_y + w * (second + two * third)
        if i > 0:
            by_x = by_x + splat(cast_like(i, f0) * extract(X, i)) * plane
    along = repeat(Z)
    v, g0, g1 = reduce_add_nodes(along * mean), reduce_add_nodes(along * by_x), reduce_add_nodes(along * by_y)
    g2 = reduce_add_nodes(repeat((cast_like(0, f0), Z[1], Z[2] + Z[2])) * mean)
    return v, g0 - splat_like(f0, v) * v, g1 - splat_like(f1, v) * v, g2 - splat_like(f2, v) * v


@njit(**INLINE)
def gradient(velocity, start, shape, X, Y, Z, dX, dY, dZ):
    """Sum of v times the weights' slopes along each axis."""
    rows, zero = NUMBERS * shape[2], cast_like(0, X[0])
    by_x = by_y = by_z = splat(zero)
    for i in range(3):
        for j in range(3):
            here = load(velocity, start + (i * shape[1] + j) * rows)
            by_x = by_x + splat(extract(dX, i) * extract(Y, j)) * here
            by_y = by_y + splat(extract(X, i) * extract(dY, j)) * here
            by_z = by_z + splat(extract(X, i) * extract(Y, j)) * here
    along = repeat(Z)
    return reduce_add_nodes(along * by_x), reduce_add_nodes(along * by_y), reduce_add_nodes(repeat(dZ) * by_z)


@njit(**INLINE)
def locate_stencil(x, p, origin, dx, shape):
    """The start of a particle's stencil in a flat grid, and its distances to the lowest node in cells."""
    b0, f0 = lowest_node(x[p, 0] / dx - cast_like(origin[0], dx), shape[0])
    b1, f1 = lowest_node(x[p, 1] / dx - cast_like(origin[1], dx), shape[1])
    b2, f2 = lowest_node(x[p, 2] / dx - cast_like(origin[2], dx), shape[2])
    return NUMBERS * ((b0 * shape[1] + b1) * shape[2] + b2), f0, f1, f2


@njit(**INLINE)
def may_leave(near, far, origin, dx, low, high, shape):
    """Return whether `leaves_window` or `passes_walls` may count a particle between corners ``near`` and ``far``."""
    for d in range(3):
        first = int(np.floor(extract(near, d) / dx - cast_like(0.5, dx))) - origin[d]
        last = int(np.floor(extract(far, d) / dx - cast_like(0.5, dx))) - origin[d]
        if first < 0 or last + 3 > shape[d] or extract(near, d) < low or extract(far, d) > high:
            return True
    return False


@njit(**INLINE)
def leaves_window(x, p, origin, dx, low, high, shape):
    """1 if the stencil is not wholly inside the window, once the walls have stopped the particle, else 0."""
    for d in range(3):
        within = min(max(x[p, d], low), high)
        b = int(np.floor(within / dx - cast_like(0.5, dx))) - origin[d]
        if b < 0 or b + 3 > shape[d]:
            return 1
    return 0


@njit(**INLINE)
def passes_walls(x, p, low, high):
    """1 if a coordinate is not within ``low`` and ``high``, else 0."""
    for d in range(3):
        if x[p, d] < low or x[p, d] > high:
            return 1
    return 0


@njit(**OPTIONS)
def compute_log_J(F, first, last, logs):
    """Ln det F of the particles ``first`` to ``last``, into the first places of ``logs``.

    A block at a time: one logarithm takes as long as several at once, and what a particle scatters would wait for it.
    """
    for p in range(first, last):
        logs[p - first] = determinant(load_row(F, p, 0), load_row(F, p, 1), load_row(F, p, 2))
    for k in range(last - first):
        logs[k] = log(logs[k])


@njit(**INLINE)
def neo_hookean_stress(F, mu, lam, log_J, p):
    """Columns of the Kirchhoff stress of `materials.NeoHookean`."""
    a, b, c = load_row(F, p, 0), load_row(F, p, 1), load_row(F, p, 2)
    pressure = lam * log_J - mu
    ab, ac, bc = mu * dot(a, b), mu * dot(a, c), mu * dot(b, c)
    return (
        (mu * dot(a, a) + pressure, ab, ac),
        (ab, mu * dot(b, b) + pressure, bc),
        (ac, bc, mu * dot(c, c) + pressure),
    )


@njit(**INLINE)
def add_viscous_stress(t0, t1, t2, F, C, viscosity, p):
    """Columns t of a stress with that of `materials.viscous_stress`."""
    J = determinant(load_row(F, p, 0), load_row(F, p, 1), load_row(F, p, 2))
    a, b, c = load_row(C, p, 0), load_row(C, p, 1), load_row(C, p, 2)
    k, third = viscosity * J, (a[0] + b[1] + c[2]) / cast_like(3, viscosity)
    ab, ac, bc = k * (a[1] + b[0]), k * (a[2] + c[0]), k * (b[2] + c[1])
    twice = k + k
    return (
        (t0[0] + twice * (a[0] - third), t0[1] + ab, t0[2] + ac),
        (t1[0] + ab, t1[1] + twice * (b[1] - third), t1[2] + bc),
        (t2[0] + ac, t2[1] + bc, t2[2] + twice * (c[2] - third)),
    )


@njit(**INLINE)
def affine(t0, t1, t2, k, C, m, p):
    """Columns of k tau + m C."""
    return (
        (k * t0[0] + m * C[p, 0, 0], k * t0[1] + m * C[p, 1, 0], k * t0[2] + m * C[p, 2, 0]),
        (k * t1[0] + m * C[p, 0, 1], k * t1[1] + m * C[p, 1, 1], k * t1[2] + m * C[p, 2, 1]),
        (k * t2[0] + m * C[p, 0, 2], k * t2[1] + m * C[p, 1, 2], k * t2[2] + m * C[p, 2, 2]),
    )


@njit(**INLINE)
def momentum(v, dv, m, a0, a1, a2, p, f0, f1, f2):
    """m (v + dv) less the affine part between the particle and its lowest node."""
    return (
        m * (v[p, 0] + dv[0]) - (a0[0] * f0 + a1[0] * f1 + a2[0] * f2),
        m * (v[p, 1] + dv[1]) - (a0[1] * f0 + a1[1] * f1 + a2[1] * f2),
        m * (v[p, 2] + dv[2]) - (a0[2] * f0 + a1[2] * f1 + a2[2] * f2),
    )
