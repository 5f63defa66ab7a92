"""Remedies: the changes to a force field that can mend one expected motion, the mildest first.

Every remedy is a `Change`: the whole next force field and the reason for it. The executor takes the first
that has not been tried.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from physagent_jax.agents.matching import (
    Cause,
    agrees,
    find_misfits,
    find_own_causes,
    is_thrown_up,
    list_causes,
)
from physagent_jax.agents.rules import edits
from physagent_jax.agents.rules.edits import AXIAL, Case, Change
from physagent_jax.agents.rules.tolerances import round_window
from physagent_jax.agents.schema import MotionKind
from physagent_jax.agents.vectors import clamp, norm, scale
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN, TRAVEL
from physagent_jax.forces.schema import Action, ActionType

_PUSH_BACK = 1.6  # how much harder to try if the motion is contrary although the force is right


def list_remedies(case: Case) -> Iterator[Change]:
    """All remedies for a case, the mildest first."""
    if case.expectation.kind is MotionKind.STILL:
        yield from _calm(case)
        return
    if (
        case.expectation.kind is MotionKind.FALL
        and not case.force_field.default_drop
        and case.expectation.window[0] < 1
    ):
        yield Change(
            case.force_field.model_copy(update={"default_drop": True}),
            "Gravity is switched on: it should fall.",
        )
    causes = find_own_causes(case.expectation, case.expectations, case.force_field)
    if not causes:
        yield from _switch_type(case)
        yield _add(case)
        return
    if case.expectation.kind not in (MotionKind.SWAY, MotionKind.FALL) and not any(
        agrees(cause, case.expectation) for cause in causes
    ):
        yield _turn_around(case, causes)
    if case.failed("return"):
        yield edits.shorten(case, causes, 0.5, "it should come back after letting go")
    if case.failed("repeats"):
        yield edits.alternate(case, causes)
    check = case.failed("amount") or case.failed("direction")
    gain = check.gain if check and check.gain is not None else _PUSH_BACK
    if gain <= 0:  # the fixed mapping stays: other motion must be overcome
        gain = _PUSH_BACK
    thrown = is_thrown_up(case.expectation, case.expectations, case.brief)
    if thrown and case.force_field.default_drop and gain > 1:
        yield edits.lighten_gravity(case, causes)
    yield from _stronger(case, causes, gain) if gain > 1 else _weaker(case, causes, gain)


def _stronger(case: Case, causes: Sequence[Cause], gain: float) -> Iterator[Change]:
    """More of the same up to the limit, then more of it by other means."""
    yield edits.scale_magnitudes(case, causes, gain)
    types = {cause.type for cause in causes}
    if ActionType.SCALE in types and case.expectation.direction is not None:
        yield edits.pull_ends(case, [c for c in causes if c.type is ActionType.SCALE])
    if ActionType.IMPULSE in types:
        yield edits.make_particle_impulse(case, [c for c in causes if c.type is ActionType.IMPULSE], gain)
    if types & {ActionType.TRANSLATION, ActionType.TORQUE} and case.expectation.kind is not MotionKind.SWAY:
        yield from edits.lengthen(case, causes, math.sqrt(gain))
    if not edits.is_doubled(case, causes):
        yield edits.double(case, causes, gain)
    if case.expectation.kind is MotionKind.MOVE and ActionType.TRANSLATION in types:
        yield edits.enforce(case, [c for c in causes if c.type is ActionType.TRANSLATION])
    yield edits.scale_magnitudes(case, causes, MAGNITUDE_MAX / MAGNITUDE_MIN)


def _weaker(case: Case, causes: Sequence[Cause], gain: float) -> Iterator[Change]:
    """Less of the same down to the limit, then for a shorter time; blows become brief pushes."""
    yield edits.scale_magnitudes(case, causes, gain)
    if len(causes) > 1 and case.expectation.kind is not MotionKind.SWAY:
        yield edits.remove_last(case, causes)
    impulses = [c for c in causes if c.type is ActionType.IMPULSE]
    if impulses:
        yield edits.soften(case, impulses)
    yield edits.shorten(case, causes, clamp(math.sqrt(gain), 0.3, 0.9), "the weakest push is still too much")
    yield edits.scale_magnitudes(case, causes, MAGNITUDE_MIN / MAGNITUDE_MAX)


def _turn_around(case: Case, causes: Sequence[Cause]) -> Change:
    """All causes go against the sentence: flip those that are contrary, redirect the others."""
    expectation = case.expectation
    items = []
    for cause in causes:
        flipped = cause.item.model_copy(update={"magnitude": -cause.item.magnitude})
        contrary = expectation.kind in AXIAL or agrees(Cause(cause.group, cause.index, flipped), expectation)
        items.append(
            flipped
            if contrary
            else cause.item.model_copy(
                update={"vector": expectation.direction, "magnitude": abs(cause.item.magnitude)}
            )
        )
    names = edits.format_names(causes)
    why = f"{names} went against '{expectation.words}': reversed, or pointed where the sentence says."
    return Change(edits.replace_items(case.force_field, causes, items), why, "sentence_direction")


def _switch_type(case: Case) -> Iterator[Change]:
    """A discrete leap: the action has the wrong kind of effect and becomes the skill that has the right one."""
    wrong = find_misfits(case.expectation, case.expectations, case.force_field)
    if wrong:
        new = edits.make_actions(case)
        field = edits.replace_items(case.force_field, wrong, [*new[:1], *[None] * (len(wrong) - 1)])
        field = field.model_copy(update={"actions": (*field.actions, *new[1:])})
        yield Change(
            field,
            f"{edits.format_names(wrong)} ({wrong[0].type.value}) cannot make it {case.expectation.kind.value}: "
            f"replaced by {new[0].action_type.value}.",
            "known_skills",
        )


def _add(case: Case) -> Change:
    new = edits.make_actions(case)
    field = case.force_field.model_copy(update={"actions": (*case.force_field.actions, *new)})
    return Change(
        field,
        f"Nothing made it {case.expectation.kind.value}: {new[0].action_type.value} is added.",
        "sentence_direction",
    )


def _calm(case: Case) -> Iterator[Change]:
    """Stillness: nothing acts in the window; what drifts on is stopped by a blow against its motion."""
    falls = any(e.kind is MotionKind.FALL for e in case.expectations)
    if case.force_field.default_drop and not falls:
        yield Change(
            case.force_field.model_copy(update={"default_drop": False}),
            "Gravity is switched off: it should be still.",
        )
    active = find_misfits(case.expectation, case.expectations, case.force_field)
    if active:
        yield Change(
            edits.replace_items(case.force_field, active, [None] * len(active)),
            f"{edits.format_names(active)} removed: it should be still.",
        )
    first, last = round_window(case.expectation, case.brief.frame_count)
    if case.brief.anchored is not None:  # a held object swings on rather than drifts: let it settle
        before = [
            c for c in list_causes(case.force_field) if c.item.active_time and c.item.active_time[0] < first
        ]
        yield edits.shorten(case, before, 0.8, "it should be still afterwards")
        return
    window = next((w for w in case.report.windows if (w.first, w.last) == (first, last)), None)
    if window is None or window.displacement is None or norm(window.displacement) < 1e-3 or last - first < 1:
        return
    speed = norm(window.displacement) * case.last / (last - first)  # [body lengths per clip]
    brake = Action(
        action_type=ActionType.IMPULSE,
        vector=scale(window.displacement, -1.0),
        magnitude=round(clamp(speed / TRAVEL, MAGNITUDE_MIN, MAGNITUDE_MAX), 4),
        active_time=(float(first), first + 1.0),
    )
    yield Change(
        case.force_field.model_copy(update={"actions": (*case.force_field.actions, brake)}),
        "It drifts on: a blow against its motion stops it.",
    )
