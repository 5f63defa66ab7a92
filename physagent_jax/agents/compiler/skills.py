"""Events in their windows -> actions of the skill library and what a viewer should see: one function per `Effect`."""

from __future__ import annotations

import math
from dataclasses import replace

from physagent_jax.agents.compiler.amounts import (
    find_effort,
    find_held_magnitude,
    find_strain_magnitude,
    find_swing_magnitude,
)
from physagent_jax.agents.compiler.builder import MAX_ACTIONS, ForceFieldBuilder
from physagent_jax.agents.compiler.directions import find_lean_axis
from physagent_jax.agents.compiler.events import Event
from physagent_jax.agents.compiler.schedule import Slot
from physagent_jax.agents.compiler.steady import BRAKED_BEFORE, Task, add_steady, shorten
from physagent_jax.agents.dosing import find_reference_seconds
from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.regions import make_end_region
from physagent_jax.agents.schema import MotionKind
from physagent_jax.agents.vectors import add, dot, normalise, scale
from physagent_jax.agents.windows import Window, divide, divide_swings
from physagent_jax.forces.calibration import DROP_HEIGHT, GRAVITY, MAGNITUDE_MAX, SWING
from physagent_jax.forces.schema import ActionType

_IMPULSE_FRAMES = 1.0
_SHORTEST_SWING = 2.0  # frames; faster swings alias in the pictures
_UPRIGHT = 0.7  # cosine
_LEAN = 0.5  # torque of a lean relative to a full turn
_RAISING = (Effect.STRIKE, Effect.JUMP)


def compile_slots(slots: list[Slot], builder: ForceFieldBuilder) -> None:
    """Compiles every event; each knows what comes after it."""
    for index, slot in enumerate(slots):
        builder.room = slots[index + 1].window[1] if index + 1 < len(slots) else builder.last
        after = [event for later in slots[index + 1 : index + 2] for event in later.events]
        stops = [each for each in slot.events if each.effect is Effect.STILL]
        if stops and len(stops) < len(slot.events):
            builder.add_doubt(f"What '{stops[0].words}' keeps still while the rest moves is not understood.")
        for event in slot.events:
            for note in event.notes:
                builder.add_note(note)
            for doubt in event.doubts:
                builder.add_doubt(doubt)
            builder.obstacles += [each for each in event.obstacles if each not in builder.obstacles]
            _COMPILERS[event.effect](Task(event, slot.window, after, slots[:index], builder))


def _compile_push(task: Task) -> None:
    event = task.event
    if event.repeat.alternate:
        _compile_sway(task)
    elif (event.repeat.count or 1) > 1:
        _compile_repeated_push(task)
    else:
        acted = add_steady(task, ActionType.TRANSLATION, task.direction, event.strength)
        task.builder.add_expectation(
            event,
            MotionKind.MOVE,
            event.direction,
            acted,
            released=task.is_released,
            leaves_place=_leaves_place(event),
        )


def _leaves_place(event: Event) -> bool:
    """Return whether a push or a blow takes the whole object elsewhere: it is thrown, goes somewhere, or goes so far.

    A lean and a wind bend what is rooted, however far. So may a push or a blow of which no distance is told; a motion
    that says no more than that the object goes a told way does not.
    """
    if event.region is not None or event.part is not None or event.wind or event.effect is Effect.LEAN:
        return False
    thrown = event.effect is Effect.STRIKE and (event.motion.gravity or event.motion.direction == "up")
    goes = event.effect is Effect.PUSH and event.motion.generic and not event.is_way_assumed
    told = event.amount is not None and event.amount.unit in ("lengths", "metres")
    return thrown or goes or told or event.effect is Effect.JUMP


def _compile_repeated_push(task: Task) -> None:
    """The same push several times, with pauses."""
    event, builder = task.event, task.builder
    count = _limit_count(task, event.repeat.count or 1, 2 * _SHORTEST_SWING)
    for push in divide(task.window, [1.0] * (2 * count))[::2]:
        builder.add_action(event, ActionType.TRANSLATION, task.direction, event.strength, push)
    kind = MotionKind.SWAY if builder.anchored and count > 1 else MotionKind.MOVE
    builder.add_expectation(
        event, kind, event.direction, task.window, repeats=count, released=task.is_released
    )


