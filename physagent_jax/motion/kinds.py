"""The kind of skill that carries out a motion: a body force, or velocity constraints.

A force lets the object answer as it likes, and what comes of it depends on stiffness, weight and whatever opposes. A
velocity constraint brings about the stated motion whatever opposes, and looks like what it is: something that grips,
presses or hits. The table is `docs/skills.md`, with what each kind was measured to do in `docs/executor.md`. Which
constraint does a force's work, the force's skill says (`Skill.prescribed_by`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import (
    BLOW,
    GAIN_MAX,
    GAIN_MIN,
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    PRESCRIBED_TRAVEL,
    QUICK,
    TRAVEL,
    TURN,
    find_magnitude,
)
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.schema import (
    Action,
    ActionType,
    Bend,
    CellsRegion,
    ConstraintType,
    ForceField,
    Region,
    VelocityConstraint,
)
from physagent_jax.forces.skills import list_skills
from physagent_jax.forces.slabs import make_end_region
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.breaking import let_go_of_pieces
from physagent_jax.motion.efforts import (
    MOVING,
    find_pace,
    find_spin,
    find_spin_time,
    find_strain,
    find_wanted_way,
    spread_effort,
)
from physagent_jax.motion.hinges import find_box
from physagent_jax.motion.landing import list_rebounds
from physagent_jax.motion.limbs import sum_directions
from physagent_jax.motion.matching import (
    AXIAL,
    Cause,
    agrees,
    find_own_causes,
    is_turned_against,
    list_causes,
    share_line,
    share_time,
)
from physagent_jax.motion.pressing import find_pressed
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.slashing import find_grip
from physagent_jax.motion.tolerances import SPIN, expect_rotation, expect_wrung, find_told
from physagent_jax.motion.vectors import add, clamp, cosine, cross, norm, normalise, scale
from physagent_jax.motion.windows import divide, make_impulse_window
from physagent_jax.motion.wishes import Wish, replace_items

SLAB = 0.75  # where a gripped end begins, as a fraction of the extent; a thinner one tears off what tapers
TURNING = 0.8  # the same of an end that is turned
_VERTICAL = 0.7  # cosine
_OVER = 120.0  # [degrees] about a level line, from where on something is turned over
_TILT = 60.0  # [degrees] up to which what stands is tilted
_PRESSED = 0.07  # of its height, by which a plain blow presses what stands: held at its feet, twice as deep
_UPENDED = 95.0  # [degrees] the same of an angle that is told
_UPRIGHT = 90.0  # [degrees] by which what lies is set up on an edge
_RAISED = 20.0  # [degrees] by which it is tilted where one side is raised
_CRUMPLED = [1.0, 1.5]  # shares of the time in which it is pressed from both sides, and from above alone
_SPUN = 0.9  # of the most of its word that what lies spins by about its own line: less is hardly seen of what is slim
_CIRCLE = 0.8  # [body lengths] radius of a circle that it goes along, at most
_SMALL_CIRCLE = 0.3  # the same, below which there is no room for one
_REST = 0.4  # [s] for which what was spun where it stands is then seen to stand
_LEVELLED = 0.1  # of its largest turn, below which it is level again
_ASKEW = 10.0  # [degrees] up to which it lies on one of its sides
_LOWERED = 0.75  # of the way that it was lifted, by which what was turned is carried down: its middle is elsewhere now
_LEVELLING = 0.4  # of the time in which it is set down, in which it is turned back first
_ALONG_LIMB = 0.4  # cosine of a stretch to a limb from which on it is drawn out along itself
_AROUND = 2.0  # [body lengths]: all of a limb's joint, and all of its length
_LENGTHENED = 0.5  # of its length, by which a plain word draws a limb out
_LONGER = 0.15  # [body lengths] the same at least, but no more than it is long
_DRAWN_BACK, _SLASHED = 0.7, 0.4  # [s] in which something is drawn back, and slashes with a strength of 1
_PARTED, _ASIDE, _PARTING = (
    0.22,
    0.5,
    0.4,
)  # [body lengths] that halves are led, or a top aside, and [s] in which
_RAISED_TOP = 0.4  # of its way aside, by which a top is raised
_SETTLED = 0.35  # [s] that what splits rests before, after another motion
_DRAWN_OUT, _SNAP = 1.0, 0.2  # [s] in which it is drawn out, at most, and snaps back
_NO_WAY = (0.0, 0.0, 0.0)
_PLATE = next(skill.name for skill in list_skills("constraints") if skill.deforms == "plates")


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

    ``brief`` holds what the sentence says about holding.
    """
    reasons: list[str] = []
    for expectation in expectations:
        wish = Wish(force_field, expectation, expectations, brief)
        replaced = next((found for rule in _RULES if (found := rule(wish)) is not None), None)
        if replaced is not None:
            force_field, why = replaced
            reasons.append(f"'{expectation.words}': {why}.")
    return Choice(let_go_of_pieces(force_field), tuple(reasons))


_Replaced = tuple[ForceField, str] | None


def move_ends(wish: Wish, causes: Sequence[Cause]) -> ForceField:
    """Exactly two opposed translations of the end slabs in place of ``causes`` (paper, appendix B.2)."""
    axis = wish.expectation.direction or causes[0].item.vector
    outward = 1.0 if wish.expectation.kind is MotionKind.STRETCH else -1.0
    travel = _find_travel(wish, causes)
    pair = [
        _prescribe(causes[0], scale(axis, side * outward), *travel, make_end_region(scale(axis, side), SLAB))
        for side in (1.0, -1.0)
    ]
    return _put(wish, causes, *pair)


