"""Landings: what jumps stands where it comes down.

Soft matter springs up again by nearly half as much: of who jumps twice a viewer counts three jumps, the second the
higher. Knees take that up; here the object gets up but slowly once its feet have touched the ground.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import GAIN_MIN, GRAVITY, MAGNITUDE_MIN, find_flight, find_spin_aloft
from physagent_jax.forces.schema import Action, ConstraintType, VelocityConstraint
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.vectors import dot, scale
from physagent_jax.motion.windows import IMPULSE_FRAMES, Window

LIMP = re.compile(r"\b(flop|splat|splodge|slump|crumple|floppy|limp|flatten)")
"""Words of who asks that it lands limp, and lies as it comes."""
LANDED = "'{}': it is stopped where it comes down, as knees would, and does not spring up again."
# Frames after a body in free flight would be down: what is soft loses some height as it leaps.
_TOUCHES = -0.25
_STANDS = 0.6  # [s] for which it does not spring up
_SPUN_UP = 4.0  # frames in which what is thrown up is set spinning, and stopped
_SPINS = 0.8  # of its flight, in which it turns: it comes down as it is to stand
_SLOWED = 1.05  # times as fast as it would turn if it were rigid
_RESTITUTION = 0.75  # speed after a rebound over that before it
_PRESSED, _MOST_REBOUNDS = 1.0, 4  # frames for which it touches the ground; rebounds at most
FLIPPED, _LAID, _WHOLE = (
    180.0,
    90.0,
    360.0,
)  # [degrees] that it is turned by upside down, onto a side, and once
_LEVEL = 0.5  # cosine to the vertical below which an axis is level
_WOBBLES = 1.6  # M with which what is soft is seen to stretch again, and hardly leaves the ground


def land(jump: Action, until: float, brief: SceneBrief) -> VelocityConstraint | None:
    """The stop of what jumps where it comes down; None if it does not before something else begins.

    Args:
        jump: The blow that throws it up by M body lengths against its weight.
        until: Frame at which the next motion begins, or the clip's last.
        brief: The scene, with a ground.
    """
    rise = jump.magnitude * jump.gain * dot(jump.vector, brief.directions.up) * brief.size
    if jump.active_time is None or rise <= 0:
        return None
    at = jump.active_time[1] + find_flight(rise) / brief.frame_dt
    return _stop(at, until, _STANDS / brief.frame_dt, brief)


class Spin(NamedTuple):
    """A spin aloft: M of the torques that begin and end it, and their windows [frames]."""

    magnitude: float
    windows: tuple[Window, Window]


def spin_until_landed(jump: Action, degrees: float, brief: SceneBrief) -> Spin | None:
    """The spin of what a blow throws up, by so much until it comes down; None if that throws nothing up.

    Args:
        jump: The blow, which throws it up by M body lengths against its weight.
        degrees: Turn until it comes down [degrees].
        brief: The scene, with a ground.
    """
    rise = jump.magnitude * dot(jump.vector, brief.directions.up) * brief.size
    if jump.active_time is None or rise <= 0:
        return None
    at, turn = jump.active_time[1], _SLOWED * degrees / _SPINS
    stop = round(at + _SPINS * find_flight(rise) / brief.frame_dt, 3)
    push = _SPUN_UP * max(degrees / _WHOLE, 1.0)  # no torque in range does so much sooner
    size = find_spin_aloft(turn, rise, push * brief.frame_dt, brief.seconds)
    return Spin(size, ((at, at + push), (stop, stop + push)))


def turn_until_landed(
    degrees: float, own: Vector | None, side: Vector | None, over: bool, brief: SceneBrief
) -> tuple[Vector, float]:
    """The axis and the angle [degrees] of a turn aloft that ends upside down, or on a side: with whole turns before.

    Args:
        degrees: Turn that is told; 0 = none is.
        own: Axis that is told (unit vector); None = none is.
        side: Axis about which a quarter turn lays it onto that side, or a half one upside down (unit vector).
        over: Whether it lands upside down.
        brief: The scene.
    """
    whole, level = degrees - degrees % _WHOLE, own is not None and abs(dot(own, brief.directions.up)) < _LEVEL
    if over or side is None:
        return (own if own and level else side or brief.directions.toward), whole + FLIPPED
    if whole and own and level and dot(own, side) >= 0:
        return side, whole + _LAID
    return scale(side, -1.0), (whole or _WHOLE) - _LAID  # what flips goes over its head first


def list_rebounds(
    height: float, count: int, end: float, brief: SceneBrief
) -> tuple[list[tuple[float, float]], float]:
    """The frame and height [L] of each leap by which what is dropped comes up again, and the last one's top [frame].

    Soft matter on the grid keeps too little of its fall for a viewer to see it bounce, and what lands on thin parts
    keeps none.

    Args:
        height: From which it falls [L].
        count: How often it is to come up.
        end: Frame before which the last leap begins.
        brief: The scene, with a ground.
    """
    falls = math.sqrt(2.0 * height * brief.size / GRAVITY) / brief.frame_dt
    begin, leaps = falls + _PRESSED, []
    while len(leaps) < min(count, _MOST_REBOUNDS) and begin <= end - IMPULSE_FRAMES:
        height, falls = height * _RESTITUTION**2, falls * _RESTITUTION
        leaps.append((begin, height))
        begin += 2.0 * falls + _PRESSED
    return leaps, begin - _PRESSED - falls


def stand_after_drop(
    height: float, until: float, brief: SceneBrief, since: float = 0.0
) -> VelocityConstraint | None:
    """The stop of what is soft where it lands: it is pressed together and wobbles there, and does not bounce over.

    Args:
        height: From which it falls [L].
        until: Frame at which it ends.
        brief: The scene, with a ground.
        since: Frame from which it falls, at rest: the top of its last leap, of what bounces first.
    """
    at = since + math.sqrt(2.0 * height * brief.size / GRAVITY) / brief.frame_dt
    return _stop(at, until, until, brief, _WOBBLES)


def _stop(
    at: float, until: float, stands: float, brief: SceneBrief, magnitude: float = MAGNITUDE_MIN
) -> VelocityConstraint | None:
    """A stop of what would be down at a frame, which acts for ``stands`` frames; None if there is no time for it."""
    at = round(at + _TOUCHES, 3)
    if at + 2.0 > until:
        return None
    return VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_TRANSLATION,
        vector=brief.directions.down,
        magnitude=magnitude,
        gain=GAIN_MIN,
        active_time=(at, at + 1.0),
        held_until=min(at + 1.0 + stands, until),
    )
