"""`render.rasterize`'s blending and its derivative on the CPU: sixteen pixels of a tile's row at a time.

Tiles are dealt to the threads in turn. Each pixel goes through the same operations in the same order as in the
reference; only the exponential and the order of sums over pixels differ, by round-off.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

from numba import njit, prange

from physagent_jax.kernels.lanes import (
    ROW,
    any_greater,
    counted,
    exponential,
    flat,
    lane_sum,
    load,
    same,
    store,
    where_greater,
)
from physagent_jax.kernels.numbers import INLINE, OPTIONS, like

PACKED = 10  # numbers of a Gaussian: centre, conic, opacity, colour, depth
SIDE = ROW  # of a tile [px]
PIXELS = SIDE * SIDE
_TURN = 8  # Gaussians between two checks whether pixels are finished


@njit(parallel=True, **OPTIONS)
def blend(packed, reach, gaussians, starts, columns, width, height, limits, features, left, parts):
    """Fills ``features`` and the transmittance ``left``.

    Args:
        packed: Gaussians, shape (n, PACKED).
        reach: Square of the distance in y beyond which a Gaussian is not seen, shape (n,).
        gaussians: Of each tile, front to back, shape (capacity,).
        starts: Where each tile's list starts, and the end of the last one, shape (tiles + 1,).
        columns: Tiles side by side.
        width: Of the image [px].
        height: Of the image [px].
        limits: Least alpha, greatest alpha, transmittance at which blending stops.
        features: Result, shape (tiles, 4, PIXELS).
        left: Result, shape (tiles, PIXELS).
        parts: Shares of the work.
    """
    tiles = left.shape[0]
    for part in prange(parts):
        for tile in range(part, tiles, parts):
            for r in range(SIDE):
                blend_row(
                    packed,
                    reach,
                    gaussians,
                    starts[tile],
                    starts[tile + 1],
                    tile % columns * SIDE,
                    tile // columns * SIDE + r,
                    width,
                    height,
                    limits,
                    flat(features[tile]),
                    left[tile],
                    r * SIDE,
                )


@njit(**OPTIONS)
def blend_row(packed, reach, gaussians, first, last, x0, y0, width, height, limits, features, left, at):
    """One row of a tile, whose leftmost pixel has the indices x0 and y0."""
    half = like(0.5, reach[0])
    ahead = counted(half)
    zero = same(like(0, half), ahead)
    one, least, most = same(like(1, half), ahead), same(limits[0], ahead), same(limits[1], ahead)
    stop = same(limits[2], ahead)
    x, y = ahead + same(like(x0, half) + half, ahead), like(y0, half) + half
    T = where_greater(same(like(width - x0 if y0 < height else 0, half), ahead), ahead, one, zero)
    red = green = blue = depth = zero
    for i in range(first, last):
        p = gaussians[i]
        dy = y - packed[p, 1]
        if dy * dy > reach[p]:
            continue
        alpha = seen_alpha(packed, p, x, dy)
        kept = where_greater(alpha, least, where_greater(alpha, most, most, alpha), zero)  # NaN is nothing
        kept = where_greater(T, stop, kept, zero)
        weight = T * kept
        red, green = red + weight * same(packed[p, 6], x), green + weight * same(packed[p, 7], x)
        blue, depth = blue + weight * same(packed[p, 8], x), depth + weight * same(packed[p, 9], x)
        T = T - weight
        if i % _TURN == 0 and not any_greater(T, stop):
            break
    store(features, at, red)
    store(features, at + PIXELS, green)
    store(features, at + 2 * PIXELS, blue)
    store(features, at + 3 * PIXELS, depth)
    store(left, at, T)


@njit(parallel=True, **OPTIONS)
def blend_backward(
    packed,
    reach,
    gaussians,
    starts,
    columns,
    limits,
    g,
    g_left,
    features,
    left,
    inside,
    gradient,
    room,
    parts,
):
    """Fills ``gradient``, shape (parts, n, PACKED): each thread's share of the derivatives of the Gaussians.

    The first six and the last are as in `blend`. ``g``, shape (tiles, 4, PIXELS), and ``g_left``, shape (tiles,
    PIXELS), are the cotangents of what `blend` gave, ``features`` and ``left``; ``inside``, like ``left``, is 1 for
    pixels on the image, else 0; ``room``, shape (parts, 3, PIXELS), is scratch.
    """
    tiles = left.shape[0]
    for part in prange(parts):
        gradient[part] = 0
        for tile in range(part, tiles, parts):
            backward_tile(
                packed,
                reach,
                gaussians,
                starts[tile],
                starts[tile + 1],
                tile % columns * SIDE,
                tile // columns * SIDE,
                limits,
                flat(g[tile]),
                g_left[tile],
                flat(features[tile]),
                left[tile],
                inside[tile],
                gradient[part],
                room[part, 0],
                room[part, 1],
                room[part, 2],
            )


@njit(**OPTIONS)
def backward_tile(
    packed,
    reach,
    gaussians,
    first,
    last,
    x0,
    y0,
    limits,
    g,
    g_left,
    features,
    left,
    inside,
    gradient,
    T,
    prefix,
    total,
):
    """Front to back again, with prefix sums, as in `rasterize._blend_bwd`; T, prefix and total are scratch."""
    half = like(0.5, reach[0])
    ahead = counted(half)
    zero, one = same(like(0, half), ahead), same(like(1, half), ahead)
    least, most, stop = same(limits[0], ahead), same(limits[1], ahead), same(limits[2], ahead)
    x = ahead + same(like(x0, half) + half, ahead)
    for r in range(SIDE):
        o = r * SIDE
        store(T, o, load(inside, o))
        store(prefix, o, zero)
        store(total, o, dotted(g, o, features, o) + load(left, o) * load(g_left, o))
    for i in range(first, last):
        p = gaussians[i]
        row = (same(packed[p, 6], x), same(packed[p, 7], x), same(packed[p, 8], x), same(packed[p, 9], x))
        dx = x - same(packed[p, 0], x)
        s = sx = sy = sxx = sxy = syy = red = green = blue = depth = zero
        going = False
        for r in range(SIDE):
            dy = like(y0 + r, half) + half - packed[p, 1]
            o = r * SIDE
            t = load(T, o)
            going |= any_greater(t, stop)
            if dy * dy > reach[p]:
                continue
            raw = seen_alpha(packed, p, x, dy)
            alpha = where_greater(raw, least, where_greater(raw, most, most, raw), zero)
            alpha = where_greater(t, stop, alpha, zero)
            g0, g1, g2, g3 = load(g, o), load(g, o + PIXELS), load(g, o + 2 * PIXELS), load(g, o + 3 * PIXELS)
            seen = row[0] * g0 + row[1] * g1 + row[2] * g2 + row[3] * g3
            weight = t * alpha
            behind = load(prefix, o) + weight * seen
            store(prefix, o, behind)
            store(T, o, t - weight)
            slope = (t * seen - (load(total, o) - behind) / (one - alpha)) * raw
            slope = where_greater(alpha, zero, slope, zero)  # of the exponent
            slope = where_greater(most, raw, slope, zero)  # constant where it is capped
            along, down = slope * dx, slope * same(dy, x)
            s, sx, sy = s + slope, sx + along, sy + down
            sxx, sxy, syy = sxx + along * dx, sxy + down * dx, syy + down * same(dy, x)
            red, green, blue, depth = (
                red + weight * g0,
                green + weight * g1,
                blue + weight * g2,
                depth + weight * g3,
            )
        if not going:
            break
        a, b, c, opacity = packed[p, 2], packed[p, 3], packed[p, 4], packed[p, 5]
        total_s, total_x, total_y = lane_sum(s), lane_sum(sx), lane_sum(sy)
        own = gradient[p]
        own[0] += a * total_x + b * total_y
        own[1] += c * total_y + b * total_x
        own[2] -= half * lane_sum(sxx)
        own[3] -= lane_sum(sxy)
        own[4] -= half * lane_sum(syy)
        own[5] += total_s / (opacity if opacity > 0 else like(1, half))
        own[6] += lane_sum(red)
        own[7] += lane_sum(green)
        own[8] += lane_sum(blue)
        own[9] += lane_sum(depth)


@njit(**INLINE)
def seen_alpha(packed, p, x, dy):
    """Alpha o exp(-q / 2) of a Gaussian at sixteen pixels, before any limit."""
    a, b, c = packed[p, 2], packed[p, 3], packed[p, 4]
    half = like(0.5, dy)
    dx = x - same(packed[p, 0], x)
    exponent = (same(-half * a, x) * dx - same(b * dy, x)) * dx - same(half * c * dy * dy, x)
    return same(packed[p, 5], x) * exponential(exponent)


@njit(**INLINE)
def dotted(a, i, b, j):
    """The sum over the four features."""
    total = load(a, i) * load(b, j)
    for k in range(1, 4):
        total = total + load(a, i + k * PIXELS) * load(b, j + k * PIXELS)
    return total
