"""Toppling: the way that the top goes, how far it leans, and whether it lies in the end."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.motion import tolerances
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.comparing import (
    SAME_WAY,
    START,
    check_limit,
    compare_amount,
    compare_direction,
)
from physagent_jax.motion.judging.posing import find_last_lean
from physagent_jax.motion.judging.seen import Course, View, find_farthest, find_first_response
from physagent_jax.motion.schema import Check
from physagent_jax.motion.vectors import clamp, cosine, cross, dot, norm, normalise, rotate, scale

_OVER = 0.5  # of its largest lean, from where on it goes over: it may go over a corner of its foot at first
_ASIDE = 0.7  # cosine of a way to the viewer's right or left, from which on it is seen as that
_LIES = 40.0  # [degrees] from upright of what has tipped over, on whatever it then lies
_SLIM, _ON_ITS_HEAD = 1.3, 150.0  # times its breadth; [degrees] from where on what is slim stands on its head
_VIOLENT = 1.3  # strength from which it may go over its head and roll on
_ALL_ROUND = 180.0  # [degrees], beyond which a lean gets less again


def check_topple(asked: Asked, turns: Course) -> list[Check]:
    """Way, angle and end of a toppling, from the rotation vectors of the whole [deg].

    It goes by the lean alone, which is the turn without what is about the vertical: it may turn about itself as it goes
    over, and roll about where it then lies.
    """
    view, axis, up = asked.view, asked.direction, asked.view.brief.directions.up
    leans = [(t, find_lean(v, up)) for t, v in turns]
    over_all = asked.until == view.last
    farthest = max(norm(find_farthest(leans)[1]), find_last_lean(view) if over_all else 0.0)
    checks: list[Check] = []
    over = find_first_response(leans, max(_OVER * farthest, tolerances.VISIBLE_DEGREES))
    if axis is not None and over is not None:
        seen, wanted, spread = cross(over[1], up), normalise(cross(axis, up)), max(view.sigma("axis"), 1.0)
        question = "which way does it tip over?"
        aside = wanted is not None and abs(dot(wanted, view.brief.directions.right)) > _ASIDE
        within = START if aside else SAME_WAY  # what it goes towards the viewer as well is foreshortened
        checks.append(
            compare_direction(asked, question, seen, spread, wanted, f", at frame {over[0]}", within)
        )
    if asked.motion.amount is not None and asked.motion.amount.unit == "degrees":
        return checks
    turn = find_farthest(turns)[1]
    rolled = norm(turn) if axis is None else dot(turn, axis)
    headlong = rolled > _ALL_ROUND and farthest > _ON_ITS_HEAD  # else it lies, and rolls about its own length
    angle = rolled if headlong else farthest
    words = f"{angle:.0f} degrees from upright"
    tolerance = tolerances.expect_topple(asked.motion)
    width, height, depth = view.brief.extents
    if height > _SLIM * max(width, depth) and asked.motion.strength < _VIOLENT:
        tolerance = dataclasses.replace(tolerance, high=min(tolerance.high, _ON_ITS_HEAD))
    checks.append(compare_amount(asked, "how far does it tip over?", tolerance, angle, words))
    lean = find_last_lean(view) if over_all else norm(leans[-1][1])
    return [*checks, check_limit(asked, "lies", lean, _LIES, asked.sigma)]


def find_sinking(view: View, ways: Sequence[Vector]) -> float:
    """The way down of the middle of what tips over an edge of its foot onto its side [body lengths].

    Args:
        view: The scene.
        ways: Ways that its top may go; none = its narrower side.
    """
    (width, height, depth), table = view.brief.extents, view.brief.directions
    breadths = [abs(dot(way, table.right)) * width + abs(dot(way, table.toward)) * depth for way in ways]
    breadth = min(breadths, default=min(width, depth))
    return 0.5 * (math.hypot(height, breadth) - breadth)


def find_sunk_top(view: View, first: int, last: int) -> float:
    """The way that its highest point has come down in some frames, from the highest to the lowest [body lengths]."""
    up, boxes = view.brief.directions.up, view.report.box[first : last + 1]
    tops = [
        sum(max(u * a, u * b) for u, a, b in zip(up, box.low, box.high)) for box in boxes if box is not None
    ]
    return max(tops, default=0.0) - min(tops, default=0.0)


def find_lean(turn: Vector, up: Vector) -> Vector:
    """The shortest turn that brings upright to where a turn brings it, as a rotation vector [deg]."""
    top = rotate(up, turn)
    angle = math.degrees(math.acos(clamp(cosine(top, up), -1.0, 1.0)))
    return scale(normalise(cross(up, top)) or (0.0, 0.0, 0.0), angle)
