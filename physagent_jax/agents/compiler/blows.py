"""Blows, leaps and falls: what begins with a speed, or is left to weight."""

from __future__ import annotations

import math
from dataclasses import replace

from physagent_jax.agents.compiler.amounts import find_effort
from physagent_jax.agents.compiler.events import BY_DEFAULT, Event
from physagent_jax.agents.compiler.steady import BRAKED_BEFORE, SHORTEST_STROKE, Task
from physagent_jax.agents.lexicon import Effect
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import (
    DROP_HEIGHT,
    GRAVITY,
    HIGH_DROP,
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    MOST_DROP,
    find_highest_leap,
    find_reference_time,
    find_tipping,
)
from physagent_jax.forces.schema import Action, ActionType
from physagent_jax.forces.slabs import make_box
from physagent_jax.forces.upright import begin_of
from physagent_jax.motion.attitudes import find_attitude
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.efforts import find_held_magnitude, find_lengths
from physagent_jax.motion.landing import LANDED, land, list_rebounds, spin_until_landed, stand_after_drop
from physagent_jax.motion.pressing import LEAST_ROOM, poke, shake_itself
from physagent_jax.motion.schema import Amount, MotionKind
from physagent_jax.motion.tipping import find_end_axis, tip, tip_off_end
from physagent_jax.motion.vectors import add, dot, normalise, scale
from physagent_jax.motion.windows import IMPULSE_FRAMES, divide, make_impulse_window

_RAISING = (Effect.STRIKE, Effect.JUMP)
_UPRIGHT = 0.7  # cosine
_LEVEL = 0.5  # cosine to the vertical below which a way is level
_LIFT = 1.6  # rise over way aside of what is thrown: it is to be seen to fly
_ASIDE = 0.9  # cosine below which a leap goes aside
# Of a blow, with which what is thrown comes down about as far aside as one along the ground goes, and a leap rises by a
# third of a length and comes down six tenths aside; and with which a leap comes down as far aside as is told.
_THROWN, _LED = 0.45, 0.77
_HOPS = 1.0  # the same of each of several leaps: they are as high as there is time for
_FLUNG = 1.5  # power of a strength by which what is flung hard goes farther: it flies, and does not hop

_AGAINST = 1.6  # strength as which it is taken where a wall is to be reached


def compile_strike(task: Task) -> None:
    """Blows, evenly spaced if counted; thrown things come down again."""
    event, builder, window = task.event, task.builder, task.window
    swings, way, up = event.repeat.alternate, task.direction, task.brief.directions.up
    if event.motion.gravity and dot(way, up) < -_UPRIGHT:
        task.act(ActionType.IMPULSE, way, event.strength, make_impulse_window(window[0]))
        return compile_fall(task)
    if not swings and _takes_a_finger(task):
        return _poke(task)
    count = task.limit_count(event.repeat.count or (2 if swings else event.motion.strokes), SHORTEST_STROKE)
    if event.motion.gravity and not builder.grounded:
        builder.enable_gravity(event.words, "what is thrown or jumps comes down again")
    falls_back = builder.default_drop or (builder.grounded and not builder.anchored)
    rises = falls_back and dot(way, up) > 0.5
    strength, flown = _find_blow(task, count, rises), way
    jumps, hops = event.effect is Effect.JUMP, event.effect is Effect.JUMP and count > 1 and not event.amount
    most, lift = (_ASIDE, 1.0) if jumps else (_LEVEL, _LIFT)
    if rises and count > 1:
        each = (window[1] - window[0]) * task.brief.frame_dt / count
        strength = min(strength, find_highest_leap(each) / task.brief.size)
    if event.motion.gravity and builder.grounded and not builder.anchored and abs(dot(way, up)) < most:
        share = _HOPS if hops else _LED if jumps and event.amount else _THROWN
        flung = event.effect is Effect.STRIKE and event.amount is None
        least = _AGAINST if event.clause.solids else 1.0
        share *= max(strength, least) ** _FLUNG if flung else 1.0
        flown, strength = normalise(add([way, scale(up, lift)])) or way, share * strength
    for index, part in enumerate(divide(window, [1.0] * count)):
        blow, at = scale(flown, -1.0 if swings and index % 2 else 1.0), make_impulse_window(part[0])
        task.act(ActionType.IMPULSE, blow, strength, at, gains=strength < MAGNITUDE_MIN)
    if task.needs_brake and count == 1 and not builder.grounded:  # else friction stops it
        stop = make_impulse_window(window[1] - IMPULSE_FRAMES)
        task.act(ActionType.IMPULSE, scale(way, -1.0), strength, stop)
        builder.notes.append(BRAKED_BEFORE)
    if rises and event.motion.tumbles:
        spin_aloft(task, find_lean_axis(task.brief.directions.toward, task.brief))
    rise, fall = divide(window, [1.0, 1.0])
    if count > 1:  # every one of them is a rise
        rise, fall = window, divide(window, [1.0] * 2 * count)[-1]
    task.expect(
        MotionKind.SWAY if swings else MotionKind.MOVE,
        way,
        rise if rises and count == 1 else window,
        sudden=True,
        repeats=count,
        released=builder.anchored,
        leaves_place=task.leaves_place,
    )
    thrown = event.motion.gravity or builder.default_drop
    if rises and thrown and not any(each.effect in (Effect.FALL, Effect.TOPPLE) for each in task.after):
        task.expect(MotionKind.FALL, None, fall, amount=None)


