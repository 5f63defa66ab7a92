"""Places that are pressed in: the upper end of a part, or where a blow on a side dents what stands."""

from __future__ import annotations

from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import BoxRegion, CellsRegion, Region
from physagent_jax.forces.slabs import make_box
from physagent_jax.motion.schema import ExpectedMotion, SceneBrief
from physagent_jax.motion.vectors import add, cosine, cross, scale

_VERTICAL = 0.7  # cosine
_DENT = 0.35  # [box] twice as far as a dent reaches from its middle: up and down, to either side, inwards
_DEEP = 1.0  # of a squeeze's strain, by which a dent goes in: much of it is given way to


def find_pressed(
    motion: ExpectedMotion, brief: SceneBrief, region: Region | None, start: float
) -> tuple[Vector, Region, float] | None:
    """The way in which what stands is pressed in, the place, and the share of a squeeze; None if it is squeezed.

    Args:
        motion: The squeeze that is asked for.
        brief: The scene.
        region: The part that is named, if any.
        start: Fraction of the height beyond which a part's upper end is.
    """
    way, up = motion.direction, brief.directions.up
    if way is None or motion.excludes_part:
        return None
    if abs(cosine(way, up)) >= _VERTICAL:
        place = make_box(region)
        return None if place is None else (brief.directions.down, _make_upper_end(place, brief, start), 1.0)
    if not motion.sudden or motion.limb is not None or abs(cosine(way, up)) > 1 - _VERTICAL:
        return None
    return way, _make_dent(way, up), _DEEP


def _make_upper_end(place: BoxRegion, brief: SceneBrief, start: float) -> BoxRegion:
    low, high = list(place.low), list(place.high)
    if 0 < low[2] < high[2] < 1:  # of what is pressed from above, the middle is not half-way up
        sides = [0] if brief.long_axis == (1, 0, 0) else [1] if brief.long_axis == (0, 1, 0) else [0, 1]
        for side in sides:
            low[side], high[side] = place.low[2], place.high[2]
    return BoxRegion(low=(low[0], low[1], start), high=(high[0], high[1], 1.0))


def _make_dent(way: Vector, up: Vector) -> CellsRegion:
    """The surface half-way up on the side that a blow comes from, not as wide as the object."""
    surface = add(((0.5, 0.5, 0.5), scale(way, -0.5)))
    around = [scale(each, sign * _DENT) for each in (up, cross(up, way)) for sign in (1.0, -1.0)]
    outside = tuple(add((surface, each)) for each in (*around, scale(way, _DENT)))
    return CellsRegion(inside=(surface,), outside=outside, label="place that is hit")
