"""The events of a sentence in their order, with what the clauses around them change."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.compiler.builder import ForceFieldBuilder
from physagent_jax.agents.compiler.directions import WAYS
from physagent_jax.agents.compiler.events import Event
from physagent_jax.agents.compiler.holding import keeps_end
from physagent_jax.agents.compiler.interpretation import (
    interpret,
    is_back,
    lands_aside,
    resolve_obstacles,
)
from physagent_jax.agents.compiler.schedule import follows
from physagent_jax.agents.compiler.words import Meaning, WayKind
from physagent_jax.agents.intent import Timing
from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.agents.vectors import dot

_AWAY = 0.01  # [lengths, metres or degrees] from where nothing has to come back
_RESTING = (Effect.STILL, Effect.RELEASE)


def make_events(meanings: list[Meaning], builder: ForceFieldBuilder) -> list[Event]:
    """The events that happen, in order."""
    events: list[Event] = []
    for meaning in meanings:
        if meaning.motion is None or meaning.motion.effect is Effect.HOLD:
            builder.obstacles += resolve_obstacles(meaning.clause.solids, None, builder.brief)
        elif keeps_end(meaning, meanings):
            continue  # "while the bottom stays put": what is held
        elif meaning.clause.negated or any(each.times == 0 for each in meaning.clause.repetitions):
            builder.add_note(f"'{meaning.words}' is negated: it does not happen.")
        else:
            _add_event(events, meaning, builder)
    events = _share_time(_find_releases(events, builder))
    if any(each.effect not in _RESTING for each in events):
        events = [each for each in events if not _is_only_posture(each, events)]
    return events


def _add_event(events: list[Event], meaning: Meaning, builder: ForceFieldBuilder) -> None:
    """Adds what a clause tells, or tells it of the event before."""
    event = interpret(meaning, _find_measure(events, meaning), builder.brief)
    event = _put_under_gravity(_measure_return(event, events, meaning), meaning, builder.gravity)
    last = events[-1] if events else None
    if last is not None and last.effect is Effect.FALL and event.effect is Effect.FALL:
        if meaning.bare:
            return  # "it drops and bounces"
        if lands_aside(meaning) and last.direction is None:
            events[-1] = replace(
                last,
                direction=event.direction,
                amount=event.amount,
                doubts=last.doubts + event.doubts,
                words=f"{last.words} {event.words}",
                sources=last.sources | event.sources,
            )
            return  # "drop it; as it reaches the ground it is farther to the right"
    upwards = any(way.names == ("up",) for way in meaning.pick(WayKind.TO))
    if event.effect is Effect.FALL and builder.gravity is None and upwards:
        builder.gravity = "up"  # "it falls upwards"
    events.append(event)


def _is_only_posture(event: Event, events: list[Event]) -> bool:
    """Return whether "standing" is no wish for stillness: "the robot standing on the ground is pushed"."""
    last = event is events[-1] and event.order == "then"
    return event.effect is Effect.STILL and event.motion.generic and not last and not event.is_timed


def _find_measure(events: list[Event], meaning: Meaning) -> Event | None:
    """The last event with a direction; for what comes "back" or goes on the same way, the last like it."""
    directed = [each for each in events if each.direction is not None]
    turns = meaning.motion is not None and meaning.motion.effect is Effect.TURN
    if is_back(meaning):
        directed = [each for each in directed if (each.effect is Effect.TURN) == turns] or directed
    if any(way.names == ("same",) for way in meaning.pick(WayKind.AGAIN)):
        directed = [each for each in directed if each.effect is not Effect.TURN] or directed
    return directed[-1] if directed else None


def _measure_return(event: Event, events: list[Event], meaning: Meaning) -> Event:
    """The distance of a return, where the distance away was told."""
    untold = event.amount is None and not meaning.clause.quantities
    if not is_back(meaning) or not untold or event.direction is None:
        return event
    alike = [each for each in events if each.effect is event.effect and each.direction is not None]
    amounts = [each.amount for each in alike if each.amount is not None]
    if not amounts or len(amounts) < len(alike) or len({amount.unit for amount in amounts}) > 1:
        return event
    ways = [dot(each.direction or event.direction, event.direction) for each in alike]
    away = -sum(way * amount.value for way, amount in zip(ways, amounts))
    if away < _AWAY:
        return event
    return replace(event, amount=amounts[0].model_copy(update={"value": round(away, 6)}))


def _share_time(events: list[Event]) -> list[Event]:
    """A time that is told of all steps together ("left, then up, in a second") as a time of each, by its way."""
    told = events[-1].when if events else Timing()
    timed = any(each.is_timed for each in events[:-1])
    if not told.overall or told.lasts is None or timed:
        return events
    if not all(follows(one, other) for one, other in zip(events, events[1:])):
        return events
    units = {each.amount.unit if each.amount else None for each in events}
    ways = [each.amount.value if each.amount and len(units) == 1 else 1.0 for each in events]
    lengths = [told.lasts.model_copy(update={"value": told.lasts.value * way / sum(ways)}) for way in ways]
    return [replace(each, when=Timing(lasts=length, within=True)) for each, length in zip(events, lengths)]


def _put_under_gravity(event: Event, meaning: Meaning, gravity: str | None) -> Event:
    """Let gravity make things fall; what floats in zero gravity is still, unless something else moves it."""
    motions, told = read_lexicon().motions, bool(meaning.pick(*WAYS))
    if meaning.clause.cause == "gravity" and gravity in ("down", None) and event.effect is Effect.PUSH:
        if not told or event.motion.pulls:
            return replace(event, motion=motions["fall"], phrase="fall", direction=None)
    if gravity == "none" and event.motion.floats and not told:
        resting = replace(motions["motionless"], generic=True)
        return replace(event, motion=resting, phrase="motionless", direction=None)
    return event


def _find_releases(events: list[Event], builder: ForceFieldBuilder) -> list[Event]:
    """Letting go of something at rest lets it fall; letting go before a fall is part of the fall."""
    fall = read_lexicon().motions["fall"]
    result: list[Event] = []
    for index, event in enumerate(events):
        if event.effect is not Effect.RELEASE:
            result.append(event)
            continue
        if result and result[-1].effect is Effect.RELEASE:
            continue  # "release it and let it swing back" is one release
        acted = any(each.effect not in _RESTING for each in result)
        falls = index + 1 < len(events) and events[index + 1].effect in (Effect.FALL, Effect.TOPPLE)
        if event.motion.lets_go and _is_lifted(result, builder):
            result.append(replace(event, motion=fall, phrase="fall", direction=None))
        elif acted and not falls:
            result.append(event)
        elif not falls and event.motion.lets_go:
            result.append(replace(event, motion=fall))
            builder.add_note(f"'{event.words}': nothing acts before it, so the object is let fall.")
        elif not falls:
            builder.unsure.append(f"What '{event.words}' comes back from is not understood.")
    return result


def _is_lifted(events: list[Event], builder: ForceFieldBuilder) -> bool:
    """Return whether the last motion raised an object that gravity acts on, and nothing holds."""
    last = next((each for each in reversed(events) if each.effect is not Effect.STILL), None)
    if last is None or last.effect is not Effect.PUSH or last.direction is None:
        return False
    raised = dot(last.direction, builder.brief.directions.up) > 0.5
    return raised and builder.grounded and not builder.anchored
