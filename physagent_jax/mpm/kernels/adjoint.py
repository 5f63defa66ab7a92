"""Adjoints of P2G, node velocities and G2P on the CPU, for the MLS form (Hu et al. 2019, ChainQueen, appendix).

The adjoint of a gather is a scatter and that of a scatter a gather. With bars for derivatives of a loss, w_i for the
weight of node i and d_i = i - f for its place in cells, seen from the particle:

    G2P  v = sum w_i v_i,  C = 4/dx sum w_i v_i d_i^T,  x' = x + dt v,  F' = F + dt C F
         bar v_i = w_i (a + B d_i)             a = bar v + dt bar x',  B = 4/dx (bar C + dt bar F' F^T)
    grid v_i = (m v)_i / m_i
         bar (m v)_i = bar v_i / m_i,  bar m_i = -bar (m v)_i . v_i
    P2G  (m v)_i = w_i (q + A d_i),  m_i = w_i m;  q = m (v + dv),  A = m dx C - 4 dt V/dx tau
         bar q = sum w_i bar (m v)_i,  bar A = sum w_i bar (m v)_i d_i^T

What particles add to the grid is cut into shares as in `transfer.p2g`.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels.lanes import (
    clear,
    flatten,
    load,
    load_rows,
    pack,
    reduce_add,
    reduce_add_nodes,
    repeat,
    rotate,
    splat,
    splat_like,
    store_rows,
    tile,
    transpose,
    unpack,
    unpack_node,
)
from physagent_jax.kernels.numbers import (
    INLINE,
    OPTIONS,
    cast_like,
    dot,
    extract,
    load_columns,
    spline,
    spline_derivative,
    split_range,
)
from physagent_jax.kernels.team import share_loop
from physagent_jax.mpm.kernels.transfer import (
    BLOCK,
    NUMBERS,
    PADDING,
    affine,
    compute_log_J,
    find_planes,
    inner,
    interleave_plane,
    locate_stencil,
    momentum,
    neo_hookean_stress,
    product,
    scatter_rows,
    sum_plane,
    triple,
)

TOTALS = 4  # per share of the particles: derivatives by dv and dt


@njit(**OPTIONS)
def g2p_adjoint(
    team, x, F, velocity, origin, dt, dx, bars, new_x, new_F, nodes, private, totals, touched, padded
):
    """Fill the derivatives by x, F and the node velocities; ``totals`` has a row per share, its last entry for dt.

    ``bars`` are those by the x, v, C and F that `transfer.g2p` gave; of the four numbers per node in ``nodes`` three
    count.
    """
    shape, parts = nodes.shape, private.shape[0]
    plane, fields = NUMBERS * shape[1] * shape[2], flatten(velocity)
    for i in share_loop(team, 0, shape[0]):
        interleave_plane(fields, padded, i, shape, False)
    for part in share_loop(team, 1, parts):
        first, last = split_range(x.shape[0], part, parts)
        low, high = find_planes(x, first, last, origin[0], dx, shape[0])
        touched[part, 0], touched[part, 1] = low, high
        own = private[part]
        clear(own, low * plane, max(low, high) * plane + PADDING)
        scatter_bars(x, F, padded, origin, dt, dx, bars, new_x, new_F, own, totals[part], shape, first, last)
    numbers = flatten(nodes)
    for i in share_loop(team, 2, shape[0]):
        sum_plane(private, touched, numbers, i, shape)


@njit(**OPTIONS)
def scatter_bars(x, F, velocity, origin, dt, dx, bars, new_x, new_F, nodes, total, shape, first, last):
    """`g2p_adjoint` of the particles ``first`` to ``last``."""
    bar_x, bar_v, bar_C, bar_F = bars
    old_F, flat_C, flat_F = flatten(F), flatten(bar_C), flatten(bar_F)
    zero, by_dt = cast_like(0, dx), cast_like(0, dx)
    still = pack((zero, zero, zero))
    k, step = splat_like(cast_like(4, dx) / dx, still), splat_like(dt, still)
    for p in range(first, last):
        start, f0, f1, f2 = locate_stencil(x, p, origin, dx, shape)
        X, Y, Z = spline(f0), spline(f1), spline(f2)
        h0, h1, h2 = load_rows(flat_F, 9 * p)
        a0, a1, a2 = load_rows(old_F, 9 * p)
        t0, t1, t2 = transpose(a0, a1, a2)
        d0, d1, d2 = product(h0, t0, t1, t2), product(h1, t0, t1, t2), product(h2, t0, t1, t2)  # bar F' F^T
        c0, c1, c2 = load_rows(flat_C, 9 * p)
        b0, b1, b2 = transpose(
            k * (c0 + step * d0), k * (c1 + step * d1), k * (c2 + step * d2)
        )  # columns of B
        moved = pack((bar_x[p, 0], bar_x[p, 1], bar_x[p, 2]))
        a = pack((bar_v[p, 0], bar_v[p, 1], bar_v[p, 2])) + step * moved
        q = a - (splat_like(f0, a) * b0 + splat_like(f1, a) * b1 + splat_like(f2, a) * b2)
        row, next_x, next_y = spread(unpack(q), zero, unpack(b0), unpack(b1), unpack(b2))
        v, g0, g1, g2, s0, s1, s2 = gather_sloped(
            velocity, start, shape, f0, f1, f2, X, Y, Z, row, next_x, next_y
        )
        g0, g1, g2 = k * g0, k * g1, k * g2  # columns of C
        s = pack((s0 - inner(b0, v), s1 - inner(b1, v), s2 - inner(b2, v)))
        store_flat(new_x, 3 * p, unpack(moved + splat_like(cast_like(1, dx) / dx, s) * s))
        e0, e1, e2 = product(g0, h0, h1, h2), product(g1, h0, h1, h2), product(g2, h0, h1, h2)  # C^T bar F'
        store_rows(new_F, 9 * p, h0 + step * e0, h1 + step * e1, h2 + step * e2)
        r0, r1, r2 = transpose(g0, g1, g2)
        by_dt += inner(moved, v) + (inner(d0, r0) + inner(d1, r1) + inner(d2, r2))
        along = repeat(Z)
        scatter_rows(nodes, start, shape, X, Y, along * row, along * next_x, along * next_y)
    total[0], total[1], total[2], total[3] = zero, zero, zero, by_dt


@njit(**OPTIONS)
def grid_velocity_adjoint(team, nodes, least, bars, results):
    """Fill ``results``, the derivatives by the nodes' momentum and mass, from ``bars``, those by their velocities.

    Zero where the mass is not above ``least``. All are ordered as in `transfer.p2g`.
    """
    total, plane = nodes.size // NUMBERS, nodes.shape[1] * nodes.shape[2]
    old, bar, new = flatten(nodes), flatten(bars), flatten(results)
    one, zero = cast_like(1, least), cast_like(0, least)
    for i in share_loop(team, 0, nodes.shape[0]):
        for o in range(i * plane, (i + 1) * plane):
            mass = old[3 * total + o]
            share = one / mass if mass > least else zero
            a, b, c = share * bar[o], share * bar[o + total], share * bar[o + 2 * total]
            new[o], new[o + total], new[o + 2 * total] = a, b, c
            along = a * old[o] + b * old[o + total] + c * old[o + 2 * total]
            new[o + 3 * total] = -share * along


@njit(**OPTIONS)
def p2g_adjoint(
    team, particles, material, dv, origin, dt, dx, neo_hookean, bars, passed, results, totals, padded
):
    """Fill ``results``: the derivatives by x, v, C, tau (or F), mu, lam, mass and volume.

    ``particles`` are x, v, C, tau, mass and volume, where tau is F if the stress is neo-Hookean, and ``material`` is mu
    and lam, one number each if the stress is given; their derivatives are not written then. ``bars`` are those by the
    nodes' momentum and mass, ordered as in `transfer.p2g`; ``passed`` are those by x and F of what comes after, which
    are added if the stress is neo-Hookean. ``totals`` gets a row per share of the particles: the derivatives by dv and
    dt. ``padded`` has room for a grid and `PADDING`.
    """
    shape, shares, numbers, count = bars.shape, totals.shape[0], flatten(bars), particles[0].shape[0]
    for i in share_loop(team, 0, shape[0]):
        interleave_plane(numbers, padded, i, shape, True)
    for share in share_loop(team, 1, shares):
        first, last = split_range(count, share, shares)
        gather_bars(
            particles,
            material,
            dv,
            origin,
            dt,
            dx,
            neo_hookean,
            padded,
            passed,
            results,
            totals[share],
            shape,
            first,
            last,
        )


@njit(**OPTIONS)
def gather_bars(
    particles, material, dv, origin, dt, dx, neo_hookean, bars, passed, results, total, shape, first, last
):
    """`p2g_adjoint` of the particles ``first`` to ``last``."""
    (x, v, C, tau, mass, volume), (mu, lam) = particles, material
    bar_x, bar_v, bar_C, bar_tau, bar_mu, bar_lam, bar_mass, bar_volume = results
    flat_C, flat_tau, (passed_x, passed_F) = flatten(C), flatten(tau), passed
    zero, kick, by_dt = cast_like(0, dx), (dv[0], dv[1], dv[2]), cast_like(0, dx)
    by_dv, logs = pack((zero, zero, zero)), np.empty(BLOCK, x.dtype)
    for begin in range(first, last, BLOCK):
        end = min(begin + BLOCK, last)
        if neo_hookean:
            compute_log_J(tau, begin, end, logs)
        for p in range(begin, end):
            start, f0, f1, f2 = locate_stencil(x, p, origin, dx, shape)
            m, k = mass[p], -cast_like(4, dx) * dt / dx
            if neo_hookean:
                t0, t1, t2 = neo_hookean_stress(tau, mu[p], lam[p], logs[p - begin], p)
            else:
                t0, t1, t2 = load_columns(tau, p)
            a0, a1, a2 = affine(t0, t1, t2, k * volume[p], C, m * dx, p)
            q = momentum(v, kick, m, a0, a1, a2, p, f0, f1, f2)
            row, next_x, next_y = spread(q, m, a0, a1, a2)
            X, Y, Z = spline(f0), spline(f1), spline(f2)
            mean, g0, g1, g2, s0, s1, s2 = gather_sloped(
                bars, start, shape, f0, f1, f2, X, Y, Z, row, next_x, next_y
            )
            n0, n1, n2, by_mass = unpack_node(mean)
            n = n0, n1, n2
            cells = cast_like(1, dx) / dx
            slopes = cells * (s0 - dot(a0, n)), cells * (s1 - dot(a1, n)), cells * (s2 - dot(a2, n))
            if neo_hookean:
                others = passed_x[3 * p], passed_x[3 * p + 1], passed_x[3 * p + 2]
                slopes = slopes[0] + others[0], slopes[1] + others[1], slopes[2] + others[2]
            store_flat(bar_x, 3 * p, slopes)
            by_v = splat_like(m, mean) * mean
            by_dv = by_dv + by_v
            store_flat(bar_v, 3 * p, unpack(by_v))
            r0, r1, r2 = transpose(g0, g1, g2)  # rows of bar A, of which g are the columns
            c0, c1, c2 = load_rows(flat_C, 9 * p)
            spin = splat_like(m * dx, mean)
            store_rows(bar_C, 9 * p, spin * r0, spin * r1, spin * r2)
            bar_mass[p] = (
                by_mass + n0 * (v[p, 0] + kick[0]) + n1 * (v[p, 1] + kick[1]) + n2 * (v[p, 2] + kick[2])
            )
            bar_mass[p] += dx * (inner(c0, r0) + inner(c1, r1) + inner(c2, r2))
            bar_volume[p] = k * (dot(t0, unpack(g0)) + dot(t1, unpack(g1)) + dot(t2, unpack(g2)))
            by_dt += volume[p] * bar_volume[p]
            s = splat_like(k * volume[p], mean)
            if neo_hookean:
                F0, F1, F2 = load_rows(flat_tau, 9 * p)
                pull_neo_hookean(
                    p,
                    (F0, F1, F2),
                    (mu[p], lam[p]),
                    logs[p - begin],
                    (s * r0, s * r1, s * r2),
                    (s * g0, s * g1, s * g2),
                    load_rows(passed_F, 9 * p),
                    bar_tau,
                    bar_mu,
                    bar_lam,
                )
            else:
                store_rows(bar_tau, 9 * p, s * r0, s * r1, s * r2)
    total[0], total[1], total[2] = unpack(by_dv)
    total[3] = by_dt / dt


@njit(**INLINE)
def pull_neo_hookean(p, F, lame, log_J, rows, columns, others, bar_F, bar_mu, bar_lam):
    """Derivatives by F, mu and lam of tau = mu (F F^T - I) + lam ln J I, those by tau given by rows and by columns.

    ``others`` are the rows of what is added to those by F.
    """
    (a, b, c), (mu, lam), (r0, r1, r2), (g0, g1, g2) = F, lame, rows, columns
    o0, o1, o2 = others
    J = triple(a, b, c)
    trace = unpack(r0)[0] + unpack(r1)[1] + unpack(r2)[2]
    t0, t1, t2 = transpose(a, b, c)
    square = inner(r0, product(a, t0, t1, t2)) + inner(r1, product(b, t0, t1, t2))
    square += inner(r2, product(c, t0, t1, t2))
    bar_mu[p], bar_lam[p] = square - trace, log_J * trace
    # F^-T = cof F / J, whose rows are cross products of those of F.
    s, u = splat_like(mu, a), splat_like(lam * trace / J, a)
    store_rows(
        bar_F,
        9 * p,
        o0 + s * product(r0 + g0, a, b, c) + u * cross(b, c),
        o1 + s * product(r1 + g1, a, b, c) + u * cross(c, a),
        o2 + s * product(r2 + g2, a, b, c) + u * cross(a, b),
    )


@njit(**INLINE)
def store_flat(numbers, o, a):
    """Write a vector's numbers side by side."""
    numbers[o], numbers[o + 1], numbers[o + 2] = a[0], a[1], a[2]


