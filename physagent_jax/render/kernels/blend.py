"""`render.rasterize`'s blending and its derivative on the CPU: sixteen pixels of a tile's row at a time.

A thread of the team that is done takes the next tile. Each pixel goes through the same operations in the same order as
in the reference; only the exponential and the order of sums over pixels differ, by round-off.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

from numba import njit

from physagent_jax.kernels.lanes import (
    ROW,
    any_greater,
    exp,
    flatten,
    iota,
    load,
    reduce_add,
    select_greater,
    splat_like,
    store,
)
from physagent_jax.kernels.numbers import INLINE, OPTIONS, cast_like
from physagent_jax.kernels.team import share_loop

PACKED = 10  # numbers of a Gaussian: centre, conic, opacity, colour, depth
SIDE = ROW  # of a tile [px]
PIXELS = SIDE * SIDE
_TURN = 8  # Gaussians between two checks whether pixels are finished


@njit(**OPTIONS)
def blend(team, packed, reach, gaussians, starts, columns, width, height, limits, features, transmittance):
    """Fill ``features`` and ``transmittance``, what passes each pixel.

    Args:
        team: Who runs this.
        packed: Gaussians, shape (n, PACKED).
        reach: Square of the distance in y beyond which a Gaussian is not seen, shape (n,).
        gaussians: Gaussians of each tile, front to back, shape (capacity,).
        starts: Where each tile's list starts, and the end of the last one, shape (tiles + 1,).
        columns: Tiles side by side.
        width: Width of the image [px].
        height: Height of the image [px].
        limits: Least alpha, greatest alpha, transmittance at which blending stops.
        features: Result, shape (tiles, 4, PIXELS).
        transmittance: Result, shape (tiles, PIXELS).
    """
    for tile in share_loop(team, 0, transmittance.shape[0]):
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
                flatten(features[tile]),
                transmittance[tile],
                r * SIDE,
            )


@njit(**OPTIONS)
def blend_row(
    packed, reach, gaussians, first, last, x0, y0, width, height, limits, features, transmittance, at
):
    """One row of a tile, whose leftmost pixel has the indices x0 and y0."""
    half = cast_like(0.5, reach[0])
    lane = iota(half)
    zero = splat_like(cast_like(0, half), lane)
    one, least, most = (
        splat_like(cast_like(1, half), lane),
        splat_like(limits[0], lane),
        splat_like(limits[1], lane),
    )
    stop = splat_like(limits[2], lane)
    x, y = lane + splat_like(cast_like(x0, half) + half, lane), cast_like(y0, half) + half
    T = select_greater(splat_like(cast_like(width - x0 if y0 < height else 0, half), lane), lane, one, zero)
    red = green = blue = depth = zero
    for i in range(first, last):
        p = gaussians[i]
        dy = y - packed[p, 1]
        if dy * dy > reach[p]:
            continue
        alpha = evaluate_alpha(packed, p, x, dy)
        kept = select_greater(alpha, least, select_greater(alpha, most, most, alpha), zero)  # NaN is nothing
        kept = select_greater(T, stop, kept, zero)
        weight = T * kept
        red, green = red + weight * splat_like(packed[p, 6], x), green + weight * splat_like(packed[p, 7], x)
        blue, depth = (
            blue + weight * splat_like(packed[p, 8], x),
            depth + weight * splat_like(packed[p, 9], x),
        )
        T = T - weight
        if i % _TURN == 0 and not any_greater(T, stop):
            break
    store(features, at, red)
    store(features, at + PIXELS, green)
    store(features, at + 2 * PIXELS, blue)
    store(features, at + 3 * PIXELS, depth)
    store(transmittance, at, T)


@njit(**OPTIONS)
def blend_backward(
    team,
    packed,
    reach,
    gaussians,
    starts,
    columns,
    limits,
    g,
    g_transmittance,
    features,
    transmittance,
    inside,
    gradient,
    scratch,
):
    """Fill ``gradient``, shape (parts, n, PACKED): each share's part of the derivatives of the Gaussians.

    The first six and the last are as in `blend`. ``g``, shape (tiles, 4, PIXELS), and ``g_transmittance``, shape
    (tiles, PIXELS), are the cotangents of `blend`'s ``features`` and ``transmittance``; ``inside``, shape (tiles,
    PIXELS), is 1 for pixels on the image, else 0; ``scratch`` has the shape (parts, 3, PIXELS).
    """
    tiles, parts = transmittance.shape[0], gradient.shape[0]
    for part in share_loop(team, 0, parts):
        gradient[part] = 0
        for tile in range(part, tiles, parts):
            blend_tile_backward(
                packed,
                reach,
                gaussians,
                starts[tile],
                starts[tile + 1],
                tile % columns * SIDE,
                tile // columns * SIDE,
                limits,
                flatten(g[tile]),
                g_transmittance[tile],
                flatten(features[tile]),
                transmittance[tile],
                inside[tile],
                gradient[part],
                scratch[part, 0],
                scratch[part, 1],
                scratch[part, 2],
            )


@njit(**OPTIONS)
def blend_tile_backward(
    packed,
    reach,
    gaussians,
    first,
    last,
    x0,
    y0,
    limits,
    g,
    g_transmittance,
    features,
    transmittance,
    inside,
    gradient,
    T,
    prefix,
    total,
):
    """Front to back again, with prefix sums, as in `rasterize._blend_bwd`; T, prefix and total are scratch."""
    half = cast_like(0.5, reach[0])
    lane = iota(half)
    zero, one = splat_like(cast_like(0, half), lane), splat_like(cast_like(1, half), lane)
    least, most, stop = splat_like(limits[0], lane), splat_like(limits[1], lane), splat_like(limits[2], lane)
    x = lane + splat_like(cast_like(x0, half) + half, lane)
    for r in range(SIDE):
        o = r * SIDE
        store(T, o, load(inside, o))
        store(prefix, o, zero)
        store(total, o, sum_features(g, o, features, o) + load(transmittance, o) * load(g_transmittance, o))
    for i in range(first, last):
        p = gaussians[i]
        f0, f1 = splat_like(packed[p, 6], x), splat_like(packed[p, 7], x)
        f2, f3 = splat_like(packed[p, 8], x), splat_like(packed[p, 9], x)
        dx = x - splat_like(packed[p, 0], x)
        s = sx = sy = sxx = sxy = syy = red = green = blue = depth = zero
        going = False
        for r in range(SIDE):
            dy = cast_like(y0 + r, half) + half - packed[p, 1]
            o = r * SIDE
            t = load(T, o)
            going |= any_greater(t, stop)
            if dy * dy > reach[p]:
                continue
            raw = evaluate_alpha(packed, p, x, dy)
            alpha = select_greater(raw, least, select_greater(raw, most, most, raw), zero)
            alpha = select_greater(t, stop, alpha, zero)
            g0, g1, g2, g3 = load(g, o), load(g, o + PIXELS), load(g, o + 2 * PIXELS), load(g, o + 3 * PIXELS)
            seen = f0 * g0 + f1 * g1 + f2 * g2 + f3 * g3
            weight = t * alpha
            behind = load(prefix, o) + weight * seen
            store(prefix, o, behind)
            store(T, o, t - weight)
            slope = (t * seen - (load(total, o) - behind) / (one - alpha)) * raw
            slope = select_greater(alpha, zero, slope, zero)  # of the exponent
            slope = select_greater(most, raw, slope, zero)  # constant where it is capped
            along, down = slope * dx, slope * splat_like(dy, x)
            s, sx, sy = s + slope, sx + along, sy + down
            sxx, sxy, syy = sxx + along * dx, sxy + down * dx, syy + down * splat_like(dy, x)
            red, green, blue, depth = (
                red + weight * g0,
                green + weight * g1,
                blue + weight * g2,
                depth + weight * g3,
            )
        if not going:
            break
        a, b, c, opacity = packed[p, 2], packed[p, 3], packed[p, 4], packed[p, 5]
        total_s, total_x, total_y = reduce_add(s), reduce_add(sx), reduce_add(sy)
        own = gradient[p]
        own[0] += a * total_x + b * total_y
        own[1] += c * total_y + b * total_x
        own[2] -= half * reduce_add(sxx)
        own[3] -= reduce_add(sxy)
        own[4] -= half * reduce_add(syy)
        own[5] += total_s / (opacity if opacity > 0 else cast_like(1, half))
        own[6] += reduce_add(red)
        own[7] += reduce_add(green)
        own[8] += reduce_add(blue)
        own[9] += reduce_add(depth)


@njit(**INLINE)
def evaluate_alpha(packed, p, x, dy):
    """Alpha o exp(-q / 2) of a Gaussian at sixteen pixels, before any limit."""
    a, b, c = packed[p, 2], packed[p, 3], packed[p, 4]
    half = cast_like(0.5, dy)
    dx = x - splat_like(packed[p, 0], x)
    exponent = (splat_like(-half * a, x) * dx - splat_like(b * dy, x)) * dx - splat_like(
        half * c * dy * dy, x
    )
    return splat_like(packed[p, 5], x) * exp(exponent)


@njit(**INLINE)
def sum_features(a, i, b, j):
    """The sum over the four features."""
    total = load(a, i) * load(b, j)
    for k in range(1, 4):
        total = total + load(a, i + k * PIXELS) * load(b, j + k * PIXELS)
    return total