def _takes_a_finger(task: Task) -> bool:
    """Return whether it is poked where it stands, is soft, and the clip has time for a finger to go in and back."""
    event, builder = task.event, task.builder
    room = (task.window[1] - task.window[0]) / event.count
    return event.motion.pokes and builder.soft and builder.grounded and room >= LEAST_ROOM and not event.limbs


def _poke(task: Task) -> None:
    """A finger that goes into what is soft and back, as often as it is told."""
    event, brief, way = task.event, task.brief, task.direction
    width, tall, depth = brief.extents
    if event.sources["vector"].why.endswith(BY_DEFAULT) and tall < min(width, depth):
        way = brief.directions.down  # on its broadest side
    box = make_box(event.region)
    height = 0.5 if box is None else 0.5 * (box.low[2] + box.high[2])
    hand, held = "hand" if event.motion.palm else "finger", task.builder.anchored and event.motion.palm
    above = event.motion.palm and dot(way, brief.directions.down) > _UPRIGHT  # hit aside, it swings by itself
    about = dict(palm=event.motion.palm, held=held, quivers=above and event.trembles > 0)
    task.builder.constraints += poke(brief, way, height, event.strength, event.count, task.window, **about)
    task.builder.notes.append(f"'{event.words}': it is soft, so that a {hand} goes in and back.")
    # It goes along as a whole, as far as it is not held.
    whole = dict(part=None, partial=False, strength=MAGNITUDE_MIN, jiggles=above or event.trembles > 0)
    kind, way = (MotionKind.SWAY, brief.directions.right) if above else (MotionKind.MOVE, way)
    task.expect(kind, way, task.window, repeats=event.count, sudden=True, released=True, **whole)


def spin_aloft(task: Task, axis: Vector) -> bool:
    """Adds the turn of what the action before throws up, once until it comes down; return whether one does."""
    brief, amount = task.brief, task.event.amount or Amount(value=360.0, unit="degrees")
    blows = [each for each in task.builder.actions[-1:] if each.action_type is ActionType.IMPULSE]
    at_once = (
        blows and amount.unit == "degrees" and all(abs(begin_of(e) - task.window[0]) <= 0.5 for e in blows)
    )
    spin = spin_until_landed(blows[0], amount.value, brief) if at_once else None
    if spin is None:
        return False
    for way, span in zip((axis, scale(axis, -1.0)), spin.windows):
        task.act(ActionType.TORQUE, way, spin.magnitude, span, gains=True)
    upright = amount.value % 360.0 == 0 and task.builder.grounded and not task.builder.anchored
    if upright and (
        landing := land(blows[0], task.window[1], brief)
    ):  # it would topple, as it has no balance
        until = task.window[1] if task.after else float(brief.last)
        others = [c for c in task.builder.constraints if c.active_time != landing.active_time]
        task.builder.constraints[:] = [*others, landing.model_copy(update=dict(held_until=until))]
    # It lands as it comes.
    task.expect(MotionKind.ROTATE, axis, task.window, amount=None, strength=MAGNITUDE_MAX)
    return True


def _find_blow(task: Task, count: int, rises: bool) -> float:
    """Magnitude of each of ``count`` blows that reach the event's quantity, or of its words."""
    event, brief = task.event, task.brief
    effort = find_effort(event.amount, event.effect, brief)
    if effort is None or event.amount is None:
        # A small hop is far lower than a leap: what it rises by goes with its speed squared.
        return event.strength ** (2 if rises and event.effect is Effect.JUMP and event.strength < 1 else 1)
    if rises:
        return effort  # what weight stops rises by M body lengths (`forces.opposition`)
    if task.builder.anchored and (held := find_held_magnitude(event.amount, brief)):
        return held
    seconds = (task.window[1] - task.window[0]) * brief.frame_dt / count
    return effort * find_reference_time(False, brief.seconds) / max(seconds, brief.frame_dt)


