"""Landings: what jumps stands where it comes down.

Soft matter springs up again by nearly half as much: of who jumps twice a viewer counts three jumps, the second the
higher. Knees take that up; here the object gets up but slowly once its feet have touched the ground.
"""

from __future__ import annotations

import math

from physagent_jax.forces.calibration import GAIN_MIN, GRAVITY, MAGNITUDE_MIN, find_flight
from physagent_jax.forces.schema import Action, ConstraintType, VelocityConstraint
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.vectors import dot

LANDED = "'{}': it is stopped where it comes down, as knees would, and does not spring up again."
# Frames after a body in free flight would be down: what is soft loses some height as it leaps.
_TOUCHES = -0.25
_STANDS = 0.6  # [s] for which it does not spring up
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
