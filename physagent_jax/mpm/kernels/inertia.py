"""The nodes of `mpm.inertia.aggregate`, box sums for its derivative, and velocities with the stencil of `sharpen`.

A box sum is its own adjoint; the stencil has one. It goes over the nodes once: XLA would join the stencil with what
makes the increments, and make those anew for every neighbour; apart, small grids would wait for one kernel after the
other.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportAttributeAccessIssue=false

from __future__ import annotations

from numba import njit

from physagent_jax.kernels.lanes import (
    BATCH,
    flatten,
    has_positive,
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
def sum_neighbours(team, values, sums):
    """Fill ``sums`` with `mpm.inertia.sum_neighbours`, one number of all nodes after the other, as ``values``."""
    nx, ny, nz, numbers = values.shape
    old, new, plane = flatten(values), flatten(sums), ny * nz
    for n in share_loop(team, 0, numbers * nx):
        i = n % nx
        low, high = (-plane if i > 0 else 0), (plane if i + 1 < nx else 0)
        for j in range(ny):
            row = n * plane + j * nz
            rows = low, high, plane, (-nz if j > 0 else 0), (nz if j + 1 < ny else 0), nz
            end = row + nz - 1
            for o in range(row, end + 1, 1 if nz < BATCH + 2 else nz - 1):
                window = sum_window(load_one, old, o, rows, (-1 if o > row else 0), (1 if o < end else 0))
                store(new, o, window)
            if nz >= BATCH + 2:
                for o in range(row + 1, end, BATCH):  # the last batch overlaps
                    o = min(o, end - BATCH)
                    store(new, o, sum_window(load_batch, old, o, rows, -1, 1))


@njit(**INLINE)
def sum_window(load, old, o, rows, first, last):
    """Of the nodes from ``o`` on, as many as ``load`` loads, the sums over planes, rows and nodes around them."""
    low, high, plane, south, north, row = rows
    value = load(old, o)
    total = value - value
    for p in range(o + low, o + high + 1, plane):
        for q in range(p + south, p + north + 1, row):
            for r in range(q + first, q + last + 1):
                total = total + load(old, r)
    return total


@njit(**OPTIONS)
def aggregate(team, nodes, options, follows, shares, increments):
    """Fill ``follows`` with `mpm.inertia.aggregate`, one number of all nodes after the other, as all arrays.

    Or with `mpm.inertia.aggregated_velocity`, if ``options`` has a mass up to which a node has no velocity, above
    zero. Before that are the aggregation, the unit, and the mass in that up to which a node has none. ``shares`` is
    for a node's own share, what it hands over per mass squared, and its mass; ``increments`` for those and whether
    anything is handed to it. Most nodes are empty, or have none around that follow others, and are passed by.
    """
    shape = nodes.shape[:3]
    arrays = flatten(nodes), flatten(follows), flatten(shares), flatten(increments)
    for i in share_loop(team, 0, shape[0]):
        walk_rows(share_nodes, i, shape, arrays, options)
    for i in share_loop(team, 1, shape[0]):
        walk_rows(collect_nodes, i, shape, arrays, options)
    for i in share_loop(team, 2, shape[0]):
        walk_rows(lead_nodes, i, shape, arrays, options)


@njit(**INLINE)
def walk_rows(work, i, shape, arrays, options):
    """Call ``work`` for all nodes of a plane, with where the planes, rows and nodes around them lie."""
    nx, ny, nz = shape
    plane = ny * nz
    low, high = (-plane if i > 0 else 0), (plane if i + 1 < nx else 0)
    for j in range(ny):
        row = i * plane + j * nz
        rows = low, high, plane, (-nz if j > 0 else 0), (nz if j + 1 < ny else 0), nz
        end = row + nz - 1
        for o in range(row, end + 1, 1 if nz < BATCH + 2 else nz - 1):  # the ends, or all of a short row
            work(load_one, arrays, o, rows, (-1 if o > row else 0), (1 if o < end else 0), options)
        if nz >= BATCH + 2:
            for o in range(row + 1, end, BATCH):  # the last batch overlaps
                work(load_batch, arrays, min(o, end - BATCH), rows, -1, 1, options)


@njit(**INLINE)
def share_nodes(load, arrays, o, rows, first, last, options):
    """The shares and masses of the nodes from ``o`` on."""
    (numbers, _, shares, _), (aggregation, unit, bare, _) = arrays, options
    low, high, plane, south, north, row = rows
    total = numbers.size // 8
    mass = load(numbers, o + 3 * total)
    zero, one, scale = mass - mass, splat_like(cast_like(1, unit), mass), splat_like(unit, mass)
    mass, least = scale * mass, splat_like(bare, mass)
    mass = select_greater(mass, least, mass, zero)
    own, share = one, zero
    if has_positive(mass):
        around = squares = zero
        for p in range(o + low, o + high + 1, plane):
            for q in range(p + south, p + north + 1, row):
                for r in range(q + first, q + last + 1):
                    other = scale * load(numbers, r + 3 * total)
                    other = select_greater(other, least, other, zero)
                    around, squares = around + other, squares + other * other
        squares = select_greater(mass, zero, squares, one)
        own = mass * around / (splat_like(aggregation, mass) * squares)
        own = select_greater(mass, zero, lesser(own, one), one)
        share = (one - own) / squares
    store(shares, o, own)
    store(shares, o + total, share)
    store(shares, o + 2 * total, mass)


@njit(**INLINE)
def collect_nodes(load, arrays, o, rows, first, last, options):
    """The increments of the nodes from ``o`` on, with what is handed to them."""
    numbers, _, shares, increments = arrays
    low, high, plane, south, north, row = rows
    total = numbers.size // 8
    mass = load(shares, o + 2 * total)
    zero, one = mass - mass, splat_like(cast_like(1, options[0]), mass)
    d0 = d1 = d2 = handed = zero
    for p in range(o + low, o + high + 1, plane):
        for q in range(p + south, p + north + 1, row):
            for r in range(q + first, q + last + 1):
                handed = handed + load(shares, r + total)
    if has_positive(handed):
        f0 = f1 = f2 = gained = zero
        for p in range(o + low, o + high + 1, plane):
            for q in range(p + south, p + north + 1, row):
                for r in range(q + first, q + last + 1):
                    share = load(shares, r + total)
                    gained = gained + share * load(shares, r + 2 * total)
                    f0 = f0 + share * load(numbers, r + 4 * total)
                    f1 = f1 + share * load(numbers, r + 5 * total)
                    f2 = f2 + share * load(numbers, r + 6 * total)
        own, square = load(shares, o), mass * mass
        whole = select_greater(mass, zero, own * mass + square * gained, one)
        inverse = select_greater(mass, zero, one / whole, zero)
        d0 = inverse * (own * load(numbers, o + 4 * total) + square * f0)
        d1 = inverse * (own * load(numbers, o + 5 * total) + square * f1)
        d2 = inverse * (own * load(numbers, o + 6 * total) + square * f2)
    store(increments, o, d0)
    store(increments, o + total, d1)
    store(increments, o + 2 * total, d2)
    store(increments, o + 3 * total, handed)


@njit(**INLINE)
def lead_nodes(load, arrays, o, rows, first, last, options):
    """The impulses of the nodes from ``o`` on."""
    numbers, follows, shares, increments = arrays
    low, high, plane, south, north, row = rows
    total, empty = numbers.size // 8, options[3]
    f0, f1, f2 = load(numbers, o + 4 * total), load(numbers, o + 5 * total), load(numbers, o + 6 * total)
    if has_positive(load(increments, o + 3 * total)):
        own, share, mass = load(shares, o), load(shares, o + total), load(shares, o + 2 * total)
        d0, d1, d2 = load(increments, o), load(increments, o + total), load(increments, o + 2 * total)
        d0, d1, d2, zero = own * d0, own * d1, own * d2, mass - mass
        if has_positive(share):
            l0 = l1 = l2 = zero
            for p in range(o + low, o + high + 1, plane):
                for q in range(p + south, p + north + 1, row):
                    for r in range(q + first, q + last + 1):
                        other = load(shares, r + 2 * total)
                        square = other * other
                        l0 = l0 + square * load(increments, r)
                        l1 = l1 + square * load(increments, r + total)
                        l2 = l2 + square * load(increments, r + 2 * total)
            d0, d1, d2 = d0 + share * l0, d1 + share * l1, d2 + share * l2
        f0 = select_greater(mass, zero, mass * d0, f0)
        f1 = select_greater(mass, zero, mass * d1, f1)
        f2 = select_greater(mass, zero, mass * d2, f2)
    if empty > cast_like(0, empty):
        mass = load(numbers, o + 3 * total)
        zero, one, least = mass - mass, splat_like(cast_like(1, empty), mass), splat_like(empty, mass)
        inverse = select_greater(mass, least, one / mass, zero)
        f0 = inverse * (load(numbers, o) + f0)
        f1 = inverse * (load(numbers, o + total) + f1)
        f2 = inverse * (load(numbers, o + 2 * total) + f2)
    store(follows, o, f0)
    store(follows, o + total, f1)
    store(follows, o + 2 * total, f2)


@njit(**OPTIONS)
def sharpened_velocity(team, nodes, opposed, options, free, velocity):
    """Fill ``velocity`` with `mpm.inertia.sharpened_velocity`, one number of all nodes after the other, as all arrays.

    ``options`` are the strength, sum w m^2 / (sum w m)^2 ``unit`` below which a node's edges count in full, and the
    masses up to which a node has no particles and no velocity. ``opposed`` is not read where all of it is ``free``.
    """
    shape, given, new = velocity.shape, (flatten(nodes), flatten(opposed)), flatten(velocity)
    for i in share_loop(team, 0, shape[0]):
        for j in range(shape[1]):
            row, first, inside, last = find_neighbours(i, j, shape)
            end = row + shape[2] - 1
            sharpen_nodes(load_one, given, options, free, row, first, new)
            sharpen_nodes(load_one, given, options, free, end, last, new)
            if shape[2] < BATCH + 2:
                for o in range(row + 1, end):
                    sharpen_nodes(load_one, given, options, free, o, inside, new)
            else:
                for o in range(row + 1, end, BATCH):  # the last batch overlaps
                    sharpen_nodes(load_batch, given, options, free, min(o, end - BATCH), inside, new)


@njit(**OPTIONS)
def sharpened_velocity_adjoint(team, nodes, opposed, options, free, bars, by_nodes, by_opposed):
    """Fill the derivatives by ``nodes`` and, unless all is ``free``, by ``opposed``, from ``bars``."""
    shape, given, bars = nodes.shape, (flatten(nodes), flatten(opposed)), flatten(bars)
    new = flatten(by_nodes), flatten(by_opposed)
    for i in share_loop(team, 0, shape[0]):
        for j in range(shape[1]):
            row, first, inside, last = find_neighbours(i, j, shape)
            end = row + shape[2] - 1
            pull_nodes(load_one, given, options, free, bars, row, first, new)
            pull_nodes(load_one, given, options, free, bars, end, last, new)
            if shape[2] < BATCH + 2:
                for o in range(row + 1, end):
                    pull_nodes(load_one, given, options, free, bars, o, inside, new)
            else:
                for o in range(row + 1, end, BATCH):
                    pull_nodes(load_batch, given, options, free, bars, min(o, end - BATCH), inside, new)


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
def load_nodes(load, given, options, free, o):
    """Of the nodes from ``o`` on, as many as ``load`` loads: what their increments are, mass, share and inverse mass.

    The share is particles per node over `mpm.inertia.FULL`; the inverse is zero where a node has no velocity.
    """
    (_, full, bare, empty), (numbers, opposed) = options, given
    total = numbers.size // 8
    m = load(numbers, o + 3 * total)
    zero, one = m - m, splat_like(cast_like(1, full), m)
    inverse = select_greater(m, splat_like(empty, m), one / m, zero)
    some = select_greater(m, splat_like(bare, m), m, zero)
    squares = select_greater(some, zero, load(numbers, o + 7 * total), one)
    share = some * (some / (splat_like(full, m) * squares))
    if free:
        l0 = inverse * load(numbers, o + 4 * total)
        l1 = inverse * load(numbers, o + 5 * total)
        l2 = inverse * load(numbers, o + 6 * total)
    else:
        l0 = load(opposed, o) - inverse * load(numbers, o)
        l1 = load(opposed, o + total) - inverse * load(numbers, o + total)
        l2 = load(opposed, o + 2 * total) - inverse * load(numbers, o + 2 * total)
    return l0, l1, l2, m, share, inverse


@njit(**INLINE)
def sharpen_nodes(load, given, options, free, o, neighbours, new):
    """The nodes from ``o`` on."""
    (numbers, opposed), total = given, given[0].size // 8
    l0, l1, l2, m, c, inverse = load_nodes(load, given, options, free, o)
    zero, one = m - m, splat_like(cast_like(1, options[0]), m)
    lack0 = lack1 = lack2 = zero
    for step in neighbours:
        n0, n1, n2, n, d, _ = load_nodes(load, given, options, free, o + step)
        weight = lesser(m, n) * lesser(lesser(c, d), one)
        lack0, lack1 = lack0 + weight * (l0 - n0), lack1 + weight * (l1 - n1)
        lack2 = lack2 + weight * (l2 - n2)
    share = splat_like(options[0], m) * select_greater(c, zero, inverse, zero)
    if free:
        v0 = inverse * load(numbers, o) + l0
        v1 = inverse * load(numbers, o + total) + l1
        v2 = inverse * load(numbers, o + 2 * total) + l2
    else:
        v0, v1, v2 = load(opposed, o), load(opposed, o + total), load(opposed, o + 2 * total)
    store(new, o, v0 + share * lack0)
    store(new, o + total, v1 + share * lack1)
    store(new, o + 2 * total, v2 + share * lack2)


@njit(**INLINE)
def pull_nodes(load, given, options, free, bars, o, neighbours, new):
    """The derivatives by the nodes from ``o`` on."""
    numbers, (by_nodes, by_opposed), total = given[0], new, given[0].size // 8
    l0, l1, l2, m, c, inverse = load_nodes(load, given, options, free, o)
    zero, one, strength = m - m, splat_like(cast_like(1, options[0]), m), splat_like(options[0], m)
    half = splat_like(cast_like(0.5, options[0]), m)
    own = select_greater(c, zero, inverse, zero)
    a0, a1, a2 = load(bars, o), load(bars, o + total), load(bars, o + 2 * total)
    share = strength * own
    g0, g1, g2 = share * a0, share * a1, share * a2
    by0 = by1 = by2 = by_mass = by_share = zero
    for step in neighbours:
        p = o + step
        n0, n1, n2, n, d, other = load_nodes(load, given, options, free, p)
        share, fewest = strength * select_greater(d, zero, other, zero), lesser(c, d)
        least, part = lesser(m, n), lesser(fewest, one)
        weight = least * part
        w0, w1, w2 = l0 - n0, l1 - n1, l2 - n2
        h0, h1 = g0 - share * load(bars, p), g1 - share * load(bars, p + total)
        h2 = g2 - share * load(bars, p + 2 * total)
        by0, by1, by2 = by0 + weight * h0, by1 + weight * h1, by2 + weight * h2
        by_weight = w0 * h0 + w1 * h1 + w2 * h2
        # A minimum's derivative is shared out evenly where both are the least, as `jnp.minimum` has it.
        by_mass = by_mass + by_weight * part * select_greater(m, n, zero, select_greater(n, m, one, half))
        by_mass = by_mass - own * weight * (g0 * w0 + g1 * w1 + g2 * w2)
        mine = select_greater(c, d, zero, select_greater(d, c, one, half))
        capped = select_greater(fewest, one, zero, select_greater(one, fewest, one, half))
        by_share = by_share + by_weight * least * mine * capped
    by_count = by_share * c
    by_mass = by_mass + (by_count + by_count) * own
    squares = select_greater(c, zero, load(numbers, o + 7 * total), one)
    store(by_nodes, o + 7 * total, zero - by_count / squares)
    # By momentum brought and given, of which over the mass what is above is made.
    if free:
        f0, f1, f2 = inverse * (a0 + by0), inverse * (a1 + by1), inverse * (a2 + by2)
        q0, q1, q2 = inverse * a0, inverse * a1, inverse * a2
        by_mass = by_mass - (f0 * l0 + f1 * l1 + f2 * l2)
    else:
        f0 = f1 = f2 = zero
        q0, q1, q2 = zero - inverse * by0, zero - inverse * by1, zero - inverse * by2
        store(by_opposed, o, a0 + by0)
        store(by_opposed, o + total, a1 + by1)
        store(by_opposed, o + 2 * total, a2 + by2)
    along = q0 * load(numbers, o) + q1 * load(numbers, o + total) + q2 * load(numbers, o + 2 * total)
    store(by_nodes, o, q0)
    store(by_nodes, o + total, q1)
    store(by_nodes, o + 2 * total, q2)
    store(by_nodes, o + 3 * total, by_mass - inverse * along)
    store(by_nodes, o + 4 * total, f0)
    store(by_nodes, o + 5 * total, f1)
    store(by_nodes, o + 6 * total, f2)
