"""The events of a sentence in their order, with what the clauses around them change; and what is held."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.compiler.builder import ForceFieldBuilder
from physagent_jax.agents.compiler.events import Event
from physagent_jax.agents.compiler.interpretation import interpret, resolve_obstacles
from physagent_jax.agents.compiler.schedule import follows
from physagent_jax.agents.compiler.words import WAYS, Meaning, WayKind
from physagent_jax.agents.intent import Held, Timing
from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.agents.schema import AnchorRequest
from physagent_jax.agents.vectors import dot

_AWAY = 0.01  # [lengths, metres or degrees] from where nothing has to come back
_RESTING = (Effect.STILL, Effect.RELEASE)
_HOLDABLE = (Effect.PUSH, Effect.LEAN, Effect.SCALE, Effect.SWELL, Effect.TURN)
_RISING = (Effect.PUSH, Effect.STRIKE, Effect.JUMP)


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


def apply_holding(meanings: list[Meaning], held: Held | None) -> list[Meaning]:
    """Holding what was just moved keeps it there; holding what is then let go is no anchor."""
    result: list[Meaning] = []
    for index, meaning in enumerate(meanings):
        last = result[-1] if result else None
        follows = next((each for each in meanings[index + 1 :] if not each.clause.negated), None)
        alike = last is not None and last.motion and meaning.has_effect(last.motion.effect)
        if last is not None and meaning.stays and meaning.is_bare and alike:
            last.stays = True  # "compress it and keep it compressed"
            continue
        if _hangs_in_the_air(meaning, last):
            if follows is not None and follows.has_effect(Effect.FALL):
                continue  # "thrown up, it hangs there and falls": so does all that turns back
            meaning = _wait(meaning)
        if _is_bare_hold(meaning) and held is None:
            result += _hold(meaning, last, follows)
        else:
            result.append(meaning)
    return result


def _hold(meaning: Meaning, last: Meaning | None, follows: Meaning | None) -> list[Meaning]:
    """A bare hold as an anchor, as a time of rest, or (nothing) as a property of what was done before."""
    timed = meaning.timing != Timing()
    moved = last is not None and not last.clause.negated and last.has_effect(*_HOLDABLE)
    let_go = follows is not None and follows.has_effect(Effect.RELEASE) and follows.is_bare
    if moved and last is not None and let_go and last.timing == Timing():
        last.timing = meaning.timing  # "hold it for a second, then release it"
    elif follows is not None and timed:
        return [_wait(meaning)]  # "hold it for a second, then"
    elif moved and last is not None and meaning.clause.order != "together":
        last.stays = follows is None
    elif follows is None or not follows.has_effect(Effect.FALL, Effect.RELEASE):
        return [meaning]
    return []


def choose_anchor(told: Held | None, meanings: list[Meaning]) -> AnchorRequest:
    """Choose the hold: an adjective ("rooted"), a motion ("hold the pot"), or an end that "does not move"."""
    if told is not None:
        return AnchorRequest(kind=told.end, words=told.text, described=told.described)
    for meaning in meanings:
        motion = meaning.motion
        if motion is not None and motion.effect is Effect.HOLD:
            end = "none" if meaning.clause.negated else _find_held_end(meaning, motion.holds)
        elif keeps_end(meaning, meanings):
            end = _find_held_end(meaning, None)
        else:
            continue
        return AnchorRequest.model_validate({"kind": end, "words": meaning.text})
    return AnchorRequest()


def keeps_end(meaning: Meaning, meanings: list[Meaning]) -> bool:
    """Return whether a clause says of an end that it is still while the rest moves."""
    still = meaning.has_effect(Effect.STILL) and not meaning.clause.negated
    beside = meaning is meanings[0] or meaning.clause.order != "then"
    return still and beside and _find_held_end(meaning, None) is not None


def _find_held_end(meaning: Meaning, otherwise: str | None) -> str | None:
    """The end that a clause names: "base" or "top"; other parts cannot be held."""
    if not meaning.parts:
        return otherwise
    names = meaning.parts[0].place.names
    return "base" if "down" in names else "top" if "up" in names else None


def _is_bare_hold(meaning: Meaning) -> bool:
    """Return whether a clause only holds the object."""
    motion = meaning.motion
    holds = motion is not None and motion.effect is Effect.HOLD and motion.holds == "base"
    return holds and not meaning.parts and not meaning.clause.negated


def _hangs_in_the_air(meaning: Meaning, last: Meaning | None) -> bool:
    """Return whether what hangs has just been moved, and nothing is told that it hangs from."""
    if meaning.phrase != "hang" or meaning.clause.negated or meaning.clause.order == "together":
        return False
    if last is None or last.clause.negated or meaning.pick(WayKind.FROM, WayKind.PLANE):
        return False
    return last.has_effect(*_RISING)


def _wait(meaning: Meaning) -> Meaning:
    """The same for a time in which nothing moves."""
    return replace(meaning, verb=read_lexicon().motions["wait"], phrase="wait", cause=None)