def press_between(wish: Wish, causes: Sequence[Cause]) -> ForceField:
    """Two opposed plates in place of ``causes``; one against the ground or the fixture, where there is one."""
    axis, brief = wish.expectation.direction or causes[0].item.vector, wish.brief
    ways = (axis, scale(axis, -1.0))
    if _stands_on_its_end(wish, axis):
        free = brief.directions.up if "top" in (brief.anchored or "") else brief.directions.down
        ways = (axis if cosine(axis, free) > 0 else scale(axis, -1.0),)
    travel = _find_travel(wish, causes, movers=len(ways))
    region = causes[0].item.region
    return _put(wish, causes, *[_prescribe(_PLATE, way, *travel, region) for way in ways])


def replace_blows(wish: Wish, causes: Sequence[Cause]) -> ForceField:
    """Instantaneous changes of velocity in place of ``causes``, with the same magnitudes."""
    told = {"vector", "magnitude", "active_time", "region", "object", "touched"}
    return _put(wish, causes, *[cause.prescribe(**cause.item.model_dump(include=told)) for cause in causes])


def _prescribe(
    by: Cause | str,
    way: Vector,
    magnitude: float,
    window: tuple[float, float],
    kept: float | None,
    region: Region | None = None,
) -> VelocityConstraint:
    """The velocity constraint that does the work of a force, held until ``kept`` where that is after its window."""
    name = by if isinstance(by, str) else by.skill.prescribed_by or by.skill.name
    size = math.copysign(clamp(abs(magnitude), MAGNITUDE_MIN, MAGNITUDE_MAX), magnitude)
    return VelocityConstraint(
        constraint_type=ConstraintType(name),
        vector=way,
        magnitude=round(size, 4),
        gain=round(clamp(magnitude / size, GAIN_MIN, GAIN_MAX), 4),
        active_time=window,
        held_until=kept if kept is not None and kept > window[1] else None,
        region=region,
    )


def _put(wish: Wish, causes: Sequence[Cause], *constraints: VelocityConstraint) -> ForceField:
    field = replace_items(wish.force_field, causes, [None] * len(causes))
    # A limb comes on top of what carries it, and so after that.
    rest, limbs = ([e for e in field.constraints if e.carried == on_top] for on_top in (False, True))
    return field.model_copy(update={"constraints": (*rest, *constraints, *limbs)})


def _find_next(wish: Wish, end: float) -> float:
    """Frame at which the next motion begins, or the clip's last."""
    return min([begin for begin in wish.list_other_begins() if begin >= end - 0.5], default=wish.brief.last)


def _find_hold_end(wish: Wish, end: float) -> float:
    """Until when what is brought somewhere by frame ``end`` is kept there: until the next motion, if it is to stay."""
    still = [e for e in wish.expectations if e.kind is MotionKind.STILL and abs(e.window[0] - end) < 1.5]
    if still and not wish.expectation.stays:
        return max(end, min(still[0].window[1], wish.brief.last))  # "it crouches, waits a second, leaps"
    return max(end, _find_next(wish, end)) if wish.expectation.stays else end


def _find_travel(
    wish: Wish, causes: Sequence[Cause], *, movers: int = 2
) -> tuple[float, tuple[float, float], float]:
    """Magnitude, window, and until when to hold, with which ``movers`` ends change the extent as the sentence asks.

    They move in the first part of the cause's window and are held in the rest of it, and for as long as it is to stay.
    What was deformed the other way just before is brought back first.
    """
    expectation, (first, end) = wish.expectation, wish.get_span(causes[:1])
    end = min(end, wish.brief.last)
    target = find_strain(expectation, wish.brief)
    target += sum(
        find_strain(each, wish.brief)
        for each in wish.expectations
        if each.kind in AXIAL and each.kind is not expectation.kind and not each.released
        if abs(each.window[1] - first) < 1.5 and share_line(each, expectation)
    )
    effort = target * wish.reference / (movers * PRESCRIBED_TRAVEL)  # magnitude times frames
    magnitude, until = spread_effort(effort, first, end)
    if expectation.sudden:
        until = first + max(round(wish.brief.count_frames(BLOW)), 2.0)
        return effort / (until - first), (first, until), _find_hold_end(wish, until)
    return magnitude, (first, until), _find_hold_end(wish, end)


def _stands_on_its_end(wish: Wish, axis: Vector) -> bool:
    """Return whether the ground or a fixture is at one end of ``axis``: only the other end can then be moved freely."""
    bound = wish.brief.world == "ground" or wish.brief.anchored is not None
    return bound and abs(cosine(axis, wish.brief.directions.up)) > _VERTICAL


def _stands_alone(wish: Wish) -> bool:
    """Return whether the object stands on the ground as it was captured, and nothing else moves it."""
    grounded = wish.brief.world == "ground" and not wish.force_field.default_drop
    return grounded and not wish.list_other_begins()