def compile_jump(task: Task) -> None:
    """Leaps after each of which it stands, if it comes down onto the ground as it was."""
    builder, before = task.builder, len(task.builder.actions)
    leap(task)
    jumps, event = builder.actions[before:], task.event
    falls = any(
        each.effect is Effect.TOPPLE or each.effect is Effect.FALL and not _lands_upright(each)
        for each in task.after
    )  # "it jumps up and lands on its feet" stands
    bounces = event.motion.tumbles or event.verb is not None and event.verb.bounces
    if not builder.grounded or builder.anchored or event.region or event.limbs or falls or bounces:
        return
    begins = [jump.active_time[0] for jump in jumps if jump.active_time]
    landings = [land(*pair, task.brief) for pair in zip(jumps, [*begins[1:], task.window[1]])]
    made = [each for each in landings if each is not None]
    builder.constraints += made
    builder.notes += [LANDED.format(event.text)] if made else []


def _lands_upright(event: Event) -> bool:
    """Return whether it only tells that what leapt comes down again: "it jumps up and lands on its feet"."""
    return event.motion.lands and not (event.clause.pose or event.motion.pose)


def leap(task: Task) -> None:
    """An impulse upwards, and along the direction if there is one."""
    up = task.brief.directions.up
    direction = normalise(add([up, task.direction])) or up
    compile_strike(replace(task, event=replace(task.event, direction=direction)))


def compile_fall(task: Task) -> None:
    """Gravity from the first frame; where there is none, a fall after other motion is a push downwards instead."""
    event, builder, up = task.event, task.builder, task.brief.directions.up
    if builder.gravity == "up":
        task.expect(MotionKind.FALL, up, task.window)
        return
    _let_fall(task)
    _rebound(task)
    level = event.direction is not None and abs(dot(event.direction, up)) < _UPRIGHT
    effort = find_effort(event.amount, Effect.PUSH, task.brief) if level and builder.default_drop else None
    aside = dict(amount=None) if effort else {}  # the quantity is that of the way aside
    told = dict(rebounds=event.rebounds, counted=bool(event.repeat.count) and not event.repeat.vague)
    task.expect(MotionKind.FALL, None, task.window, **told, **aside)
    if effort:
        _throw_aside(task, effort)
    elif level:
        task.act(ActionType.TRANSLATION, task.direction, event.strength, task.window)
        task.expect(MotionKind.MOVE, task.direction, task.window)


def _rebound(task: Task) -> None:
    """Adds the leaps by which what bounces comes up again, each lower than the one before."""
    event, builder = task.event, task.builder
    aside = event.direction is not None and abs(dot(event.direction, task.brief.directions.up)) < _UPRIGHT
    if not (event.rebounds and builder.default_drop) or builder.earlier or event.region or aside:
        return
    leaps, top = list_rebounds(builder.drop_height or DROP_HEIGHT, event.rebounds, task.window[1], task.brief)
    for begin, rise in leaps:
        task.act(ActionType.IMPULSE, task.brief.directions.up, rise, make_impulse_window(begin), gains=True)
    if leaps and event.trembles and event.repeat.count:  # it would spring up by itself again and again
        _stand(task, leaps[-1][1], top)
    told = "" if len(leaps) == event.rebounds else f", {len(leaps)} times: more do not fit"
    builder.notes.append(f"'{event.text}': it is thrown up again where it lands{told}.")


def _throw_aside(task: Task, effort: float) -> None:
    """Adds the blow by which a falling object lands so far aside: it falls for sqrt(2 h / g)."""
    brief, (first, last), way = task.brief, task.window, task.direction
    seconds = math.sqrt(2.0 * DROP_HEIGHT * brief.size / GRAVITY)
    strength = effort * find_reference_time(False, brief.seconds) / seconds
    task.act(ActionType.IMPULSE, way, strength, make_impulse_window(first))
    task.expect(MotionKind.MOVE, way, (first, min(first + seconds / brief.frame_dt, last)))


