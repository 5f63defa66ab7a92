"""What a clause does: its verb, direction, strength, place and time as values.

Directions come from the brief's `DirectionTable` alone; several are added and normalised. A push moves
the object where it is told, whoever pushes or pulls ("pull it to the left" goes left): the sign of
the magnitude is kept for stretching (+) and squeezing (-).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from physagent_jax.agents.rules.language.amounts import MOST, Target, find_target
from physagent_jax.agents.rules.language.clauses import (
    Clause,
    find_excluded,
    find_places,
    find_repeats,
    get_verb,
)
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import ADDRESSEES, FRONTS, Join, Names, Place, Repeat
from physagent_jax.agents.rules.language.naming import has_wheels
from physagent_jax.agents.rules.language.quantities import Quantity
from physagent_jax.agents.rules.language.regions import make_end_region, make_region, sum_directions
from physagent_jax.agents.rules.language.solids import Solid
from physagent_jax.agents.rules.language.timing import TimeSpan
from physagent_jax.agents.rules.language.verbs import (
    LANDINGS,
    PICTURE_PLANE_TURNS,
    TUMBLES,
    TURNED_OVER,
    VERBS,
    Effect,
    Verb,
)
from physagent_jax.agents.schema import Amount, ObstacleRequest, SceneBrief
from physagent_jax.agents.vectors import add, clamp, cosine, cross, dot, normalise, scale
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Region

ASSUMED = "left"
TOLD = "time as told"
_BY_DEFAULT = "by default"
_SIDE_NAMES = frozenset({("left",), ("right",), ("up",), ("down",), ("toward",), ("away",)})

_WAYS = frozenset({MentionKind.DIRECTION, MentionKind.FROM})
_LINES = _WAYS | {MentionKind.AXIS, MentionKind.PLANE}
_PARTED = frozenset({MentionKind.PLACE, MentionKind.EXCLUDED})
_TURNING = frozenset({MentionKind.SENSE, MentionKind.VIEW})
_ALL_SIDES = frozenset({MentionKind.SIDES})
_TELLING = (*_LINES, *_PARTED, *_TURNING, *_ALL_SIDES)
# What each effect makes use of; the rest of `_TELLING` beside it is not understood.
_USED: dict[Effect, frozenset[MentionKind]] = {
    Effect.PUSH: _LINES | _PARTED | _ALL_SIDES,
    Effect.LEAN: _LINES | _PARTED,
    Effect.SWAY: _LINES | _PARTED | _ALL_SIDES,
    Effect.SCALE: _LINES | _PARTED | _ALL_SIDES,
    Effect.SWELL: _PARTED | _ALL_SIDES,
    Effect.STRIKE: _LINES | _PARTED | _ALL_SIDES,
    Effect.BURST: _ALL_SIDES,
    Effect.TURN: _LINES | _PARTED | _TURNING,
    Effect.ROLL: _LINES,
    Effect.FALL: _LINES,
    Effect.TOPPLE: _WAYS,
    Effect.JUMP: _LINES,
    Effect.HOLD: frozenset(_TELLING),
    Effect.RELEASE: _WAYS | _PARTED,
    Effect.STILL: _PARTED,
}
_TOWARDS = (Effect.PUSH, Effect.STRIKE, Effect.SCALE, Effect.LEAN, Effect.ROLL, Effect.JUMP, Effect.TOPPLE)
_ONCE = (Effect.FALL, Effect.TOPPLE, Effect.ROLL, Effect.BURST)


@dataclass(frozen=True)
class ValueSource:
    """Which words led to a value of an event, and by which rule."""

    words: str
    why: str


@dataclass(frozen=True)
class Event:
    """One thing that happens.

    Attributes:
        verb, phrase: What is done, and the lexicon's entry.
        words: The clause's words.
        join: Relation to the event before.
        direction: Unit world direction, stretch axis or rotation axis; None if the verb needs none or
            acts in all directions.
        strength: Magnitude in [0.4, 1.6].
        region: Part of the object; None = all of it.
        part: The end that is named (unit vector towards it); None = none, or a part that is no end.
        excludes_part: ``part`` is the one that is not meant.
        amount: A quantity that the sentence names.
        stays: It is to be held where it was brought.
        even: It is to go at one speed.
        obstacles: Solids that it meets.
        repeat: Count and alternation.
        when: Time that the sentence names.
        wind: A wind does it.
        sources: Where each value comes from.
        notes: Assumptions.
        doubts: What was not understood and matters.
    """

    verb: Verb
    phrase: str
    words: str
    join: Join
    direction: Vector | None
    strength: float
    region: Region | None = None
    part: Vector | None = None
    excludes_part: bool = False
    amount: Amount | None = None
    stays: bool = False
    even: bool = False
    obstacles: tuple[ObstacleRequest, ...] = ()
    repeat: Repeat = Repeat()
    when: TimeSpan = TimeSpan()
    wind: bool = False
    sources: dict[str, ValueSource] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def effect(self) -> Effect:
        """How it acts."""
        return self.verb.effect


def interpret(clause: Clause, before: Event | None, brief: SceneBrief) -> Event:
    """The event that a clause with a verb or a cause describes; ``before`` gives "harder" its measure."""
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
    if phrase == "coast" and clause.select(*_WAYS):
        verb, phrase = VERBS["move"], "move"  # "it coasts to the left"; else it goes on by itself
    if verb.effect is Effect.ROLL and has_wheels(brief):
        verb, phrase = VERBS["push"], "push"  # its wheels turn, and it does not
    if verb.effect is Effect.SWELL and clause.select(*_LINES):
        verb = replace(verb, effect=Effect.SCALE)  # "expands horizontally", "grows upwards"
    if verb.effect is Effect.SWAY:
        clause.modifiers = [m for m in clause.modifiers if m.phrase not in ADDRESSEES]
    words = _quote(clause)
    strength, strength_source = _resolve_strength(clause, verb, before if clause.inherited else None)
    place = next(iter(find_places(clause)), None)
    if verb.effect is Effect.FALL and place is not None and place.names == ("down",):
        place = None  # "lands on its feet", as it stood
    direction, repeat, direction_source, notes = _resolve_direction(clause, verb, phrase, place, brief)
    if verb.effect in (Effect.BURST, Effect.STRIKE, Effect.PUSH, Effect.SWAY, Effect.SCALE, Effect.SWELL):
        verb = _choose_by_direction(verb, clause, direction_source)
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
        if going is not None and verb.effect in _TOWARDS:
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
        sources,
        tuple(notes),
        tuple(doubts),
    )


def _find_way(before: Event | None) -> Vector | None:
    """Where an event went; nothing that turns on the spot goes anywhere."""
    return None if before is None or before.effect not in _TOWARDS else before.direction


def _find_unused(clause: Clause, verb: Verb) -> list[str]:
    """What the clause says of where, which way and how often that means nothing for what its verb does."""
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
    """Whether it tells where something comes down: "as it reaches the ground it is farther to the right"."""
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
    """What a bare wind does: what is held or grows sways, what is free is blown away."""
    return brief.anchored is not None or brief.object_kind == "plant"


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
        if (verb.generic and verb.effect is Effect.PUSH) or struck:
            return cause, clause.cause.phrase
        return replace(verb, brief=verb.brief or cause.brief), phrase
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


def _list_names(mentions: list[Mention]) -> list[Names]:
    return [mention.value for mention in mentions if isinstance(mention.value, tuple)]


def _resolve_direction(
    clause: Clause, verb: Verb, phrase: str, place: Place | None, brief: SceneBrief
) -> tuple[Vector | None, Repeat, ValueSource, list[str]]:
    """Direction (or axis), repetition, source and notes."""
    repeat = _resolve_repeat(clause)
    if verb.effect is Effect.TURN and clause.select(*_TURNING, MentionKind.AXIS, MentionKind.PLANE):
        return *_resolve_turn_axis(clause, verb, phrase, brief, repeat), []
    told = clause.select(MentionKind.DIRECTION, MentionKind.FROM)
    if verb.wrings and place is None and not told and brief.long_axis is not None:
        return brief.long_axis, repeat, ValueSource("", "the object is longest along it"), []
    lines = clause.select(MentionKind.AXIS, MentionKind.PLANE)
    solids = [
        m.value for m in clause.select(MentionKind.SOLID) if isinstance(m.value, Solid) and m.value.kind
    ]
    if told:
        pulled_from = verb.pulls and not clause.select(MentionKind.DIRECTION)  # "pull it from left to right"
        parts: list[Vector] = []
        seen: set[tuple[MentionKind, Names]] = set()
        for mention in told:
            names = mention.value
            if not isinstance(names, tuple) or (mention.kind, names) in seen:
                continue
            seen.add((mention.kind, names))
            sign = -1.0 if mention.kind is MentionKind.FROM and not pulled_from else 1.0
            parts.append(scale(sum_directions(names, brief), sign))
        total, words = normalise(add(parts)), " ".join(mention.words for mention in told)
        if total is None:  # "to the left and to the right": an axis for stretching, to and fro for the rest
            both = verb.effect is Effect.SCALE or bool(clause.select(MentionKind.SIDES))  # "its ends apart"
            total, repeat = normalise(parts[0]), replace(repeat, alternate=not both)
        source = ValueSource(
            words, "the viewer's directions, added" if len(told) > 1 else "the viewer's direction"
        )
    elif lines and not (repeat.names and verb.effect is Effect.SCALE):
        total, source = (
            normalise(sum_directions(_list_names(lines)[0], brief)),
            ValueSource(lines[0].words, "an axis by name"),
        )
    elif repeat.names:
        total = normalise(sum_directions(repeat.names, brief))
        source = ValueSource(clause.select(MentionKind.REPEAT)[0].words, "to and fro, this way first")
        repeat = replace(repeat, alternate=verb.effect is not Effect.SCALE)
        if verb.effect is Effect.TURN and total is not None:
            total = _find_turn_towards(total, brief)
    elif solids and verb.effect in _TOWARDS:
        names = solids[0].names or (ASSUMED,)
        total = normalise(sum_directions(names, brief))
        words = clause.select(MentionKind.SOLID)[0].words
        source = ValueSource(words, "towards what is in the way")
        if not solids[0].names:
            return total, repeat, source, [f"'{words}': no side given, assumed {ASSUMED}."]
    elif place and verb.effect is Effect.STRIKE and clause.select(MentionKind.PLACE)[0].phrase in FRONTS:
        total, source = brief.directions.away, ValueSource(clause.words, "a blow on the front drives it away")
    elif place and place.names and verb.effect is Effect.STRIKE:
        total = normalise(scale(sum_directions(place.names, brief), -1.0))
        source = ValueSource(
            clause.select(MentionKind.PLACE)[0].words, "a blow drives away from the side that it hits"
        )
    else:
        return _assume_direction(clause, verb, brief, repeat)
    if verb.effect is Effect.TURN and told and total is not None:
        tumbles = phrase in TUMBLES and abs(dot(total, brief.directions.up)) < 0.7
        total = find_lean_axis(total, brief) if tumbles else _find_turn_towards(total, brief)
        source = replace(
            source, why=f"{'the top' if tumbles else 'the side that faces the viewer'} turns this way"
        )
    return total, repeat, source, []


def is_way_assumed(event: Event) -> bool:
    """Whether the sentence does not say, as far as it was read, which way an event goes."""
    source = event.sources.get("vector")
    return source is not None and source.why.endswith(_BY_DEFAULT)


def _assume_direction(
    clause: Clause, verb: Verb, brief: SceneBrief, repeat: Repeat
) -> tuple[Vector | None, Repeat, ValueSource, list[str]]:
    """The verb's own direction, else the assumed one with a note."""
    words = clause.words
    if verb.effect in (Effect.FALL, Effect.HOLD, Effect.RELEASE, Effect.STILL, Effect.SWELL, Effect.BURST):
        return None, repeat, ValueSource(words, "needs no direction"), []
    out = [m for m in clause.select(MentionKind.ANCHOR) if m.phrase.startswith("out of")]
    if out and verb.effect is Effect.PUSH:  # "pull it out of the pot"
        return brief.directions.up, repeat, ValueSource(out[0].words, "up, out of what holds it"), []
    sides = [m for m in clause.select(MentionKind.SIDES) if "side" in m.words.lower() and not m.value]
    name = "right" if sides and verb.effect is Effect.SCALE else verb.direction or ASSUMED
    vector = normalise(sum_directions((name,), brief))
    source = ValueSource(words, f"no direction given: {name} {_BY_DEFAULT}")
    if verb.direction:
        return vector, repeat, source, []
    return vector, repeat, source, [f"'{words}': no direction given, assumed {name}."]