def _stands_after_moving(wish: Wish) -> bool:
    """Return whether the object stands on the ground until the next motion, upright again whatever it did before."""
    first, end = wish.expectation.window
    others, up = wish.list_others(), wish.brief.directions.up
    before = [e for e in others if e.window[1] <= first + 0.5]
    tilts = [
        e for e in before if e.kind is MotionKind.ROTATE and abs(cosine(e.direction or up, up)) < _VERTICAL
    ]
    level = all(_stays_level(e, up) for e in before if e not in tilts)
    level &= all(e.released or e.put_back for e in tilts[-1:])
    after = all(e in before or e.window[0] >= end - 0.5 for e in others)
    return level and after and wish.brief.world == "ground" and not wish.force_field.default_drop


def _stays_level(motion: ExpectedMotion, up: Vector) -> bool:
    """Return whether a motion leaves the object upright on the ground: along it, about the upright, or a hop."""
    cosine_up = cosine(motion.direction or up, up)
    if motion.kind is MotionKind.MOVE:
        return abs(cosine_up) < _VERTICAL or motion.sudden and cosine_up > 0
    return motion.kind in (MotionKind.FALL, MotionKind.ROTATE)


def _stands_again(wish: Wish) -> bool:
    """Return whether the object stands on the ground, from which it has leapt before at most, until it goes on."""
    first, end = wish.expectation.window
    leaps = [e for e in wish.list_others() if e.window[0] < end - 0.5]
    grounded = wish.brief.world == "ground" and not wish.force_field.default_drop
    return grounded and all(
        e.window[1] <= first + 0.5
        and (
            e.kind is MotionKind.FALL
            or e.sudden
            and cosine(e.direction or _NO_WAY, wish.brief.directions.up) > _VERTICAL
        )
        for e in leaps
    )


def _find_forces(wish: Wish, keep: Callable[[Cause], bool]) -> list[Cause]:
    """Forces of the wish's own whose work a constraint can do, of those to ``keep``; none if none goes its way."""
    causes = find_own_causes(wish.expectation, wish.expectations, wish.force_field)
    found = [c for c in causes if c.group == "actions" and c.skill.prescribed_by and keep(c)]
    return found if any(agrees(c, wish.expectation) for c in found) else []


def _is_first(wish: Wish, causes: Sequence[Cause]) -> bool:
    """Return whether nothing moves the object before."""
    return wish.get_span(causes[:1])[0] < 1 and not wish.force_field.default_drop


def _lies_below(wish: Wish, axis: Vector) -> bool:
    """Return whether a plate from above meets it wherever it has gone on the ground by then."""
    begins = wish.expectation.window[0]
    raised = [
        e for e in wish.list_others() if cosine(e.direction or _NO_WAY, wish.brief.directions.up) > _VERTICAL
    ]
    up = any(e.kind is MotionKind.MOVE and not e.sudden and e.window[0] < begins for e in raised)
    return _stands_on_its_end(wish, axis) and wish.brief.world == "ground" and not up


def _deform(wish: Wish) -> _Replaced:
    """A stretch by its two ends; a squeeze between plates if nothing moves the object before, else by its ends."""
    expectation, axis = wish.expectation, wish.expectation.direction
    if expectation.kind not in AXIAL or expectation.partial or expectation.part is not None or axis is None:
        return None
    causes = _find_forces(wish, lambda c: c.item.region is None and agrees(c, expectation))
    if not causes:
        return None
    upright = _stands_on_its_end(wish, axis)
    pulled = any(e.kind is MotionKind.STRETCH and share_line(e, expectation) for e in wish.expectations)
    if expectation.kind is MotionKind.STRETCH:
        why = "the two ends are moved apart, whatever the stiffness"
    elif (not pulled or upright) and (_is_first(wish, causes) or _lies_below(wish, axis)):
        return press_between(wish, causes), "it is pressed between plates, not pulled inwards at every point"
    else:
        where = "as they are moved apart in turn" if pulled else "wherever it is by then"
        why = f"the two ends are moved together, {where}"
    held = wish.brief.anchored is not None or wish.force_field.default_drop
    return None if upright and held else (move_ends(wish, causes), why)


def _split(wish: Wish) -> _Replaced:
    """Lead two halves apart, as far as the grid's kernels reach, and let them go: to both sides, or the top off.

    What is split across the upright lies beside the rest in the end: on it, it would be seen as whole. How far it has
    rolled or spun before is not known, and so it is split across the axis of that.
    """
    expectation, axis, table = wish.expectation, wish.expectation.direction, wish.brief.directions
    if expectation.manner != "split" or axis is None or expectation.partial:
        return None
    causes = _find_forces(wish, lambda c: c.item.region is None and agrees(c, expectation))
    if not causes:
        return None
    first, end = wish.get_span(causes[:1])
    turned = [
        e.direction
        for e in wish.expectations
        if e.kind is MotionKind.ROTATE and e.limb is None and e.window[1] < first + 0.5
    ]
    axis = next((each for each in turned[-1:] if each), axis)
    first += (
        min(wish.brief.count_frames(_SETTLED), 0.3 * (end - first)) if first > 0 else 0.0
    )  # it has landed
    span = (first, first + min(max(round(wish.brief.count_frames(_PARTING)), 2.0), max(end - first, 2.0)))
    box, back = find_box(wish.brief), scale(axis, -1.0)
    upright = abs(cosine(axis, table.up)) > _VERTICAL
    ways = [(table.up, normalise(add((table.right, scale(table.up, _RAISED_TOP)))) or axis)]
    led = []
    for side, way in ways if upright else [(axis, axis), (back, back)]:
        width = sum(abs(x) * extent for x, extent in zip(way, box))
        length = _ASIDE if upright else _PARTED
        pace = length / width * wish.reference / PRESCRIBED_TRAVEL / (span[1] - span[0])
        led.append(_prescribe(causes[0], way, pace, span, None, _make_half(side, box)))
    if upright:  # sheared, the rest would go along
        least = MAGNITUDE_MIN * GAIN_MIN
        rest = _make_half(scale(table.up, -1.0), box)
        led.append(_prescribe(causes[0], table.up, least, (first, first + 1.0), span[1], rest))
    return _put(wish, causes, *led), "its halves are led apart, and let go"


