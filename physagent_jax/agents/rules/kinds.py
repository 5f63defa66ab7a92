"""The kind of skill that carries out a motion: a body force, or velocity constraints.

A force lets the object answer as it likes, and what comes of it depends on stiffness, weight and whatever opposes. A
velocity constraint brings about the stated motion whatever opposes, and looks like what it is: something that grips,
presses or hits. The table is `docs/skills.md`, with what each kind was measured to do in `docs/executor.md`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from physagent_jax.agents.dosing import find_magnitude
from physagent_jax.agents.matching import Cause, agrees, find_own_causes, share_time
from physagent_jax.agents.regions import make_box, make_end_region
from physagent_jax.agents.rules.edits import AXIAL, replace_items
from physagent_jax.agents.rules.tolerances import (
    expect_move,
    expect_quantity,
    expect_rotation,
    expect_strain,
)
from physagent_jax.agents.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.agents.vectors import clamp, cosine, scale
from physagent_jax.forces.calibration import (
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    PRESCRIBED_TRAVEL,
    TRAVEL,
    TURN,
    find_reference_time,
)
from physagent_jax.forces.schema import (
    ActionType,
    BoxRegion,
    ConstraintType,
    ForceField,
    VelocityConstraint,
)

SLAB = 0.75  # where a gripped end begins, as a fraction of the extent; a thinner one tears off what tapers
MOVING = 0.6  # share of its window in which an end or a plate moves; in the rest it is held
MEAN_OF_ENDS = 1.375
"""[1] how much more a bar stretches on average (the affine fit of its points) than from end to end, where its outer
quarters (`SLAB`) are moved as they are: 24 d (1/48 + 3/32) for ends moved by d each, over 2 d."""
_VERTICAL = 0.7  # cosine
_OPPOSED = -0.7


@dataclass(frozen=True)
class Choice:
    """A force field with its kinds chosen.

    Attributes:
        force_field: The result.
        reasons: What was chosen and why, a sentence each; none where all stay body forces.
    """

    force_field: ForceField
    reasons: tuple[str, ...] = ()


def choose_kinds(
    force_field: ForceField, expectations: Sequence[ExpectedMotion], brief: SceneBrief
) -> Choice:
    """Replace body forces by velocity constraints where these do what the sentence says and a force does not.

    Args:
        force_field: Force field of body forces, as a sentence is read.
        expectations: What the sentence asks for.
        brief: The scene, with what the sentence says about holding.
    """
    reasons: list[str] = []
    for expectation in expectations:
        for make in (_part_ends, _press, _press_part, _turn_ends, _strike, _carry, _set_down, _lead):
            replaced = make(force_field, expectation, expectations, brief)
            if replaced is not None:
                force_field, why = replaced
                reasons.append(why)
                break
    return Choice(force_field, tuple(reasons))


_Replaced = tuple[ForceField, str] | None


def find_new_places(before: ForceField, after: ForceField) -> dict[str, str]:
    """The place in ``after`` of each action of ``before``: its new place, or its first constraint."""
    places = {}
    for index, action in enumerate(before.actions):
        here = next((i for i, other in enumerate(after.actions) if other is action), None)
        heirs = [
            i
            for i, other in enumerate(after.constraints)
            if i >= len(before.constraints)
            and abs(cosine(other.vector, action.vector)) > _VERTICAL
            and (other.active_time or (0.0,))[0] == (action.active_time or (0.0,))[0]
        ]
        if here is not None:
            places[f"actions[{index}]"] = f"actions[{here}]"
        elif heirs:  # of two ends that turn or move against each other the one that goes the action's way
            heir = max(heirs, key=lambda i: cosine(after.constraints[i].vector, action.vector))
            places[f"actions[{index}]"] = f"constraints[{heir}]"
    return places


def stands_on_its_end(brief: SceneBrief, axis: Sequence[float]) -> bool:
    """Return whether the ground or a fixture is at one end of ``axis``: only the other end can then be moved freely."""
    x, y, z = axis
    return (brief.world == "ground" or brief.anchored is not None) and abs(
        cosine((x, y, z), brief.directions.up)
    ) > _VERTICAL


def find_hold_end(
    expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], end: float, last: float
) -> float:
    """Until when what is brought somewhere by frame ``end`` is kept there: until the next motion, if it is to stay."""
    if not expectation.stays:
        return end
    begins = [e.window[0] for e in everything if e is not expectation and e.kind is not MotionKind.STILL]
    return max(end, min([begin for begin in begins if begin >= end - 0.5], default=last))


def move_ends(
    force_field: ForceField,
    causes: Sequence[Cause],
    expectation: ExpectedMotion,
    brief: SceneBrief,
    everything: Sequence[ExpectedMotion] = (),
) -> ForceField:
    """Exactly two opposed translations of the end slabs in place of ``causes`` (paper, appendix B.2)."""
    axis = expectation.direction or causes[0].item.vector
    outward = 1.0 if expectation.kind is MotionKind.STRETCH else -1.0
    magnitude, window, hold_end = find_travel(
        causes, expectation, brief, everything, share=1.0 / math.sqrt(MEAN_OF_ENDS)
    )
    pair = tuple(
        VelocityConstraint(
            constraint_type=ConstraintType.PARTICLE_TRANSLATION,
            vector=scale(axis, side * outward),
            magnitude=magnitude,
            active_time=window,
            held_until=hold_end,
            region=make_end_region(scale(axis, side), SLAB),
        )
        for side in (1.0, -1.0)
    )
    return _put(force_field, causes, pair)


def press_between(
    force_field: ForceField,
    causes: Sequence[Cause],
    expectation: ExpectedMotion,
    brief: SceneBrief,
    everything: Sequence[ExpectedMotion] = (),
) -> ForceField:
    """Two opposed plates in place of ``causes``; one against the ground or the fixture, where there is one."""
    axis = expectation.direction or causes[0].item.vector
    alone = stands_on_its_end(brief, axis)
    movers = 1 if alone else 2
    magnitude, window, hold_end = find_travel(causes, expectation, brief, everything, movers=movers)
    top_is_held = brief.anchored is not None and "top" in brief.anchored
    free = brief.directions.down if not top_is_held else brief.directions.up
    towards_it = axis if cosine(axis, free) > 0 else scale(axis, -1.0)
    plates = tuple(
        VelocityConstraint(
            constraint_type=ConstraintType.MOVING_PLATE,
            vector=way,
            magnitude=magnitude,
            active_time=window,
            held_until=hold_end,
        )
        for way in ((towards_it,) if alone else (axis, scale(axis, -1.0)))
    )
    return _put(force_field, causes, plates)


def find_travel(
    causes: Sequence[Cause],
    expectation: ExpectedMotion,
    brief: SceneBrief,
    everything: Sequence[ExpectedMotion] = (),
    *,
    movers: int = 2,
    share: float = 1.0,
) -> tuple[float, tuple[float, float], float | None]:
    """Magnitude, window, and until when to hold, with which ``movers`` ends change the extent as the sentence asks.

    They move in the first part of the cause's window and are held in the rest of it, and for as long as it is to stay.
    What was deformed the other way just before is brought back first. ``share``: of the asked change, that the ends go.
    """
    last = float(brief.frame_count - 1)
    first, end = causes[0].item.active_time or (0.0, last)
    end = min(end, last)
    squeeze = expectation.kind is MotionKind.SQUEEZE
    target = share * _find_strain(expectation, squeeze, brief)
    target += sum(
        share * _find_strain(each, not squeeze, brief)
        for each in everything
        if each.kind in AXIAL and each.kind is not expectation.kind and not each.released
        if abs(each.window[1] - first) < 1.5 and _share_line(each, expectation)
    )
    reference = find_reference_time(brief.anchored is not None, last * brief.frame_dt) / brief.frame_dt
    effort = target * reference / (movers * PRESCRIBED_TRAVEL)  # magnitude times frames
    magnitude, until = _spread_effort(effort, first, end)
    kept = find_hold_end(expectation, everything, end, last)
    return magnitude, (first, until), (kept if kept > until else None)


def _spread_effort(effort: float, first: float, end: float) -> tuple[float, float]:
    """Magnitude with which an effort [magnitude times frames] takes `MOVING` of a window, and its last frame.

    In whole frames, and as long as the largest magnitude needs.
    """
    magnitude = clamp(effort / (MOVING * (end - first)), MAGNITUDE_MIN, MAGNITUDE_MAX)
    until = clamp(float(round(first + effort / magnitude)), first + 1.0, max(end, first + 1.0))
    return round(clamp(effort / (until - first), MAGNITUDE_MIN, MAGNITUDE_MAX), 4), until


def _find_strain(expectation: ExpectedMotion, squeeze: bool, brief: SceneBrief) -> float:
    """By how much of its length it is to get longer or shorter."""
    told = expectation.amount and expect_quantity(expectation.amount, expectation.kind, brief)
    if told and told.unit == "of its length":
        return told.target
    return expect_strain(expectation, squeeze).target


def _share_line(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    return (
        one.direction is not None
        and other.direction is not None
        and abs(cosine(one.direction, other.direction)) > _VERTICAL
    )


def _part_ends(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], brief: SceneBrief
) -> _Replaced:
    """A stretch along an axis: its two ends are moved apart."""
    causes = _find_scales(field, expectation, everything)
    if expectation.kind is not MotionKind.STRETCH or not causes or expectation.direction is None:
        return None
    if stands_on_its_end(brief, expectation.direction):
        return None  # the lower end cannot move: a force stretches what rises above it
    why = f"'{expectation.words}': the two ends are moved apart, whatever the stiffness."
    return move_ends(field, causes, expectation, brief, everything), why


def _press(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], brief: SceneBrief
) -> _Replaced:
    """A squeeze along an axis: between plates if nothing moves the object before, else by its ends."""
    causes = _find_scales(field, expectation, everything)
    if expectation.kind is not MotionKind.SQUEEZE or not causes or expectation.direction is None:
        return None
    begin = (causes[0].item.active_time or (0.0, 0.0))[0]
    pulled = any(e.kind is MotionKind.STRETCH and _share_line(e, expectation) for e in everything)
    if (
        begin < 1
        and not field.default_drop
        and (not pulled or stands_on_its_end(brief, expectation.direction))
    ):
        why = f"'{expectation.words}': it is pressed between plates, not pulled inwards at every point."
        return press_between(field, causes, expectation, brief, everything), why
    if stands_on_its_end(brief, expectation.direction):
        return None
    where = "as they are moved apart in turn" if pulled else "wherever it is by then"
    why = f"'{expectation.words}': the two ends are moved together, {where}."
    return move_ends(field, causes, expectation, brief, everything), why


def _press_part(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], brief: SceneBrief
) -> _Replaced:
    """A part of what stands is pressed down: the upper end of that part is moved, as a hand would."""
    axis, down = expectation.direction, brief.directions.down
    if expectation.kind is not MotionKind.SQUEEZE or axis is None or abs(cosine(axis, down)) < _VERTICAL:
        return None
    if brief.world != "ground" or "top" in (brief.anchored or "") or field.default_drop:
        return None
    if expectation.excludes_part:
        return None  # all but that part
    causes = find_own_causes(expectation, everything, field)
    causes = [c for c in causes if c.type is ActionType.SCALE and agrees(c, expectation)]
    place = make_box(causes[0].item.region) if causes else None
    if place is None:
        return None
    low, high = list(place.low), list(place.high)
    if 0 < low[2] < high[2] < 1:  # of what is pressed from above, the middle is not half-way up
        sides = [0] if brief.long_axis == (1, 0, 0) else [1] if brief.long_axis == (0, 1, 0) else [0, 1]
        for side in sides:
            low[side], high[side] = place.low[2], place.high[2]
    low[2], high[2] = SLAB, 1.0
    there = expectation.model_copy(update={"partial": False, "part": None})  # as deep as if all were pressed
    magnitude, window, hold_end = find_travel(causes, there, brief, everything, movers=1)
    hand = VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_TRANSLATION,
        vector=down,
        magnitude=magnitude,
        active_time=window,
        held_until=hold_end,
        region=BoxRegion(low=(low[0], low[1], low[2]), high=(high[0], high[1], high[2])),
    )
    why = f"'{expectation.words}': the upper end of that part is pressed down, whatever the stiffness."
    return _put(field, causes, (hand,)), why


def _turn_ends(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], brief: SceneBrief
) -> _Replaced:
    """One end turned against the other: two opposed rotations of the ends; a torque on each half would shear it."""
    if expectation.kind is not MotionKind.ROTATE or expectation.direction is None:
        return None
    other = next((e for e in everything if _is_turned_against(expectation, e)), None)
    if other is None:
        return None
    pair = []
    for each in (expectation, other):
        causes = [c for c in find_own_causes(each, everything, field) if c.type is ActionType.TORQUE]
        causes = [c for c in causes if c.item.region is not None and agrees(c, each)]
        if not causes:
            return None
        pair.append((each, causes[0]))
    ends = tuple(_make_turn(each, cause, brief, everything) for each, cause in pair)
    why = f"'{expectation.words}': its ends are turned against each other, each about its own middle."
    return _put(field, [cause for _, cause in pair], ends), why


def _is_turned_against(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    if other is one or other.kind is not MotionKind.ROTATE or not share_time(one, other):
        return False
    if one.part is None or other.part is None or other.direction is None or one.direction is None:
        return False
    return cosine(one.part, other.part) < _OPPOSED and cosine(one.direction, other.direction) < _OPPOSED


def _make_turn(
    expectation: ExpectedMotion, cause: Cause, brief: SceneBrief, everything: Sequence[ExpectedMotion]
) -> VelocityConstraint:
    assert expectation.part is not None
    last = float(brief.frame_count - 1)
    first, end = cause.item.active_time or (0.0, last)
    until = max(float(round(first + MOVING * (min(end, last) - first))), first + 1.0)
    kept = find_hold_end(expectation, everything, min(end, last), last)
    magnitude, amount = cause.item.magnitude, expectation.amount
    if amount is not None and amount.unit == "degrees":
        reference = find_reference_time(brief.anchored is not None, last * brief.frame_dt) / brief.frame_dt
        needed = math.radians(amount.value) / TURN * reference / (until - first)
        magnitude = math.copysign(clamp(needed, MAGNITUDE_MIN, MAGNITUDE_MAX), magnitude)
    return VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_ROTATION,
        vector=cause.item.vector,
        magnitude=round(magnitude, 4),
        active_time=(first, until),
        held_until=kept if kept > until else None,
        region=make_end_region(expectation.part, SLAB),
    )


def _strike(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], brief: SceneBrief
) -> _Replaced:
    """A blow on a part, or on what is held: at once, before the rest can answer."""
    if not expectation.sudden:
        return None
    causes = [
        c
        for c in find_own_causes(expectation, everything, field)
        if c.type is ActionType.IMPULSE
        and agrees(c, expectation)
        and (c.item.region is not None or brief.anchored is not None)
    ]
    if not causes:
        return None
    why = f"'{expectation.words}': the blow changes the velocity at once, before the rest can answer."
    return replace_blows(field, causes), why


def replace_blows(force_field: ForceField, causes: Sequence[Cause]) -> ForceField:
    """Instantaneous changes of velocity in place of ``causes``, with the same magnitudes."""
    return _put(force_field, causes, tuple(as_particle_impulse(c) for c in causes))


def as_particle_impulse(cause: Cause) -> VelocityConstraint:
    """The same blow as an instantaneous change of velocity."""
    item = cause.item
    return VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_IMPULSE,
        vector=item.vector,
        magnitude=item.magnitude,
        active_time=item.active_time,
        region=item.region,
        object=item.object,
    )


def _carry(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], brief: SceneBrief
) -> _Replaced:
    """Carry what is raised from the ground and then kept up, since a force would let it tip.

    Only where something is to come after: what is raised and no more may be pushed up to the clip's end.
    """
    way, up = expectation.direction, brief.directions.up
    if expectation.kind is not MotionKind.MOVE or way is None or cosine(way, up) < _VERTICAL:
        return None
    if brief.world != "ground" or brief.anchored is not None or expectation.sudden or expectation.partial:
        return None
    after = [e for e in everything if e.window[0] >= expectation.window[1] - 0.5]
    if not (after or expectation.stays):
        return None
    rests = any(e.kind is MotionKind.STILL and e.window[0] < expectation.window[1] + 1.5 for e in after)
    causes = [c for c in find_own_causes(expectation, everything, field) if c.type is ActionType.TRANSLATION]
    if not any(agrees(c, expectation) for c in causes) or any(c.item.region is not None for c in causes):
        return None
    last = float(brief.frame_count - 1)
    first = min((c.item.active_time or (0.0, last))[0] for c in causes)
    end = max((c.item.active_time or (0.0, last))[1] for c in causes)
    effort = _find_way(expectation, (end - first) * brief.frame_dt, brief) / PRESCRIBED_TRAVEL
    effort *= find_reference_time(False, last * brief.frame_dt) / brief.frame_dt
    magnitude = clamp(effort / (MOVING * (end - first)), MAGNITUDE_MIN, MAGNITUDE_MAX)
    until = clamp(float(round(first + effort / magnitude)), first + 1.0, end)
    moves = [e.window[0] for e in after if e.kind is not MotionKind.STILL]
    kept = min([*moves, last]) if expectation.stays or rests else end
    hand = VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_TRANSLATION,
        vector=way,
        magnitude=round(magnitude, 4),
        active_time=(first, until),
        held_until=kept if kept > until else None,
    )
    return _put(field, causes, (hand,)), f"'{expectation.words}': it is carried up, and kept there."


def _set_down(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], brief: SceneBrief
) -> _Replaced:
    """Carry down what was carried up and goes down again without falling, as far as it was up."""
    down = brief.directions.down
    if (
        expectation.kind is not MotionKind.MOVE
        or cosine(expectation.direction or (0.0, 0.0, 0.0), down) < _VERTICAL
    ):
        return None
    if expectation.sudden or expectation.partial or expectation.amount is not None:
        return None
    carrying = [
        index
        for index, hand in enumerate(field.constraints)
        if hand.constraint_type is ConstraintType.PARTICLE_TRANSLATION
        and hand.region is None
        and hand.active_time is not None
        and cosine(hand.vector, down) < -_VERTICAL
    ]
    causes = [c for c in find_own_causes(expectation, everything, field) if c.type is ActionType.TRANSLATION]
    if not carrying or not any(agrees(c, expectation) for c in causes):
        return None
    last = float(brief.frame_count - 1)
    first, end = causes[0].item.active_time or (0.0, last)
    lift = field.constraints[carrying[-1]]
    begun, stopped = lift.active_time or (0.0, last)
    moves = [e.window[0] for e in everything if e.kind is not MotionKind.STILL and e is not expectation]
    if stopped > first + 0.5 or any(stopped - 0.5 < begin < first + 0.5 for begin in moves):
        return None  # what moves it meanwhile needs it free
    magnitude, until = _spread_effort(lift.magnitude * (stopped - begun), first, end)
    hands = list(field.constraints)
    hands[carrying[-1]] = lift.model_copy(update={"held_until": first if first > stopped else None})
    lowering = VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_TRANSLATION,
        vector=down,
        magnitude=magnitude,
        active_time=(first, until),
    )
    field = field.model_copy(update={"constraints": tuple(hands)})
    return _put(field, causes, (lowering,)), f"'{expectation.words}': it is carried down again."


def _lead(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion], brief: SceneBrief
) -> _Replaced:
    """Lead what moves at one speed, or so far that no force in range starts and stops it in its time."""
    told = expectation.amount and expect_quantity(expectation.amount, expectation.kind, brief)
    skills = {MotionKind.MOVE: ActionType.TRANSLATION, MotionKind.ROTATE: ActionType.TORQUE}
    turns = expectation.kind is MotionKind.ROTATE
    measured = told is not None and told.unit == ("degrees" if turns else "body lengths")
    if expectation.kind not in skills or not (measured or expectation.even):
        return None
    if brief.anchored is not None or expectation.sudden or expectation.partial or expectation.repeats > 1:
        return None
    others = [e for e in everything if e is not expectation and e.kind is not MotionKind.STILL]
    if any(share_time(e, expectation) for e in others) or expectation.direction is None:
        return None  # what is led does nothing else
    causes = find_own_causes(expectation, everything, field)
    causes = [c for c in causes if c.type is skills[expectation.kind] and c.item.region is None]
    if not any(agrees(c, expectation) for c in causes):
        return None
    last = float(brief.frame_count - 1)
    first = min((c.item.active_time or (0.0, last))[0] for c in causes)
    end = min(expectation.window[1], last)
    seconds = (end - first) * brief.frame_dt
    if turns:
        way = (
            told
            if measured and told
            else expect_rotation(expectation, brief.frame_count, False, seconds=seconds)
        )
        effort = math.radians(way.target) / TURN
    else:
        effort = _find_way(expectation, seconds, brief) / TRAVEL
    if not expectation.even and find_magnitude(effort, seconds, True, brief) <= MAGNITUDE_MAX:
        return None
    frames = find_reference_time(False, last * brief.frame_dt) / brief.frame_dt
    effort *= frames if turns else frames * TRAVEL / PRESCRIBED_TRAVEL  # magnitude times frames
    magnitude = clamp(effort / (end - first), MAGNITUDE_MIN, MAGNITUDE_MAX)
    until = clamp(float(round(first + effort / magnitude)), first + 1.0, end)
    kept = min([e.window[0] for e in others if e.window[0] >= end - 0.5], default=last)
    hand = VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_ROTATION if turns else ConstraintType.PARTICLE_TRANSLATION,
        vector=expectation.direction,
        magnitude=round(clamp(effort / (until - first), MAGNITUDE_MIN, MAGNITUDE_MAX), 4),
        active_time=(first, until),
        held_until=kept if kept > until else None,
    )
    reason = "at one speed" if expectation.even else "no force in range starts and stops it in that time"
    short = (
        ""
        if effort <= 1.01 * MAGNITUDE_MAX * (until - first)
        else ", as far as the fastest goes in that time"
    )
    why = f"'{expectation.words}': {reason}, so it is led there{short}."
    return _put(field, causes, (hand,)), why


def _find_way(expectation: ExpectedMotion, seconds: float, brief: SceneBrief) -> float:
    """The intended distance [body lengths]."""
    told = expectation.amount and expect_quantity(expectation.amount, expectation.kind, brief)
    if told and told.unit == "body lengths":
        return told.target
    return expect_move(expectation, brief.frame_count, False, seconds=seconds).target


def _find_scales(
    field: ForceField, expectation: ExpectedMotion, everything: Sequence[ExpectedMotion]
) -> list[Cause]:
    """The stretches of the whole object that serve the expectation alone."""
    if expectation.kind not in AXIAL or expectation.partial or expectation.part is not None:
        return []
    causes = find_own_causes(expectation, everything, field)
    return [
        c for c in causes if c.type is ActionType.SCALE and c.item.region is None and agrees(c, expectation)
    ]


def _put(
    field: ForceField, causes: Sequence[Cause], constraints: tuple[VelocityConstraint, ...]
) -> ForceField:
    field = replace_items(field, causes, [None] * len(causes))
    return field.model_copy(update={"constraints": (*field.constraints, *constraints)})
