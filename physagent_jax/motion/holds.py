"""Holds against motions: whether a hold gives way, stays, or makes a motion impossible.

A hold that only the object's kind or shape implies gives way to a motion that needs the object free: it falls, rises,
turns as a whole, or leaves its place (`ExpectedMotion.leaves_place`). What is bent, swayed, stretched or twisted keeps
it. So does a push of which neither a distance nor another place is told: it bends what is rooted. What only stands goes
where it is pushed, unless it is then let go. A hold that the sentence or the user asks for never gives way; a motion
that it makes impossible is found before anything is simulated.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from physagent_jax.core.errors import UserError
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import ForceField
from physagent_jax.forces.skills import get_skill
from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from physagent_jax.motion.swaying import bends
from physagent_jax.motion.vectors import cosine, scale

_UPWARD = 0.5  # cosine to the vertical from which on a way leads up
_LEVEL = 0.7  # cosine to the vertical below which an axis is level
_BENT = 90.0  # [degrees] that a held object may be bent by
_TURNED_OVER = 180.0  # [degrees] about a level axis that no bending reaches
_PLACES = {
    "region": "all but the part that moves",
    "base": "its base",
    "top": "its top",
    "box": "a box",
    "mask": "a mask",
}


class HoldOrigin(enum.Enum):
    """The source of a hold."""

    KIND = "kind"
    SUPPORT = "support"
    SENTENCE = "sentence"
    OPTION = "option"


@dataclass(frozen=True)
class Hold:
    """The hold of an object.

    Attributes:
        place: Where it is held, as in `Anchor`.
        origin: Who says so.
        words: The sentence's words for it; empty for the other origins.
    """

    place: Literal["base", "top", "box", "mask", "region"]
    origin: HoldOrigin
    words: str = ""


def list_motions(field: ForceField) -> tuple[ExpectedMotion, ...]:
    """The falls and the moves of the whole object that a force field without a sentence tells of."""
    motions = [ExpectedMotion(kind=MotionKind.FALL, window=(0, 1))] if field.default_drop else []
    for action in field.actions:
        skill, window = get_skill(action), action.active_time or (0, 1)
        if "move" in skill.causes and action.region is None:
            move = {"direction": action.vector, "window": window, "sudden": skill.is_sudden}
            motions.append(ExpectedMotion(kind=MotionKind.MOVE, **move))
    return tuple(motions)


def find_leaving(
    plan: Sequence[ExpectedMotion], up: Vector, *, stands: bool = False
) -> ExpectedMotion | None:
    """The first planned motion that needs the object free; None if a hold can stay.

    Args:
        plan: The planned motions.
        up: Unit vector against gravity.
        stands: Whether the object is held only so that it stands (`HoldOrigin.SUPPORT`).
    """
    whole = _keep_whole(plan)
    if stands:
        whole = [each for each in whole if not _comes_back(each)]
    return next((each for each in whole if _needs_free(each, up) or stands and _slides(each)), None)


def _comes_back(motion: ExpectedMotion) -> bool:
    """Return whether what only stands is bent over its feet, or tilted and then let go."""
    return motion.kind is MotionKind.ROTATE and (motion.released or bends(motion))


def _slides(motion: ExpectedMotion) -> bool:
    """Return whether what only stands goes somewhere: a push, rather than a blow, a bend, or what is then let go."""
    pushed = motion.kind is MotionKind.MOVE and motion.repeats == 1
    return pushed and not (motion.sudden or motion.released or bends(motion))


def find_impossible(hold: Hold, plan: Sequence[ExpectedMotion], up: Vector) -> ExpectedMotion | None:
    """The first planned motion that a held object cannot make in any degree; None if there is none.

    What is held can still be pulled, pushed and turned as far as it gives way, so that fewer motions are impossible
    than need the object free.
    """
    return next((each for each in _keep_whole(plan) if _is_impossible(each, hold, up)), None)


def refuse_impossible(hold: Hold, plan: Sequence[ExpectedMotion], up: Vector, *, whole: bool) -> None:
    """Refuse a plan with a motion that the hold makes impossible.

    Args:
        hold: What holds the object.
        plan: The planned motions.
        up: Unit vector against gravity.
        whole: Whether all of the object is held, so that nothing of it can move.

    Raises:
        UserError: There is such a motion.
    """
    moving = [each for each in plan if each.kind is not MotionKind.STILL]
    motion = next(iter(moving), None) if whole else find_impossible(hold, plan, up)
    if motion is None:
        return
    held = "as a whole" if whole else f"at {_PLACES[hold.place]}"
    said = hold.origin is HoldOrigin.SENTENCE
    raise UserError(
        f"{_name(motion)} is impossible for an object that is held {held}",
        got=repr(hold.words) if said else f"anchor '{hold.place}', chosen for the run",
        do=f"Leave out {'these words' if said else 'that anchor'}, so that nothing holds it, or ask for what a held "
        "object can do: bend, sway, stretch, twist",
    )


def describe_yielding(hold: Hold, plan: Sequence[ExpectedMotion], up: Vector) -> str | None:
    """A warning that a lift or a turn only stretches or twists what is held; None if there is none to give."""
    motions = [each for each in _keep_whole(plan) if _needs_free(each, up)]
    upright = [each for each in motions if each.kind is MotionKind.ROTATE or _find_height(each, up) > _UPWARD]
    if not upright:
        return None
    held = f"the object is held at {_PLACES[hold.place]}"
    return f"{_name(upright[0])}: {held}, so that it can only stretch, bend or twist and not leave its place"


def describe_release(motion: ExpectedMotion, hold: Hold, kind: str) -> str:
    """The assumption that the implied hold of an object of this kind gives way to a motion, in a sentence."""
    free = f"it is not held, as an object of kind '{kind}' otherwise is"
    if hold.origin is HoldOrigin.SUPPORT:
        free = "its feet are let go, which are otherwise held so that it stands"
    return f"{_name(motion)} needs the object free: {free}."


def needs_weight(motion: ExpectedMotion, plan: Sequence[ExpectedMotion], up: Vector) -> bool:
    """Return whether a viewer would miss the weight of what a motion of a plan lets go.

    It falls, tips over, is flung, or rises and falls later.
    """
    tips = motion.kind is MotionKind.ROTATE and abs(_find_height(motion, up)) < _LEVEL
    rises = motion.kind is MotionKind.MOVE and _find_height(motion, up) > _UPWARD
    drops = rises and any(each.kind is MotionKind.FALL for each in _keep_whole(plan))
    return motion.kind is MotionKind.FALL or tips or drops or motion.kind is MotionKind.MOVE and motion.sudden


def find_blow(plan: Sequence[ExpectedMotion], up: Vector) -> Vector | None:
    """The way of a blow that presses the object in, from above or at a side, if nothing else is planned."""
    moves = [each for each in plan if each.kind is not MotionKind.STILL]
    if not moves or not all(each.sudden and each.limb is None for each in moves):
        return None
    whole = len(_keep_whole(moves)) == len(moves)
    if whole and all(each.kind is MotionKind.MOVE and _find_height(each, up) < -_LEVEL for each in moves):
        return scale(up, -1.0)
    dents = (each.kind is MotionKind.SQUEEZE and abs(_find_height(each, up)) < _LEVEL for each in moves)
    return moves[0].direction if all(dents) else None


def _name(motion: ExpectedMotion) -> str:
    return f"'{motion.words}'" if motion.words else f"The planned motion ({motion.kind.value})"


def _keep_whole(plan: Sequence[ExpectedMotion]) -> list[ExpectedMotion]:
    """The motions of the object as a whole: no part needs it free, and none is impossible by its hold."""
    return [each for each in plan if not each.partial and each.part is None]


def _needs_free(motion: ExpectedMotion, up: Vector) -> bool:
    height = _find_height(motion, up)
    match motion.kind:
        case MotionKind.FALL:
            return True
        case MotionKind.MOVE:
            return motion.leaves_place or height > _UPWARD
        case MotionKind.ROTATE:
            return motion.repeats == 1 and not (abs(height) < _LEVEL and 0 < _find_angle(motion) < _BENT)
    return False


def _is_impossible(motion: ExpectedMotion, hold: Hold, up: Vector) -> bool:
    height = _find_height(motion, up)
    match motion.kind:
        case MotionKind.FALL:
            return True
        case MotionKind.MOVE:
            return motion.sudden and (motion.leaves_place or (height > _UPWARD and hold.place == "base"))
        case MotionKind.ROTATE:
            return abs(height) < _LEVEL and _find_angle(motion) >= _TURNED_OVER
    return False


def _find_height(motion: ExpectedMotion, up: Vector) -> float:
    """Cosine of the motion's direction or axis to the vertical; 0 if it has none."""
    return 0.0 if motion.direction is None else cosine(motion.direction, up)


def _find_angle(motion: ExpectedMotion) -> float:
    """Angle that the sentence tells [degrees]; 0 if it tells none."""
    return motion.amount.value if motion.amount is not None and motion.amount.unit == "degrees" else 0.0