def _make_half(side: Vector, box: Vector) -> CellsRegion:
    """All that lies on one side of its middle, as a piece of its own."""
    x, y, z = (0.25 * min(box) * along / extent for along, extent in zip(side, box))
    inside, outside = ((0.5 + sign * x, 0.5 + sign * y, 0.5 + sign * z) for sign in (1, -1))
    return CellsRegion(inside=(inside,), outside=(outside,), label="half of it", rigid=True)


def _crumple(wish: Wish) -> _Replaced:
    """Press what is crumpled from one side after another: evenly from all at once it would only get smaller.

    Plates before and behind it would hide it.
    """
    expectation, table = wish.expectation, wish.brief.directions
    if expectation.manner != "crumple" or expectation.direction is not None or expectation.partial:
        return None
    field, axes = wish.force_field, (table.right, table.up)
    for part, axis in zip(divide(expectation.window, _CRUMPLED), axes):
        there = expectation.model_copy(update=dict(direction=axis, stays=True, strength=MAGNITUDE_MAX))
        pressed = replace(wish.about(there), force_field=field)
        causes = [c for c in _find_forces(pressed, lambda c: c.item.region is None) if agrees(c, there)]
        causes = [c for c in causes if abs(cosine(c.item.vector, axis)) > _VERTICAL]
        if not causes:
            return None
        timed = replace_items(
            field, causes, [c.item.model_copy(update=dict(active_time=part)) for c in causes]
        )
        moved = [Cause(c.group, c.index, getattr(timed, c.group)[c.index]) for c in causes]
        field = press_between(replace(pressed, force_field=timed), moved)
    depth = _find_forces(replace(wish, force_field=field), lambda c: c.item.region is None)
    field = replace_items(field, depth, [None] * len(depth))
    return field, "it is pressed from one side after another"


def _press_part(wish: Wish) -> _Replaced:
    """A part of what stands is pressed down, or a side is dented: what is pressed is moved, as a hand would."""
    expectation, brief = wish.expectation, wish.brief
    if expectation.kind is not MotionKind.SQUEEZE or brief.world != "ground":
        return None
    if "top" in (brief.anchored or "") or wish.force_field.default_drop:
        return None
    causes = _find_forces(wish, lambda c: agrees(c, expectation))
    pressed = find_pressed(expectation, brief, causes[0].item.region, SLAB) if causes else None
    if pressed is None:
        return None
    way, region, share = pressed
    there = expectation.model_copy(update={"partial": False, "part": None})  # as deep as if all were pressed
    travel = _find_travel(wish.about(there), causes, movers=1)
    hand = _prescribe(ConstraintType.PARTICLE_TRANSLATION, way, share * travel[0], *travel[1:], region)
    return _put(wish, causes, hand), "what is pressed there is moved, whatever the stiffness"


def _squeeze_limb(wish: Wish) -> _Replaced:
    """A limb is squeezed between two plates of its size."""
    if wish.expectation.kind is not MotionKind.SQUEEZE or wish.expectation.limb is None:
        return None
    causes = _find_forces(wish, lambda c: c.item.region is not None and agrees(c, wish.expectation))
    whole = wish.expectation.model_copy(update={"partial": False, "strength": MAGNITUDE_MAX})
    if not causes:
        return None
    return press_between(wish.about(whole), causes), "it is squeezed between two plates of its size"


def _stretch_limb(wish: Wish) -> _Replaced:
    """A limb that sticks out is drawn out along itself, from its joint on: a force would draw all of the object out."""
    here, brief = wish.expectation, wish.brief
    if here.kind is not MotionKind.STRETCH or here.limb is None or here.repeats > 1:
        return None
    part = brief.parts[here.limb]
    long, causes = norm(part.arm), _find_forces(wish, lambda c: c.item.region is not None and agrees(c, here))
    if part.seated or not causes or abs(cosine(part.arm, here.direction or part.arm)) < _ALONG_LIMB:
        return None
    first, end = wish.get_span(causes)
    drawn, back = (max(float(round(brief.count_frames(each))), 2.0) for each in (_DRAWN_OUT, _SNAP))
    until, driver = min(end, first + drawn), PartDriver(part, brief.frame_dt, brief.frame_count)
    place = Bend(joint=part.joint, rest=part.rest, reach=_AROUND, depth=min(long, _AROUND))
    goes, way = here.released and end + back <= brief.last, scale(part.arm, 1.0 / long)
    kept = end if goes else _find_next(wish, end)
    spans = [(way, (first, until), kept if kept > until else None)]
    spans += [(scale(way, -1.0), (end, end + back), None)] if goes else []
    least = max(_LENGTHENED * long, min(_LONGER, long)) * here.strength  # of one limb, less is hardly seen
    length = max(find_strain(here, brief) * long, 0.0 if here.amount else least)
    made = [driver.shift(each, length, span, stop) for each, span, stop in spans]
    own = part.moved.model_copy(update=dict(rigid=False))  # a piece of its own gets longer as well
    made = [each.model_copy(update=dict(bend=place, region=own)) for each in made]
    return _put(wish, causes, *made), "it is drawn out along itself" + ", and snaps back" * goes


