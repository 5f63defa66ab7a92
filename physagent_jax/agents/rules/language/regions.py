"""Directions and parts that a sentence names, as vectors and regions of the object's box."""

from __future__ import annotations

from physagent_jax.agents.rules.language.modifiers import Names, Place
from physagent_jax.agents.schema import SceneBrief
from physagent_jax.agents.vectors import add, normalise, scale
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import BoxRegion, HalfSpaceRegion, Region

_ALONG = 0.999  # cosine
_WORLD_AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def sum_directions(names: Names, brief: SceneBrief) -> Vector:
    """Sum of named directions (not normalised)."""
    along = {
        "long": brief.long_axis or brief.directions.up,
        "lengthwise": brief.long_axis or brief.directions.right,
    }
    known = _WORLD_AXES | along
    return add(known.get(name) or getattr(brief.directions, name) for name in names)


def make_region(place: Place, brief: SceneBrief) -> tuple[Region | None, str]:
    """A place as a region in bounding-box fractions: half-spaces, and a box for the middle band."""
    if not place.names:
        up = brief.directions.up
        axis = max(range(3), key=lambda i: abs(up[i]))
        if abs(up[axis]) < _ALONG:
            return None, "The middle is not a box here, because world up is oblique to the axes."
        x, y, z = ((1 / 3, 2 / 3) if i == axis else (0.0, 1.0) for i in range(3))
        return BoxRegion(low=(x[0], y[0], z[0]), high=(x[1], y[1], z[1])), ""
    normal = normalise(sum_directions(place.names, brief))
    if normal is None:
        return None, "The directions of the part that is named cancel."
    return make_end_region(normal, place.start), ""


def make_end_region(normal: Vector, start: float) -> HalfSpaceRegion:
    """The part beyond fraction ``start`` of the unit cube's extent along ``normal``."""
    reach = (start - 0.5) * sum(abs(c) for c in normal)
    x, y, z = add([(0.5, 0.5, 0.5), scale(normal, reach)])
    return HalfSpaceRegion(point=(round(x, 6), round(y, 6), round(z, 6)), normal=normal)


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
