"""Small pictures of a skill and its direction, as the viewer sees it.

The viewer's right and up lie in the picture; "towards us" is drawn obliquely, down and to the left, as in a
cabinet projection.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from physagent_jax.forces.skills import Skill
from physagent_jax.forces.skills.icons import Mark
from physagent_jax.motion.schema import DirectionTable
from physagent_jax.report.directions import find_components
from physagent_jax.report.markup import Markup, tag

RADIUS = 21.0
OBLIQUE = (-0.45, 0.38)  # where one unit towards us lands in the picture (x right, y down)


def draw_skill_icon(skill: Skill, vector: Sequence[float], table: DirectionTable, *, reverse: bool) -> Markup:
    """The lines of a skill's icon, as they lie along its vector.

    Args:
        skill: Whose.
        vector: Unit world vector as stored.
        table: The viewer's directions.
        reverse: Whether the magnitude is negative: a direction or axis turns round, a stretch becomes a squeeze.
    """
    sign = -1.0 if reverse and not skill.is_two_sided else 1.0
    along = [sign * value for value in find_components(vector, table)]
    across = _find_perpendicular(along)
    frame = (along, across, _cross(along, across))
    drawing = [_draw_mark(mark, frame) for mark in skill.draw_icon(reverse)]
    return tag("svg", _draw_axes(), *drawing, viewBox="-26 -26 52 52", class_="compass", aria_hidden="true")


def _draw_mark(mark: Mark, frame: Sequence[Sequence[float]]) -> Markup:
    points = [
        _project([sum(share * axis[i] for share, axis in zip(point, frame)) for i in range(3)])
        for point in mark.points
    ]
    if mark.kind == "rod":
        return _draw_line(points[0], points[-1], class_="rod")
    if len(points) == 2:
        drawing = [_draw_line(points[0], points[1])]
    else:
        drawing = [tag("path", d="M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points))]
    if mark.kind != "line":
        drawing.append(_draw_head(points[max(0, len(points) - 3)], points[-1]))
    if mark.kind == "burst":
        drawing.append(_draw_burst(points[0]))
    return tag("g", *drawing)


def _project(seen: Sequence[float]) -> tuple[float, float]:
    right, up, toward = seen
    return RADIUS * (right + OBLIQUE[0] * toward), RADIUS * (-up + OBLIQUE[1] * toward)


def _draw_axes() -> Markup:
    lines = []
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        x, y = _project(axis)
        lines.append(_draw_line((-x, -y), (x, y)))
    return tag("g", *lines, class_="faint")


def _find_perpendicular(axis: Sequence[float]) -> tuple[float, float, float]:
    smallest = min(range(3), key=lambda i: abs(axis[i]))
    helper = tuple(1.0 if i == smallest else 0.0 for i in range(3))
    x, y, z = _cross(axis, helper)
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length


def _cross(a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _draw_line(start: tuple[float, float], end: tuple[float, float], class_: str | None = None) -> Markup:
    return tag(
        "line",
        class_=class_,
        x1=f"{start[0]:.1f}",
        y1=f"{start[1]:.1f}",
        x2=f"{end[0]:.1f}",
        y2=f"{end[1]:.1f}",
    )


def _draw_head(start: tuple[float, float], tip: tuple[float, float], size: float = 8.0) -> Markup:
    angle = math.atan2(tip[1] - start[1], tip[0] - start[0])
    corners = [tip]
    for side in (2.6, -2.6):
        corners.append((tip[0] + size * math.cos(angle + side), tip[1] + size * math.sin(angle + side)))
    return tag("polygon", points=" ".join(f"{x:.1f},{y:.1f}" for x, y in corners))


def _draw_burst(at: tuple[float, float]) -> Markup:
    return tag("circle", cx=f"{at[0]:.1f}", cy=f"{at[1]:.1f}", r=3.2)