def _resolve_turn_axis(
    clause: Clause, verb: Verb, phrase: str, brief: SceneBrief, repeat: Repeat
) -> tuple[Vector | None, Repeat, ValueSource]:
    """Rotation axis from "about the vertical axis", "horizontally", "clockwise", "seen from above".

    Counter-clockwise is right-handed about the axis that points at whoever looks: at the viewer for
    turns in the picture plane, up (seen from above) for spinning and twisting.
    """
    planes: dict[Names, Names] = {
        ("right",): ("up",),
        ("up",): ("right",),
    }  # turning horizontally is about the vertical
    named = [
        (mention, names)
        for mention, names in zip(
            clause.select(MentionKind.AXIS), _list_names(clause.select(MentionKind.AXIS))
        )
    ]
    named += [
        (mention, planes.get(names, names))
        for mention, names in zip(
            clause.select(MentionKind.PLANE), _list_names(clause.select(MentionKind.PLANE))
        )
    ]
    views = clause.select(MentionKind.VIEW)
    senses = clause.select(MentionKind.SENSE)
    told = clause.select(MentionKind.DIRECTION)
    if named:
        axis = sum_directions(named[0][1], brief)
    elif views:
        axis = sum_directions(_list_names(views)[0], brief)
    elif verb.wrings and brief.long_axis is not None and not told:
        axis = brief.long_axis
    else:
        axis = sum_directions(
            ("toward",) if phrase in PICTURE_PLANE_TURNS else (verb.direction or "toward",), brief
        )
    sign = 1.0
    if senses:
        assert isinstance(senses[0].value, int)
        sign = float(senses[0].value)
    elif told:
        sign = (
            1.0
            if dot(axis, _find_turn_towards(sum_directions(_list_names(told)[0], brief), brief)) >= 0
            else -1.0
        )
    words = " ".join(
        mention.words for mention in [*senses, *(mention for mention, _ in named), *views, *told]
    )
    why = "counter-clockwise is right-handed about the axis towards whoever looks"
    return normalise(scale(axis, sign)), repeat, ValueSource(words, why)