def _turn_ends(wish: Wish) -> _Replaced:
    """One end turned against the other, or against what holds that; a torque on each half would shear it."""
    here = wish.expectation
    turned = [each for each in wish.expectations if each is here or is_turned_against(here, each)]
    line = abs(cosine(here.part or _NO_WAY, here.direction or _NO_WAY))
    wrung = wish.brief.anchored and here.repeats == 1 and here.limb is None and line > _VERTICAL
    if here.kind is not MotionKind.ROTATE or not (wrung or len(turned) == 2):
        return None
    found = [_find_forces(wish.about(e), lambda c, e=e: bool(c.item.region) and agrees(c, e)) for e in turned]
    if not all(found):
        return None
    ends = [_make_turn(wish.about(each), causes[0]) for each, causes in zip(turned, found)]
    taken = [causes[0] for causes in found]
    return _put(wish, taken, *ends), "one end is turned against the other, all between in proportion"


def _make_turn(wish: Wish, cause: Cause) -> VelocityConstraint:
    expectation, (first, end), size = wish.expectation, wish.get_span([cause]), cause.item.magnitude
    end, told = min(end, wish.brief.last), expectation.amount
    effort = abs(size) * TURNING * (end - first)
    if told is not None and told.unit == "degrees" or wish.brief.anchored:
        effort = math.radians(expect_wrung(expectation, wish.brief)) / TURN * wish.reference
    amount, until = spread_effort(effort, first, end, TURNING)
    way, region = cause.item.vector, make_end_region(expectation.part or _NO_WAY, SLAB)
    kept = _find_hold_end(wish, end)
    return _prescribe(cause, way, math.copysign(amount, size), (first, until), kept, region)


def _strike(wish: Wish) -> _Replaced:
    """A blow on a part, or on what is held, acts at once; one on top of what stands presses it."""
    expectation, brief = wish.expectation, wish.brief
    blows = _find_forces(wish, lambda c: c.skill.is_sudden and agrees(c, expectation))
    if not expectation.sudden or not blows:
        return None
    stands = cosine(expectation.direction or _NO_WAY, brief.directions.down) >= _VERTICAL
    stands &= brief.world == "ground" and not wish.force_field.default_drop
    stands &= "top" not in (brief.anchored or "")
    causes = [c for c in blows if c.item.region is not None or (brief.anchored and not stands)]
    if causes:
        return replace_blows(wish, causes), "it changes the velocity at once, before the rest can answer"
    if not stands:
        return None
    effort = (1 + bool(brief.anchored)) * _PRESSED * wish.reference / PRESCRIBED_TRAVEL
    frames = max(float(round(brief.count_frames(BLOW))), 2.0)
    spans = [(cause.item.magnitude * effort / frames, wish.get_span([cause])[0]) for cause in blows]
    plates = [_prescribe(_PLATE, brief.directions.down, size, (at, at + frames), None) for size, at in spans]
    return _put(wish, blows, *plates), "the ground bears it, so it is pressed for a moment"


def _raise_side(wish: Wish) -> _Replaced:
    """One side of what stands is raised: it is tilted over its foot, and let go where it is to fall."""
    expectation, brief, side = wish.expectation, wish.brief, wish.expectation.part
    raised = cosine(expectation.direction or _NO_WAY, brief.directions.up) > _VERTICAL
    if expectation.kind is not MotionKind.MOVE or side is None or not raised or expectation.limb is not None:
        return None
    level = abs(cosine(side, brief.directions.up)) < 1 - _VERTICAL and not expectation.excludes_part
    causes = _find_forces(wish, lambda c: c.pushes and c.item.region is not None)
    if not level or not causes or brief.world != "ground" or brief.anchored is not None:
        return None
    first, end = wish.get_span(causes)
    effort = math.radians(_RAISED * expectation.strength) / TURN * wish.reference
    size, until = spread_effort(effort, first, end)
    axis = find_lean_axis(scale(side, -1.0), brief)
    hand = _prescribe(ConstraintType.PARTICLE_ROTATION, axis, size, (first, until), _find_next(wish, end))
    return _put(wish, causes, hand), "one side is raised, so it is tilted over its foot"


def _carry(wish: Wish) -> _Replaced:
    """Carry what is raised from the ground and then kept up, since a force would let it tip.

    Only where something is to come after: what is raised and no more may be pushed up to the clip's end.
    """
    expectation, brief, way = wish.expectation, wish.brief, wish.expectation.direction
    if expectation.kind is not MotionKind.MOVE or way is None or cosine(way, brief.directions.up) < _VERTICAL:
        return None
    if brief.world != "ground" or brief.anchored is not None or expectation.sudden or expectation.partial:
        return None
    after = [e for e in wish.expectations if e.window[0] >= expectation.window[1] - 0.5]
    rests = any(e.kind is MotionKind.STILL and e.window[0] < expectation.window[1] + 1.5 for e in after)
    causes = _find_forces(wish, lambda c: c.pushes)
    if not (after or expectation.stays) or not causes or any(c.item.region is not None for c in causes):
        return None
    first, end = wish.get_span(causes)
    effort = (
        find_wanted_way(wish.expectation, brief, (end - first) * brief.frame_dt)
        / PRESCRIBED_TRAVEL
        * wish.reference
    )
    magnitude, until = find_pace(effort, first, end)
    moves = [e.window[0] for e in after if e.kind is not MotionKind.STILL]
    kept = min([*moves, wish.brief.last]) if expectation.stays or rests else end
    hand = _prescribe(causes[0], way, magnitude, (first, until), kept)
    return _put(wish, causes, hand), "it is carried up, and kept there"


