"""P2G of two grids at once: what particles bring, and what the step gives them (`mpm.inertia`); and its adjoint.

As `transfer.p2g` and `adjoint.p2g_adjoint`; particles find their stencil and their stress once for both.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels.lanes import (
    clear,
    flatten,
    load_rows,
    pack,
    repeat,
    splat_like,
    store_rows,
    tile,
    transpose,
    unpack,
    unpack_node,
)
from physagent_jax.kernels.numbers import (
    OPTIONS,
    cast_like,
    dot,
    load_columns,
    scale,
    spline,
    spline_derivative,
    split_range,
)
from physagent_jax.kernels.team import share_loop
from physagent_jax.mpm.kernels.adjoint import gather_sloped, pull_neo_hookean, spread, store_flat
from physagent_jax.mpm.kernels.transfer import (
    BLOCK,
    NUMBERS,
    PADDING,
    add_viscous_stress,
    compute_log_J,
    find_planes,
    inner,
    interleave_plane,
    locate_stencil,
    momentum,
    neo_hookean_stress,
    scatter_force,
    scatter_rows,
    sum_plane,
)


@njit(**OPTIONS)
def p2g_apart(
    team, particles, law, mass, volume, dv, push, origin, dt, dx, unit, options, nodes, private, touched
):
    """Fill ``nodes`` with two times four numbers, those of `mpm.transfer.p2g_apart`, ordered as in `transfer.p2g`.

    ``private`` has two rows per share of the particles, one of either grid: first all of the one, then all of the
    other. ``particles`` are x, v, C and tau. ``options`` are those of `transfer.p2g`, and whether ``push`` has a row
    per particle; otherwise there is none.
    """
    x, parts, shape = particles[0], touched.shape[0], nodes.shape
    plane, total, numbers = NUMBERS * shape[1] * shape[2], shape[0] * shape[1] * shape[2], flatten(nodes)
    for part in share_loop(team, 0, parts):
        first, last = split_range(x.shape[0], part, parts)
        low, high = find_planes(x, first, last, origin[0], dx, shape[0])
        touched[part, 0], touched[part, 1] = low, high
        brought, given = private[part], private[parts + part]
        clear(brought, low * plane, max(low, high) * plane + PADDING)
        clear(given, low * plane, max(low, high) * plane + PADDING)
        scatter_apart(
            particles,
            law,
            mass,
            volume,
            dv,
            push,
            origin,
            dt,
            dx,
            unit,
            options,
            brought,
            given,
            shape,
            first,
            last,
        )
    for i in share_loop(team, 1, shape[0]):
        sum_plane(private[:parts], touched, numbers, i, shape)
        sum_plane(private[parts:], touched, numbers[NUMBERS * total :], i, shape)


@njit(**OPTIONS)
def scatter_apart(
    particles, law, mass, volume, dv, push, origin, dt, dx, unit, options, brought, given, shape, first, last
):
    """Add the particles ``first`` to ``last`` to two flat arrays with four numbers per node each."""
    zero, (classical, neo_hookean, viscous, pushed) = cast_like(0, dx), options
    (x, v, C, tau), (mu, lam, viscosity, rate), kick = particles, law, (dv[0], dv[1], dv[2])
    still, logs = (zero, zero, zero), np.empty(BLOCK, x.dtype)
    for begin in range(first, last, BLOCK):
        end = min(begin + BLOCK, last)
        if neo_hookean:
            compute_log_J(tau, begin, end, logs)
        for p in range(begin, end):
            start, f0, f1, f2 = locate_stencil(x, p, origin, dx, shape)
            X, Y, Z = spline(f0), spline(f1), spline(f2)
            along, climb = repeat(Z), repeat((zero, Z[1], Z[2] + Z[2]))
            m, impulse = mass[p], -dt * volume[p] / dx
            k = zero if classical else cast_like(4, dx) * impulse
            if neo_hookean:
                t0, t1, t2 = neo_hookean_stress(tau, mu[p], lam[p], logs[p - begin], p)
            else:
                t0, t1, t2 = load_columns(tau, p)
            if viscous:
                t0, t1, t2 = add_viscous_stress(t0, t1, t2, tau, rate, viscosity[p], p)
            c0, c1, c2 = load_columns(C, p)
            a0, a1, a2 = scale(m * dx, c0), scale(m * dx, c1), scale(m * dx, c2)
            q = momentum(v, kick, m, a0, a1, a2, p, f0, f1, f2)
            row = tile(q, m) * along + tile(a2, zero) * climb
            scatter_rows(brought, start, shape, X, Y, row, tile(a0, zero) * along, tile(a1, zero) * along)
            a0, a1, a2 = scale(k, t0), scale(k, t1), scale(k, t2)
            q = momentum(push, still, m if pushed else zero, a0, a1, a2, p if pushed else 0, f0, f1, f2)
            row = tile(q, m * (unit * m)) * along + tile(a2, zero) * climb
            scatter_rows(given, start, shape, X, Y, row, tile(a0, zero) * along, tile(a1, zero) * along)
            if classical:
                dX, dY, dZ = spline_derivative(f0), spline_derivative(f1), spline_derivative(f2)
                scatter_force(t0, t1, t2, impulse, X, Y, Z, dX, dY, dZ, given, start, shape)


@njit(**OPTIONS)
def p2g_apart_adjoint(
    team, particles, law, dv, push, origin, dt, dx, unit, options, bars, passed, results, totals, padded
):
    """Fill ``results``: the derivatives by x, v, C, tau (or F), mu, lam, mass, volume and push, of the MLS form.

    ``particles`` are x, v, C, tau, mass and volume; ``bars`` those by the nodes' eight numbers, ordered as in
    `p2g_apart`; ``passed`` those by x and tau of what comes after, which are added. ``options`` are whether ``tau`` is
    F of a neo-Hookean law, whose mu and lam are ``law`` and whose derivatives are written then, and whether ``push``
    has a row per particle. ``totals`` gets a row per share of the particles: the derivatives by dv, dt and a push of
    all. ``padded`` has room for two grids and `PADDING` each.
    """
    shape, shares, numbers, count = bars.shape, totals.shape[0], flatten(bars), particles[0].shape[0]
    size, total = padded.size // 2, shape[0] * shape[1] * shape[2]
    for i in share_loop(team, 0, shape[0]):
        interleave_plane(numbers, padded[:size], i, shape, True)
        interleave_plane(numbers[NUMBERS * total :], padded[size:], i, shape, True)
    for share in share_loop(team, 1, shares):
        first, last = split_range(count, share, shares)
        gather_apart(
            particles,
            law,
            dv,
            push,
            origin,
            dt,
            dx,
            unit,
            options,
            (padded[:size], padded[size:]),
            passed,
            results,
            totals[share],
            shape,
            first,
            last,
        )


@njit(**OPTIONS)
def gather_apart(
    particles, law, dv, push, origin, dt, dx, unit, options, bars, passed, results, total, shape, first, last
):
    """`p2g_apart_adjoint` of the particles ``first`` to ``last``."""
    (x, v, C, tau, mass, volume), (mu, lam), (neo_hookean, pushed) = particles, law, options
    bar_x, bar_v, bar_C, bar_tau, bar_mu, bar_lam, bar_mass, bar_volume, bar_push = results
    flat_C, flat_tau, kick, by_dt = flatten(C), flatten(tau), (dv[0], dv[1], dv[2]), cast_like(0, dx)
    zero, cells = cast_like(0, dx), cast_like(1, dx) / dx
    still, logs, (passed_x, passed_tau) = (zero, zero, zero), np.empty(BLOCK, x.dtype), passed
    by_dv, by_push = pack(still), pack(still)
    for begin in range(first, last, BLOCK):
        end = min(begin + BLOCK, last)
        if neo_hookean:
            compute_log_J(tau, begin, end, logs)
        for p in range(begin, end):
            start, f0, f1, f2 = locate_stencil(x, p, origin, dx, shape)
            X, Y, Z = spline(f0), spline(f1), spline(f2)
            m, k = mass[p], -cast_like(4, dx) * dt / dx
            c0, c1, c2 = load_columns(C, p)
            a0, a1, a2 = scale(m * dx, c0), scale(m * dx, c1), scale(m * dx, c2)
            q = momentum(v, kick, m, a0, a1, a2, p, f0, f1, f2)
            row, next_x, next_y = spread(q, m, a0, a1, a2)
            mean, g0, g1, g2, s0, s1, s2 = gather_sloped(
                bars[0], start, shape, f0, f1, f2, X, Y, Z, row, next_x, next_y
            )
            n0, n1, n2, by_mass = unpack_node(mean)
            n = n0, n1, n2
            s0, s1, s2 = s0 - dot(a0, n), s1 - dot(a1, n), s2 - dot(a2, n)
            by_v = splat_like(m, mean) * mean
            by_dv = by_dv + by_v
            store_flat(bar_v, 3 * p, unpack(by_v))
            by_mass += n0 * (v[p, 0] + kick[0]) + n1 * (v[p, 1] + kick[1]) + n2 * (v[p, 2] + kick[2])
            r0, r1, r2 = transpose(g0, g1, g2)
            d0, d1, d2 = load_rows(flat_C, 9 * p)
            spin = splat_like(m * dx, mean)
            store_rows(bar_C, 9 * p, spin * r0, spin * r1, spin * r2)
            by_mass += dx * (inner(d0, r0) + inner(d1, r1) + inner(d2, r2))
            if neo_hookean:
                t0, t1, t2 = neo_hookean_stress(tau, mu[p], lam[p], logs[p - begin], p)
            else:
                t0, t1, t2 = load_columns(tau, p)
            weight = k * volume[p]
            a0, a1, a2 = scale(weight, t0), scale(weight, t1), scale(weight, t2)
            q = momentum(push, still, m if pushed else zero, a0, a1, a2, p if pushed else 0, f0, f1, f2)
            row, next_x, next_y = spread(q, m * (unit * m), a0, a1, a2)
            mean, g0, g1, g2, e0, e1, e2 = gather_sloped(
                bars[1], start, shape, f0, f1, f2, X, Y, Z, row, next_x, next_y
            )
            n0, n1, n2, by_square = unpack_node(mean)
            n = n0, n1, n2
            s0, s1, s2 = s0 + e0 - dot(a0, n), s1 + e1 - dot(a1, n), s2 + e2 - dot(a2, n)
            d0, d1, d2 = passed_x[3 * p], passed_x[3 * p + 1], passed_x[3 * p + 2]
            store_flat(bar_x, 3 * p, (d0 + cells * s0, d1 + cells * s1, d2 + cells * s2))
            by_mass += by_square * (unit * (m + m))
            by_kick = splat_like(m, mean) * mean
            if pushed:
                store_flat(bar_push, 3 * p, unpack(by_kick))
                by_mass += n0 * push[p, 0] + n1 * push[p, 1] + n2 * push[p, 2]
            else:
                by_push = by_push + by_kick
            bar_mass[p] = by_mass
            bar_volume[p] = k * (dot(t0, unpack(g0)) + dot(t1, unpack(g1)) + dot(t2, unpack(g2)))
            by_dt += volume[p] * bar_volume[p]
            r0, r1, r2 = transpose(g0, g1, g2)
            s = splat_like(weight, mean)
            if neo_hookean:
                pull_neo_hookean(
                    p,
                    load_rows(flat_tau, 9 * p),
                    (mu[p], lam[p]),
                    logs[p - begin],
                    (s * r0, s * r1, s * r2),
                    (s * g0, s * g1, s * g2),
                    load_rows(passed_tau, 9 * p),
                    bar_tau,
                    bar_mu,
                    bar_lam,
                )
            else:
                d0, d1, d2 = load_rows(passed_tau, 9 * p)
                store_rows(bar_tau, 9 * p, d0 + s * r0, d1 + s * r1, d2 + s * r2)
    total[0], total[1], total[2] = unpack(by_dv)
    total[3] = by_dt / dt
    total[4], total[5], total[6] = unpack(by_push)
