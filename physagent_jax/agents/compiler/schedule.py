"""The schedule: the time of each event, and the clip's length that follows.

An overlay shares its neighbour's window. A sequence gets a second and a half for each of its steps, more where a
quantity or a count needs it, and the clip grows with it; a clip of a fixed length is divided instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_jax.agents.compiler.amounts import find_effort, find_word_effort
from physagent_jax.agents.compiler.events import Event, WayKind
from physagent_jax.agents.intent import Duration
from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.lexicon.types import is_end
from physagent_jax.core.strict import Vector
from physagent_jax.motion.efforts import find_span, find_spin, find_spin_time
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.tipping import find_tipping_time
from physagent_jax.motion.vectors import clamp, dot
from physagent_jax.motion.windows import Window

_MOTIONS = (Effect.PUSH, Effect.STRIKE, Effect.JUMP, Effect.ROLL)
_STILL_SHARE = 0.5  # stillness at the end needs less of the clip than what comes before it
_SMALLEST_SHARE = 0.1  # of a run of events, kept for those without a told length
STEP = 1.5  # [s] that a step of a sequence takes, and settling
_LEVEL = 0.7  # cosine to the vertical below which an axis is level
_STROKE = 0.75  # [s] that each of several strokes or swings takes at least
_SWAYS = {"bend": 0.5, "rock": 0.7}  # [s] that a swing over its foot takes at least, by manner
_SWING = 4.0  # [s] in which what is held swings until it is still: 1 Hz with a damping ratio of 0.2
# [s] that all else takes until it is seen to be still: what is braked, and what is led to and fro, falls or is hit.
_SETTLING: dict[Effect, float] = dict.fromkeys((Effect.PUSH, Effect.TURN, Effect.ROLL, Effect.LEAN), 0.6)
_SETTLING |= dict.fromkeys((Effect.SWAY, Effect.FALL, Effect.TOPPLE, Effect.JUMP, Effect.STRIKE), STEP)
_BEFORE = 0.4  # [s] before what is sudden, in which nothing happens yet
_REST = 0.5  # [s] after a motion by a quantity, in which it is seen to be reached
LONGEST = 10.0  # [s] of a clip that a sentence can ask for
_MOST_FRAMES = 10_000  # of any clip (`motion.schema`)


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
    if brief.frames_fixed:
        slots, notes = _group_slots(events, brief, brief.last), []
    else:
        needed = _find_end(_make_needy_slots(events, brief, anchored, math.inf), brief)
        frame_count, notes = _lengthen(math.ceil(needed) + 1, brief)
        brief = brief.model_copy(update={"frame_count": frame_count})
        slots = _make_needy_slots(events, brief, anchored, brief.last)
        for slot in slots:
            if slot.length is None and _is_dosed(slot.events[0], brief, anchored):
                slot.length = min(slot.need, brief.last)
    starts = [index for index, slot in enumerate(slots) if index == 0 or slot.start is not None]
    for first, after in zip(starts, [*starts[1:], None]):
        end = brief.last if after is None else slots[after].start or 0.0
        _share(slots[first:after], slots[first].start or 0.0, end)
    return slots, brief.frame_count, notes


def _lengthen(needed: int, brief: SceneBrief) -> tuple[int, list[str]]:
    """The number of frames of a clip that grows, and a note if that is not enough."""
    most = max(min(int(LONGEST / brief.frame_dt), _MOST_FRAMES), brief.frame_count)
    note = f"The clip is {LONGEST:g} s long at most: what does not fit is shortened."
    return min(max(brief.frame_count, needed), most), [note] if needed > most else []


def _is_dosed(event: Event, brief: SceneBrief, anchored: bool) -> bool:
    """Return whether it should end early, so that what it brought about is seen to last."""
    moves = event.effect in (Effect.PUSH, Effect.TURN, Effect.LEAN) and not anchored
    measured = event.stays or find_effort(event.amount, event.effect, brief) is not None
    return moves and measured and not event.repeat.alternate and event.count == 1


def _make_needy_slots(events: list[Event], brief: SceneBrief, anchored: bool, last: float) -> list[Slot]:
    """Slots with their least durations [frames]: told lengths as they are, steps of a sequence `STEP`."""
    slots = _group_slots(events, brief, last)
    grounded, clip = brief.world == "ground", brief.seconds
    for before, slot, following in zip([None, *slots], slots, [*slots[1:], None]):
        seconds = 0.0
        for event in slot.events:
            after = following.events if following else []
            tips = event.effect is Effect.FALL and any(e.effect is Effect.TOPPLE for e in after)
            usual = _STROKE if tips else STEP if len(slots) > 1 or event.stays else min(clip, 2.0)
            rests = event.effect is Effect.STILL and event.phrase != "wait"
            if rests and before and following is None and (anchored or grounded):
                free = [e.effect for e in before.events if e.effect is Effect.SWAY or not anchored]
                usual = max((_SETTLING.get(each, _SWING) for each in free), default=_SWING)
            swings = _SWAYS.get(event.motion.manner, 0.0) * (event.repeat.count or event.motion.cycles)
            swings *= event.effect is Effect.SWAY
            seconds = max(seconds, usual, _STROKE * event.count, swings)
            if (way := event.direction) and event.effect is Effect.TOPPLE:
                seconds = max(seconds, find_tipping_time(way, event.strength, brief, event.lies_aside))
            effort = find_effort(event.amount, event.effect, brief)
            flies = event.motion.leaps and slot is slots[0] or any(e.motion.gravity for e in slot.events)
            effort = None if flies and event.effect is Effect.TURN else effort
            stops = has_to_stop(event, after, brief.directions.up, grounded)
            if event.amount is None and stops and not event.motion.brief:
                effort = find_word_effort(event.strength, event.effect)
            line = event.direction if event.effect is Effect.TURN else None
            # `motion.kinds` leads it over.
            led = line is not None and abs(dot(line, brief.directions.up)) < _LEVEL
            if effort is not None and not anchored:
                # "slowly, by a quarter turn"
                pace = event.strength if event.amount and event.strengths else 1.0
                span = find_span(effort, STEP / pace, brief, led)
                seconds = max(span, STEP if len(slots) > 1 else 0.0)
            spun = None if event.parts else find_spin(event.amount, event.motion.manner, line, brief)
            if spun is not None and not anchored and not event.repeat.alternate:
                seconds = max(
                    find_spin_time(spun, event.strength, event.motion.manner), STEP if len(slots) > 1 else 0.0
                )
        slot.need = slot.length if slot.length is not None else seconds / brief.frame_dt
    return slots


def _find_end(slots: list[Slot], brief: SceneBrief) -> float:
    """Frame at which all is over: what is let go, held or stopped by a quantity takes some time yet."""
    at = 0.0
    for slot in slots:
        at = max(at, slot.start or 0.0) + slot.need
    if not slots:
        return at
    last, leading = slots[-1], slots[-1].events[0]
    blow = leading.effect is Effect.STRIKE and last.start is not None and last.length is not None
    topples = leading.effect is Effect.TOPPLE and len(slots) > 1  # it takes its time, and then lies
    rest = STEP if leading.stays or blow or topples else _REST if leading.amount else 0.0
    return at + rest / brief.frame_dt


def _group_slots(events: list[Event], brief: SceneBrief, last: float) -> list[Slot]:
    """One slot per step of the sequence; told starts that run backwards are ignored.

    Args:
        events: In their order.
        brief: The scene.
        last: The clip's last frame; infinity while its length is still to be found.
    """
    slots: list[Slot] = []
    latest = 0.0
    for index, event in enumerate(events):
        if index and not follows(events[index - 1], event):
            slots[-1].events.append(event)
            continue
        start, length = (find_frames(told, brief) for told in (event.when.starts, event.when.lasts))
        if start is not None:
            start = clamp(brief.last + start if start < 0 else start, 0.0, max(last - 1.0, 0.0))
            start = start if start > latest or not slots else None
            latest = start if start is not None else latest
        elif not slots and event.clause.pace == "sudden" and event.effect not in (Effect.FALL, Effect.STILL):
            start = min(_BEFORE / brief.frame_dt, max(last - 1.0, 0.0))  # it is seen to begin
        slots.append(Slot([event], start, None if length is None else clamp(length, min(1.0, last), last)))
    return slots


def find_frames(told: Duration | None, brief: SceneBrief) -> float | None:
    """A told length of time in frames; a clip is as long as its last frame's index."""
    if told is None:
        return None
    per_unit = {"seconds": 1.0 / brief.frame_dt, "frames": 1.0, "clip": brief.last}
    return told.value * per_unit[told.unit]


