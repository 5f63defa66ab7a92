"""Events in their windows -> actions of the skill library and what a viewer should see.

One function per `Effect`. A free object keeps its speed when a force ends, so a push that is followed by
another motion or by stillness brakes in the second half of its window; an anchored one comes back by itself. A
length that the sentence tells is the cause's own: what is to stop then is braked after it.
"""

from __future__ import annotations

import math
from dataclasses import replace

from physagent_jax.agents.displacement import HAULING_VERBS
from physagent_jax.agents.rules.language.amounts import (
    find_effort,
    find_held_magnitude,
    find_magnitude,
    find_reference_seconds,
    find_strain_magnitude,
    find_swing_magnitude,
    find_word_effort,
)
from physagent_jax.agents.rules.language.builder import MAX_ACTIONS, ForceFieldBuilder
from physagent_jax.agents.rules.language.directions import find_lean_axis
from physagent_jax.agents.rules.language.events import Event, is_way_assumed
from physagent_jax.agents.rules.language.regions import make_end_region
from physagent_jax.agents.rules.language.schedule import Slot, Window, divide, divide_swings, has_to_stop
from physagent_jax.agents.rules.language.verbs import Effect
from physagent_jax.agents.schema import MotionKind
from physagent_jax.agents.vectors import add, dot, normalise, scale
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import DROP_HEIGHT, GRAVITY, MAGNITUDE_MAX, SWING
from physagent_jax.forces.schema import ActionType
from physagent_jax.forces.skills import find_skill

_IMPULSE_FRAMES = 1.0
_SHORTEST_SWING = 2.0  # frames; faster swings alias in the pictures
_UPRIGHT = 0.7  # cosine
_GUST = 0.3  # part of its window during which a gust impulses
_LEAN = 0.5  # torque of a lean relative to a full turn
_RAISING = (Effect.STRIKE, Effect.JUMP)


def compile_slots(slots: list[Slot], builder: ForceFieldBuilder) -> None:
    """Compiles every event; each knows what comes after it."""
    for index, slot in enumerate(slots):
        builder.room = slots[index + 1].window[1] if index + 1 < len(slots) else builder.last
        after = [event for later in slots[index + 1 : index + 2] for event in later.events]
        stops = [e for e in slot.events if e.effect is Effect.STILL]
        if stops and len(stops) < len(slot.events):
            builder.unsure.append(
                f"What '{stops[0].words}' keeps still while the rest moves is not understood."
            )
        for event in slot.events:
            for note in event.notes:
                builder.add_note(note)
            builder.unsure += [doubt for doubt in event.doubts if doubt not in builder.unsure]
            builder.obstacles += [each for each in event.obstacles if each not in builder.obstacles]
            named = event.verb.skill is not None and not event.repeat.alternate
            compiler = _compile_by_skill if named else _COMPILERS[event.effect]
            compiler(event, slot.window, after, builder, slots[:index])


def _is_released(event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder) -> bool:
    """Return whether the cause ends and leaves the object to itself; what is brought to a place is not left there."""
    let_go = any(e.effect is Effect.RELEASE for e in after)
    if event.stays or _is_measured(event, builder) or _is_reached_within(event) and not let_go:
        return False
    ends_early = not after and window[1] < builder.last - 0.5
    return let_go or ends_early or event.verb.brief


def _is_reached_within(event: Event) -> bool:
    """Return whether the told time is the one in which a quantity is reached, and says nothing of later."""
    return event.when.whole and event.amount is not None and not event.verb.brief


def _is_kept(event: Event, after: list[Event]) -> bool:
    """Return whether a change of shape that is reached in its time is to stay: nothing says that it is let go."""
    return _is_reached_within(event) and not any(later.effect is Effect.RELEASE for later in after)


def _is_measured(event: Event, builder: ForceFieldBuilder) -> bool:
    """Return whether a free object is to go so far, or turn by so much, and no further."""
    return not builder.anchored and find_effort(event.amount, event.effect, builder.brief) is not None


