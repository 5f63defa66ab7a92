"""Regions of an object's box: its ends and slabs, as fractions of its extents."""

from __future__ import annotations

from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import BoxRegion, HalfSpaceRegion, Region
from physagent_jax.motion.vectors import add, scale

_ALONG = 0.999  # cosine


def make_end_region(normal: Vector, start: float) -> HalfSpaceRegion:
    """The part beyond fraction ``start`` of the unit cube's extent along ``normal``."""
    reach = (start - 0.5) * sum(abs(c) for c in normal)
    x, y, z = add([(0.5, 0.5, 0.5), scale(normal, reach)])
    return HalfSpaceRegion(point=(round(x, 6), round(y, 6), round(z, 6)), normal=normal)


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