def _find_hand(wish: Wish, first: float) -> list[Cause]:
    """The constraint that holds all of what was raised until a frame; none if nothing does."""
    hands = [cause for cause in list_causes(wish.force_field) if cause.carries]
    hands.sort(key=lambda hand: hand.lets_go)
    return [hand for hand in hands[-1:] if _list_lifts(wish) and abs(hand.lets_go - first) < 1.5]


def _find_upended(wish: Wish, first: float) -> list[Cause]:
    """The turn that holds until a frame what it has set up on an edge, from which it would fall; none if none does."""
    stood = [e for e in wish.list_others() if e.amount and e.manner == "rock" and e.amount.value == _UPRIGHT]
    hands = [each for each in list_causes(wish.force_field) if each.carries and each.skill.is_axis]
    return [hand for hand in hands[-1:] if stood and abs(hand.lets_go - first) < 1.5]


def _list_lifts(wish: Wish) -> list[Cause]:
    """The constraints that raise all of the object."""
    moves = [each for each in list_causes(wish.force_field) if each.carries and each.skill.deforms]
    return [each for each in moves if cosine(each.item.vector, wish.brief.directions.up) > _VERTICAL]


def _hold_until(wish: Wish, hands: list[Cause], frame: float) -> Wish:
    """The wish with hands that keep what they carry until a frame, if that is after their own time."""
    held = [
        hand.item.model_copy(update={"held_until": frame if frame > wish.get_span([hand])[1] else None})
        for hand in hands
    ]
    return replace(wish, force_field=replace_items(wish.force_field, hands, held))


def _set_down(wish: Wish) -> _Replaced:
    """Carry down what was carried up and goes down again without falling, as far as it was up."""
    expectation, brief, down = wish.expectation, wish.brief, wish.brief.directions.down
    if expectation.kind is not MotionKind.MOVE or cosine(expectation.direction or _NO_WAY, down) < _VERTICAL:
        return None
    if expectation.sudden or expectation.partial or expectation.amount is not None:
        return None
    lifts = _list_lifts(wish)
    causes = _find_forces(wish, lambda c: c.pushes)
    if not lifts or not causes:
        return None
    (first, end), (begun, stopped) = wish.get_span(causes[:1]), wish.get_span(lifts[-1:])
    hands = _find_hand(wish, first) or lifts[-1:]
    moves = wish.list_other_begins() if hands[0].name == lifts[-1].name else []
    if stopped > first + 0.5 or any(stopped - 0.5 < begin < first + 0.5 for begin in moves):
        return None  # what moves it meanwhile needs it free
    tilt, turned = _find_tilt(wish, stopped, first)
    degrees, levelled, back = abs(turned) * math.degrees(TURN) / wish.reference, first, []
    effort, quarters = lifts[-1].item.magnitude * (stopped - begun), round(degrees / 90.0)
    if tilt is not None and abs(degrees - 90.0 * quarters) < _ASKEW:  # it is to stand on that side
        width, height, depth = brief.extents
        across = abs(cosine(tilt.item.vector, brief.directions.right))
        lying = across * depth + (1.0 - across) * width if quarters % 2 else height
        effort += 0.5 * (height - lying) * wish.reference / PRESCRIBED_TRAVEL
        effort *= _LOWERED if quarters % 4 else 1.0
    elif tilt is not None:  # set down as it was tilted, it would go into the ground
        levelled = first + _LEVELLING * (end - first)
        hand = _prescribe(tilt, tilt.item.vector, -turned / (levelled - first), (first, levelled), None)
        back.append(hand)
    magnitude, until = spread_effort(effort, levelled, end)
    lowering = _prescribe(causes[0], down, magnitude, (levelled, until), None)
    field = _put(_hold_until(wish, hands, first), causes, *back, lowering)
    return field, f"it is {'turned back and ' * len(back)}carried down again"


def _bounce(wish: Wish) -> _Replaced:
    """Throw up again what falls from where it was carried to, and bounces."""
    expectation, brief, lifts = wish.expectation, wish.brief, _list_lifts(wish)
    if expectation.kind is not MotionKind.FALL or not expectation.rebounds or not lifts:
        return None
    (begun, stopped), (first, last) = wish.get_span(lifts[-1:]), expectation.window
    lift = lifts[-1].item
    height = lift.magnitude * lift.gain * (stopped - begun) * PRESCRIBED_TRAVEL / wish.reference
    leaps, _ = list_rebounds(height, expectation.rebounds, last - first, brief)
    kicks, field = [], wish.force_field
    for begin, rise in leaps:
        size = clamp(rise, MAGNITUDE_MIN, MAGNITUDE_MAX)
        kick = Action(
            action_type=ActionType.IMPULSE,
            vector=brief.directions.up,
            magnitude=round(size, 4),
            gain=round(clamp(rise / size, GAIN_MIN, GAIN_MAX), 4),
            active_time=make_impulse_window(first + begin),
        )
        kicks.append(kick)
    return field.model_copy(
        update={"actions": (*field.actions, *kicks)}
    ), "it is thrown up again where it lands"


