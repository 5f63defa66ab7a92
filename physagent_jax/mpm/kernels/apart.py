"""P2G of two grids at once: what particles bring, and what the step gives them (`mpm.inertia`); as `transfer.p2g`."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels.lanes import clear, flatten, repeat, tile
from physagent_jax.kernels.numbers import (
    OPTIONS,
    cast_like,
    load_columns,
    scale,
    spline,
    spline_derivative,
    split_range,
)
from physagent_jax.kernels.team import share_loop
from physagent_jax.mpm.kernels.transfer import (
    BLOCK,
    NUMBERS,
    PADDING,
    add_viscous_stress,
    compute_log_J,
    find_planes,
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
