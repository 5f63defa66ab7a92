"""The stencil of `mpm.inertia.sharpen`: a node takes from its six neighbours; its adjoint, and that of what it takes.

XLA would join it with what makes the increments, and make those anew for every neighbour.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportAttributeAccessIssue=false

from __future__ import annotations

from numba import njit

from physagent_jax.kernels.lanes import (
    BATCH,
    flatten,
    lesser,
    load_batch,
    load_one,
    select_greater,
    splat_like,
    store,
)
from physagent_jax.kernels.numbers import INLINE, OPTIONS, cast_like
from physagent_jax.kernels.team import share_loop


@njit(**OPTIONS)
def sharpen(team, increments, mass, squares, options, sharpened):
    """Fill ``sharpened`` with `mpm.inertia.sharpen`: three numbers a node, one of all nodes after the other.

    ``increments`` are ordered so too. ``options`` are the strength, sum w m^2 / (sum w m)^2 ``unit`` below which a
    node's edges count in full, and the mass up to which a node is empty.
    """
    nodes, new = (flatten(increments), flatten(mass), flatten(squares)), flatten(sharpened)
    for i in share_loop(team, 0, mass.shape[0]):
        for j in range(mass.shape[1]):
            row, first, inside, last = find_neighbours(i, j, mass.shape)
            end = row + mass.shape[2] - 1
            sharpen_nodes(load_one, nodes, options, row, first, new)
            sharpen_nodes(load_one, nodes, options, end, last, new)
            if mass.shape[2] < BATCH + 2:
                for o in range(row + 1, end):
                    sharpen_nodes(load_one, nodes, options, o, inside, new)
            else:
                for o in range(row + 1, end, BATCH):  # the last batch overlaps
                    sharpen_nodes(load_batch, nodes, options, min(o, end - BATCH), inside, new)


@njit(**OPTIONS)
def sharpen_adjoint(team, increments, mass, squares, options, bars, results):
    """Fill ``results``: the derivatives by increments, mass and squares, from ``bars``; options as of `sharpen`."""
    nodes, bars = (flatten(increments), flatten(mass), flatten(squares)), flatten(bars)
    new = flatten(results[0]), flatten(results[1]), flatten(results[2])
    for i in share_loop(team, 0, mass.shape[0]):
        for j in range(mass.shape[1]):
            row, first, inside, last = find_neighbours(i, j, mass.shape)
            end = row + mass.shape[2] - 1
            pull_nodes(load_one, nodes, options, bars, row, first, new)
            pull_nodes(load_one, nodes, options, bars, end, last, new)
            if mass.shape[2] < BATCH + 2:
                for o in range(row + 1, end):
                    pull_nodes(load_one, nodes, options, bars, o, inside, new)
            else:
                for o in range(row + 1, end, BATCH):
                    pull_nodes(load_batch, nodes, options, bars, min(o, end - BATCH), inside, new)


@njit(**OPTIONS)
def grid_velocities_adjoint(team, nodes, least, bars, results):
    """Fill ``results``, the derivatives by the nodes' eight numbers, from ``bars``, those by what they make.

    As `adjoint.grid_velocity_adjoint`, of `mpm.transfer.grid_velocities`.
    """
    plane, total = nodes.shape[1] * nodes.shape[2], nodes.shape[0] * nodes.shape[1] * nodes.shape[2]
    old, new, by_mass, by_square = flatten(nodes), flatten(results), flatten(bars[2]), flatten(bars[3])
    brought, given = flatten(bars[0]), flatten(bars[1])
    for i in share_loop(team, 0, nodes.shape[0]):
        for k in range(i * plane, (i + 1) * plane, BATCH):
            o = min(k, (i + 1) * plane - BATCH)  # as in `transfer.sum_plane`
            mass = load_batch(old, o + 3 * total)
            zero, one = mass - mass, splat_like(cast_like(1, least), mass)
            share = select_greater(mass, splat_like(least, mass), one / mass, zero)
            a, b, c = (
                load_batch(brought, o),
                load_batch(brought, o + total),
                load_batch(brought, o + 2 * total),
            )
            d, e, f = load_batch(given, o), load_batch(given, o + total), load_batch(given, o + 2 * total)
            along = (
                a * load_batch(old, o) + b * load_batch(old, o + total) + c * load_batch(old, o + 2 * total)
            )
            along = along + d * load_batch(old, o + 4 * total) + e * load_batch(old, o + 5 * total)
            along = along + f * load_batch(old, o + 6 * total)
            store(new, o, share * a)
            store(new, o + total, share * b)
            store(new, o + 2 * total, share * c)
            store(new, o + 3 * total, load_batch(by_mass, o) - share * (share * along))
            store(new, o + 4 * total, share * d)
            store(new, o + 5 * total, share * e)
            store(new, o + 6 * total, share * f)
            store(new, o + 7 * total, load_batch(by_square, o))


@njit(**INLINE)
def find_neighbours(i, j, shape):
    """A row's first node, and where the neighbours lie of that, of one inside and of the last one.

    A neighbour beyond the window is the node itself, which takes nothing from itself.
    """
    plane, row = shape[1] * shape[2], shape[2]
    west, east = (-plane if i > 0 else 0), (plane if i + 1 < shape[0] else 0)
    south, north = (-row if j > 0 else 0), (row if j + 1 < shape[1] else 0)
    sides = west, east, south, north
    return (i * shape[1] + j) * row, (*sides, 0, 1), (*sides, -1, 1), (*sides, -1, 0)


@njit(**INLINE)
def count_shares(load, nodes, o, options):
    """Mass of the nodes from ``o`` on, particles per node over `mpm.inertia.FULL`, and one over the mass; or zeros."""
    _, full, empty = options
    m = load(nodes[1], o)
    zero, one = m - m, splat_like(cast_like(1, full), m)
    inverse = select_greater(m, splat_like(empty, m), one / m, zero)
    some = select_greater(m, splat_like(empty, m), m, zero)
    share = some * (some / (splat_like(full, m) * select_greater(some, zero, load(nodes[2], o), one)))
    return m, share, inverse


@njit(**INLINE)
def sharpen_nodes(load, nodes, options, o, neighbours, new):
    """The nodes from ``o`` on, as many as ``load`` loads."""
    v, total = nodes[0], nodes[1].size
    m, c, inverse = count_shares(load, nodes, o, options)
    one = splat_like(cast_like(1, options[0]), m)
    v0, v1, v2 = load(v, o), load(v, o + total), load(v, o + 2 * total)
    lack0 = lack1 = lack2 = m - m
    for step in neighbours:
        p = o + step
        n, d, _ = count_shares(load, nodes, p, options)
        weight = lesser(m, n) * lesser(lesser(c, d), one)
        lack0 = lack0 + weight * (v0 - load(v, p))
        lack1 = lack1 + weight * (v1 - load(v, p + total))
        lack2 = lack2 + weight * (v2 - load(v, p + 2 * total))
    share = splat_like(options[0], m) * inverse
    store(new, o, share * lack0)
    store(new, o + total, share * lack1)
    store(new, o + 2 * total, share * lack2)


@njit(**INLINE)
def pull_nodes(load, nodes, options, bars, o, neighbours, new):
    """The derivatives by the nodes from ``o`` on."""
    v, (new_v, new_mass, new_squares), total = nodes[0], new, nodes[1].size
    m, c, inverse = count_shares(load, nodes, o, options)
    zero, one, strength = m - m, splat_like(cast_like(1, options[0]), m), splat_like(options[0], m)
    half = splat_like(cast_like(0.5, options[0]), m)
    v0, v1, v2 = load(v, o), load(v, o + total), load(v, o + 2 * total)
    share = strength * inverse
    g0, g1, g2 = share * load(bars, o), share * load(bars, o + total), share * load(bars, o + 2 * total)
    by0 = by1 = by2 = by_mass = by_share = zero
    for step in neighbours:
        p = o + step
        n, d, other = count_shares(load, nodes, p, options)
        share, fewest = strength * other, lesser(c, d)
        least, part = lesser(m, n), lesser(fewest, one)
        weight = least * part
        w0, w1, w2 = v0 - load(v, p), v1 - load(v, p + total), v2 - load(v, p + 2 * total)
        h0, h1 = g0 - share * load(bars, p), g1 - share * load(bars, p + total)
        h2 = g2 - share * load(bars, p + 2 * total)
        by0, by1, by2 = by0 + weight * h0, by1 + weight * h1, by2 + weight * h2
        by_weight = w0 * h0 + w1 * h1 + w2 * h2
        # A minimum's derivative is shared out evenly where both are the least, as `jnp.minimum` has it.
        by_mass = by_mass + by_weight * part * select_greater(m, n, zero, select_greater(n, m, one, half))
        by_mass = by_mass - inverse * weight * (g0 * w0 + g1 * w1 + g2 * w2)
        mine = select_greater(c, d, zero, select_greater(d, c, one, half))
        capped = select_greater(fewest, one, zero, select_greater(one, fewest, one, half))
        by_share = by_share + by_weight * least * mine * capped
    store(new_v, o, by0)
    store(new_v, o + total, by1)
    store(new_v, o + 2 * total, by2)
    by_count = by_share * c
    store(new_mass, o, by_mass + (by_count + by_count) * inverse)
    squares = load(nodes[2], o)
    store(new_squares, o, zero - by_count / select_greater(c, zero, squares, one))
