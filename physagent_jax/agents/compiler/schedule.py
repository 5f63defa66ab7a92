"""The schedule: the time of each event, and the clip's length that follows.

An overlay shares its neighbour's window. A sequence gets a second and a half for each of its steps, more where a
quantity or a count needs it, and the clip grows with it; a clip of a fixed length is divided instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_jax.agents.compiler.amounts import find_effort, find_span, find_word_effort
from physagent_jax.agents.compiler.events import Event
from physagent_jax.agents.intent import Duration
from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.schema import SceneBrief
from physagent_jax.agents.vectors import clamp, dot
from physagent_jax.agents.windows import Window
from physagent_jax.core.strict import Vector

_MOTIONS = (Effect.PUSH, Effect.STRIKE, Effect.JUMP, Effect.ROLL)
_STILL_SHARE = 0.5  # stillness at the end needs less of the clip than what comes before it
_SMALLEST_SHARE = 0.1  # of a run of events, kept for those without a told length
STEP = 1.5  # [s] that a step of a sequence takes, and settling
_STROKE = 0.75  # [s] that each of several strokes or swings takes at least
_SWING = (
    4.0  # [s] in which what is held swings until it is still: a plant of 1 Hz with a damping ratio of 0.2
)
_REST = 0.5  # [s] after a motion by a quantity, in which it is seen to be reached
LONGEST = 10.0  # [s] of a clip that a sentence can ask for
_MOST_FRAMES = 10_000  # of any clip (`agents.schema`)


@dataclass
class Slot:
    """Events that happen together, and what the sentence says about their time.

    Attributes:
        events: The events, the first one leading.
        start, length: Told by the sentence [frames]; None = by share.
        need: What it takes at least [frames].
        window: Filled by `schedule` [frames].
    """

    events: list[Event]
    start: float | None
    length: float | None
    need: float = 0.0
    window: Window = (0.0, 0.0)


def schedule(events: list[Event], brief: SceneBrief, anchored: bool) -> tuple[list[Slot], int, list[str]]:
    """Groups events into slots and finds their windows.

    Slots with a told start begin there; between two such starts, told lengths are kept (shortened if
    they do not fit) and the rest is shared. The last window ends with the clip unless its length was told.

    Returns:
        The slots, the number of frames that the clip needs (the brief's if that suffices or is fixed), and notes.
    """
    frame_count, notes = brief.frame_count, []
    if not brief.frames_fixed:
        slots = _group_slots(events, brief, math.inf)
        _find_needs(slots, brief, anchored)
        most = max(min(int(LONGEST / brief.frame_dt), _MOST_FRAMES), frame_count)
        needed = max(frame_count, math.ceil(_find_end(slots, brief)) + 1)
        if needed > most:
            notes.append(f"The clip is {LONGEST:g} s long at most: what does not fit is shortened.")
        frame_count = min(needed, most)
    brief = brief.model_copy(update={"frame_count": frame_count})
    last = float(frame_count - 1)
    slots = _group_slots(events, brief, last)
    if not brief.frames_fixed:
        _find_needs(slots, brief, anchored)
        for slot in slots:
            if slot.length is None and _is_dosed(slot, brief, anchored):
                slot.length = min(slot.need, last)
    first = 0
    while first < len(slots):
        run_end = next((i for i in range(first + 1, len(slots)) if slots[i].start is not None), len(slots))
        begin = slots[first].start or 0.0
        end = slots[run_end].start if run_end < len(slots) else None
        _share(slots[first:run_end], begin, last if end is None else end)
        first = run_end
    return slots, frame_count, notes


def _is_dosed(slot: Slot, brief: SceneBrief, anchored: bool) -> bool:
    """Return whether it should end early, so that what it brought about is seen to last."""
    event = slot.events[0]
    moves = event.effect in (Effect.PUSH, Effect.TURN, Effect.LEAN)
    measured = event.stays or find_effort(event.amount, event.effect, brief) is not None
    return (
        moves and measured and not anchored and not event.repeat.alternate and (event.repeat.count or 1) == 1
    )


def _find_needs(slots: list[Slot], brief: SceneBrief, anchored: bool) -> None:
    """The least duration of each slot [frames]: told lengths as they are, steps of a sequence `STEP`."""
    for index, slot in enumerate(slots):
        seconds = 0.0
        after = slots[index + 1].events if index + 1 < len(slots) else []
        for event in slot.events:
            usual = (
                STEP if len(slots) > 1 or event.stays else min(brief.frame_dt * (brief.frame_count - 1), 2.0)
            )
            if event.effect is Effect.STILL and len(slots) > 1 and (anchored or brief.world == "ground"):
                usual = _SWING
            seconds = max(seconds, usual, _STROKE * (event.repeat.count or 1))
            effort = find_effort(event.amount, event.effect, brief)
            stops = has_to_stop(event, after, brief.directions.up, brief.world == "ground")
            if event.amount is None and stops and not event.motion.brief:
                effort = find_word_effort(event.strength, event.effect)
            if effort is not None and not anchored:
                seconds = max(find_span(effort, STEP, brief), STEP if len(slots) > 1 else 0.0)
        slot.need = slot.length if slot.length is not None else seconds / brief.frame_dt


def _find_end(slots: list[Slot], brief: SceneBrief) -> float:
    """Frame at which all is over: what is let go, held or stopped by a quantity takes some time yet."""
    at = 0.0
    for slot in slots:
        at = max(at, slot.start if slot.start is not None else at) + slot.need
    if not slots:
        return at
    leading = slots[-1].events[0]
    rest = STEP if leading.stays else _REST if leading.amount else 0.0
    blow = leading.effect is Effect.STRIKE and slots[-1].start is not None
    return at + (max(rest, STEP) if blow and slots[-1].length is not None else rest) / brief.frame_dt


def _group_slots(events: list[Event], brief: SceneBrief, last: float) -> list[Slot]:
    """One slot per step of the sequence; told starts that run backwards are ignored.

    Args:
        events: In their order.
        brief: The scene.
        last: The clip's last frame; infinity while its length is still to be found.
    """
    clip_end = float(brief.frame_count - 1)
    slots: list[Slot] = []
    latest = 0.0
    for index, event in enumerate(events):
        if index and not follows(events[index - 1], event):
            slots[-1].events.append(event)
            continue
        start, length = (find_frames(told, brief) for told in (event.when.starts, event.when.lasts))
        if start is not None:
            start = clamp(clip_end + start if start < 0 else start, 0.0, max(last - 1.0, 0.0))
            start = start if start > latest or not slots else None
            latest = start if start is not None else latest
        slots.append(Slot([event], start, None if length is None else clamp(length, min(1.0, last), last)))
    return slots


def find_frames(told: Duration | None, brief: SceneBrief) -> float | None:
    """A told length of time in frames; a clip is as long as its last frame's index."""
    if told is None:
        return None
    per_unit = {"seconds": 1.0 / brief.frame_dt, "frames": 1.0, "clip": float(brief.frame_count - 1)}
    return told.value * per_unit[told.unit]


def has_to_stop(event: Event, after: list[Event], up: Vector, grounded: bool) -> bool:
    """Return whether a free object must be stopped before what comes next can be seen."""
    for later in after:
        stops = later.effect is Effect.STILL
        turned = event.effect in (Effect.TURN, Effect.LEAN) and later.effect is event.effect
        moved = event.effect in _MOTIONS and later.effect in (*_MOTIONS, Effect.SWAY)
        lifted = event.direction and dot(event.direction, up) > 0.5
        if lifted and event.effect is Effect.PUSH and later.effect is Effect.FALL:
            return not grounded  # else the push downwards that follows would only slow it
        same = event.direction and later.direction and dot(event.direction, later.direction) > 0.5
        if stops or ((turned or moved) and not same):
            return True
    return False


def follows(before: Event, event: Event) -> bool:
    """Return whether ``event`` comes after ``before`` rather than with it."""
    if event.order != "and":
        return event.order == "then"
    if event.when.starts is not None and event.when.starts != before.when.starts:
        return True  # "rolls left and tips over at the end"
    if event.effect is Effect.RELEASE or (event.effect is Effect.STILL and not event.motion.generic):
        return True
    if before.effect is Effect.FALL and event.effect is Effect.SWAY:
        return True  # "drops and jiggles"
    return _contrary(before, event)


def _contrary(before: Event, event: Event) -> bool:
    """Return whether two events joined by "and" would cancel if they happened together ("squeezed and stretched")."""
    if before.effect in (Effect.STRIKE, Effect.JUMP) and event.effect is Effect.FALL:
        return True  # "jumps and lands"
    if before.effect is Effect.JUMP and event.effect is Effect.TOPPLE:
        return True  # "jumps and lands on its back"
    if before.effect is Effect.PUSH and before.phrase != event.phrase and event.effect is Effect.FALL:
        return True  # "lifted and dropped"
    if before.effect is not event.effect:
        return False
    if event.effect in (Effect.SCALE, Effect.SWELL):
        crossed = before.direction and event.direction and abs(dot(before.direction, event.direction)) < 0.5
        if crossed:
            return False  # "wider and shorter"
        return before.motion.sign != event.motion.sign
    if before.direction is None or event.direction is None or before.region != event.region:
        return False
    return dot(before.direction, event.direction) < -0.5


def _share(slots: list[Slot], begin: float, end: float) -> None:
    """Divides [begin, end] among the slots of one run."""
    free = [slot for slot in slots if slot.length is None]
    span = end - begin
    told = sum(slot.length for slot in slots if slot.length is not None)
    room = span * (1.0 - _SMALLEST_SHARE * min(len(free), 5)) if free else span
    shrink = min(1.0, room / told) if told > 0 else 1.0
    weights = sum(_weight(slot, free) for slot in free)
    at = begin
    for slot in slots:
        if slot.length is None:
            size = (span - told * shrink) * _weight(slot, free) / weights
        else:
            size = slot.length * shrink
        slot.window = (at, at + size)
        at += size


def _weight(slot: Slot, free: list[Slot]) -> float:
    """Its share: by need where the clip's length follows from needs."""
    if all(each.need > 0.0 for each in free):
        return slot.need
    return _STILL_SHARE if all(e.effect is Effect.STILL for e in slot.events) else 1.0
