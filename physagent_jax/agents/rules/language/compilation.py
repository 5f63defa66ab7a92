"""Events in their windows -> actions of the skill library and what a viewer should see.

One function per `Doing`. A free object keeps its speed when a force ends, so a push that is followed by
another motion or by stillness brakes in the second half of its window; an anchored one comes back by itself.
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.rules.language.draft import MAX_ACTIONS, Draft
from physagent_jax.agents.rules.language.events import Event, lean_axis
from physagent_jax.agents.rules.language.schedule import Slot, Window, divide
from physagent_jax.agents.rules.language.verbs import Doing
from physagent_jax.agents.schema import MotionKind
from physagent_jax.agents.vectors import add, clamp, dot, normalised, scaled
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import ActionType

_IMPULSE_FRAMES = 1.0
_SHORTEST_SWING = 2.0  # frames; faster swings alias in the pictures
_GUST = 0.3  # part of its window during which a gust blows
_LEAN = 0.5  # torque of a lean relative to a full turn
_MOTIONS = (Doing.PUSH, Doing.STRIKE, Doing.JUMP, Doing.ROLL)


def compile_slots(slots: list[Slot], draft: Draft) -> None:
    """Compiles every event; each knows what comes after it."""
    for index, slot in enumerate(slots):
        after = [event for later in slots[index + 1 : index + 2] for event in later.events]
        for event in slot.events:
            for note in event.notes:
                draft.note(note)
            _COMPILERS[event.doing](event, slot.window, after, draft, slots[:index])


def _released(event: Event, window: Window, after: list[Event], draft: Draft) -> bool:
    """Whether the cause ends and leaves the object to itself."""
    let_go = any(e.doing is Doing.RELEASE for e in after)
    ends_early = not after and window[1] < draft.last - 0.5
    return let_go or ends_early or event.verb.brief


def _brakes(event: Event, after: list[Event], draft: Draft) -> bool:
    """Whether a free object must be stopped before what comes next can be seen."""
    if draft.anchored:
        return False
    for later in after:
        stops = later.doing is Doing.STILL
        turned = event.doing in (Doing.TURN, Doing.LEAN) and later.doing is event.doing
        moved = event.doing in _MOTIONS and later.doing in (*_MOTIONS, Doing.SWAY)
        lifted = event.direction and dot(event.direction, draft.brief.directions.up) > 0.5
        if lifted and event.doing is Doing.PUSH and later.doing is Doing.FALL:
            return True  # else the push downwards that follows would only slow it
        same = event.direction and later.direction and dot(event.direction, later.direction) > 0.5
        if stops or ((turned or moved) and not same):
            return True
    return False


def _steady(
    event: Event,
    kind: ActionType,
    vector: Vector,
    magnitude: float,
    window: Window,
    after: list[Event],
    draft: Draft,
) -> Window:
    """A force or torque over the window, braked in its second half if need be; returns where it acts."""
    if event.verb.brief:
        window = (window[0], window[0] + max(_GUST * (window[1] - window[0]), min(1.0, draft.last)))
    if not _brakes(event, after, draft):
        draft.act(event, kind, vector, magnitude, window)
        return window
    speed_up, slow_down = divide(window, [1.0, 1.0])
    draft.act(event, kind, vector, magnitude, speed_up)
    draft.act(event, kind, scaled(vector, -1.0), magnitude, slow_down)
    draft.note("The object is free and would drift on: it is braked before what follows.")
    return window


def _push(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    assert event.direction is not None
    if event.repeat.alternate:
        return _sway(event, window, after, draft, _before)
    if (event.repeat.count or 1) > 1:
        return _again(event, window, after, draft)
    acted = _steady(event, ActionType.TRANSLATION, event.direction, event.strength, window, after, draft)
    draft.expect(
        event, MotionKind.MOVE, event.direction, acted, released=_released(event, window, after, draft)
    )


def _again(event: Event, window: Window, after: list[Event], draft: Draft) -> None:
    """The same push several times, with pauses."""
    assert event.direction is not None
    count = _fitting(event.repeat.count or 1, window, 2 * _SHORTEST_SWING, draft)
    for push, _pause in _pairs(divide(window, [1.0] * (2 * count))):
        draft.act(event, ActionType.TRANSLATION, event.direction, event.strength, push)
    kind = MotionKind.SWAY if draft.anchored and count > 1 else MotionKind.MOVE
    draft.expect(
        event, kind, event.direction, window, repeats=count, released=_released(event, window, after, draft)
    )


def _pairs(windows: list[Window]) -> list[tuple[Window, Window]]:
    return list(zip(windows[::2], windows[1::2]))


def _fitting(count: int, window: Window, shortest: float, draft: Draft) -> int:
    """``count`` limited to what the pictures can show and the action list can hold."""
    fits = max(1, min(int((window[1] - window[0]) / shortest), MAX_ACTIONS // 3))
    if fits < count:
        draft.note(
            f"{count} repetitions do not fit into {window[1] - window[0]:.0f} frames: {fits} are made."
        )
    return min(count, fits)


def _blow(at: float) -> Window:
    """The shortest window that begins nearest to ``at``."""
    return (float(round(at)), round(at) + _IMPULSE_FRAMES)


def _sway(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    """To and fro.

    Anchored: pushes of half a period each. Free: the first and last push last a quarter, so that the
    object goes out, comes back to its place and stops there; a smooth sway of a free object is small
    (its size goes with the square of the period), so it goes once unless the sentence counts. Abrupt
    sways of a free object are made of blows, half-size at both ends for the same reason.
    """
    assert event.direction is not None
    free_smooth = not draft.anchored and not event.verb.abrupt and event.doing is Doing.SWAY
    count = _fitting(
        event.repeat.count or (1 if free_smooth else event.verb.cycles), window, 2 * _SHORTEST_SWING, draft
    )
    kind, magnitude = ActionType.TRANSLATION, event.strength
    halves = 2 * count
    if draft.anchored:
        parts = [(w, 1.0) for w in divide(window, [1.0] * halves)]
    elif event.verb.abrupt:
        kind, magnitude = ActionType.IMPULSE, max(event.strength, 2 * MAGNITUDE_MIN)
        swings = divide(window, [0.5] + [1.0] * (halves - 1) + [0.5])
        blows = [_blow(swing[0]) for swing in swings] + [_blow(window[1] - _IMPULSE_FRAMES)]
        parts = [(w, 0.5 if i in (0, len(blows) - 1) else 1.0) for i, w in enumerate(blows)]
    else:
        parts = [(w, 1.0) for w in divide(window, [0.5] + [1.0] * (halves - 1) + [0.5])]
    for index, (part, factor) in enumerate(parts):
        draft.act(event, kind, scaled(event.direction, -1.0 if index % 2 else 1.0), magnitude * factor, part)
    draft.expect(
        event,
        MotionKind.SWAY,
        event.direction,
        window,
        repeats=count,
        released=_released(event, window, after, draft),
    )


def _lean(event: Event, window: Window, after: list[Event], draft: Draft, before: list[Slot]) -> None:
    """Anchored things and things in the wind are pushed over; a free thing is turned."""
    assert event.direction is not None
    horizontal = abs(dot(event.direction, draft.brief.directions.up)) < 0.9
    if event.repeat.alternate or (event.repeat.count or 1) > 1:
        return _sway(event, window, after, draft, before)
    if draft.anchored or event.wind or not horizontal or draft.brief.object_kind == "plant":
        return _push(event, window, after, draft, before)
    axis = lean_axis(event.direction, draft.brief)
    acted = _steady(event, ActionType.TORQUE, axis, _LEAN * event.strength, window, after, draft)
    draft.expect(
        event,
        MotionKind.ROTATE,
        axis,
        acted,
        strength=_LEAN * event.strength,
        released=_released(event, window, after, draft),
    )
    return None


def _scale(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    """Along one axis, or along all three (`Doing.SWELL`); several times with pauses if counted."""
    table = draft.brief.directions
    axes = [table.right, table.up, table.toward] if event.direction is None else [event.direction]
    count = _fitting(
        event.repeat.count or (2 if event.repeat.alternate else 1), window, 2 * _SHORTEST_SWING, draft
    )
    windows = [w for w, _ in _pairs(divide(window, [1.0] * (2 * count)))] if count > 1 else [window]
    for part in windows:
        for axis in axes:
            draft.act(event, ActionType.SCALE, axis, event.verb.sign * event.strength, part)
    kind = MotionKind.STRETCH if event.verb.sign > 0 else MotionKind.SQUEEZE
    seen = windows[0] if count > 1 else window
    draft.expect(
        event,
        kind,
        event.direction,
        seen,
        repeats=count,
        released=count > 1 or _released(event, window, after, draft),
    )


def _burst(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    """Outward along all axes, briefly: a uniform impulse has no outward form."""
    table = draft.brief.directions
    burst = (window[0], window[0] + max(_GUST * (window[1] - window[0]), min(1.0, draft.last)))
    for axis in (table.right, table.up, table.toward):
        draft.act(event, ActionType.SCALE, axis, event.strength, burst)
    draft.note("An explosion without a direction is a brief, strong stretch in all directions.")
    draft.expect(event, MotionKind.STRETCH, None, burst, released=True)


def _strike(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    """Blows, evenly spaced if counted; thrown things come down again."""
    assert event.direction is not None
    count = _fitting(
        event.repeat.count or (2 if event.repeat.alternate else 1), window, _SHORTEST_SWING, draft
    )
    for index, part in enumerate(divide(window, [1.0] * count)):
        sign = -1.0 if event.repeat.alternate and index % 2 else 1.0
        draft.act(event, ActionType.IMPULSE, scaled(event.direction, sign), event.strength, _blow(part[0]))
    if _brakes(event, after, draft) and count == 1:
        stop = _blow(window[1] - _IMPULSE_FRAMES)
        draft.act(event, ActionType.IMPULSE, scaled(event.direction, -1.0), event.strength, stop)
        draft.note("The object is free and would drift on: it is braked before what follows.")
    if event.verb.gravity:
        draft.drop(event.sources["action_type"].words, "what is thrown or jumps comes down again")
    rises = draft.default_drop and dot(event.direction, draft.brief.directions.up) > 0.5
    rise, fall = divide(window, [1.0, 1.0])
    draft.expect(
        event,
        MotionKind.SWAY if event.repeat.alternate else MotionKind.MOVE,
        event.direction,
        rise if rises else window,
        sudden=True,
        repeats=count,
        released=draft.anchored,
    )
    if rises and not any(e.doing is Doing.FALL for e in after):
        draft.expect(event, MotionKind.FALL, None, fall)


def _jump(event: Event, window: Window, after: list[Event], draft: Draft, before: list[Slot]) -> None:
    """A blow upwards, and along the direction if there is one."""
    assert event.direction is not None
    up = normalised(add([draft.brief.directions.up, event.direction])) or draft.brief.directions.up
    _strike(replace(event, direction=up), window, after, draft, before)


def _turn(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    assert event.direction is not None
    if not event.repeat.alternate:
        strength = event.strength
        if (event.repeat.count or 1) > 1:
            strength = clamp(1.3 * strength, MAGNITUDE_MIN, MAGNITUDE_MAX)
            draft.note("The number of turns is not controlled: it makes the rotation faster.")
        acted = _steady(event, ActionType.TORQUE, event.direction, strength, window, after, draft)
        draft.expect(
            event,
            MotionKind.ROTATE,
            event.direction,
            acted,
            strength=strength,
            released=_released(event, window, after, draft),
        )
        return
    count = _fitting(event.repeat.count or 2, window, 2 * _SHORTEST_SWING, draft)
    shares = [1.0] * (2 * count) if draft.anchored else [0.5] + [1.0] * (2 * count - 1) + [0.5]
    windows = divide(window, shares)
    for index, part in enumerate(windows):
        draft.act(
            event,
            ActionType.TORQUE,
            scaled(event.direction, -1.0 if index % 2 else 1.0),
            event.strength,
            part,
        )
    draft.expect(event, MotionKind.ROTATE, event.direction, windows[0], repeats=count)


def _roll(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    """Travels along the direction while the top turns into it."""
    assert event.direction is not None
    axis = lean_axis(event.direction, draft.brief)
    acted = _steady(event, ActionType.TRANSLATION, event.direction, event.strength, window, after, draft)
    _steady(event, ActionType.TORQUE, axis, event.strength, window, after, draft)
    draft.expect(event, MotionKind.MOVE, event.direction, acted)
    draft.expect(event, MotionKind.ROTATE, axis, acted)


def _fall(event: Event, window: Window, after: list[Event], draft: Draft, before: list[Slot]) -> None:
    """Gravity from the first frame; a fall after other motion is a strong push downwards instead."""
    words = event.sources["action_type"].words
    earlier = [e for slot in before for e in slot.events]
    thrown = all(e.doing in (Doing.STRIKE, Doing.JUMP, Doing.FALL, Doing.STILL) for e in earlier)
    if (
        (draft.default_drop or thrown)
        and draft.gravity is not False
        and not any(e.doing is Doing.STILL for e in earlier)
    ):
        draft.drop(words, "a falling object needs gravity")
    else:
        draft.act(event, ActionType.TRANSLATION, draft.brief.directions.down, MAGNITUDE_MAX, window)
        draft.note(
            "Gravity acts from the first frame, so a fall that comes later is made by a push downwards."
        )
    draft.expect(event, MotionKind.FALL, None, window)
    if event.direction is not None and abs(dot(event.direction, draft.brief.directions.up)) < 0.7:
        draft.act(event, ActionType.TRANSLATION, event.direction, event.strength, window)
        draft.expect(event, MotionKind.MOVE, event.direction, window)


def _topple(event: Event, window: Window, after: list[Event], draft: Draft, before: list[Slot]) -> None:
    """Gravity and a turn of the top towards the direction."""
    assert event.direction is not None
    draft.drop(event.sources["action_type"].words, "a toppling object needs gravity")
    axis = lean_axis(event.direction, draft.brief)
    draft.act(event, ActionType.TORQUE, axis, event.strength, window)
    draft.expect(event, MotionKind.ROTATE, axis, window)
    draft.expect(event, MotionKind.FALL, None, window)


def _still(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    draft.expect(event, MotionKind.STILL, None, window)


def _nothing(event: Event, window: Window, after: list[Event], draft: Draft, _before: list[Slot]) -> None:
    """Release and holding act through the windows of others and through the anchor."""


_COMPILERS = {
    Doing.PUSH: _push,
    Doing.LEAN: _lean,
    Doing.SWAY: _sway,
    Doing.SCALE: _scale,
    Doing.SWELL: _scale,
    Doing.STRIKE: _strike,
    Doing.BURST: _burst,
    Doing.TURN: _turn,
    Doing.ROLL: _roll,
    Doing.FALL: _fall,
    Doing.TOPPLE: _topple,
    Doing.JUMP: _jump,
    Doing.STILL: _still,
    Doing.RELEASE: _nothing,
    Doing.HOLD: _nothing,
}