def _find_tilt(wish: Wish, lifted: float, first: float) -> tuple[Cause | None, float]:
    """The cause that tilted it in the air until frame ``first``, and the effort of all that did; 0 if it is level."""
    up, efforts, tilt = wish.brief.directions.up, [0.0], None
    for cause in list_causes(wish.force_field):
        begin, stop = cause.item.active_time or (0.0, 0.0)
        tilts = cause.carries and cause.skill.is_axis and abs(cosine(cause.item.vector, up)) < _VERTICAL
        if tilts and lifted - 0.5 < begin < first - 0.5:
            tilt = tilt or cause
            effort = cause.item.magnitude * cause.item.gain * (stop - begin)
            efforts.append(effort * cosine(cause.item.vector, tilt.item.vector))
    total = sum(efforts)
    return tilt, total if abs(total) >= _LEVELLED * max(map(abs, efforts)) else 0.0


def _tilt_back(wish: Wish) -> _Replaced:
    """Bring back what was tilted over its foot, as far as it was; or beyond, to the other side."""
    expectation, way = wish.expectation, wish.expectation.direction
    back, aside = expectation.put_back, expectation.manner == "rock"
    if expectation.kind is not MotionKind.ROTATE or not (back or aside) or expectation.amount or not way:
        return None
    causes = _find_forces(wish, lambda c: c.item.region is None)
    if not causes:
        return None
    first, end = wish.get_span(causes)
    hands = [each for each in list_causes(wish.force_field) if each.carries and each.skill.is_axis]
    hands = [
        e for e in hands if wish.get_span([e])[0] < first and abs(cosine(e.item.vector, way)) > _VERTICAL
    ]
    tilted = -sum(_find_turn(wish, each, way) for each in hands)
    if tilted <= 0:
        return None
    size, until = spread_effort(tilted * (1.0 if back else 2.0), first, end, share=MOVING)
    let_go, home = expectation.released and not back, 2 * end - first
    turn = _prescribe(
        causes[0], way, size, (first, until), None if back else end if let_go else _find_next(wish, end)
    )
    turns = [turn]
    if let_go and home <= wish.brief.last:
        size, until = spread_effort(tilted, end, home, share=MOVING)
        turns.append(_prescribe(causes[0], scale(way, -1.0), size, (end, until), None))
    told = "it is brought back from where it was tilted to" + ("" if back else ", and as far beyond")
    return _put(_hold_until(wish, [max(hands, key=lambda each: each.lets_go)], first), causes, *turns), told


def _find_turn(wish: Wish, hand: Cause, way: Vector) -> float:
    """The magnitude times frames of a hand's turn about an axis (unit world vector)."""
    begun, stopped = wish.get_span([hand])
    return (
        hand.item.magnitude
        * hand.item.gain
        * (stopped - begun)
        * math.copysign(1.0, cosine(hand.item.vector, way))
    )


def _lead_round(wish: Wish) -> _Replaced:
    """Lead what goes in a circle, its front ahead: it turns about a place beside it."""
    here, brief, axis = wish.expectation, wish.brief, wish.expectation.direction
    causes = _find_forces(wish, lambda c: c.item.region is None)
    if here.manner != "circle" or axis is None or not causes or brief.anchored is not None:
        return None
    ahead, box = sum_directions(("ahead",), brief), find_box(brief)
    inwards = normalise(cross(axis, ahead)) or brief.directions.away
    radius = min(0.5 * (brief.reach - 0.5 * max(box[:2])), _CIRCLE)
    if radius < _SMALL_CIRCLE:
        return None  # it would meet the wall of the space; turned where it is, it is judged not to go round
    first, end = wish.get_span(causes)[0], min(here.window[1], brief.last - brief.count_frames(_REST))
    told = find_told(here, brief, "degrees")
    degrees = told.target if told else SPIN
    stop = min(
        max(end, first + 1.0), first + brief.count_frames(find_spin_time(degrees, here.strength, "circle"))
    )
    effort = math.radians(degrees) / TURN * wish.reference
    size, until = spread_effort(effort, first, stop)
    hand = _prescribe(causes[0], axis, size, (first, until), _find_next(wish, end))
    gain = clamp(round(effort / (size * (until - first)), 4), 1.0, GAIN_MAX)
    pivot = tuple(0.5 + radius * way / side for way, side in zip(inwards, box))
    hand = hand.model_copy(update={"gain": gain, "pivot": pivot})
    return _put(wish, causes, hand), "it is led along the circle"


def _slash(wish: Wish) -> _Replaced:
    """Swing something about the end that it is held by, at once; it is drawn back more slowly, and kept there."""
    here, brief, axis = wish.expectation, wish.brief, wish.expectation.direction
    causes = _find_forces(wish, lambda c: c.item.region is None)
    told = find_told(here, brief, "degrees")
    if here.manner != "slash" or axis is None or not causes or told is None or brief.anchored is not None:
        return None
    first, end = wish.get_span(causes)[0], min(here.window[1], brief.last)
    stop = min(first + brief.count_frames(_DRAWN_BACK if here.means else _SLASHED / here.strength), end)
    effort = math.radians(told.target) / TURN * wish.reference / (stop - first)
    hand = _prescribe(causes[0], axis, effort, (first, stop), _find_next(wish, end))
    held = _hold_until(wish, _find_hand(wish, first), first)
    return _put(held, causes, hand.model_copy(update={"pivot": find_grip(brief)})), "it is swung by one end"