def _let_fall(task: Task) -> None:
    """Turns gravity on, or pushes downwards where it would have to begin after other motion."""
    builder, earlier = task.builder, task.builder.earlier
    up = task.brief.directions.up
    raised = any(effect in _RAISING for effect in earlier)
    raised |= any(e.action_type is ActionType.IMPULSE and dot(e.vector, up) > 0 for e in builder.actions)
    thrown = all(effect in (*_RAISING, Effect.FALL) for effect in earlier)
    falls = thrown or builder.default_drop and Effect.STILL not in earlier
    pose = task.event.clause.pose or task.event.motion.pose
    if pose and pose != "down" and earlier:
        builder.unsure.append(f"What turns it for '{task.event.text}' is not planned.")
    if falls and builder.gravity != "none":
        if not (builder.grounded and raised):
            event, height = task.event, HIGH_DROP if task.event.strength > 1 else None
            if event.direction is None or abs(dot(event.direction, task.brief.directions.up)) >= _UPRIGHT:
                height = find_lengths(event.amount, task.brief) or height
            if height is not None and height > MOST_DROP:
                room = f"'{event.text}': there is room for a fall of {MOST_DROP:g} body lengths."
                builder.notes.append(room)
                event.amount, height = None, MOST_DROP
            builder.drop_height = height
            builder.enable_gravity(task.event.words, "a falling object needs gravity")
            if pose and not earlier:
                builder.attitude = find_attitude(pose, builder.brief)
            elif task.event.trembles and builder.default_drop and not (earlier or task.event.rebounds):
                _stand(task, height or DROP_HEIGHT)
    elif not builder.grounded:
        task.act(ActionType.TRANSLATION, builder.brief.directions.down, MAGNITUDE_MAX, task.window)
        builder.notes.append("Gravity acts from the first frame: a later fall is a push downwards.")


def _stand(task: Task, height: float, since: float = 0.0) -> None:
    """Adds the stop of what is soft where it lands: it wobbles there, and goes on in nothing but a rest."""
    goes_on = any(each.effect is not Effect.STILL for each in task.after)
    until = task.window[1] if goes_on else task.brief.last
    landing = stand_after_drop(height, until, task.brief, since)
    if landing is not None and landing.active_time:
        about = (landing.active_time[0], until)
        shaken = shake_itself(task.brief, task.brief.directions.right, task.event.trembles, about)
        task.builder.constraints += [landing, *shaken]


def compile_topple(task: Task) -> None:
    """Gravity and a turn of the top towards the direction, past the balance: gravity goes on with it."""
    if not task.builder.grounded:
        task.builder.enable_gravity(task.event.words, "a toppling object needs gravity")
        task.builder.drop_height = task.builder.drop_height or 0.0  # it stands on what it falls onto
    axis, (first, last), dt = find_lean_axis(task.direction, task.brief), task.window, task.brief.frame_dt
    magnitude, seconds = find_tipping(task.event.strength, (last - first) * dt, task.brief.seconds)
    builder, blows = task.builder, _find_blows(task)
    before = (*builder.actions[: len(builder.actions) - len(blows)], *builder.constraints)
    whole = builder.grounded and task.event.region is None
    goes_on = any(each.effect is not Effect.STILL for each in task.after)
    kept = (last if goes_on else task.brief.last) if task.event.lies_aside else None
    led = tip(task.brief, task.direction, task.event.strength, task.window, before, kept) if whole else []
    end = None if led or blows or not whole else find_end_axis(builder.expectations)
    if end is not None:  # it goes on the way that it was set up
        axis = axis if abs(dot(axis, end)) < _LEVEL else end
        led = tip_off_end(task.brief, axis, task.window)
    builder.constraints += led
    if led and blows:  # what is knocked over goes as far as it falls
        places = tuple(f"actions[{builder.actions.index(each)}]" for each in blows)
        del builder.actions[-len(blows) :]
        builder.evidence[:] = [each for each in builder.evidence if not each.field.startswith(places)]
        builder.expectations[-1] = builder.expectations[-1].model_copy(update=dict(strength=1.0))
    elif not led:
        task.act(ActionType.TORQUE, axis, magnitude, (first, first + seconds / dt))
    told = BY_DEFAULT not in task.event.sources["vector"].why
    # However hard or slowly, it turns until it lies.
    task.expect(MotionKind.ROTATE, axis if told else None, task.window, strength=1.0)
    task.expect(MotionKind.FALL, None, task.window)


def _find_blows(task: Task) -> list[Action]:
    """The level blow by which it is knocked over, as it was planned just before: none if it is another motion."""
    builder, last = task.builder, task.builder.expectations[-1:]
    at_once = [each for each in last if each.sudden and abs(each.window[0] - task.window[0]) < 0.5]
    moved = any(each.kind is MotionKind.MOVE and each.repeats == 1 for each in at_once)
    blow = builder.actions[-1:] if moved else []
    level = all(abs(dot(e.vector, task.brief.directions.up)) < _LEVEL and e.region is None for e in blow)
    return blow if level and all(each.action_type is ActionType.IMPULSE for each in blow) else []