def has_to_stop(event: Event, after: list[Event], up: Vector, grounded: bool) -> bool:
    """Return whether a free object must be stopped before what comes next can be seen."""
    turns, moves = event.effect in (Effect.TURN, Effect.LEAN), event.effect in _MOTIONS
    lifted = event.effect is Effect.PUSH and event.direction and dot(event.direction, up) > 0.5
    for later in after:
        if lifted and later.effect is Effect.FALL:
            return not grounded  # else the push downwards that follows would only slow it
        turned = turns and later.effect is event.effect
        moved = moves and later.effect in (*_MOTIONS, Effect.SWAY)
        tilted = moves and later.effect is Effect.LEAN  # "brakes and tips up"
        if later.effect is Effect.STILL or tilted or ((turned or moved) and not _cosine(event, later) > 0.5):
            return True
    return False


def _cosine(one: Event, other: Event) -> float:
    """Cosine between the directions of two events; 0 if either goes no way."""
    return dot(one.direction, other.direction) if one.direction and other.direction else 0.0


def follows(before: Event, event: Event) -> bool:
    """Return whether ``event`` comes after ``before`` rather than with it."""
    order, effect = event.clause.order, event.effect
    if order != "and":
        return order == "then"
    later = event.when.starts is not None and event.when.starts != before.when.starts
    if later or event.clause.pace == "sudden" and before.clause.pace != "sudden":
        return True  # "rolls left and tips over at the end", "stands still and suddenly spins"
    rests = effect is Effect.STILL and (not event.motion.generic or event.is_timed)
    # "Its wheels spin, but it".
    rests &= not (before.limbs and event.phrase.startswith("stay") and not event.is_timed)
    thrown = effect is Effect.STRIKE and event.motion.gravity and before.motion.direction == "up"
    if before.effect is Effect.TOPPLE and event.motion.puts_back:
        return True  # "it falls over and gets up again"
    if before.effect is Effect.LEAN and before.motion.angle == 90 and effect in (Effect.PUSH, Effect.ROLL):
        return True  # "it stands up on its edge and rolls away"
    flipped = before.effect is Effect.TURN and before.motion.angle == 180
    if effect is Effect.SWAY and flipped and not event.parts:
        return True  # "lands on its back and rocks"
    over = effect is Effect.TURN and event.motion.angle == 180 and before.motion.direction in ("up", None)
    falls = effect is Effect.FALL or thrown or over  # "pick it up and throw it"
    lifted = before.effect is Effect.PUSH and falls and before.phrase != event.phrase
    rests |= effect is Effect.RELEASE
    rests |= before.motion.drops and effect is Effect.TOPPLE  # "it is dropped and tips over"
    return rests or lifted or _carries_on(before, event) or _contrary(before, event)


