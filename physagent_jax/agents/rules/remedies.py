"""Remedies: the changes to a force field that can mend one expected motion, the mildest first.

Every remedy is a `Change`: the whole next force field and the reason for it. The executor takes the first
that has not been tried. None of them stacks what is at its limit, and none replaces gravity by a push.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN, TRAVEL
from physagent_jax.forces.schema import Action, ForceField
from physagent_jax.motion import edits, kinds
from physagent_jax.motion.edits import Case, Change
from physagent_jax.motion.matching import (
    AXIAL,
    POINTED,
    Cause,
    agrees,
    find_action_type,
    find_misfits,
    find_own_causes,
    find_strays,
    is_thrown_up,
    list_causes,
    share_time,
)
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.tolerances import round_window
from physagent_jax.motion.vectors import clamp, cosine, norm, scale
from physagent_jax.motion.wishes import replace_items

_PUSH_BACK = 1.6  # how much harder to try if the motion is contrary although the force is right
_GENTLER = 0.6  # the factor where too much came of it and nothing says by how much
_NO_AIM = (MotionKind.SWAY, MotionKind.FALL)
_LEVEL, _STEEP = 0.5, 0.7  # cosines to the vertical below which an axis is level, above which a way is steep
_FAINT = 2.0  # gain from which on a motion is so weak that what else moves it decides on its direction
_FAR_BEYOND = 2.5  # times the range's end: a skill that has to be so much stronger is the wrong one
_TOLD_APART = 0.3  # logarithm of the ratio of two efforts from which on their responses can be compared
_EXPONENTS = (0.25, 4.0)  # of the response over the effort that two rounds may show


def list_remedies(case: Case) -> Iterator[Change]:
    """All remedies for a case, the mildest first."""
    strays = find_strays(case.expectations, case.force_field)
    if strays:
        yield edits.remove(case, strays, "nothing in the sentence asks for it")
    if case.expectation.kind is MotionKind.STILL:
        yield from _calm(case)
        return
    if _is_let_fall_first(case):
        field = case.force_field.model_copy(update={"default_drop": False})
        yield Change(
            field, "It is let fall from above, and the fall hides the leap: it leaps from the ground."
        )
    falls = case.expectation.kind is MotionKind.FALL
    stands = case.brief.world == "ground" and _tips_over(case)
    if falls and case.expectation.window[0] < 1 and not case.force_field.default_drop and not stands:
        field = case.force_field.model_copy(update={"default_drop": True})
        yield Change(field, "Gravity is switched on: it should fall.", "gravity_makes_it_fall")
        return
    causes = find_own_causes(case.expectation, case.expectations, case.force_field)
    if not causes:
        if not falls:
            yield from _switch_type(case)
            yield _add(case)
        return
    yield from _aim(case, causes)
    if case.failed("return") and case.expectation.stays:
        yield from edits.keep(case, causes)
    elif case.failed("return"):
        yield edits.shorten(case, causes, 0.5, "it should come back after letting go")
    if case.failed("part"):
        yield edits.act_on_part(case, causes)
    blows = case.expectation.sudden and case.expectation.kind is MotionKind.MOVE  # they go one way
    if case.failed("repeats") and not blows and not edits.alternates(case, causes):
        yield edits.alternate(case, causes)
    if case.expectation.sudden and case.failed("order") and any(c.pushes for c in causes):
        field = _replace(case, causes, edits.make_actions(case)[:1])
        why = f"{edits.format_names(causes)} starts too slowly: a blow in its place."
        yield Change(field, why, "known_skills")
    yield from _change_amount(case, causes)


def _tips_over(case: Case) -> bool:
    """Return whether the fall is the end of a turn about a level axis: gravity acts on what stands there already."""
    up = case.brief.directions.up
    turns = [e for e in case.expectations if e.kind is MotionKind.ROTATE and e.direction is not None]
    return any(abs(cosine(e.direction or up, up)) < _LEVEL and share_time(e, case.expectation) for e in turns)


def _is_let_fall_first(case: Case) -> bool:
    """Return whether what leaps from the ground is lifted and let fall, although no fall is asked for first."""
    first = min(e.window[0] for e in case.expectations)
    falls_first = any(e.kind is MotionKind.FALL and e.window[0] < first + 1.0 for e in case.expectations)
    thrown = any(is_thrown_up(e, case.expectations, case.brief) for e in case.expectations)
    return case.force_field.default_drop and case.brief.world == "ground" and thrown and not falls_first


def _aim(case: Case, causes: Sequence[Cause]) -> Iterator[Change]:
    """Direction and window: as the sentence maps them; then against what is seen."""
    expectation, aims = case.expectation, case.expectation.kind not in _NO_AIM
    aims &= not any(c.turns_limb for c in causes)  # its axis is none of the directions
    if aims:
        told = None if expectation.kind in AXIAL else expectation.direction
        if not any(
            agrees(c, expectation) and (told is None or cosine(c.direction, told) >= POINTED) for c in causes
        ):
            yield edits.point(case, causes)
    if expectation.kind is not MotionKind.FALL:
        mistimed = [c for c in causes if edits.is_mistimed(case, c)]
        whole = expectation.kind is not MotionKind.SWAY and len(causes) == 1
        if mistimed and whole and (change := edits.retime(case, mistimed)):
            yield change
    amount = case.failed("amount")
    if amount is not None and (amount.gain or 0.0) >= _FAINT:
        return  # the way of what is hardly seen says little
    if case.failed("direction") and aims:
        if change := edits.counter(case, [c for c in causes if agrees(c, expectation)] or causes):
            yield change


def _change_amount(case: Case, causes: Sequence[Cause]) -> Iterator[Change]:
    """More or less of the same; if too little is asked together with too much, by another kind of skill."""
    check = case.failed("amount") or case.failed("direction")
    spoilt = case.failed("collateral") or case.failed("integrity")
    if check is None and spoilt is None:
        return
    overdone = [c.gain for c in case.checks if c.gain is not None and 0 < c.gain < 1]
    gain = gentler = clamp(min(overdone, default=_GENTLER), 0.3, 0.85)
    if check is not None:
        gain = _find_gain(case, causes, _PUSH_BACK if check.gain is None else check.gain)
    if case.failed("integrity"):  # what breaks is not asked for more
        gain = min(gain, gentler)
    if case.failed("integrity") or (spoilt is not None and gain > 1):
        yield from _try_other_kind(case, causes, gain)
    yield from _strengthen(case, causes, gain) if gain > 1 else _weaken(case, causes, gain)


def _find_gain(case: Case, causes: Sequence[Cause], gain: float) -> float:
    """The factor on the effort: proportional at first, by the secant once two rounds differ in nothing else.

    The secant is taken in logarithms, response = effort ** p: it keeps the sign, and between one that was too little
    and one that was too much it stays between them.
    """
    if gain <= 0:  # the fixed mapping stays: other motion must be overcome
        return _PUSH_BACK
    for ratio, needed in _list_ratios(case, causes):
        exponent = math.log(gain / needed) / math.log(ratio)
        if _EXPONENTS[0] < exponent < _EXPONENTS[1]:
            gain = gain ** (1.0 / exponent)
        if (needed > 1) != (gain > 1):  # one was too little, the other too much
            between = math.log(ratio)
            gain = math.exp(clamp(math.log(gain) / between, 0.15, 0.85) * between)
        return gain
    return gain


def _answers(case: Case, causes: Sequence[Cause], gain: float) -> bool:
    """Return whether more of the same has been seen to do more, as far as rounds that differ in nothing else tell."""
    for ratio, needed in _list_ratios(case, causes):
        if abs(math.log(ratio)) > _TOLD_APART:
            return math.log(gain / needed) / math.log(ratio) >= _EXPONENTS[0]
    return True


def _list_ratios(case: Case, causes: Sequence[Cause]) -> Iterator[tuple[float, float]]:
    """Effort of the same entries in other rounds over the present one, with the gain asked for there; newest first."""
    now = sum(cause.get_effort(case.brief.last) for cause in causes)
    for field, needed in reversed(case.earlier):
        before = _get_same_effort(case, causes, field)
        if before is not None and needed > 0 and abs(math.log(before / now)) >= 0.02:
            yield before / now, needed


def _get_same_effort(case: Case, causes: Sequence[Cause], field: ForceField) -> float | None:
    """The effort of the same entries in another force field; None if it does not have them."""
    wanted = [cause.identity for cause in causes]
    found = [cause for cause in list_causes(field) if cause.identity in wanted]
    if len(found) != len(causes):
        return None
    return sum(cause.get_effort(case.brief.last) for cause in found)


def _strengthen(case: Case, causes: Sequence[Cause], gain: float) -> Iterator[Change]:
    """More of the same, then for longer, then by the other kind of skill; nothing is stacked.

    More of the same comes last where it did no more before, or where it would have to be very much more.
    """
    most = max(abs(c.item.magnitude) * gain / MAGNITUDE_MAX for c in causes)
    more = edits.scale_magnitudes(case, causes, gain)
    more_helps = most <= _FAR_BEYOND and _answers(case, causes, gain)
    if more_helps:
        yield more
    lasting = any(c.group == "actions" and not (c.skill.is_sudden or c.skill.is_two_sided) for c in causes)
    if lasting and case.expectation.kind is not MotionKind.SWAY:
        yield from edits.lengthen(case, causes, math.sqrt(gain))
    yield from _try_other_kind(case, causes, gain)
    if not more_helps:
        yield more
    yield edits.scale_magnitudes(case, causes, MAGNITUDE_MAX / MAGNITUDE_MIN)


def _try_other_kind(case: Case, causes: Sequence[Cause], gain: float) -> Iterator[Change]:
    """Velocity constraints in place of a body force that does not do it."""
    expectation, whole = case.expectation, not case.expectation.partial
    forces = [c for c in causes if c.group == "actions" and c.skill.prescribed_by]
    stretches = [c for c in forces if c.skill.is_two_sided and c.item.region is None]
    if stretches and expectation.direction is not None and whole:
        cannot = f"{edits.format_names(stretches)} cannot do it:"
        if expectation.kind is MotionKind.SQUEEZE:
            field = kinds.press_between(case, stretches)
            yield Change(field, f"{cannot} it is pressed between plates instead.")
        why = f"{cannot} two opposed translations of the end slabs instead."
        yield Change(kinds.move_ends(case, stretches), why, "paired_translation")
    blows = [c for c in forces if c.skill.is_sudden]
    if blows:
        why = f"{edits.format_names(blows)} becomes an instantaneous change of velocity."
        yield Change(kinds.replace_blows(case, blows), why, "brief_impulse")
    pushes = [c for c in forces if c.pushes]
    way, up = expectation.direction, case.brief.directions.up
    sinks = case.brief.world == "ground" and way is not None and cosine(way, up) < -_STEEP  # into the ground
    if pushes and expectation.kind is MotionKind.MOVE and case.brief.anchored is None and whole and not sinks:
        yield edits.enforce(case, pushes, gain)


def _weaken(case: Case, causes: Sequence[Cause], gain: float) -> Iterator[Change]:
    """Less of the same down to the limit, then for a shorter time; blows become brief pushes."""
    yield edits.scale_magnitudes(case, causes, gain)
    impulses = [c for c in causes if c.group == "actions" and c.skill.is_sudden]
    if impulses:
        yield edits.soften(case, impulses)
    lasting = [c for c in causes if not c.skill.is_sudden and not c.skill.prescribes]
    if lasting and case.expectation.kind is not MotionKind.SWAY:  # pushes to and fro follow each other
        why = "the weakest push is still too much"
        yield edits.shorten(case, lasting, clamp(math.sqrt(gain), 0.3, 0.9), why)
    yield edits.scale_magnitudes(case, causes, MAGNITUDE_MIN / MAGNITUDE_MAX)


def _replace(case: Case, causes: Sequence[Cause], new: Sequence[Action]) -> ForceField:
    """The first new action in place of the first cause, and the others after all that is left."""
    field = replace_items(case.force_field, causes, [*new[:1], *[None] * (len(causes) - 1)])
    return field.model_copy(update={"actions": (*field.actions, *new[1:])})


def _switch_type(case: Case) -> Iterator[Change]:
    """A discrete leap: the action has the wrong kind of effect and becomes the skill that has the right one."""
    wrong = find_misfits(case.expectation, case.expectations, case.force_field)
    if wrong:
        new, kind = edits.make_actions(case), case.expectation.kind.value
        cannot = f"{edits.format_names(wrong)} ({wrong[0].skill.name}) cannot make it {kind}"
        why = f"{cannot}: replaced by {new[0].action_type}."
        field = kinds.choose_kinds(_replace(case, wrong, new), [case.expectation], case.brief).force_field
        yield Change(field, why, "known_skills")


def _add(case: Case) -> Change:
    """A new action, of the kind that the sentence calls for."""
    new = edits.make_actions(case)
    field = case.force_field.model_copy(update={"actions": (*case.force_field.actions, *new)})
    field = kinds.choose_kinds(field, [case.expectation], case.brief).force_field
    why = f"Nothing made it {case.expectation.kind.value}: {new[0].action_type} is added."
    return Change(field, why, "sentence_direction")


def _calm(case: Case) -> Iterator[Change]:
    """Stillness: nothing acts in the window; what drifts on is stopped by a blow against its motion."""
    falls = any(e.kind is MotionKind.FALL for e in case.expectations)
    if case.force_field.default_drop and not falls:
        field = case.force_field.model_copy(update={"default_drop": False})
        yield Change(field, "It is not let fall: it should be still.")
    active = find_misfits(case.expectation, case.expectations, case.force_field)
    if active:
        yield edits.remove(case, active, "it should be still")
    first, last = round_window(case.expectation, case.brief.frame_count)
    if case.brief.anchored is not None:  # a held object swings on rather than drifts: let it settle
        causes = list_causes(case.force_field)
        before = [c for c in causes if c.item.active_time and c.item.active_time[0] < first]
        yield edits.shorten(case, before, 0.8, "it should be still afterwards")
        return
    window = case.seen_window
    if window is None or window.displacement is None or norm(window.displacement) < 1e-3 or last - first < 1:
        return
    speed = norm(window.displacement) * case.brief.last / (last - first)  # [body lengths per clip]
    brake = Action(
        action_type=find_action_type(MotionKind.MOVE, sudden=True),
        vector=scale(window.displacement, -1.0),
        magnitude=round(clamp(speed / TRAVEL, MAGNITUDE_MIN, MAGNITUDE_MAX), 4),
        active_time=(float(first), first + 1.0),
    )
    why = "It drifts on: a blow against its motion stops it."
    yield Change(case.force_field, why).adding(actions=[brake])