def _limit_count(task: Task, count: int, shortest: float = _SHORTEST_SWING) -> int:
    """``count`` limited to what the pictures can show and the action list can hold."""
    frames = task.window[1] - task.window[0]
    fits = max(1, min(int(frames / shortest), MAX_ACTIONS // 3))
    if fits < count:
        task.builder.add_note(f"{count} repetitions do not fit into {frames:.0f} frames: {fits} are made.")
    return min(count, fits)


def _make_impulse_window(at: float) -> Window:
    """The shortest window that begins nearest to ``at``."""
    return (float(round(at)), round(at) + _IMPULSE_FRAMES)


def _compile_sway(task: Task) -> None:
    """To and fro.

    How far the pushes go does not depend on how short they are (`forces.swinging`). What bobs on the ground is thrown
    up each time, and weight brings it back.
    """
    event, builder = task.event, task.builder
    count = _limit_count(task, event.repeat.count or event.motion.cycles, 2 * _SHORTEST_SWING)
    magnitude = event.strength
    if event.amount is not None:
        magnitude = find_swing_magnitude(event.amount, builder.anchored, builder.brief) or magnitude
    up = builder.brief.directions.up
    if builder.grounded and not builder.anchored and abs(dot(task.direction, up)) > _UPRIGHT:
        for part in divide(task.window, [1.0] * count):
            rise = 2 * SWING * magnitude
            builder.add_action(event, ActionType.IMPULSE, up, rise, _make_impulse_window(part[0]))
    else:
        _alternate(
            task, ActionType.TRANSLATION, magnitude, divide_swings(task.window, count, builder.anchored)
        )
    builder.add_expectation(
        event, MotionKind.SWAY, event.direction, task.window, repeats=count, released=task.is_released
    )


def _alternate(task: Task, kind: ActionType, magnitude: float, windows: list[Window]) -> None:
    """Adds an action in each window, each against the one before."""
    for index, window in enumerate(windows):
        way = scale(task.direction, -1.0 if index % 2 else 1.0)
        task.builder.add_action(task.event, kind, way, magnitude, window)


def _compile_lean(task: Task) -> None:
    """Anchored things and things in the wind are pushed over; a free thing is turned."""
    event, builder = task.event, task.builder
    horizontal = abs(dot(task.direction, builder.brief.directions.up)) < 0.9
    if event.repeat.alternate or (event.repeat.count or 1) > 1:
        return _compile_sway(task)
    if builder.anchored or event.wind or not horizontal or builder.brief.object_kind == "plant":
        return _compile_push(task)
    axis, strength = find_lean_axis(task.direction, builder.brief), _LEAN * event.strength
    acted = add_steady(task, ActionType.TORQUE, axis, strength)
    builder.add_expectation(
        event, MotionKind.ROTATE, axis, acted, strength=strength, released=task.is_released
    )


def _compile_scale(task: Task) -> None:
    """Along one axis, or along all three (`Effect.SWELL`); several times with pauses if counted."""
    event, builder, window = task.event, task.builder, task.window
    table = builder.brief.directions
    axes = [table.right, table.up, table.toward] if event.direction is None else [event.direction]
    count = event.repeat.count or (2 if event.repeat.alternate else 1)
    count = _limit_count(task, count, 2 * _SHORTEST_SWING)
    windows = divide(window, [1.0] * (2 * count))[::2] if count > 1 else [window]
    strength = event.strength
    if event.amount is not None and event.amount.unit == "factor":
        strength = find_strain_magnitude(event.amount)
        event = replace(event, stays=event.stays or count == 1 and task.is_kept)
        if strength > MAGNITUDE_MAX:
            builder.add_note(f"'{event.words}': more than the library's strongest force is calibrated for.")
    for part in windows:
        for axis in axes:
            builder.add_action(event, ActionType.SCALE, axis, event.motion.sign * strength, part)
    kind = MotionKind.STRETCH if event.motion.sign > 0 else MotionKind.SQUEEZE
    released = count > 1 or replace(task, event=event).is_released
    builder.add_expectation(event, kind, event.direction, windows[0], repeats=count, released=released)


def _compile_burst(task: Task) -> None:
    """Outward along all axes, briefly: a uniform impulse has no outward form."""
    event, builder, table = task.event, task.builder, task.builder.brief.directions
    burst = shorten(task.window, builder.last)
    for axis in (table.right, table.up, table.toward):
        builder.add_action(event, ActionType.SCALE, axis, event.strength, burst)
    builder.add_note("An explosion without a direction is a brief, strong stretch in all directions.")
    builder.add_expectation(event, MotionKind.STRETCH, None, burst, released=True)


def _compile_strike(task: Task) -> None:
    """Blows, evenly spaced if counted; thrown things come down again."""
    event, builder, window = task.event, task.builder, task.window
    swings = event.repeat.alternate
    count = _limit_count(task, event.repeat.count or (2 if swings else event.motion.strokes))
    if event.motion.gravity and not builder.grounded:
        builder.enable_gravity(event.sources["action_type"].words, "what is thrown or jumps comes down again")
    falls_back = builder.default_drop or (builder.grounded and not builder.anchored)
    rises = falls_back and dot(task.direction, builder.brief.directions.up) > 0.5
    strength = _find_blow(task, count, rises)
    for index, part in enumerate(divide(window, [1.0] * count)):
        way = scale(task.direction, -1.0 if swings and index % 2 else 1.0)
        builder.add_action(event, ActionType.IMPULSE, way, strength, _make_impulse_window(part[0]))
    if task.needs_brake and count == 1 and not builder.grounded:  # else friction stops it
        stop = _make_impulse_window(window[1] - _IMPULSE_FRAMES)
        builder.add_action(event, ActionType.IMPULSE, scale(task.direction, -1.0), strength, stop)
        builder.add_note(BRAKED_BEFORE)
    rise, fall = divide(window, [1.0, 1.0])
    builder.add_expectation(
        event,
        MotionKind.SWAY if swings else MotionKind.MOVE,
        event.direction,
        rise if rises else window,
        sudden=True,
        repeats=count,
        released=builder.anchored,
        leaves_place=_leaves_place(event),
    )
    thrown = event.motion.gravity or builder.default_drop
    if rises and thrown and not any(each.effect in (Effect.FALL, Effect.TOPPLE) for each in task.after):
        builder.add_expectation(event, MotionKind.FALL, None, fall, amount=None)


def _find_blow(task: Task, count: int, rises: bool) -> float:
    """Magnitude of each of ``count`` blows that reach the event's quantity, or of its words."""
    event, builder, brief = task.event, task.builder, task.builder.brief
    effort = find_effort(event.amount, event.effect, brief)
    if effort is None or event.amount is None:
        return event.strength
    if rises:
        return effort  # what weight stops rises by M body lengths (`forces.opposition`)
    seconds = (task.window[1] - task.window[0]) * brief.frame_dt / count
    strength = effort * find_reference_seconds(brief) / max(seconds, brief.frame_dt)
    if builder.anchored:
        return find_held_magnitude(event.amount, event.effect, brief) or strength
    return strength


def _compile_jump(task: Task) -> None:
    """An impulse upwards, and along the direction if there is one."""
    up = task.builder.brief.directions.up
    direction = normalise(add([up, task.direction])) or up
    _compile_strike(replace(task, event=replace(task.event, direction=direction)))


def _compile_turn(task: Task) -> None:
    event, builder = task.event, task.builder
    if event.motion.wrings and event.part is None and event.region is None and not event.repeat.alternate:
        event = replace(event, stays=event.stays or task.is_kept)
        ends = _split_ends(event, builder)
        task = replace(task, event=ends[0])
        if len(ends) > 1:  # the object as a whole stays where it is, and nothing has to be braked
            for end in ends:
                assert end.direction is not None
                builder.add_action(end, ActionType.TORQUE, end.direction, end.strength, task.window)
                builder.add_expectation(
                    end, MotionKind.ROTATE, end.direction, task.window, released=task.is_released
                )
            return
        event = ends[0]
    if not event.repeat.alternate:
        acted = add_steady(task, ActionType.TORQUE, task.direction, event.strength)
        builder.add_expectation(event, MotionKind.ROTATE, event.direction, acted, released=task.is_released)
        return
    count = _limit_count(task, event.repeat.count or 2, 2 * _SHORTEST_SWING)
    shares = [1.0] * (2 * count) if builder.anchored else [0.5] + [1.0] * (2 * count - 1) + [0.5]
    windows = divide(task.window, shares)
    _alternate(task, ActionType.TORQUE, event.strength, windows)
    builder.add_expectation(event, MotionKind.ROTATE, event.direction, windows[0], repeats=count)


def _split_ends(event: Event, builder: ForceFieldBuilder) -> list[Event]:
    """A twist as a turn of one end and of the other against it, half each; of the free end where the other is held."""
    assert event.direction is not None
    up, down = builder.brief.directions.up, builder.brief.directions.down
    if builder.anchored:
        ends = [down if "top" in (builder.brief.anchored or "") else up]
    else:
        first = up if abs(dot(event.direction, up)) > 0.7 else event.direction
        ends = [first, scale(first, -1.0)]
        builder.add_note(f"'{event.words}': one end turns against the other.")
    amount = event.amount
    if amount is not None and amount.unit == "degrees":
        amount = amount.model_copy(update={"value": amount.value / len(ends)})
    return [
        replace(
            event,
            part=end,
            region=make_end_region(end, 0.5),
            direction=scale(event.direction, -1.0 if index else 1.0),
            amount=amount,
        )
        for index, end in enumerate(ends)
    ]


def _compile_roll(task: Task) -> None:
    """Travels along the direction while the top turns into it."""
    event, builder = task.event, task.builder
    axis = find_lean_axis(task.direction, builder.brief)
    acted = add_steady(task, ActionType.TRANSLATION, task.direction, event.strength)
    add_steady(task, ActionType.TORQUE, axis, event.strength)
    turns = event.amount is not None and event.amount.unit == "degrees"
    builder.add_expectation(
        event, MotionKind.MOVE, event.direction, acted, amount=None if turns else event.amount
    )
    builder.add_expectation(event, MotionKind.ROTATE, axis, acted, amount=event.amount if turns else None)


def _compile_fall(task: Task) -> None:
    """Gravity from the first frame; where there is none, a fall after other motion is a push downwards instead."""
    event, builder, window = task.event, task.builder, task.window
    brief = builder.brief
    if builder.gravity == "up":
        builder.add_expectation(event, MotionKind.FALL, brief.directions.up, window)
        return
    _let_fall(task)
    aside = event.direction is not None and abs(dot(event.direction, brief.directions.up)) < _UPRIGHT
    effort = find_effort(event.amount, Effect.PUSH, brief) if aside and builder.default_drop else None
    told = {} if effort is None else {"amount": None}  # the quantity is that of the way aside
    builder.add_expectation(event, MotionKind.FALL, None, window, **told)
    if not aside or event.direction is None:
        return
    if effort is not None:
        seconds = math.sqrt(2.0 * DROP_HEIGHT * brief.size / GRAVITY)  # of the fall
        strength = effort * find_reference_seconds(brief) / seconds
        start = _make_impulse_window(window[0])
        builder.add_action(event, ActionType.IMPULSE, event.direction, strength, start)
        window = (window[0], min(window[0] + seconds / brief.frame_dt, window[1]))
    else:
        builder.add_action(event, ActionType.TRANSLATION, event.direction, event.strength, window)
    builder.add_expectation(event, MotionKind.MOVE, event.direction, window)


def _let_fall(task: Task) -> None:
    """Turns gravity on, or pushes downwards where it would have to begin after other motion."""
    event, builder = task.event, task.builder
    earlier = [each for slot in task.before for each in slot.events]
    thrown = all(each.effect in (*_RAISING, Effect.FALL, Effect.STILL) for each in earlier)
    stands = any(each.effect is Effect.STILL for each in earlier)
    if (builder.default_drop or thrown) and builder.gravity != "none" and not stands:
        if not (builder.grounded and any(each.effect in _RAISING for each in earlier)):
            builder.enable_gravity(event.sources["action_type"].words, "a falling object needs gravity")
    elif not builder.grounded:
        down = builder.brief.directions.down
        builder.add_action(event, ActionType.TRANSLATION, down, MAGNITUDE_MAX, task.window)
        builder.add_note(
            "Gravity acts from the first frame, so a fall that comes later is made by a push downwards."
        )


def _compile_topple(task: Task) -> None:
    """Gravity and a turn of the top towards the direction."""
    event, builder = task.event, task.builder
    if not builder.grounded:
        builder.enable_gravity(event.sources["action_type"].words, "a toppling object needs gravity")
    axis = find_lean_axis(task.direction, builder.brief)
    builder.add_action(event, ActionType.TORQUE, axis, event.strength, task.window)
    builder.add_expectation(event, MotionKind.ROTATE, axis, task.window)
    builder.add_expectation(event, MotionKind.FALL, None, task.window)


def _compile_still(task: Task) -> None:
    task.builder.add_expectation(task.event, MotionKind.STILL, None, task.window)


def _compile_nothing(task: Task) -> None:
    """Release and holding act through the windows of others and through the anchor."""


_COMPILERS = {
    Effect.PUSH: _compile_push,
    Effect.LEAN: _compile_lean,
    Effect.SWAY: _compile_sway,
    Effect.SCALE: _compile_scale,
    Effect.SWELL: _compile_scale,
    Effect.STRIKE: _compile_strike,
    Effect.BURST: _compile_burst,
    Effect.TURN: _compile_turn,
    Effect.ROLL: _compile_roll,
    Effect.FALL: _compile_fall,
    Effect.TOPPLE: _compile_topple,
    Effect.JUMP: _compile_jump,
    Effect.STILL: _compile_still,
    Effect.RELEASE: _compile_nothing,
    Effect.HOLD: _compile_nothing,
}