def _carries_on(before: Event, event: Event) -> bool:
    """Return whether what was raised is then moved on: "it takes off and flies right", "lift it and shake it"."""
    raised = before.effect is Effect.PUSH and before.motion.direction == "up"
    if raised and before.motion.bound and event.effect in (Effect.SWAY, Effect.TURN, Effect.LEAN):
        return before.limbs == event.limbs and bool(event.limbs) == bool(before.parts or event.parts)
    raised &= event.effect is Effect.PUSH
    aside = event.motion.direction is None and bool(event.pick(WayKind.TO)) and not event.is_upwards
    return raised and aside and not (before.parts or event.parts)


_SUCCESSIONS = (
    (Effect.FALL, Effect.SWAY),  # "drops and jiggles"
    (Effect.STRIKE, Effect.FALL),
    (Effect.SWAY, Effect.JUMP),  # "rattles and jumps up"
    (Effect.TURN, Effect.JUMP),
    (Effect.LEAN, Effect.TOPPLE),
    (Effect.FALL, Effect.ROLL),
    (Effect.PUSH, Effect.TOPPLE),  # "slides to the left and falls over"
    (Effect.FALL, Effect.BURST),  # "it falls and explodes"
    (Effect.TOPPLE, Effect.ROLL),
    (Effect.TOPPLE, Effect.PUSH),
    (Effect.TOPPLE, Effect.SWAY),  # "it falls over sideways and rocks until it stops"
    (Effect.JUMP, Effect.FALL),  # "jumps and lands"
    (Effect.JUMP, Effect.TOPPLE),  # "jumps and lands on its back"
)


def _contrary(before: Event, event: Event) -> bool:
    """Return whether two events joined by "and" would cancel if they happened together ("squeezed and stretched")."""
    limb = before.limbs == event.limbs != () and {before.effect, event.effect} == {Effect.PUSH, Effect.LEAN}
    if before.effect is not event.effect and not limb:  # "raises its arm and lets it drop"
        return (before.effect, event.effect) in _SUCCESSIONS or is_end(before.motion, event.motion)
    if event.effect in (Effect.SCALE, Effect.SWELL):
        whole = before.direction is None or event.direction is None
        return before.motion.sign != event.motion.sign and (whole or abs(_cosine(before, event)) >= 0.5)
    return before.region == event.region and _cosine(before, event) < -0.5


def _share(slots: list[Slot], begin: float, end: float) -> None:
    """Divides [begin, end] among the slots of one run: told lengths, then by need where that is known."""
    free = [slot for slot in slots if slot.length is None]
    span, told = end - begin, sum(slot.length or 0.0 for slot in slots)
    room = span * (1.0 - _SMALLEST_SHARE * min(len(free), 5))
    shrink = min(1.0, room / told) if told > 0 else 1.0
    by_need = all(slot.need > 0.0 for slot in free)

    def weigh(slot: Slot) -> float:
        rests = all(event.effect is Effect.STILL for event in slot.events)
        return slot.need if by_need else _STILL_SHARE if rests else 1.0

    total = sum(map(weigh, free))
    for slot in slots:
        size = (span - told * shrink) * weigh(slot) / total if slot.length is None else slot.length * shrink
        slot.window = (begin, begin + size)
        begin += size