def _find_turn_towards(direction: Vector, brief: SceneBrief) -> Vector:
    """Axis about which the viewer's side (or, for toward and away, the top) moves along ``direction``."""
    toward, up = brief.directions.toward, brief.directions.up
    reference = up if abs(cosine(direction, toward)) > 0.7 else toward
    return normalise(cross(reference, direction)) or up


def find_lean_axis(direction: Vector, brief: SceneBrief) -> Vector:
    """Axis about which the top moves along ``direction``."""
    return normalise(cross(brief.directions.up, direction)) or brief.directions.toward


def _choose_by_direction(verb: Verb, clause: Clause, source: ValueSource) -> Verb:
    """Verbs whose kind depends on where they act: from both sides, outward, from one side."""
    sides = clause.select(MentionKind.SIDES)
    told = bool(clause.select(MentionKind.DIRECTION, MentionKind.FROM))
    if verb.effect is Effect.BURST:
        return replace(verb, effect=Effect.STRIKE) if told else verb
    if not sides or verb.effect is Effect.SWAY:
        return verb
    if told and sides[0].phrase == "either side" and verb.effect in (Effect.PUSH, Effect.STRIKE):
        return verb  # "hit it away: by less than a tenth to either side"
    isotropic = bool(sides[0].value)
    if verb.effect in (Effect.PUSH, Effect.STRIKE):
        outward = verb.pulls or "outward" in sides[0].words or sides[0].phrase == "outward"
        verb = replace(verb, effect=Effect.SCALE, sign=1 if outward else -1)
    return replace(verb, effect=Effect.SWELL) if isotropic else verb


def _resolve_repeat(clause: Clause) -> Repeat:
    """All counts of a clause as one: "left and right twice" alternates and counts."""
    found = find_repeats(clause)
    count = next((r.count for r in found if r.count is not None), None)
    names = next((r.names for r in found if r.names), ())
    return Repeat(count, any(r.alternate for r in found), names, any(r.vague for r in found))


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
