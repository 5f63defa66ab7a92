"""The interpretation of a clause: its verb, direction, strength, place and time as values of an event."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.rules.language.amounts import MOST, Target, find_target
from physagent_jax.agents.rules.language.clauses import (
    Clause,
    find_excluded,
    find_places,
    find_repeats,
    get_verb,
)
from physagent_jax.agents.rules.language.directions import (
    TOWARDS,
    TURNING,
    WAYS,
    choose_by_direction,
    resolve_direction,
)
from physagent_jax.agents.rules.language.events import TOLD, Event, ValueSource
from physagent_jax.agents.rules.language.mentions import MentionKind
from physagent_jax.agents.rules.language.modifiers import ADDRESSEES, Place, Repeat
from physagent_jax.agents.rules.language.naming import has_wheels
from physagent_jax.agents.rules.language.quantities import Quantity
from physagent_jax.agents.rules.language.regions import make_end_region, make_region, sum_directions
from physagent_jax.agents.rules.language.solids import Solid
from physagent_jax.agents.rules.language.timing import TimeSpan
from physagent_jax.agents.rules.language.verbs import (
    LANDINGS,
    TURNED_OVER,
    VERBS,
    WHOLE_TURNS,
    Effect,
    Verb,
)
from physagent_jax.agents.schema import Amount, ObstacleRequest, SceneBrief
from physagent_jax.agents.vectors import clamp, normalise, scale
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Region

_SIDE_NAMES = frozenset({("left",), ("right",), ("up",), ("down",), ("toward",), ("away",)})
_LINES = WAYS | {MentionKind.AXIS, MentionKind.PLANE}
_PARTED = frozenset({MentionKind.PLACE, MentionKind.EXCLUDED})
_ALL_SIDES = frozenset({MentionKind.SIDES})
_TELLING = (*_LINES, *_PARTED, *TURNING, *_ALL_SIDES)
# What each effect makes use of; the rest of `_TELLING` beside it is not understood.
_USED: dict[Effect, frozenset[MentionKind]] = {
    Effect.PUSH: _LINES | _PARTED | _ALL_SIDES,
    Effect.LEAN: _LINES | _PARTED,
    Effect.SWAY: _LINES | _PARTED | _ALL_SIDES,
    Effect.SCALE: _LINES | _PARTED | _ALL_SIDES,
    Effect.SWELL: _PARTED | _ALL_SIDES,
    Effect.STRIKE: _LINES | _PARTED | _ALL_SIDES,
    Effect.BURST: _ALL_SIDES,
    Effect.TURN: _LINES | _PARTED | TURNING,
    Effect.ROLL: _LINES,
    Effect.FALL: _LINES,
    Effect.TOPPLE: WAYS,
    Effect.JUMP: _LINES,
    Effect.HOLD: frozenset(_TELLING),
    Effect.RELEASE: WAYS | _PARTED,
    Effect.STILL: _PARTED,
}
_ONCE = (Effect.FALL, Effect.TOPPLE, Effect.ROLL, Effect.BURST)


def interpret(clause: Clause, before: Event | None, brief: SceneBrief) -> Event:
    """The event that a clause with a verb or a cause describes; ``before`` gives "harder" its measure."""
    verb, phrase = _find_verb(clause, brief)
    if verb.effect is Effect.SWAY:
        clause.modifiers = [m for m in clause.modifiers if m.phrase not in ADDRESSEES]
    words = _quote(clause)
    strength, strength_source = _resolve_strength(clause, verb, before if clause.inherited else None)
    place = next(iter(find_places(clause)), None)
    if verb.effect is Effect.FALL and place is not None and place.names == ("down",):
        place = None  # "lands on its feet", as it stood
    direction, repeat, direction_source, notes = resolve_direction(clause, verb, phrase, place, brief)
    if verb.effect in (Effect.BURST, Effect.STRIKE, Effect.PUSH, Effect.SWAY, Effect.SCALE, Effect.SWELL):
        verb = choose_by_direction(verb, clause, direction_source)
        if verb.effect is Effect.SWELL:
            direction = None
        elif verb.effect is Effect.SCALE and direction is None:
            direction = sum_directions(("right",), brief)
    driven = (
        verb.effect is Effect.TOPPLE and before is not None and before.effect in (Effect.PUSH, Effect.STRIKE)
    )
    likewise = before is not None and before.effect is verb.effect
    likewise = likewise and (verb.effect is not Effect.SWAY or before is not None and before.phrase == phrase)
    if notes and before is not None and (likewise or driven):
        direction, notes = before.direction, []  # "push it to the right, then push it harder"
        direction_source = replace(direction_source, why="no direction given: as before")
    if (
        before is not None
        and before.direction is not None
        and any(m.phrase == "back" for m in clause.select(MentionKind.DIRECTION))
    ):
        direction = scale(before.direction, -1.0)
        direction_source = replace(direction_source, why="back where it came from")
    target, doubts = _resolve_amount(clause, verb, before)
    if verb.effect is Effect.TURN and repeat.count is not None and not repeat.alternate and not target.amount:
        if not repeat.vague:  # "spin three times" counts turns
            target = Target(Amount(value=min(360.0 * repeat.count, MOST), unit="degrees"))
            if 360.0 * repeat.count > MOST:
                doubts.append(f"So many turns ('{words}') cannot be shown.")
        repeat = replace(repeat, count=None)
    if phrase in TURNED_OVER and target.amount is None:
        target = Target(Amount(value=180.0, unit="degrees"))
    if phrase in WHOLE_TURNS and target.amount is None:
        target = Target(Amount(value=360.0, unit="degrees"))
    if target.everywhere:
        verb, direction = replace(verb, effect=Effect.SWELL), None
    elif target.names and not clause.select(MentionKind.DIRECTION, MentionKind.FROM):
        verb = replace(verb, effect=Effect.SCALE)
        direction = normalise(sum_directions(target.names, brief))
    starts = [
        m
        for m in clause.select(MentionKind.TIME)
        if isinstance(m.value, TimeSpan) and (m.value.start or m.words.lower().startswith("at the "))
    ]
    if len(starts) > 1:
        doubts.append(f"Which of it happens when ({', '.join(m.words for m in starts)}) is not understood.")
    if verb.effect in (Effect.RELEASE, Effect.STILL) and (repeat.count or 1) > 1:
        doubts.append(f"What is repeated by '{words}' is not understood.")
    reversals = clause.select(MentionKind.REVERSAL)
    if reversals and reversals[0].value == "same":
        going = _find_way(before)
        if going is not None and verb.effect in TOWARDS:
            direction, notes = going, []
            direction_source = replace(direction_source, why="the same way as before")
        else:
            doubts.append(f"Which way '{reversals[0].words}' is, is not understood.")
    elif reversals:
        if before is not None and before.direction is not None and before.effect is verb.effect:
            direction, notes = scale(before.direction, -1.0), []
            direction_source = replace(direction_source, why="the other way than before")
        else:
            doubts.append(f"What '{reversals[0].words}' is opposed to is not understood.")
    doubts += _find_unused(clause, verb)
    if phrase in ("droop", "sag") and brief.object_kind not in ("plant", "cloth", "animal"):
        doubts.append(f"How it '{phrase}s' is not understood.")
    whole_part, region_doubts = _resolve_part(clause, verb, place, brief)
    region, part, excludes = whole_part
    doubts += region_doubts
    obstacles = tuple(resolve_obstacles(clause, direction, brief))
    sources = {
        "action_type": ValueSource(clause.words, f"'{phrase}' is a {verb.effect.value}"),
        "magnitude": strength_source,
    }
    sources["vector"] = direction_source
    if place:
        sources["region"] = ValueSource(clause.select(MentionKind.PLACE)[0].words, "a part of the object")
    when, when_source = _resolve_time(clause, verb)
    sources["active_time"] = when_source
    return Event(
        verb,
        phrase,
        words,
        clause.join,
        direction,
        strength,
        region,
        part,
        excludes,
        target.amount,
        clause.stays,
        bool(clause.select(MentionKind.EVEN)),
        obstacles,
        repeat,
        when,
        any(get_verb(m).wind for m in (clause.cause, clause.verb) if m is not None),
        clause.elsewhere,
        sources,
        tuple(notes),
        tuple(doubts),
    )


def _find_way(before: Event | None) -> Vector | None:
    """The way of an event; nothing that turns on the spot goes anywhere."""
    return None if before is None or before.effect not in TOWARDS else before.direction


def _find_unused(clause: Clause, verb: Verb) -> list[str]:
    """Find words about place, direction and number that mean nothing for the clause's verb."""
    unused = [m for m in clause.select(*_TELLING) if m.kind not in _USED[verb.effect]]
    if verb.effect is Effect.FALL:
        first = (
            clause.verb.first if clause.verb is not None else -1
        )  # "lands on its feet", not "its feet fall"
        unused = [m for m in unused if m.first < first or getattr(m.value, "names", ()) != ("down",)]
    counted = verb.effect in _ONCE and any((r.count or 1) > 1 or r.alternate for r in find_repeats(clause))
    unused += clause.select(MentionKind.REPEAT) if counted else []
    lengths = [m for m in clause.select(MentionKind.TIME) if isinstance(m.value, TimeSpan) and m.value.length]
    counts = [m for m in clause.select(MentionKind.REPEAT) if isinstance(m.value, Repeat) and m.value.count]
    for several in (lengths, counts):
        unused += several[1:]
    return [f"What '{m.words}' means for '{clause.words}' is not understood." for m in unused]


