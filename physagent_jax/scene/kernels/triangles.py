"""Distances from the nodes of a grid to triangles, and winding numbers: one compiled function.

Each triangle is tried at the nodes about it: a row of nodes is cut where the triangle, grown by the width of the band,
leaves it, and across its plane only nodes within that width are taken. A node whose distance is known to be less than
that to the triangle's plane, or to the ball about it, looks no closer. So the work goes with the area of the surface,
or with the number of triangles where they are smaller than the cells. Beyond the band, nodes take over the nearest
triangles of their neighbours in sweeps over the grid (Zhao 2004, "A fast sweeping method for Eikonal equations", with
triangles handed on in place of values, as Tsai 2002 has it).

Windings are counted along the lines of nodes that run in z. A line counts as shifted by an infinitesimal amount, so
that it meets no vertex or edge: neighbours agree on which of them it passes, to the last bit.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportArgumentType=false, reportPrivateImportUsage=false

from __future__ import annotations

import ctypes
import math

import numpy as np
from numba import carray, njit, types

from physagent_jax.core.once import once
from physagent_jax.kernels import store
from physagent_jax.kernels.numbers import INLINE

_EXACT = {**INLINE, "fastmath": False}  # areas of triangles that share an edge have to cancel exactly
_DOUBLES, _SINGLES, _INTEGERS = (types.CPointer(each) for each in (types.float64, types.float32, types.int32))
_SIGNATURE = types.int64(
    _DOUBLES, *[types.int64] * 4, types.float64, _DOUBLES, _SINGLES, _INTEGERS, _INTEGERS
)
# Squared area by the fourth power of the size below which only the edges count: the normal is lost in round-off.
_FLAT = 1e-16
_SLACK = 1e-9  # cells by which what is known may be off where it saves a closer look
_GAIN = 1 - 1e-4  # share of a distance beyond the band that is not worth another look


def measure(
    triangles: np.ndarray, shape: tuple[int, int, int], band: float
) -> tuple[np.ndarray, np.ndarray, int]:
    """Distances to triangles and winding numbers about them at the nodes (i, j, k) of a grid.

    Args:
        triangles: Corners in cells from the first node, shape (m, 3, 3).
        shape: Nodes along each axis.
        band: Distance up to which a node sees all triangles [cells].

    Returns:
        Distances in cells, float64, shape ``shape``, to round-off where they are below ``band``, beyond it to one
        near triangle; infinite if no node lies in the band. Winding numbers, int32, shape ``shape``. Number of pairs
        of nodes and triangles that the distances took.
    """
    corners = np.ascontiguousarray(triangles, np.float64)
    distance, closest = np.full(shape, float(band)), np.empty((*shape, 3), np.float32)
    owner, winding = np.full(shape, -1, np.int32), np.zeros(shape, np.int32)
    made = (each.ctypes.data for each in (distance, closest, owner, winding))
    pairs = _load()(corners.ctypes.data, len(corners), *shape, band, *made)
    return distance, winding, pairs


@once
def _load():
    made = store.load_or_compile("triangles", _SIGNATURE, _measure)
    address, integer = ctypes.c_void_p, ctypes.c_int64
    kinds = (address, *[integer] * 4, ctypes.c_double, *[address] * 4)
    return ctypes.CFUNCTYPE(integer, *kinds)(made.address)


def _measure(corners, count, nx, ny, nz, band, distance, closest, owner, winding):
    nodes = nx * ny * nz
    t, d, o = carray(corners, (count, 3, 3)), carray(distance, nodes), carray(owner, nodes)
    q, w = carray(closest, (nodes, 3)), carray(winding, nodes)
    pairs = 0
    for i in range(count):
        pairs += _try_triangle(t, i, (nx, ny, nz), band, d, q, o)
        _count_crossings(t, i, (nx, ny, nz), w)
    for line in range(0, nodes, nz):
        for node in range(line + nz - 2, line - 1, -1):
            w[node] += w[node + 1]
    for node in range(nodes):
        if o[node] < 0:
            d[node] = np.inf
    for direction in range(8):
        pairs += _sweep(t, direction, (nx, ny, nz), band, d, q, o)
    return pairs


@njit(**_EXACT)
def _dot(a0, a1, a2, b0, b1, b2):
    return a0 * b0 + a1 * b1 + a2 * b2


@njit(**_EXACT)
def _cross(a0, a1, a2, b0, b1, b2):
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@njit(**_EXACT)
def _find_closest(t, i, p0, p1, p2):
    """The point of triangle ``i`` that is closest to p, and its squared distance."""
    a0, a1, a2 = t[i, 0, 0], t[i, 0, 1], t[i, 0, 2]
    e0, e1, e2 = t[i, 1, 0] - a0, t[i, 1, 1] - a1, t[i, 1, 2] - a2
    f0, f1, f2 = t[i, 2, 0] - a0, t[i, 2, 1] - a1, t[i, 2, 2] - a2
    x, y, z = p0 - a0, p1 - a1, p2 - a2
    n0, n1, n2 = _cross(e0, e1, e2, f0, f1, f2)
    area = _dot(n0, n1, n2, n0, n1, n2)
    size = max(_dot(e0, e1, e2, e0, e1, e2), _dot(f0, f1, f2, f0, f1, f2))
    g0, g1, g2 = _cross(f0, f1, f2, n0, n1, n2)
    h0, h1, h2 = _cross(n0, n1, n2, e0, e1, e2)
    u, v = _dot(x, y, z, g0, g1, g2), _dot(x, y, z, h0, h1, h2)
    if area > _FLAT * size * size and u >= 0 and v >= 0 and u + v <= area:
        s = _dot(x, y, z, n0, n1, n2) / area
        return p0 - s * n0, p1 - s * n1, p2 - s * n2, s * s * area
    least, q0, q1, q2 = np.inf, a0, a1, a2
    for side in range(3):
        other = side + 1 if side < 2 else 0
        b0, b1, b2 = t[i, side, 0], t[i, side, 1], t[i, side, 2]
        e0, e1, e2 = t[i, other, 0] - b0, t[i, other, 1] - b1, t[i, other, 2] - b2
        length = _dot(e0, e1, e2, e0, e1, e2)
        s = _dot(p0 - b0, p1 - b1, p2 - b2, e0, e1, e2) / length if length > 0 else 0.0
        s = min(max(s, 0.0), 1.0)
        b0, b1, b2 = b0 + s * e0, b1 + s * e1, b2 + s * e2
        x, y, z = p0 - b0, p1 - b1, p2 - b2
        squared = _dot(x, y, z, x, y, z)
        if squared < least:
            least, q0, q1, q2 = squared, b0, b1, b2
    return q0, q1, q2, least


@njit(**_EXACT)
def _find_range(t, i, axis, band, count):
    """First and last node along an axis that may be as near as ``band`` to triangle ``i``."""
    a, b, c = t[i, 0, axis], t[i, 1, axis], t[i, 2, axis]
    low, high = math.ceil(min(a, b, c) - band), math.floor(max(a, b, c) + band)
    return int(min(max(low, 0.0), count)), int(max(min(high, count - 1.0), -1.0))


@njit(**_EXACT)
def _cut_strip(t, i, across, along, low, high):
    """Least and greatest coordinate ``across`` of triangle ``i`` where that ``along`` lies in a strip."""
    least, greatest = np.inf, -np.inf
    for side in range(3):
        other = side + 1 if side < 2 else 0
        x, y = t[i, side, across], t[i, side, along]
        dx, dy = t[i, other, across] - x, t[i, other, along] - y
        if low <= y <= high:
            least, greatest = min(least, x), max(greatest, x)
        for level in (low, high):
            if (y - level) * (y + dy - level) < 0:
                at = x + (level - y) / dy * dx
                least, greatest = min(least, at), max(greatest, at)
    return least, greatest


@njit(**_EXACT)
def _try_triangle(t, i, shape, band, d, q, o):
    """Let the nodes about triangle ``i`` know it; return the number that looked at it closely."""
    a0, a1, a2 = t[i, 0, 0], t[i, 0, 1], t[i, 0, 2]
    e0, e1, e2 = t[i, 1, 0] - a0, t[i, 1, 1] - a1, t[i, 1, 2] - a2
    f0, f1, f2 = t[i, 2, 0] - a0, t[i, 2, 1] - a1, t[i, 2, 2] - a2
    n0, n1, n2 = _cross(e0, e1, e2, f0, f1, f2)
    size = max(_dot(e0, e1, e2, e0, e1, e2), _dot(f0, f1, f2, f0, f1, f2))
    area = math.sqrt(_dot(n0, n1, n2, n0, n1, n2))
    flat = area <= 1e-6 * size  # its plane saves nothing for certain
    scale = 1 / area if not flat else 0.0
    n0, n1, n2 = scale * n0, scale * n1, scale * n2
    m0, m1, m2 = a0 + (e0 + f0) / 3, a1 + (e1 + f1) / 3, a2 + (e2 + f2) / 3
    radius = 0.0
    for side in range(3):
        x, y, z = t[i, side, 0] - m0, t[i, side, 1] - m1, t[i, side, 2] - m2
        radius = max(radius, _dot(x, y, z, x, y, z))
    slack = _SLACK + 1e-12 * math.sqrt(size)
    radius = math.sqrt(radius) + slack
    # Columns of nodes run along the axis that is nearest to the normal, rows of them along the next.
    axis = 0 if abs(n0) >= max(abs(n1), abs(n2)) else (1 if abs(n1) >= abs(n2) else 2)
    upright = (n0, n1, n2)[axis]
    across, along = (axis + 1) % 3, (axis + 2) % 3
    strides = (shape[1] * shape[2], shape[2], 1)
    u_first, u_last = _find_range(t, i, across, band, shape[across])
    v_first, v_last = _find_range(t, i, along, band, shape[along])
    w_first, w_last = _find_range(t, i, axis, band, shape[axis])
    if u_first > u_last or v_first > v_last or w_first > w_last:
        return 0
    pairs = 0
    low = min(t[i, 0, along], t[i, 1, along], t[i, 2, along])
    high = max(t[i, 0, along], t[i, 1, along], t[i, 2, along])
    for v in range(v_first, v_last + 1):
        left, right = _cut_strip(t, i, across, along, v - band, v + band)
        if left > right:
            continue
        beside = max(low - v, v - high, 0.0)
        width = math.sqrt(max(band * band - beside * beside, 0.0)) + slack
        left, right = math.ceil(max(left - width, u_first)), math.floor(min(right + width, u_last))
        for u in range(int(left), int(right) + 1):
            bottom, top = w_first, w_last
            if not flat:
                ahead = (n0, n1, n2)[across] * (u - t[i, 0, across]) + (n0, n1, n2)[along] * (
                    v - t[i, 0, along]
                )
                height, reach = t[i, 0, axis] - ahead / upright, band / abs(upright) + slack
                bottom = int(math.ceil(max(height - reach, float(bottom))))
                top = int(math.floor(min(height + reach, float(top))))
            for w in range(bottom, top + 1):
                node = u * strides[across] + v * strides[along] + w * strides[axis]
                known = d[node]
                p0 = float(w if axis == 0 else (v if axis == 1 else u))
                p1 = float(u if axis == 0 else (w if axis == 1 else v))
                p2 = float(v if axis == 0 else (u if axis == 1 else w))
                if abs(_dot(p0 - a0, p1 - a1, p2 - a2, n0, n1, n2)) > known + slack:
                    continue
                x, y, z = p0 - m0, p1 - m1, p2 - m2
                if _dot(x, y, z, x, y, z) > (known + radius) * (known + radius):
                    continue
                pairs += 1
                q0, q1, q2, squared = _find_closest(t, i, p0, p1, p2)
                if squared < known * known:
                    d[node], o[node] = math.sqrt(squared), i
                    q[node, 0], q[node, 1], q[node, 2] = q0, q1, q2
    return pairs


@njit(**_EXACT)
def _find_side(ax, ay, bx, by):
    """Twice the area under the edge a b as seen from a line, and on which side that passes; a and b from the line.

    Both change sign exactly if a and b change places. Where the area vanishes, the line is moved by (e, e^2).
    """
    area = ax * by - ay * bx
    if area != 0:
        return area, 1 if area > 0 else -1
    if ay != by:
        return area, 1 if ay > by else -1
    return area, 0 if ax == bx else (1 if bx > ax else -1)


@njit(**_EXACT)
def _count_crossings(t, i, shape, w):
    """Note where the lines of nodes along z cross triangle ``i``, at the highest node that is not above it."""
    x_first, x_last = _find_range(t, i, 0, 0.0, shape[0])
    y_first, y_last = _find_range(t, i, 1, 0.0, shape[1])
    za, zb, zc = t[i, 0, 2], t[i, 1, 2], t[i, 2, 2]
    least, greatest = min(za, zb, zc), max(za, zb, zc)
    if greatest < 0:
        return
    for x in range(x_first, x_last + 1):
        for y in range(y_first, y_last + 1):
            ax, ay = t[i, 0, 0] - x, t[i, 0, 1] - y
            bx, by = t[i, 1, 0] - x, t[i, 1, 1] - y
            cx, cy = t[i, 2, 0] - x, t[i, 2, 1] - y
            a, side = _find_side(bx, by, cx, cy)
            b, second = _find_side(cx, cy, ax, ay)
            c, third = _find_side(ax, ay, bx, by)
            if side == 0 or side != second or side != third:
                continue
            total = a + b + c
            height = (a * za + b * zb + c * zc) / total if total != 0 else greatest
            height = min(max(height, least), greatest)
            if height >= 0:
                top = int(min(math.floor(height), shape[2] - 1.0))
                w[(x * shape[1] + y) * shape[2] + top] += side


@njit(**_EXACT)
def _sweep(t, direction, shape, band, d, q, o):
    """Let nodes beyond the band take over triangles of the seven neighbours behind them, in one direction."""
    nx, ny, nz = shape
    pairs = 0
    sx, sy, sz = 1 - 2 * (direction & 1), 1 - (direction & 2), 1 - (direction & 4) // 2
    for i in range(nx):
        x = i if sx > 0 else nx - 1 - i
        for j in range(ny):
            y = j if sy > 0 else ny - 1 - j
            for k in range(nz):
                z = k if sz > 0 else nz - 1 - k
                node = (x * ny + y) * nz + z
                known = d[node]
                if known < band:
                    continue
                for behind in range(1, 8):
                    bx, by, bz = behind & 1, (behind >> 1) & 1, behind >> 2
                    if (bx and i == 0) or (by and j == 0) or (bz and k == 0):
                        continue
                    other = node - (bx * sx * ny + by * sy) * nz - bz * sz
                    owner = o[other]
                    if owner < 0 or owner == o[node]:
                        continue
                    u, v, w = x - q[other, 0], y - q[other, 1], z - q[other, 2]
                    if u * u + v * v + w * w >= _GAIN * known * known:
                        continue
                    pairs += 1
                    q0, q1, q2, squared = _find_closest(t, owner, float(x), float(y), float(z))
                    if squared < known * known:
                        known = math.sqrt(squared)
                        d[node], o[node] = known, owner
                        q[node, 0], q[node, 1], q[node, 2] = q0, q1, q2
    return pairs
