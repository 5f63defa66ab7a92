"""Icons of skills: lines in the unit sphere, which the report draws as the viewer sees them.

A point is (along, across, beside): along the entry's vector with its sign, and along two axes that make a right-handed
frame with it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Mark:
    """One line of an icon.

    Attributes:
        points: Its corners, two or more.
        kind: "arrow" has a head at its end, "burst" a dot at its beginning too, "rod" is the faint line of an axis.
    """

    points: tuple[Point, ...]
    kind: Literal["arrow", "burst", "rod", "line"] = "arrow"


def draw_arrow(kind: Literal["arrow", "burst"] = "arrow") -> tuple[Mark, ...]:
    """An arrow along the vector."""
    return (Mark(((-0.8, 0.0, 0.0), (1.0, 0.0, 0.0)), kind),)


def draw_double_arrow(inwards: bool) -> tuple[Mark, ...]:
    """Two opposed arrows along the vector."""
    arrows = []
    for sign in (1.0, -1.0):
        inner, outer = (0.18 * sign, 0.0, 0.0), (sign, 0.0, 0.0)
        arrows.append(Mark((outer, inner) if inwards else (inner, outer)))
    return tuple(arrows)


def draw_turn(first: float = 0.8, last: float = 0.8, turns: float = 0.75) -> tuple[Mark, ...]:
    """A turn about the vector by the right hand, and the axis.

    Args:
        first: Radius where it begins.
        last: Radius where it ends.
        turns: Number of turns.
    """
    points = []
    for step in range(25):
        angle = math.radians(-45 + 360 * turns * step / 24)
        radius = first + (last - first) * step / 24
        points.append((0.0, radius * math.cos(angle), radius * math.sin(angle)))
    return (Mark(((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)), "rod"), Mark(tuple(points)))
