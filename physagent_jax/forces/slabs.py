"""Regions as shapes in the object's box: its ends and slabs, and what two regions have in common. No arrays.

Places are fractions of the box's extents.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import BoxRegion, CellsRegion, HalfSpaceRegion, Region

_ALONG = 0.999  # cosine
_SAMPLES = [i / 8 for i in range(9)]


def make_end_region(normal: Vector, start: float) -> HalfSpaceRegion:
    """The part beyond fraction ``start`` of the unit cube's extent along ``normal``."""
    reach = (start - 0.5) * sum(abs(c) for c in normal)
    x, y, z = (round(0.5 + reach * c, 6) for c in normal)
    return HalfSpaceRegion(point=(x, y, z), normal=normal)


def mirror_entry(item: dict[str, Any]) -> dict[str, Any]:
    """The same constraint, as data, on the opposite side of the object's middle, moving the other way."""
    region, other = item["region"], {"low": "high", "high": "low"}
    places = [key for key in ("point", "center", "low", "high") if key in region]
    mirrored = region | {other.get(key, key): [1.0 - c for c in region[key]] for key in places}
    if "normal" in region:
        mirrored["normal"] = [-c for c in region["normal"]]
    return {**item, "region": mirrored, "vector": [-c + 0.0 for c in item["vector"]]}


def make_middle_region(up: Vector) -> BoxRegion | None:
    """The middle third of the height; None if ``up`` is oblique to the axes, where it is no box."""
    axis = max(range(3), key=lambda i: abs(up[i]))
    if abs(up[axis]) < _ALONG:
        return None
    x, y, z = ((1 / 3, 2 / 3) if i == axis else (0.0, 1.0) for i in range(3))
    return BoxRegion(low=(x[0], y[0], z[0]), high=(x[1], y[1], z[1]))


def make_box(region: Region | None) -> BoxRegion | None:
    """A box, or a half-space along an axis, as a box in the unit cube; None for what is no box."""
    if not isinstance(region, HalfSpaceRegion):
        return region if isinstance(region, BoxRegion) else None
    axis = max(range(3), key=lambda i: abs(region.normal[i]))
    if abs(region.normal[axis]) < _ALONG:
        return None
    low, high = [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]
    (low if region.normal[axis] > 0 else high)[axis] = region.point[axis]
    return BoxRegion(low=(low[0], low[1], low[2]), high=(high[0], high[1], high[2]))


def do_regions_meet(one: Region | None, other: Region | None) -> bool:
    """Return whether two parts of the object have something in common; looked at on a lattice over its bounding box."""
    if one is None or other is None or one == other:
        return True
    lattice = itertools.product(_SAMPLES, _SAMPLES, _SAMPLES)
    return any(_is_inside(one, p) and _is_inside(other, p) for p in lattice)


def _is_inside(region: Region, p: tuple[float, float, float]) -> bool:
    if isinstance(region, BoxRegion):
        return all(low <= c <= high for low, c, high in zip(region.low, p, region.high))
    if isinstance(region, HalfSpaceRegion):
        return sum((c - q) * n for c, q, n in zip(p, region.point, region.normal)) >= 0
    if isinstance(region, CellsRegion):
        near, far = (min(math.dist(p, seed) for seed in seeds) for seeds in (region.inside, region.outside))
        return near < far
    return sum((c - q) ** 2 for c, q in zip(p, region.center)) <= region.radius**2