def _resolve_amount(clause: Clause, verb: Verb, before: Event | None) -> tuple[Target, list[str]]:
    """The target that the clause's quantity sets, and what its quantities say that cannot be used."""
    target, doubts = Target(None), []
    for mention in clause.select(MentionKind.QUANTITY):
        assert isinstance(mention.value, Quantity)
        landing = replace(verb, effect=Effect.PUSH) if lands_aside(clause) else verb
        found = find_target(mention.value, landing, before.amount if before else None)
        if found.usual:
            continue
        if found.amount is None or target.amount is not None:
            doubts.append(f"'{mention.words}' is a quantity that nothing here is measured in.")
        else:
            target = found
    return target, doubts


def lands_aside(clause: Clause) -> bool:
    """Return whether it tells where something comes down: "as it reaches the ground it is farther to the right"."""
    lands = clause.verb is not None and clause.verb.phrase in LANDINGS and not clause.negated
    ways = [m.value for m in clause.select(MentionKind.DIRECTION)]
    return lands and any(way not in (("up",), ("down",)) for way in ways)


def _resolve_part(
    clause: Clause, verb: Verb, place: Place | None, brief: SceneBrief
) -> tuple[tuple[Region | None, Vector | None, bool], list[str]]:
    """(region, named end, whether that end is excepted), and what cannot be had."""
    doubts = []
    excluded = find_excluded(clause)
    opposite = verb.effect is Effect.TURN and len({p.names for p in find_places(clause)} & _SIDE_NAMES) == 2
    if len(find_places(clause)) + len(excluded) > 1 and not opposite:  # "one end against the other"
        words = ", ".join(m.words for m in clause.select(MentionKind.PLACE, MentionKind.EXCLUDED))
        doubts.append(f"Of several parts ({words}) only the first is used.")
    if place is None and excluded:
        except_names = excluded[0].names
        end = normalise(sum_directions(except_names, brief)) if except_names else None
        if end is None:
            words = clause.select(MentionKind.EXCLUDED)[0].words
            return (None, None, False), [*doubts, f"All but '{words}' cannot be acted on."]
        return (make_end_region(scale(end, -1.0), 1.0 - excluded[0].start), end, True), doubts
    if place is None:
        return (None, None, False), doubts
    region, problem = make_region(place, brief)
    if problem:
        return (None, None, False), [*doubts, problem]
    return (region, normalise(sum_directions(place.names, brief)) if place.names else None, False), doubts