def _lead(wish: Wish) -> _Replaced:
    """Lead what was raised, is turned over, goes at one speed, or farther than forces start and stop it."""
    expectation, brief, way = wish.expectation, wish.brief, wish.expectation.direction
    turns = expectation.kind is MotionKind.ROTATE
    told = find_told(expectation, brief, "degrees" if turns else "body lengths")
    if not (turns or expectation.kind is MotionKind.MOVE):
        return None
    if brief.anchored is not None or expectation.sudden or expectation.partial or expectation.repeats > 1:
        return None
    causes = _find_forces(wish, lambda c: (turns or c.pushes) and c.item.region is None)
    if way is None or not causes or any(share_time(e, expectation) for e in wish.list_others()):
        return None  # what is led does nothing else
    first, end = wish.get_span(causes)[0], min(expectation.window[1], wish.brief.last)
    seconds, hands = (end - first) * brief.frame_dt, _find_hand(wish, first)
    hands = hands or ([] if turns else _find_upended(wish, first))
    quick = expectation.even and seconds <= QUICK + brief.frame_dt
    usual = brief.seconds if quick else seconds  # what is sudden goes as far as in all of the clip
    level = turns and abs(cosine(way, brief.directions.up)) < _VERTICAL
    lengthwise = abs(cosine(way, brief.long_axis or _NO_WAY)) > _VERTICAL
    spun = find_spin(expectation.amount, expectation.manner, way if turns else None, brief)
    floats = not level and brief.world == "free" and expectation.manner == "spin"
    spun = SPIN if floats and not told else spun
    spins = turns and (lengthwise and _stands_alone(wish) or floats or not level and _stands_again(wish))
    if turns:
        usually = expect_rotation(expectation.model_copy(update=dict(manner="")), False, seconds=usual)
        angle = _SPUN * usually.high if spins and level else usually.target
        angle = told.target if told else spun or angle
        effort = math.radians(angle) / TURN
    else:
        effort = find_wanted_way(expectation, brief, usual) / TRAVEL
    over = level and told and (expectation.put_back or told.target > _OVER)  # or set upright again
    stands = _stands_alone(wish) or (told or expectation.manner == "rock") and _stands_after_moving(wish)
    tilts = level and math.degrees(effort * TURN) <= (_UPENDED if told else _TILT) and stands
    needed = find_magnitude(effort, max(seconds, brief.frame_dt), brief.seconds, braked=True)
    if not (hands or expectation.even or over or tilts or spins) and (not told or needed <= MAGNITUDE_MAX):
        return None
    effort *= wish.reference * (1.0 if turns else TRAVEL / PRESCRIBED_TRAVEL)  # magnitude times frames
    kept_up = hands or not turns and cosine(way, brief.directions.up) > _VERTICAL
    # What is let go at the end would be seen to fall.
    left = brief.count_frames(_REST) if spins and not level else 1.0 if kept_up else 0.0
    stop = max(min(end, brief.last - left), first + 1.0)
    if spun is not None:
        stop = min(stop, first + brief.count_frames(find_spin_time(spun, expectation.strength)))
    size, until = spread_effort(effort, first, stop, share=MOVING if tilts else 1.0)
    if tilts and expectation.released and 2 * until - first > brief.last:
        size, until = spread_effort(effort, first, 0.5 * (first + stop))
    width, height, depth = brief.extents
    across = depth if abs(cosine(way, brief.directions.right)) > _VERTICAL else width
    # What is broad rests on what it was turned onto; what is tall and thin, as a fish, would fall onto its side.
    settles = over and lengthwise and across >= height and not hands
    hand = _prescribe(causes[0], way, size, (first, until), None if settles else _find_next(wish, end))
    rests = any(e.kind is MotionKind.STILL and abs(e.window[0] - end) < 1.5 for e in wish.expectations)
    begins = min(end, brief.last - (until - first), end - rests * (until - first))  # to come back
    if tilts and expectation.released and begins >= until:
        hand = hand.model_copy(update={"held_until": begins if begins > until else None})
        back = _prescribe(causes[0], scale(way, -1.0), size, (begins, begins + until - first), None)
        return _put(wish, causes, hand, back), "it is tilted over its foot, and brought back"
    reason = "at one speed" if expectation.even else "no force in range starts and stops it in that time"
    reason = "a torque would let it tumble" if over or spins else "it is kept up" if hands else reason
    reason = "it would fall over by itself" if tilts else reason
    if quick or spun is not None:
        hand = hand.model_copy(
            update={"gain": clamp(round(effort / (size * (until - first)), 4), 1.0, GAIN_MAX)}
        )
    far = effort <= 1.01 * hand.gain * MAGNITUDE_MAX * (until - first)
    short = "" if far else ", as far as the fastest goes in that time"
    return _put(_hold_until(wish, hands, first), causes, hand), f"{reason}, so it is led there{short}"


_RULES = (
    _crumple,
    _press_part,
    _split,
    _deform,
    _squeeze_limb,
    _stretch_limb,
    _turn_ends,
    _strike,
    _raise_side,
    _carry,
    _set_down,
    _bounce,
    _tilt_back,
    _lead_round,
    _slash,
    _lead,
)
