"""Blows, leaps and falls: what begins with a speed, or is left to weight."""

from __future__ import annotations

import math
from dataclasses import replace

from physagent_jax.agents.compiler.amounts import find_effort, find_held_magnitude
from physagent_jax.agents.compiler.directions import find_lean_axis
from physagent_jax.agents.compiler.steady import (
    BRAKED_BEFORE,
    IMPULSE_FRAMES,
    SHORTEST_STROKE,
    Task,
    make_impulse_window,
)
from physagent_jax.agents.dosing import find_reference_seconds
from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.schema import MotionKind
from physagent_jax.agents.vectors import add, dot, normalise, scale
from physagent_jax.agents.windows import divide
from physagent_jax.forces.calibration import DROP_HEIGHT, GRAVITY, MAGNITUDE_MAX
from physagent_jax.forces.schema import ActionType

_RAISING = (Effect.STRIKE, Effect.JUMP)
_UPRIGHT = 0.7  # cosine


def compile_strike(task: Task) -> None:
    """Blows, evenly spaced if counted; thrown things come down again."""
    event, builder, window = task.event, task.builder, task.window
    swings = event.repeat.alternate
    count = task.limit_count(event.repeat.count or (2 if swings else event.motion.strokes), SHORTEST_STROKE)
    if event.motion.gravity and not builder.grounded:
        builder.enable_gravity(event.sources["action_type"].words, "what is thrown or jumps comes down again")
    falls_back = builder.default_drop or (builder.grounded and not builder.anchored)
    rises = falls_back and dot(task.direction, builder.brief.directions.up) > 0.5
    strength = _find_blow(task, count, rises)
    for index, part in enumerate(divide(window, [1.0] * count)):
        way = scale(task.direction, -1.0 if swings and index % 2 else 1.0)
        builder.add_action(event, ActionType.IMPULSE, way, strength, make_impulse_window(part[0]))
    if task.needs_brake and count == 1 and not builder.grounded:  # else friction stops it
        stop = make_impulse_window(window[1] - IMPULSE_FRAMES)
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
        leaves_place=task.leaves_place,
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


def compile_jump(task: Task) -> None:
    """An impulse upwards, and along the direction if there is one."""
    up = task.builder.brief.directions.up
    direction = normalise(add([up, task.direction])) or up
    compile_strike(replace(task, event=replace(task.event, direction=direction)))


def compile_fall(task: Task) -> None:
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
        start = make_impulse_window(window[0])
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


def compile_topple(task: Task) -> None:
    """Gravity and a turn of the top towards the direction."""
    event, builder = task.event, task.builder
    if not builder.grounded:
        builder.enable_gravity(event.sources["action_type"].words, "a toppling object needs gravity")
    axis = find_lean_axis(task.direction, builder.brief)
    builder.add_action(event, ActionType.TORQUE, axis, event.strength, task.window)
    builder.add_expectation(event, MotionKind.ROTATE, axis, task.window)
    builder.add_expectation(event, MotionKind.FALL, None, task.window)