def resolve_obstacles(clause: Clause, way: Vector | None, brief: SceneBrief) -> list[ObstacleRequest]:
    """The walls and blocks that a clause names; those without a place of their own stand in the way."""
    found = []
    for mention in clause.select(MentionKind.SOLID):
        solid = mention.value
        assert isinstance(solid, Solid) and solid.kind
        direction = normalise(sum_directions(solid.names, brief)) if solid.names else way
        if direction is not None:
            found.append(ObstacleRequest(kind=solid.kind, direction=direction, words=mention.words))
        if solid.opposite:
            other = normalise(sum_directions(solid.opposite, brief))
            assert other is not None
            found.append(ObstacleRequest(kind=solid.kind, direction=other, words=mention.words))
    return found


def _is_swaying_in_wind(brief: SceneBrief) -> bool:
    """Return whether a bare wind makes it sway: what is held or grows sways, what is free is blown away."""
    return brief.anchored is not None or brief.object_kind == "plant"


def _find_verb(clause: Clause, brief: SceneBrief) -> tuple[Verb, str]:
    """The clause's verb as what stands beside it makes it, and the phrase that it then goes by."""
    verb, phrase = _choose_verb(clause)
    if (
        verb.effect is Effect.ROLL
        and clause.select(MentionKind.SENSE)
        and not clause.select(MentionKind.DIRECTION, MentionKind.FROM)
    ):
        verb = replace(verb, effect=Effect.TURN, direction="toward")  # rolls on the spot
    if (
        clause.verb is None
        and verb.wind
        and not clause.select(MentionKind.DIRECTION, MentionKind.FROM)
        and _is_swaying_in_wind(brief)
    ):
        verb, phrase = replace(VERBS["sway"], strength=verb.strength), "sway"
    if verb.effect is Effect.FALL and any(repeat.alternate for repeat in find_repeats(clause)):
        verb, phrase = VERBS["bob"], "bob"  # "bounces up and down"
    if verb.gravity and any(repeat.alternate for repeat in find_repeats(clause)):
        phrase = (
            "bob" if verb.effect is Effect.JUMP else "sway"
        )  # "jumps up and down", "is tossed to and fro"
        verb = VERBS[phrase]
    if phrase == "bounce" and any(m.value == ("up",) for m in clause.select(MentionKind.DIRECTION)):
        verb, phrase = VERBS["jump"], "jump"
    if phrase == "bounce" and any((repeat.count or 1) > 1 for repeat in find_repeats(clause)):
        verb, phrase = VERBS["jump"], "jump"  # "it bounces three times"
    if phrase == "coast" and clause.select(*WAYS):
        verb, phrase = VERBS["move"], "move"  # "it coasts to the left"; else it goes on by itself
    if verb.effect is Effect.ROLL and has_wheels(brief):
        verb, phrase = VERBS["push"], "push"  # its wheels turn, and it does not
    if verb.effect is Effect.SWELL and clause.select(*_LINES):
        verb = replace(verb, effect=Effect.SCALE)  # "expands horizontally", "grows upwards"
    return verb, phrase