@njit(**INLINE)
def cross(b, c):
    """B x c."""
    return rotate(b * rotate(c) - rotate(b) * c)


@njit(**INLINE)
def spread(q, fourth, a0, a1, a2):
    """A row of nodes' values q + A (0, 0, k) along z, with ``fourth`` beside, and what the next row in x, y adds."""
    zero, one = cast_like(0, fourth), cast_like(1, fourth)
    row = tile(q, fourth) + tile(a2, zero) * repeat((zero, one, one + one))
    return row, tile(a0, zero), tile(a1, zero)


@njit(**INLINE)
def gather_sloped(field, start, shape, f0, f1, f2, X, Y, Z, row0, next_x, next_y):
    """Sums over the stencil of a field u: of w u, of w u (i - f) along each axis, and of the weights' slopes.

    The last three are sums of (dw / df) u . r along each axis, r being the nodes' values that ``row0`` begins.
    """
    rows, two = NUMBERS * shape[2], splat(cast_like(2, f0))
    dX, dY, dZ = spline_derivative(f0), spline_derivative(f1), spline_derivative(f2)
    y0, y1, y2 = splat(Y[0]), splat(Y[1]), splat(Y[2])
    e0, e1, e2 = splat(dY[0]), splat(dY[1]), splat(dY[2])
    mean = by_x = by_y = slope_x = slope_y = slope_z = splat(cast_like(0, f0))
    row1 = row0 + next_y
    row2 = row1 + next_y
    for i in range(3):
        o = start + i * shape[1] * rows
        a, b, c = load(field, o), load(field, o + rows), load(field, o + 2 * rows)
        w = splat(extract(X, i))
        second, third = y1 * b, y2 * c
        plane = y0 * a + (second + third)
        mean = mean + w * plane
        by_y = by_y + w * (second + two * third)
        if i > 0:
            by_x = by_x + splat(cast_like(i, f0) * extract(X, i)) * plane
        a, b, c = a * row0, b * row1, c * row2
        level = y0 * a + (y1 * b + y2 * c)
        slope_x = slope_x + splat(extract(dX, i)) * level
        slope_y = slope_y + w * (e0 * a + (e1 * b + e2 * c))
        slope_z = slope_z + w * level
        row0, row1, row2 = row0 + next_x, row1 + next_x, row2 + next_x
    along = repeat(Z)
    u, g0, g1 = reduce_add_nodes(along * mean), reduce_add_nodes(along * by_x), reduce_add_nodes(along * by_y)
    g2 = reduce_add_nodes(repeat((cast_like(0, f0), Z[1], Z[2] + Z[2])) * mean)
    g0, g1, g2 = g0 - splat_like(f0, u) * u, g1 - splat_like(f1, u) * u, g2 - splat_like(f2, u) * u
    slopes = (
        reduce_add(along * slope_x),
        reduce_add(along * slope_y),
        reduce_add(repeat(dZ) * slope_z),
    )
    return u, g0, g1, g2, slopes[0], slopes[1], slopes[2]
