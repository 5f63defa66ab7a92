"""Slashes: something long is swung by one end, as a sword or a bat is, from one side to the other.

It is first drawn back to the side that it comes from, unless it points there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import split_name
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.vectors import add, clamp, cross, dot, normalise, scale, subtract

_BACK, _THROUGH = 60.0, 75.0  # [degrees] to either side of its middle, where it begins and ends
_ALREADY = 10.0  # [degrees] from where it is to begin, by which it need not be drawn back
_GRIPS = frozenset(("handle", "grip", "hilt", "shaft", "pommel"))  # words for the end that it is held by
_GRIP = 0.45  # of its length, by which that end is away from its middle
_LEVEL = 0.7  # cosine to the vertical below which what is long lies
_ALONG = 0.9  # cosine to the way from which on nothing else tells where its middle is


class Stroke(NamedTuple):
    """A turn of what is swung: its axis (unit vector), its angle [degrees], and whether it is only drawn back by it."""

    axis: Vector
    angle: float
    draws_back: bool


def plan_strokes(axis: Vector, count: int, brief: SceneBrief) -> list[Stroke]:
    """The strokes of ``count`` slashes by which the free end goes where a turn about ``axis`` takes the top."""
    arm, table = _find_arm(brief), brief.directions
    way = normalise(cross(axis, table.up)) or table.left
    along = clamp(dot(arm, way), -1.0, 1.0)
    aside = None if abs(along) > _ALONG else normalise(subtract(arm, scale(way, along)))
    own = normalise(cross(aside or table.toward, way)) or table.toward
    here = math.degrees(math.asin(along))
    back = here + _BACK if here + _BACK > _ALREADY else 0.0
    strokes = [Stroke(scale(own, -1.0), back, True), Stroke(own, _THROUGH - here + back, False)]
    for _ in range(count - 1):
        strokes += [Stroke(scale(own, -1.0), _THROUGH + _BACK, True), Stroke(own, _THROUGH + _BACK, False)]
    return strokes if back else strokes[1:]


def find_grip(brief: SceneBrief) -> Vector:
    """The place that it is swung about, in fractions of its box: its grip, else its lower or its right end."""
    return add(((0.5, 0.5, 0.5), scale(_find_arm(brief), -_GRIP)))


def _find_arm(brief: SceneBrief) -> Vector:
    """The way from the grip to the free end, a unit vector."""
    table, long = brief.directions, brief.long_axis or brief.directions.up
    usual = table.up if abs(dot(long, table.up)) > _LEVEL else table.left
    grips = [
        each.side for each in brief.parts if not _GRIPS.isdisjoint((*each.roles, *split_name(each.name)))
    ]
    away = scale(grips[0], -1.0) if grips else usual
    return long if dot(long, away) >= 0 else scale(long, -1.0)
