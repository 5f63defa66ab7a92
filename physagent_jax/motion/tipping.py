"""Slow tipping of what stands: it is turned over an edge of its foot as by a hand, and its weight does the rest.

A torque that only takes it past its balance leaves nothing slow to be seen of what is slim: from there it lies within
half a second. So it is led farther, at an even rate, and let go where it cannot be taken for anything but falling.
"""

from __future__ import annotations

import math

from physagent_jax.core.strict import Vector
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.schema import VelocityConstraint
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.swaying import lies, make_upper
from physagent_jax.motion.vectors import dot
from physagent_jax.motion.windows import Window

SLOW = 0.75  # strength below which tipping over is to be seen to be slow
_LED, _MOST = (
    45.0,
    65.0,
)  # [degrees] that it is led by at least, and at most: beyond, another edge may be in the way
_PAST = 8.0  # [degrees] beyond the balance of a box of its extents
_RATE = 40.0  # [degrees/s] for a strength of 1
_FALLS = 1.5  # [s] in which it then falls, and is seen to lie
_SHARE = 0.6  # of a window that is too short for both, in which it is led


def find_tipping_time(way: Vector, strength: float, brief: SceneBrief) -> float:
    """The time that slow tipping takes, with the fall and some rest [s]; 0 = it is not slow, or nothing is led.

    Args:
        way: Where its top goes (unit world vector).
        strength: 1 is plain.
        brief: The scene.
    """
    angle = _find_angle(way, brief)
    return angle / (_RATE * strength) + _FALLS if angle and strength < SLOW else 0.0


def tip(brief: SceneBrief, way: Vector, strength: float, window: Window) -> list[VelocityConstraint]:
    """The turn that leads what stands over its edge; none if it is not to be slow, or cannot be led.

    Args:
        brief: The scene.
        way: Where its top goes (unit world vector).
        strength: 1 is plain.
        window: First and last frame of turn and fall.
    """
    seconds, (first, last) = find_tipping_time(way, strength, brief) - _FALLS, window
    if seconds <= 0 or last - first < 2:
        return []
    end = first + max(float(round(min(brief.count_frames(seconds), _SHARE * (last - first)))), 1.0)
    driver = PartDriver(make_upper(brief), brief.frame_dt, brief.frame_count, held=False)
    turn = driver.turn(find_lean_axis(way, brief), _find_angle(way, brief), (first, end), None)
    return [turn.model_copy(update=dict(region=None, pivot=None))]


def _find_angle(way: Vector, brief: SceneBrief) -> float:
    """The angle that it is led by [degrees]; 0 if it lies, or is so broad that it would go over another edge first."""
    width, height, depth = brief.extents
    table = brief.directions
    across = width * abs(dot(way, table.right)) + depth * abs(dot(way, table.toward))
    angle = max(_LED, math.degrees(math.atan2(across, height)) + _PAST)
    return 0.0 if lies(brief) or angle > _MOST else angle
