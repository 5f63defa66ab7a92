"""When each event happens: a sequence divides the clip, an overlay shares its neighbour's window."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_jax.agents.rules.language.events import Event
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.verbs import Effect
from physagent_jax.agents.vectors import clamp, dot

Window = tuple[float, float]
_STILL_SHARE = 0.5  # stillness at the end needs less of the clip than what comes before it
_SMALLEST_SHARE = 0.1  # of a run of events, kept for those without a told length


@dataclass
class Slot:
    """Events that happen together, and what the sentence says about their time.

    Attributes:
        events: The events, the first one leading.
        start, length: Told by the sentence [frames]; None = by share.
        window: Filled by `schedule` [frames].
    """

    events: list[Event]
    start: float | None
    length: float | None
    window: Window = (0.0, 0.0)


def schedule(events: list[Event], frame_count: int, frame_dt: float) -> list[Slot]:
    """Groups events into slots and divides the clip among them.

    Slots with a told start begin there; between two such starts, told lengths are kept (shortened if
    they do not fit) and the rest is shared. The last window ends with the clip unless its length was told.
    """
    last = float(frame_count - 1)
    slots = _group_slots(events, frame_count, frame_dt)
    first = 0
    while first < len(slots):
        run_end = next((i for i in range(first + 1, len(slots)) if slots[i].start is not None), len(slots))
        begin = slots[first].start or 0.0
        end = slots[run_end].start if run_end < len(slots) else None
        _share(slots[first:run_end], begin, last if end is None else end)
        first = run_end
    return slots


def _group_slots(events: list[Event], frame_count: int, frame_dt: float) -> list[Slot]:
    """One slot per step of the sequence; told starts that run backwards are ignored."""
    last = float(frame_count - 1)
    slots: list[Slot] = []
    latest = 0.0
    for index, event in enumerate(events):
        if index and not follows(events[index - 1], event):
            slots[-1].events.append(event)
            continue
        start = event.when.start.to_frames(frame_count, frame_dt) if event.when.start else None
        length = event.when.length.to_frames(frame_count, frame_dt) if event.when.length else None
        if start is not None:
            start = clamp(last + start if start < 0 else start, 0.0, max(last - 1.0, 0.0))
            start = start if start > latest or not slots else None
            latest = start if start is not None else latest
        slots.append(Slot([event], start, None if length is None else clamp(length, min(1.0, last), last)))
    return slots


def follows(before: Event, event: Event) -> bool:
    """Whether ``event`` comes after ``before`` rather than with it."""
    if event.join in (Join.THEN, Join.COMMA, Join.BEFORE, Join.AFTER):
        return True
    if event.join is Join.WHILE:
        return False
    if event.effect is Effect.RELEASE or (event.effect is Effect.STILL and not event.verb.generic):
        return True
    if before.effect is Effect.FALL and event.effect is Effect.SWAY:
        return True  # "drops and jiggles"
    return contrary(before, event)


def contrary(before: Event, event: Event) -> bool:
    """Whether two events joined by "and" would cancel if they happened together ("squeezed and stretched")."""
    if before.effect is Effect.PUSH and before.phrase != event.phrase and event.effect is Effect.FALL:
        return True  # "lifted and dropped"
    if before.effect is not event.effect:
        return False
    if event.effect in (Effect.SCALE, Effect.SWELL):
        return before.verb.sign != event.verb.sign
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
    weights = sum(_weight(slot) for slot in free)
    at = begin
    for slot in slots:
        if slot.length is None:
            size = (span - told * shrink) * _weight(slot) / weights
        else:
            size = slot.length * shrink
        slot.window = (at, at + size)
        at += size


def _weight(slot: Slot) -> float:
    return _STILL_SHARE if all(e.effect is Effect.STILL for e in slot.events) else 1.0


def divide(window: Window, shares: list[float]) -> list[Window]:
    """Consecutive windows in the ratio of ``shares``."""
    first, last = window
    total = sum(shares)
    edges = [first]
    for share in shares[:-1]:
        edges.append(edges[-1] + (last - first) * share / total)
    return list(zip(edges, [*edges[1:], last]))
