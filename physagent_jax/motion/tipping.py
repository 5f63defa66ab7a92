"""Tipping over of what stands: it is turned over an edge of its foot as by a hand, and its weight does the rest.

A torque acts on after it has passed its balance, and what is broad or round then goes over its next edge as well. It is
led at an even rate instead, and let go where it cannot be taken for anything but falling. What is to tip slowly is led
so slowly that it is seen: from its balance on, what is slim lies within half a second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.schema import Action, VelocityConstraint
from physagent_jax.forces.upright import leave_upright
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.limbs import sum_directions
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.swaying import find_tipping_way, lies, make_upper
from physagent_jax.motion.vectors import clamp, cross, dot, normalise, scale
from physagent_jax.motion.windows import Window

SLOW = 0.75  # strength below which tipping over is to be seen to be slow
_LED, _MOST = (
    45.0,
    69.0,
)  # [degrees] that it is led by at least, and at most: beyond, another edge may be in the way
_SIDE = 90.0  # [degrees] that what is broad is led by onto its side, and kept there: it would go on, or back
_FLAT = 0.6  # height over breadth below which what has no edge and is long is no log
_THIN = 0.75  # breadth over height below which what is long stands on a line
_ALONG = 0.7  # cosine to the line of what stands thin, from which on a way leads over its end
_OFF_END = 25.0  # [degrees] that what was set up on its end is led by: it is slim there
_ASKEW, _LEVEL = 10.0, 0.3  # [degrees] off a quarter turn; vertical component of an axis
_PAST = 8.0  # [degrees] beyond the balance of a box of its extents
_SLOW_RATE, _RATE = 40.0, 80.0  # [degrees/s] for a strength of 1, of what is to tip slowly and of all else
_FALLS = 1.5  # [s] in which it then falls, and is seen to lie
_SHARE = 0.6  # of a window that is too short for both, in which it is led


def find_tipping_time(way: Vector, strength: float, brief: SceneBrief, aside: bool = False) -> float:
    """The time that tipping takes, with the fall and some rest [s]; 0 = nothing is led.

    Args:
        way: Where its top goes (unit world vector).
        strength: 1 is plain.
        brief: The scene.
        aside: Whether it is to lie on its side, however broad it is.
    """
    angle = _find_angle(way, brief, aside)
    return angle / ((_SLOW_RATE if strength < SLOW else _RATE) * strength) + _FALLS if angle else 0.0


def tip(
    brief: SceneBrief,
    way: Vector,
    strength: float,
    window: Window,
    before: Sequence[Action | VelocityConstraint] = (),
    kept: float | None = None,
) -> list[VelocityConstraint]:
    """The turn that leads what stands over its edge; none if it cannot be led.

    Args:
        brief: The scene.
        way: Where its top goes (unit world vector).
        strength: 1 is plain.
        window: First and last frame of turn and fall.
        before: What moves it till then.
        kept: Frame until which it is kept on its side if it would not stand there; None = it may lie as it likes.
    """
    aside, (first, last) = kept is not None, window
    seconds = find_tipping_time(way, strength, brief, aside) - _FALLS
    if seconds <= 0 or last - first < 2 or not leave_upright(before, first):
        return []
    end = first + max(float(round(min(brief.count_frames(seconds), _SHARE * (last - first)))), 1.0)
    driver = PartDriver(make_upper(brief), brief.frame_dt, brief.frame_count, held=False)
    axis, angle = find_lean_axis(find_tipping_way(way, brief), brief), _find_angle(way, brief, aside)
    turn = driver.turn(axis, angle, (first, end), kept if angle > _MOST else None)
    return [turn.model_copy(update=dict(region=None, pivot=None))]


def tip_off_end(brief: SceneBrief, axis: Vector, window: Window) -> list[VelocityConstraint]:
    """The turn that leads what was set up on its end past its balance there; its weight does the rest.

    Args:
        brief: The scene.
        axis: About which it tips (unit world vector, right-hand rule).
        window: First and last frame of turn and fall.
    """
    end = window[0] + clamp(brief.count_frames(_OFF_END / _RATE), 1.0, _SHARE * (window[1] - window[0]))
    driver = PartDriver(make_upper(brief), brief.frame_dt, brief.frame_count, held=False)
    turn = driver.turn(axis, _OFF_END, (window[0], end), None)
    return [turn.model_copy(update=dict(region=None, pivot=None))]


def find_end_axis(before: Sequence[ExpectedMotion]) -> Vector | None:
    """The axis about which it was set up on its end, by the last of the motions before; None if it was not."""
    last = before[-1] if before else None
    told = last.amount if last is not None and last.kind is MotionKind.ROTATE and last.limb is None else None
    level = last is not None and last.direction is not None and abs(last.direction[2]) < _LEVEL
    quarter = told is not None and told.unit == "degrees" and abs(told.value - _SIDE) < _ASKEW
    return last.direction if last is not None and level and quarter else None


def find_own_side(way: Vector, brief: SceneBrief) -> Vector | None:
    """The side onto which what stands thin falls when a way (unit world vector) leads over its end; None = that way.

    A bicycle that is knocked over "to the left" falls onto its own left side, and not over its rear wheel.
    """
    long, up, table = brief.long_axis, brief.directions.up, brief.directions
    if long is None or not (lies(brief) and _is_thin(brief)) or abs(dot(way, long)) < _ALONG:
        return None
    left = cross(up, sum_directions(("ahead",), brief))
    return normalise(scale(left, 1.0 if dot(way, table.left) > 0 else -1.0))


def _is_thin(brief: SceneBrief) -> bool:
    """Return whether it stands on a line, as a bicycle does: longer than high, and higher than broad."""
    width, height, depth = brief.extents
    return min(width, depth) < _THIN * height


def _find_angle(way: Vector, brief: SceneBrief, aside: bool) -> float:
    """The angle that it is led by [degrees]; 0 if it is so broad that it would go over another edge first, or rolls."""
    width, height, depth = brief.extents
    table, over = brief.directions, find_tipping_way(way, brief)
    reach = next((edge.reach for edge in brief.edges if edge.way == over), None)
    across = width * abs(dot(over, table.right)) + depth * abs(dot(over, table.toward))
    across = across if reach is None else 2 * reach
    angle = max(_LED, math.degrees(math.atan2(across, height)) + _PAST)
    # A log; a car tips over its wheels, a bicycle over the line of its own, and a pan over its rim.
    rolls = lies(brief) and reach is None and height > _FLAT * min(width, depth) and not _is_thin(brief)
    return 0.0 if rolls else angle if angle <= _MOST else _SIDE * aside
