"""Small pictures of an action's direction, as the viewer sees it.

The viewer's right and up lie in the picture; "towards us" is drawn obliquely, down and to the left, as in a
cabinet projection.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from physagent_jax.agents.schema import DirectionTable
from physagent_jax.forces.schema import ActionType
from physagent_jax.report.directions import find_components
from physagent_jax.report.markup import Markup, tag

RADIUS = 21.0
OBLIQUE = (-0.45, 0.38)  # where one unit towards us lands in the picture (x right, y down)


def draw_action_icon(
    kind: ActionType | None, vector: Sequence[float], table: DirectionTable, *, reversed_: bool
) -> Markup:
    """An arrow (translation, impulse), a double arrow (scale) or a turning arrow (torque).

    Args:
        kind: Which skill; None draws a plain arrow (velocity constraints).
        vector: Unit world vector as stored.
        table: The viewer's directions.
        reversed_: Whether the magnitude is negative: the arrow turns round, the stretch becomes a squeeze.
    """
    sign = -1.0 if reversed_ and kind is not ActionType.SCALE else 1.0
    seen = [sign * value for value in find_components(vector, table)]
    tip = _project(seen)
    if kind is ActionType.SCALE:
        drawing = _draw_double_arrow(tip, inwards=reversed_)
    elif kind is ActionType.TORQUE:
        drawing = _draw_turn(seen, tip)
    else:
        drawing = [_draw_arrow((-0.8 * tip[0], -0.8 * tip[1]), tip, burst=kind is ActionType.IMPULSE)]
    return tag("svg", _draw_axes(), *drawing, viewBox="-26 -26 52 52", class_="compass", aria_hidden="true")


def _project(seen: Sequence[float]) -> tuple[float, float]:
    right, up, toward = seen
    return RADIUS * (right + OBLIQUE[0] * toward), RADIUS * (-up + OBLIQUE[1] * toward)


def _draw_axes() -> Markup:
    lines = []
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        x, y = _project(axis)
        lines.append(_draw_line((-x, -y), (x, y)))
    return tag("g", *lines, class_="faint")


def _draw_arrow(start: tuple[float, float], tip: tuple[float, float], *, burst: bool = False) -> Markup:
    return tag("g", _draw_line(start, tip), _draw_head(start, tip), *([_draw_burst(start)] if burst else []))


def _draw_double_arrow(tip: tuple[float, float], *, inwards: bool) -> list[Markup]:
    arrows = []
    for sign in (1.0, -1.0):
        inner, outer = (sign * 0.18 * tip[0], sign * 0.18 * tip[1]), (sign * tip[0], sign * tip[1])
        arrows.append(_draw_arrow(outer, inner) if inwards else _draw_arrow(inner, outer))
    return arrows


def _draw_turn(axis: Sequence[float], tip: tuple[float, float]) -> list[Markup]:
    """Three quarters of the circle that a right-hand turn about ``axis`` follows, and the axis."""
    first = _find_perpendicular(axis)
    second = _cross(axis, first)
    points = []
    for step in range(25):
        angle = math.radians(-45 + 270 * step / 24)
        seen = [0.8 * (math.cos(angle) * p + math.sin(angle) * q) for p, q in zip(first, second)]
        points.append(_project(seen))
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
    rod = tag(
        "line", class_="rod", x1=f"{-tip[0]:.1f}", y1=f"{-tip[1]:.1f}", x2=f"{tip[0]:.1f}", y2=f"{tip[1]:.1f}"
    )
    return [rod, tag("path", d=path), _draw_head(points[-3], points[-1])]


def _find_perpendicular(axis: Sequence[float]) -> tuple[float, float, float]:
    smallest = min(range(3), key=lambda i: abs(axis[i]))
    helper = tuple(1.0 if i == smallest else 0.0 for i in range(3))
    x, y, z = _cross(axis, helper)
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length


def _cross(a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _draw_line(start: tuple[float, float], end: tuple[float, float]) -> Markup:
    return tag("line", x1=f"{start[0]:.1f}", y1=f"{start[1]:.1f}", x2=f"{end[0]:.1f}", y2=f"{end[1]:.1f}")


def _draw_head(start: tuple[float, float], tip: tuple[float, float], size: float = 8.0) -> Markup:
    angle = math.atan2(tip[1] - start[1], tip[0] - start[0])
    corners = [tip]
    for side in (2.6, -2.6):
        corners.append((tip[0] + size * math.cos(angle + side), tip[1] + size * math.sin(angle + side)))
    return tag("polygon", points=" ".join(f"{x:.1f},{y:.1f}" for x, y in corners))


def _draw_burst(at: tuple[float, float]) -> Markup:
    return tag("circle", cx=f"{at[0]:.1f}", cy=f"{at[1]:.1f}", r=3.2)