def _needs_brake(event: Event, after: list[Event], builder: ForceFieldBuilder) -> bool:
    """Return whether a free object must be stopped before what comes next can be seen."""
    if builder.anchored:
        return False
    if event.stays or _is_measured(event, builder):
        return True
    return has_to_stop(event, after, builder.brief.directions.up, builder.grounded)


def _add_steady(
    event: Event,
    kind: ActionType,
    vector: Vector,
    magnitude: float,
    window: Window,
    after: list[Event],
    builder: ForceFieldBuilder,
) -> Window:
    """A force or torque over the window, braked in its second half if need be; returns where it acts."""
    if event.verb.brief and event.when.length is None:
        window = (window[0], window[0] + max(_GUST * (window[1] - window[0]), min(1.0, builder.last)))
    brakes = _needs_brake(event, after, builder)
    told = event.when.length is not None and event.when.length.unit != "clip" and not event.when.whole
    halves = _halve(window)
    acts = (halves[0][0], halves[1][1]) if brakes and not told else window
    seconds = (acts[1] - acts[0]) * builder.brief.frame_dt
    magnitude *= _find_dose(event, kind, magnitude, seconds, brakes and not told, builder)
    if builder.anchored and _is_reached_within(event) and not after:
        builder.add_action(event, kind, vector, magnitude, (window[0], builder.last))
        return window
    if not brakes or told:
        builder.add_action(event, kind, vector, magnitude, window)
        if brakes and any(later.effect is Effect.STILL for later in after) and window[1] < builder.last:
            first, end = round(window[0]), round(window[1])
            brake = (float(end), float(min(2 * end - first, math.floor(builder.room))))
            if brake[1] <= brake[0]:
                return window
            builder.add_action(event, kind, scale(vector, -1.0), magnitude, brake)
            builder.add_note(
                "The object is free and would drift on: it is braked after the time that is told."
            )
        return window
    speed_up, slow_down = halves
    builder.add_action(event, kind, vector, magnitude, speed_up)
    builder.add_action(event, kind, scale(vector, -1.0), magnitude, slow_down)
    builder.add_note("The object is free and would drift on: it is braked before what follows.")
    return window


def _halve(window: Window) -> tuple[Window, Window]:
    """Two halves of as many whole frames each where there is room: else what is braked would drift on, or go back."""
    first = float(round(window[0]))
    half = int((round(window[1]) - first) / 2)
    if half < 1:
        speed_up, slow_down = divide(window, [1.0, 1.0])
        return speed_up, slow_down
    return (first, first + half), (first + half, first + 2.0 * half)


def _find_dose(
    event: Event, kind: ActionType, magnitude: float, seconds: float, braked: bool, builder: ForceFieldBuilder
) -> float:
    """Factor on the magnitude so that the event's quantity is reached where nothing opposes.

    Without one, what is braked goes as far as its word promises: half of its time goes to stopping.
    """
    brief = builder.brief
    if event.amount is None:
        effort = find_word_effort(event.strength, event.effect) if braked and not builder.anchored else None
        return 1.0 if effort is None else find_magnitude(effort, seconds, braked, brief) / abs(magnitude)
    if builder.anchored:
        wanted = find_held_magnitude(event.amount, event.effect, brief)
    else:
        effort = find_effort(event.amount, event.effect, brief)
        wanted = None if effort is None else find_magnitude(effort, seconds, braked, brief)
    return 1.0 if wanted is None else max(wanted, 1e-3) / abs(magnitude)


