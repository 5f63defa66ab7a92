"""Breaking into pieces: the moment at which it happens, and the burst.

What is said to break stays whole until then: what it jumps, spins or slides before, it does in one piece.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from physagent_jax.forces.calibration import (
    DROP_HEIGHT,
    GAIN_MAX,
    GAIN_MIN,
    GRAVITY,
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    find_flight,
    find_reference_time,
)
from physagent_jax.forces.schema import Action, ActionType, ConstraintType, ForceField, VelocityConstraint
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.vectors import clamp, dot
from physagent_jax.motion.windows import Window

SHATTER = "shatter"
BREAKING = frozenset(
    "shatter shatters shattered shattering break breaks broken breaking fracture fractures splinter splinters".split()
) | {f"{one} {other}" for one in ("in", "into", "to") for other in ("pieces", "bits", "shards")}
"""Words of what bursts into pieces; what is only cracked, or comes apart, does not."""
_TOUGH = frozenset("food plant wood furniture animal vehicle building cloth".split())
"""Kinds whose pieces do not fly as far."""
_PLAIN, _TOUGHER = 1.0, 0.75  # M of glass, and of those
_FLIES = 0.85  # speed of the burst with an M of 1, over that of a fall from half of its size
_MOMENT = 0.2  # [s] before what breaks by itself
_FALLS = 0.35  # [s] in which what tips over has come down, after it has been let go
_UPWARDS = 0.7  # vertical component of a blow by which it leaps


def find_burst(words: Iterable[str], brief: SceneBrief, by_kind: bool) -> float:
    """Strength with which what is of some materials bursts; 0 = no word says that it goes to pieces.

    Args:
        words: The sentence's words for materials, and for what they become.
        brief: The scene.
        by_kind: Whether the sentence does not say what it is made of.
    """
    told = [" ".join(word.lower().split()) for word in words]
    if brief.world != "ground" or not any(word in BREAKING or word.startswith("smash") for word in told):
        return 0.0
    return _TOUGHER if by_kind and brief.object_kind in _TOUGH else _PLAIN


def burst(at: float, strength: float, brief: SceneBrief) -> VelocityConstraint:
    """The burst into pieces at a frame; ``strength`` of 1 is plain."""
    size = clamp(strength, MAGNITUDE_MIN, MAGNITUDE_MAX)
    speed = _FLIES * math.sqrt(GRAVITY * brief.size)  # [m/s]
    gain = speed * find_reference_time(False, brief.seconds) / brief.size
    at = min(round(at, 3), brief.last - 2.0)
    return VelocityConstraint(
        constraint_type=ConstraintType(SHATTER),
        vector=brief.directions.up,
        magnitude=round(size, 3),
        gain=round(clamp(gain, GAIN_MIN, GAIN_MAX), 3),
        active_time=(at, at + 1.0),
    )


def find_break(
    window: Window,
    brief: SceneBrief,
    actions: Sequence[Action],
    constraints: Sequence[VelocityConstraint],
    drop: float | None,
) -> float:
    """The frame at which something breaks by what happens in a window.

    Args:
        window: First and last frame of the motion by which it breaks, or of the breaking itself.
        brief: The scene.
        actions: Forces, the last ones in that window.
        constraints: Constraints, the same.
        drop: Height from which it falls in the window without having been thrown up [body lengths]; None = it does not.
    """
    first, last = window
    thrown = [(each.active_time, each) for each in actions if _throws_up(each, brief)]
    leaps = [(span, each) for span, each in thrown if span is not None and span[0] < last]
    leads, blows = (
        [each.active_time[1] for each in items if each.active_time and first <= each.active_time[0] < last]
        for items in (constraints, actions)
    )
    if leaps:
        (_, left), leap = max(leaps, key=lambda each: each[0][0])
        rise = leap.magnitude * leap.gain * dot(leap.vector, brief.directions.up) * brief.size
        at = left + find_flight(rise) / brief.frame_dt
        if first - 1.5 <= at:
            return min(at, last)
    if drop is not None:
        return first + math.sqrt(2.0 * (drop or DROP_HEIGHT) * brief.size / GRAVITY) / brief.frame_dt
    if leads:
        return min(max(leads) + brief.count_frames(_FALLS), last)
    return min(blows) if blows else first + brief.count_frames(_MOMENT)


def let_go_of_pieces(force_field: ForceField) -> ForceField:
    """The force field with constraints until it breaks alone: pieces are led by none."""
    breaks = [each for each in force_field.constraints if each.constraint_type == SHATTER]
    if not breaks or breaks[0].active_time is None:
        return force_field
    kept, at = [], breaks[0].active_time[0]
    for each in force_field.constraints:
        first, last = each.active_time or (0.0, at)
        if first < at - 1.0:
            until = each.held_until if each.held_until is None or each.held_until <= at else at
            until = None if until is not None and until <= min(last, at) else until
            kept.append(each.model_copy(update=dict(active_time=(first, min(last, at)), held_until=until)))
    return force_field.model_copy(update=dict(constraints=(*kept, *breaks)))


def _throws_up(action: Action, brief: SceneBrief) -> bool:
    blow = action.action_type is ActionType.IMPULSE and action.active_time is not None
    return blow and action.magnitude * dot(action.vector, brief.directions.up) > _UPWARDS * abs(
        action.magnitude
    )
