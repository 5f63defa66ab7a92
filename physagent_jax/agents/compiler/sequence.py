"""The events of a sentence in their order, with what the clauses around them change."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.compiler.builder import ForceFieldBuilder
from physagent_jax.agents.compiler.events import Event
from physagent_jax.agents.compiler.holding import keeps_end
from physagent_jax.agents.compiler.interpretation import interpret, resolve_obstacles
from physagent_jax.agents.compiler.schedule import follows
from physagent_jax.agents.compiler.words import WAYS, Meaning, WayKind
from physagent_jax.agents.intent import Timing
from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.agents.vectors import dot

_AWAY = 0.01  # [lengths, metres or degrees] from where nothing has to come back
_RESTING = (Effect.STILL, Effect.RELEASE)


def make_events(meanings: list[Meaning], builder: ForceFieldBuilder) -> list[Event]:
    """The events that happen, in order."""
    events: list[Event] = []
    for meaning in meanings:
        if meaning.has_effect(Effect.HOLD):
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
    """Adds what a clause tells."""
    event = interpret(meaning, _find_measure(events, meaning), builder.brief)
    _measure_return(event, events)
    event = _put_under_gravity(event, builder.gravity)
    if events and events[-1].effect is Effect.FALL and event.effect is Effect.FALL and meaning.is_bare:
        return  # "it drops and bounces"
    if event.effect is Effect.FALL and builder.gravity is None and meaning.is_upwards:
        builder.gravity = "up"  # "it falls upwards"
    events.append(event)


def _is_only_posture(event: Event, events: list[Event]) -> bool:
    """Return whether "standing" is no wish for stillness: "the robot standing on the ground is pushed"."""
    last = event is events[-1] and event.meaning.clause.order == "then"
    return event.effect is Effect.STILL and event.motion.generic and not last and not event.is_timed


def _find_measure(events: list[Event], meaning: Meaning) -> Event | None:
    """The last event with a direction; for what comes "back" or goes on the same way, the last like it."""
    directed = [each for each in events if each.direction is not None]
    turns = meaning.has_effect(Effect.TURN)
    if meaning.is_back:
        directed = [each for each in directed if (each.effect is Effect.TURN) == turns] or directed
    if any(way.names == ("same",) for way in meaning.pick(WayKind.AGAIN)):
        directed = [each for each in directed if each.effect is not Effect.TURN] or directed
    return directed[-1] if directed else None


def _measure_return(event: Event, events: list[Event]) -> None:
    """The distance of a return, where the distance away was told."""
    way, told = event.direction, event.amount is not None or event.meaning.clause.quantities
    if told or not event.meaning.is_back or way is None:
        return
    alike = [(e.direction, e.amount) for e in events if e.effect is event.effect and e.direction is not None]
    if len({amount and amount.unit for _, amount in alike}) != 1:
        return
    away = -sum(dot(one, way) * amount.value for one, amount in alike if amount is not None)
    if away >= _AWAY and (amount := alike[0][1]) is not None:
        event.amount = amount.model_copy(update={"value": round(away, 6)})


def _share_time(events: list[Event]) -> list[Event]:
    """A time that is told of all steps together ("left, then up, in a second") as a time of each, by its way."""
    told = events[-1].when if events else Timing()
    if not told.overall or told.lasts is None or any(each.is_timed for each in events[:-1]):
        return events
    if not all(follows(one, other) for one, other in zip(events, events[1:])):
        return events
    units = {each.amount and each.amount.unit for each in events}
    ways = [each.amount.value if each.amount and len(units) == 1 else 1.0 for each in events]
    lengths = [told.lasts.model_copy(update={"value": told.lasts.value * way / sum(ways)}) for way in ways]
    return [replace(each, when=Timing(lasts=length, within=True)) for each, length in zip(events, lengths)]


def _make_another(event: Event, phrase: str, **changes) -> Event:
    """The event with another motion, which goes no way."""
    motion = replace(read_lexicon().motions[phrase], **changes)
    return replace(event, motion=motion, phrase=phrase, direction=None)


def _put_under_gravity(event: Event, gravity: str | None) -> Event:
    """Let gravity make things fall; what floats in zero gravity is still, unless something else moves it."""
    told = bool(event.meaning.pick(*WAYS))
    falls = event.meaning.clause.cause == "gravity" and gravity in ("down", None)
    if falls and event.effect is Effect.PUSH and (not told or event.motion.pulls):
        return _make_another(event, "fall")
    if gravity == "none" and event.motion.floats and not told:
        return _make_another(event, "motionless", generic=True)
    return event


def _find_releases(events: list[Event], builder: ForceFieldBuilder) -> list[Event]:
    """Letting go of something at rest lets it fall; letting go before a fall is part of the fall."""
    result: list[Event] = []
    for event, after in zip(events, [*events[1:], None]):
        if event.effect is not Effect.RELEASE:
            result.append(event)
            continue
        if result and result[-1].effect is Effect.RELEASE:
            continue  # "release it and let it swing back" is one release
        acted = any(each.effect not in _RESTING for each in result)
        if event.motion.lets_go and _is_lifted(result, builder):
            result.append(_make_another(event, "fall"))
        elif after is not None and after.effect in (Effect.FALL, Effect.TOPPLE):
            continue
        elif acted:
            result.append(event)
        elif event.motion.lets_go:
            result.append(replace(event, motion=read_lexicon().motions["fall"]))
            builder.add_note(f"'{event.words}': nothing acts before it, so the object is let fall.")
        else:
            builder.add_doubt(f"What '{event.words}' comes back from is not understood.")
    return result


def _is_lifted(events: list[Event], builder: ForceFieldBuilder) -> bool:
    """Return whether the last motion raised an object that gravity acts on, and nothing holds."""
    last = next((each for each in reversed(events) if each.effect is not Effect.STILL), None)
    if last is None or last.effect is not Effect.PUSH or last.direction is None:
        return False
    raised = dot(last.direction, builder.brief.directions.up) > 0.5
    return raised and builder.grounded and not builder.anchored