def _compile_push(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    assert event.direction is not None
    if event.repeat.alternate:
        return _compile_sway(event, window, after, builder, _before)
    if (event.repeat.count or 1) > 1:
        return _compile_repeated_push(event, window, after, builder)
    acted = _add_steady(
        event, ActionType.TRANSLATION, event.direction, event.strength, window, after, builder
    )
    builder.add_expectation(
        event,
        MotionKind.MOVE,
        event.direction,
        acted,
        released=_is_released(event, window, after, builder),
        leaves_place=_leaves_place(event, after),
    )


def _leaves_place(event: Event, after: list[Event]) -> bool:
    """Return whether a push or a blow takes the whole object elsewhere: it is thrown, goes somewhere, or goes so far.

    A lean and a wind bend what is rooted, however far. So may a push or a blow of which neither a distance nor another
    place is told; a verb that says no more than that the object goes a told way does not. What is let go afterwards
    springs back, and is in no other place.
    """
    if event.region is not None or event.part is not None or event.wind or event.effect is Effect.LEAN:
        return False
    thrown = event.effect is Effect.STRIKE and (event.verb.gravity or event.verb.direction == "up")
    way_told = event.effect is Effect.PUSH and not is_way_assumed(event)
    goes = way_told and event.verb.generic
    elsewhere = event.elsewhere or way_told and event.phrase in HAULING_VERBS
    returns = any(later.effect is Effect.RELEASE for later in after)
    told = event.amount is not None and event.amount.unit in ("lengths", "metres")
    return thrown or goes or told or elsewhere and not returns or event.effect is Effect.JUMP


def _compile_repeated_push(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder
) -> None:
    """The same push several times, with pauses."""
    assert event.direction is not None
    count = _limit_count(event.repeat.count or 1, window, 2 * _SHORTEST_SWING, builder)
    for push, _pause in _pair_windows(divide(window, [1.0] * (2 * count))):
        builder.add_action(event, ActionType.TRANSLATION, event.direction, event.strength, push)
    kind = MotionKind.SWAY if builder.anchored and count > 1 else MotionKind.MOVE
    builder.add_expectation(
        event,
        kind,
        event.direction,
        window,
        repeats=count,
        released=_is_released(event, window, after, builder),
    )


def _compile_by_skill(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    """The skill that the word stands for, as often as it is told; the first motion that it causes is expected."""
    assert event.direction is not None and event.verb.skill is not None
    skill = find_skill(event.verb.skill)
    kind, count = ActionType(skill.name), _limit_count(event.repeat.count or 1, window, 4.0, builder)
    acted, strength = window, event.strength * (event.verb.sign if skill.is_two_sided else 1)
    if count == 1 and not skill.is_sudden:
        acted = _add_steady(event, kind, event.direction, strength, window, after, builder)
    else:
        for part, _ in _pair_windows(divide(window, [1.0] * (2 * count))):
            part = _make_impulse_window(part[0]) if skill.is_sudden else part
            builder.add_action(event, kind, event.direction, strength, part)
    sways = builder.anchored and count > 1 and MotionKind.SWAY in skill.causes
    builder.add_expectation(
        event,
        MotionKind.SWAY if sways else MotionKind(skill.causes[0]),
        event.direction,
        acted,
        repeats=count,
        sudden=skill.is_sudden,
        released=_is_released(event, window, after, builder),
    )


def _pair_windows(windows: list[Window]) -> list[tuple[Window, Window]]:
    return list(zip(windows[::2], windows[1::2]))


def _limit_count(count: int, window: Window, shortest: float, builder: ForceFieldBuilder) -> int:
    """``count`` limited to what the pictures can show and the action list can hold."""
    fits = max(1, min(int((window[1] - window[0]) / shortest), MAX_ACTIONS // 3))
    if fits < count:
        builder.add_note(
            f"{count} repetitions do not fit into {window[1] - window[0]:.0f} frames: {fits} are made."
        )
    return min(count, fits)


def _make_impulse_window(at: float) -> Window:
    """The shortest window that begins nearest to ``at``."""
    return (float(round(at)), round(at) + _IMPULSE_FRAMES)


def _compile_sway(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    """To and fro.

    How far the pushes go does not depend on how short they are (`forces.swinging`). What bobs on the ground is thrown
    up each time, and weight brings it back.
    """
    assert event.direction is not None
    count = _limit_count(event.repeat.count or event.verb.cycles, window, 2 * _SHORTEST_SWING, builder)
    magnitude = event.strength
    if event.amount is not None:
        magnitude = find_swing_magnitude(event.amount, builder.anchored, builder.brief) or magnitude
    up = builder.brief.directions.up
    bobs = builder.grounded and not builder.anchored and abs(dot(event.direction, up)) > _UPRIGHT
    for part in divide(window, [1.0] * count) if bobs else []:
        rise = 2 * SWING * magnitude
        builder.add_action(event, ActionType.IMPULSE, up, rise, _make_impulse_window(part[0]))
    for index, part in enumerate([] if bobs else divide_swings(window, count, builder.anchored)):
        way = scale(event.direction, -1.0 if index % 2 else 1.0)
        builder.add_action(event, ActionType.TRANSLATION, way, magnitude, part)
    builder.add_expectation(
        event,
        MotionKind.SWAY,
        event.direction,
        window,
        repeats=count,
        released=_is_released(event, window, after, builder),
    )


def _compile_lean(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, before: list[Slot]
) -> None:
    """Anchored things and things in the wind are pushed over; a free thing is turned."""
    assert event.direction is not None
    horizontal = abs(dot(event.direction, builder.brief.directions.up)) < 0.9
    if event.repeat.alternate or (event.repeat.count or 1) > 1:
        return _compile_sway(event, window, after, builder, before)
    if builder.anchored or event.wind or not horizontal or builder.brief.object_kind == "plant":
        return _compile_push(event, window, after, builder, before)
    axis = find_lean_axis(event.direction, builder.brief)
    acted = _add_steady(event, ActionType.TORQUE, axis, _LEAN * event.strength, window, after, builder)
    builder.add_expectation(
        event,
        MotionKind.ROTATE,
        axis,
        acted,
        strength=_LEAN * event.strength,
        released=_is_released(event, window, after, builder),
    )


def _compile_scale(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    """Along one axis, or along all three (`Effect.SWELL`); several times with pauses if counted."""
    table = builder.brief.directions
    axes = [table.right, table.up, table.toward] if event.direction is None else [event.direction]
    count = _limit_count(
        event.repeat.count or (2 if event.repeat.alternate else 1), window, 2 * _SHORTEST_SWING, builder
    )
    windows = [w for w, _ in _pair_windows(divide(window, [1.0] * (2 * count)))] if count > 1 else [window]
    strength = event.strength
    if event.amount is not None and event.amount.unit == "factor":
        strength = find_strain_magnitude(event.amount)
        event = replace(event, stays=event.stays or count == 1 and _is_kept(event, after))
        if strength > MAGNITUDE_MAX:
            builder.add_note(f"'{event.words}': more than the library's strongest force is calibrated for.")
    for part in windows:
        for axis in axes:
            builder.add_action(event, ActionType.SCALE, axis, event.verb.sign * strength, part)
    kind = MotionKind.STRETCH if event.verb.sign > 0 else MotionKind.SQUEEZE
    seen = windows[0] if count > 1 else window
    builder.add_expectation(
        event,
        kind,
        event.direction,
        seen,
        repeats=count,
        released=count > 1 or _is_released(event, window, after, builder),
    )


def _compile_burst(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    """Outward along all axes, briefly: a uniform impulse has no outward form."""
    table = builder.brief.directions
    burst = (window[0], window[0] + max(_GUST * (window[1] - window[0]), min(1.0, builder.last)))
    for axis in (table.right, table.up, table.toward):
        builder.add_action(event, ActionType.SCALE, axis, event.strength, burst)
    builder.add_note("An explosion without a direction is a brief, strong stretch in all directions.")
    builder.add_expectation(event, MotionKind.STRETCH, None, burst, released=True)


def _compile_strike(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    """Blows, evenly spaced if counted; thrown things come down again."""
    assert event.direction is not None
    count = _limit_count(
        event.repeat.count or (2 if event.repeat.alternate else event.verb.strokes),
        window,
        _SHORTEST_SWING,
        builder,
    )
    strength = event.strength
    effort = find_effort(event.amount, event.effect, builder.brief)
    if effort is not None and event.amount is not None:
        seconds = (window[1] - window[0]) * builder.brief.frame_dt / count
        strength = effort * find_reference_seconds(builder.brief) / max(seconds, builder.brief.frame_dt)
        if builder.anchored:
            strength = find_held_magnitude(event.amount, event.effect, builder.brief) or strength
    if event.verb.gravity and not builder.grounded:
        builder.enable_gravity(event.sources["action_type"].words, "what is thrown or jumps comes down again")
    falls_back = builder.default_drop or (builder.grounded and not builder.anchored)
    rises = falls_back and dot(event.direction, builder.brief.directions.up) > 0.5
    if effort is not None and rises:
        strength = effort  # what weight stops rises by M body lengths (`forces.opposition`)
    for index, part in enumerate(divide(window, [1.0] * count)):
        sign = -1.0 if event.repeat.alternate and index % 2 else 1.0
        builder.add_action(
            event,
            ActionType.IMPULSE,
            scale(event.direction, sign),
            strength,
            _make_impulse_window(part[0]),
        )
    if _needs_brake(event, after, builder) and count == 1 and not builder.grounded:  # else friction stops it
        stop = _make_impulse_window(window[1] - _IMPULSE_FRAMES)
        builder.add_action(event, ActionType.IMPULSE, scale(event.direction, -1.0), strength, stop)
        builder.add_note("The object is free and would drift on: it is braked before what follows.")
    rise, fall = divide(window, [1.0, 1.0])
    builder.add_expectation(
        event,
        MotionKind.SWAY if event.repeat.alternate else MotionKind.MOVE,
        event.direction,
        rise if rises else window,
        sudden=True,
        repeats=count,
        released=builder.anchored,
        leaves_place=_leaves_place(event, after),
    )
    thrown = event.verb.gravity or builder.default_drop
    if rises and thrown and not any(e.effect in (Effect.FALL, Effect.TOPPLE) for e in after):
        builder.add_expectation(event, MotionKind.FALL, None, fall, amount=None)


def _compile_jump(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, before: list[Slot]
) -> None:
    """An impulse upwards, and along the direction if there is one."""
    assert event.direction is not None
    up = normalise(add([builder.brief.directions.up, event.direction])) or builder.brief.directions.up
    _compile_strike(replace(event, direction=up), window, after, builder, before)


def _compile_turn(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    assert event.direction is not None
    if event.verb.wrings and event.part is None and event.region is None and not event.repeat.alternate:
        event = replace(event, stays=event.stays or _is_kept(event, after))
        ends = _split_ends(event, builder)
        if len(ends) > 1:
            _compile_turn_against(ends, window, _is_released(event, window, after, builder), builder)
            return
        (event,) = ends
    assert event.direction is not None
    if not event.repeat.alternate:
        acted = _add_steady(event, ActionType.TORQUE, event.direction, event.strength, window, after, builder)
        builder.add_expectation(
            event,
            MotionKind.ROTATE,
            event.direction,
            acted,
            released=_is_released(event, window, after, builder),
        )
        return
    count = _limit_count(event.repeat.count or 2, window, 2 * _SHORTEST_SWING, builder)
    shares = [1.0] * (2 * count) if builder.anchored else [0.5] + [1.0] * (2 * count - 1) + [0.5]
    windows = divide(window, shares)
    for index, part in enumerate(windows):
        builder.add_action(
            event,
            ActionType.TORQUE,
            scale(event.direction, -1.0 if index % 2 else 1.0),
            event.strength,
            part,
        )
    builder.add_expectation(event, MotionKind.ROTATE, event.direction, windows[0], repeats=count)


def _compile_turn_against(
    ends: list[Event], window: Window, released: bool, builder: ForceFieldBuilder
) -> None:
    """Opposed turns at the same time: the object as a whole stays where it is, and nothing has to be braked."""
    for end in ends:
        assert end.direction is not None
        builder.add_action(end, ActionType.TORQUE, end.direction, end.strength, window)
        builder.add_expectation(end, MotionKind.ROTATE, end.direction, window, released=released)


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


def _compile_roll(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    """Travels along the direction while the top turns into it."""
    assert event.direction is not None
    axis = find_lean_axis(event.direction, builder.brief)
    acted = _add_steady(
        event, ActionType.TRANSLATION, event.direction, event.strength, window, after, builder
    )
    _add_steady(event, ActionType.TORQUE, axis, event.strength, window, after, builder)
    turns = event.amount is not None and event.amount.unit == "degrees"
    builder.add_expectation(
        event, MotionKind.MOVE, event.direction, acted, amount=None if turns else event.amount
    )
    builder.add_expectation(event, MotionKind.ROTATE, axis, acted, amount=event.amount if turns else None)


def _compile_fall(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, before: list[Slot]
) -> None:
    """Gravity from the first frame; where there is none, a fall after other motion is a push downwards instead."""
    words = event.sources["action_type"].words
    up = builder.brief.directions.up
    if builder.gravity == "up":
        builder.add_expectation(event, MotionKind.FALL, up, window)
        return
    earlier = [e for slot in before for e in slot.events]
    thrown = all(e.effect in (Effect.STRIKE, Effect.JUMP, Effect.FALL, Effect.STILL) for e in earlier)
    if (
        (builder.default_drop or thrown)
        and builder.gravity != "none"
        and not any(e.effect is Effect.STILL for e in earlier)
    ):
        if not (builder.grounded and any(e.effect in _RAISING for e in earlier)):
            builder.enable_gravity(words, "a falling object needs gravity")
    elif not builder.grounded:
        builder.add_action(
            event, ActionType.TRANSLATION, builder.brief.directions.down, MAGNITUDE_MAX, window
        )
        builder.add_note(
            "Gravity acts from the first frame, so a fall that comes later is made by a push downwards."
        )
    aside = event.direction is not None and abs(dot(event.direction, up)) < _UPRIGHT
    effort = find_effort(event.amount, Effect.PUSH, builder.brief)
    if aside and event.direction is not None and effort is not None and builder.default_drop:
        brief = builder.brief
        seconds = math.sqrt(2.0 * DROP_HEIGHT * brief.size / GRAVITY)  # of the fall
        landed = min(window[0] + seconds / brief.frame_dt, window[1])
        strength = effort * find_reference_seconds(brief) / seconds
        start = _make_impulse_window(window[0])
        builder.add_action(event, ActionType.IMPULSE, event.direction, strength, start)
        builder.add_expectation(event, MotionKind.FALL, None, window, amount=None)
        builder.add_expectation(event, MotionKind.MOVE, event.direction, (window[0], landed))
        return
    builder.add_expectation(event, MotionKind.FALL, None, window)
    if event.direction is not None and abs(dot(event.direction, builder.brief.directions.up)) < 0.7:
        builder.add_action(event, ActionType.TRANSLATION, event.direction, event.strength, window)
        builder.add_expectation(event, MotionKind.MOVE, event.direction, window)


def _compile_topple(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, before: list[Slot]
) -> None:
    """Gravity and a turn of the top towards the direction."""
    assert event.direction is not None
    if not builder.grounded:
        builder.enable_gravity(event.sources["action_type"].words, "a toppling object needs gravity")
    axis = find_lean_axis(event.direction, builder.brief)
    builder.add_action(event, ActionType.TORQUE, axis, event.strength, window)
    builder.add_expectation(event, MotionKind.ROTATE, axis, window)
    builder.add_expectation(event, MotionKind.FALL, None, window)


def _compile_still(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
    builder.add_expectation(event, MotionKind.STILL, None, window)


def _compile_nothing(
    event: Event, window: Window, after: list[Event], builder: ForceFieldBuilder, _before: list[Slot]
) -> None:
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
