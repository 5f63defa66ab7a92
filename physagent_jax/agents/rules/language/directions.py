"""The direction of a clause, or the axis of its turn.

Directions come from the brief's `DirectionTable` alone; several are added and normalised. A push moves
the object where it is told, whoever pushes or pulls ("pull it to the left" goes left): the sign of
the magnitude is kept for stretching (+) and squeezing (-).
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.rules.language.clauses import Clause, find_repeats
from physagent_jax.agents.rules.language.events import BY_DEFAULT, ValueSource
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import FRONTS, Names, Place, Repeat
from physagent_jax.agents.rules.language.regions import sum_directions
from physagent_jax.agents.rules.language.solids import Solid
from physagent_jax.agents.rules.language.verbs import PICTURE_PLANE_TURNS, TUMBLES, Effect, Verb
from physagent_jax.agents.schema import SceneBrief
from physagent_jax.agents.vectors import add, cosine, cross, dot, normalise, scale
from physagent_jax.core.strict import Vector

ASSUMED = "left"
WAYS = frozenset({MentionKind.DIRECTION, MentionKind.FROM})
TURNING = frozenset({MentionKind.SENSE, MentionKind.VIEW})
TOWARDS = (Effect.PUSH, Effect.STRIKE, Effect.SCALE, Effect.LEAN, Effect.ROLL, Effect.JUMP, Effect.TOPPLE)
"""Effects that go a way."""


def resolve_direction(
    clause: Clause, verb: Verb, phrase: str, place: Place | None, brief: SceneBrief
) -> tuple[Vector | None, Repeat, ValueSource, list[str]]:
    """Direction (or axis), repetition, source and notes."""
    repeat = _resolve_repeat(clause)
    if verb.effect is Effect.TURN and clause.select(*TURNING, MentionKind.AXIS, MentionKind.PLANE):
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
    elif solids and verb.effect in TOWARDS:
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
    missing = "no axis given: it points" if verb.effect is Effect.TURN else "no direction given:"
    source = ValueSource(words, f"{missing} {name} {BY_DEFAULT}")
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


def choose_by_direction(verb: Verb, clause: Clause, source: ValueSource) -> Verb:
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


def _list_names(mentions: list[Mention]) -> list[Names]:
    return [mention.value for mention in mentions if isinstance(mention.value, tuple)]