def _choose_verb(clause: Clause) -> tuple[Verb, str]:
    """The verb; a wind that "hits" pushes, a cause of generic motion ("sends it") gives its own kind."""
    if clause.verb is None:
        assert clause.cause is not None
        return get_verb(clause.cause), clause.cause.phrase
    verb, phrase = get_verb(clause.verb), clause.verb.phrase
    if clause.cause is not None:
        cause = get_verb(clause.cause)
        quakes = cause.effect is Effect.SWAY and phrase in ("hit", "strike")
        struck = (cause.wind and verb.effect is Effect.STRIKE) or quakes  # "an earthquake hits"
        named = cause.skill is not None and verb.effect is Effect.STRIKE  # "a vortex hits it"
        if (verb.generic and verb.effect is Effect.PUSH) or struck or named:
            return cause, clause.cause.phrase
        skill = cause.skill if verb.effect is cause.effect else verb.skill  # "a vortex spins it"
        return replace(verb, brief=verb.brief or cause.brief, skill=skill), phrase
    return verb, phrase


def _quote(clause: Clause) -> str:
    """The clause's own words, in their order."""
    mentions = [m for m in clause.mentions if m.words] or [m for m in (clause.verb, clause.cause) if m]
    return " ".join(m.words for m in sorted(mentions, key=lambda m: m.first))


def _resolve_strength(clause: Clause, verb: Verb, before: Event | None) -> tuple[float, ValueSource]:
    """Base strength of verb and cause times the intensities; degrees widen the next one's distance from 1."""
    value = verb.strength
    if clause.cause is not None and clause.verb is not None and get_verb(clause.cause) is not verb:
        value *= (
            get_verb(clause.cause).strength if get_verb(clause.verb) is not get_verb(clause.cause) else 1.0
        )
    words, degree = [], 1.0
    for mention in clause.select(MentionKind.DEGREE, MentionKind.INTENSITY, MentionKind.COMPARATIVE):
        assert isinstance(mention.value, float)
        words.append(mention.words)
        if mention.kind is MentionKind.DEGREE:
            degree = mention.value
        elif mention.kind is MentionKind.INTENSITY:
            value *= 1.0 + (mention.value - 1.0) * degree
            degree = 1.0
        else:
            value = mention.value * (before.strength if before else value)
    told = [m.value for m in clause.select(MentionKind.INTENSITY) if isinstance(m.value, float)]
    if (
        told and degree == 1.0 and verb.strength >= 0.8
    ):  # a word for how strong it is outweighs the verb's own
        value = max(value, 1.2) if min(told) >= 1.3 else min(value, 0.7) if max(told) <= 0.6 else value
    value = round(clamp(value, MAGNITUDE_MIN, MAGNITUDE_MAX), 3)
    if words:
        return value, ValueSource(", ".join(words), "intensity words")
    why = "the word's own strength" if value != 1.0 else "no intensity word: plain"
    return value, ValueSource(clause.words, why)


def _resolve_time(clause: Clause, verb: Verb) -> tuple[TimeSpan, ValueSource]:
    mentions = clause.select(MentionKind.TIME)
    when = TimeSpan()
    for mention in mentions:
        assert isinstance(mention.value, TimeSpan)
        told = mention.value
        latest = told if told.length else when
        when = TimeSpan(told.start or when.start, latest.length, latest.whole, latest.total)
    if mentions:
        return when, ValueSource(", ".join(mention.words for mention in mentions), TOLD)
    return when, ValueSource(clause.words, "its share of the sequence")
