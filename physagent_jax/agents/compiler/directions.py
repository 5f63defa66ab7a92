"""The direction of a clause, or the axis of its turn.

Directions come from the brief's `DirectionTable` alone; several are added and normalised. A push moves
the object where it is told, whoever pushes or pulls ("pull it to the left" goes left): the sign of
the magnitude is kept for stretching (+) and squeezing (-).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from physagent_jax.agents.compiler.events import BY_DEFAULT, ValueSource
from physagent_jax.agents.compiler.words import KnownPart, Meaning, WayKind
from physagent_jax.agents.lexicon import Effect, Motion, Names, Repeat, read_lexicon
from physagent_jax.agents.schema import SceneBrief
from physagent_jax.agents.vectors import add, cosine, cross, dot, normalise, scale
from physagent_jax.core.strict import Vector

ASSUMED = "left"
WAYS = (WayKind.TO, WayKind.FROM)
TOWARDS = (Effect.PUSH, Effect.STRIKE, Effect.SCALE, Effect.LEAN, Effect.ROLL, Effect.JUMP, Effect.TOPPLE)
"""What these do goes a way."""
_NO_WAY = (Effect.FALL, Effect.HOLD, Effect.RELEASE, Effect.STILL, Effect.SWELL, Effect.BURST)
_WORLD_AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_NORMALS: dict[Names, Names] = {("right",): ("up",), ("up",): ("right",)}
"""Turning horizontally is about the vertical."""


@dataclass(frozen=True)
class Heading:
    """Where a motion goes.

    Attributes:
        vector: Unit direction or axis; None = needs none.
        repeat: The clause's counts, alternating where two opposite ways are told.
        source: The words that led to it.
        notes: What was assumed.
    """

    vector: Vector | None
    repeat: Repeat
    source: ValueSource
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Case:
    """A clause whose direction is asked for."""

    meaning: Meaning
    motion: Motion
    part: KnownPart | None
    repeat: Repeat
    brief: SceneBrief

    def sum(self, names: Names) -> Vector | None:
        """Unit vector of the sum of named directions."""
        return normalise(sum_directions(names, self.brief))


def sum_directions(names: Names, brief: SceneBrief) -> Vector:
    """Sum of named directions (not normalised)."""
    along = {
        "long": brief.long_axis or brief.directions.up,
        "lengthwise": brief.long_axis or brief.directions.right,
    }
    known = _WORLD_AXES | along
    return add(known.get(name) or getattr(brief.directions, name) for name in names)


def resolve_direction(
    meaning: Meaning, motion: Motion, part: KnownPart | None, repeat: Repeat, brief: SceneBrief
) -> Heading:
    """The heading that the clause's words tell, in the order in which they take precedence."""
    case = _Case(meaning, motion, part, repeat, brief)
    for find in (_find_axis, _find_long_axis, _add_ways, _find_line, _find_swing, _find_obstacle, _find_blow):
        heading = find(case)
        if heading is not None:
            return heading
    return _assume(case)


def _find_axis(case: _Case) -> Heading | None:
    """Rotation axis from "about the vertical axis", "horizontally", "clockwise", "seen from above".

    Counter-clockwise is right-handed about the axis that points at whoever looks: at the viewer for
    turns in the picture plane, up (seen from above) for spinning and twisting.
    """
    clause, motion, brief = case.meaning.clause, case.motion, case.brief
    lines = [(way, way.names) for way in case.meaning.pick(WayKind.LINE)]
    lines += [(way, _NORMALS.get(way.names, way.names)) for way in case.meaning.pick(WayKind.PLANE)]
    if motion.effect is not Effect.TURN or not (lines or clause.turning or clause.seen_from):
        return None
    told = case.meaning.pick(WayKind.TO)
    if lines:
        axis = sum_directions(lines[0][1], brief)
    elif clause.seen_from:
        axis = sum_directions((clause.seen_from,), brief)
    elif motion.wrings and brief.long_axis is not None and not told:
        axis = brief.long_axis
    else:
        axis = sum_directions(("toward",) if motion.picture else (motion.direction or "toward",), brief)
    sign = 1.0
    if clause.turning:
        sign = 1.0 if clause.turning == "counterclockwise" else -1.0
    elif told:
        towards = _find_turn_towards(sum_directions(told[0].names, brief), brief)
        sign = 1.0 if dot(axis, towards) >= 0 else -1.0
    words = [clause.turning or "", *(way.text for way, _ in lines), *(way.text for way in told)]
    if clause.seen_from:
        words.insert(1, f"seen from {clause.seen_from}")
    why = "counter-clockwise is right-handed about the axis towards whoever looks"
    source = ValueSource(" ".join(word for word in words if word), why)
    return Heading(normalise(scale(axis, sign)), case.repeat, source)


def _find_long_axis(case: _Case) -> Heading | None:
    wrung = case.motion.wrings and case.part is None and not case.meaning.pick(*WAYS)
    if not wrung or case.brief.long_axis is None:
        return None
    return Heading(case.brief.long_axis, case.repeat, ValueSource("", "the object is longest along it"))


def _add_ways(case: _Case) -> Heading | None:
    """The sum of all ways that are told."""
    told, repeat, brief = case.meaning.pick(*WAYS), case.repeat, case.brief
    if not told:
        return None
    pulled_from = case.motion.pulls and not case.meaning.pick(WayKind.TO)  # "pull it from left to right"
    distinct = dict.fromkeys((way.kind, way.names) for way in told)
    parts = [
        scale(sum_directions(names, brief), -1.0 if kind is WayKind.FROM and not pulled_from else 1.0)
        for kind, names in distinct
    ]
    total, words = normalise(add(parts)), " ".join(way.text for way in told)
    if total is None:  # "to the left and to the right": an axis for stretching, to and fro for the rest
        both = case.motion.effect is Effect.SCALE or bool(
            case.meaning.pick(WayKind.SIDES)
        )  # "its ends apart"
        total, repeat = normalise(parts[0]), replace(repeat, alternate=not both)
    why = "the viewer's directions, added" if len(told) > 1 else "the viewer's direction"
    if case.motion.effect is Effect.TURN and total is not None:
        tumbles = case.motion.tumbles and abs(dot(total, brief.directions.up)) < 0.7
        total = find_lean_axis(total, brief) if tumbles else _find_turn_towards(total, brief)
        why = f"{'the top' if tumbles else 'the side that faces the viewer'} turns this way"
    return Heading(total, repeat, ValueSource(words, why))


def _find_line(case: _Case) -> Heading | None:
    lines = case.meaning.pick(WayKind.LINE, WayKind.PLANE)
    if not lines or case.repeat.names and case.motion.effect is Effect.SCALE:
        return None
    return Heading(case.sum(lines[0].names), case.repeat, ValueSource(lines[0].text, "an axis by name"))


def _find_swing(case: _Case) -> Heading | None:
    """The first swing of "left and right"."""
    total = case.sum(case.repeat.names)
    if total is None:
        return None
    if case.motion.effect is Effect.TURN:
        total = _find_turn_towards(total, case.brief)
    words = next(each.text or each.first or "" for each in case.meaning.clause.repetitions if each.first)
    repeat = replace(case.repeat, alternate=case.motion.effect is not Effect.SCALE)
    return Heading(total, repeat, ValueSource(words, "to and fro, this way first"))


def _find_obstacle(case: _Case) -> Heading | None:
    """Towards the wall that it meets."""
    solids = case.meaning.clause.solids
    if not solids or case.motion.effect not in TOWARDS:
        return None
    words = solids[0].text or solids[0].kind
    told = case.sum(solids[0].sides)
    notes = () if told else (f"'{words}': no side given, assumed {ASSUMED}.",)
    source = ValueSource(words, "towards what is in the way")
    return Heading(told or case.sum((ASSUMED,)), case.repeat, source, notes)


def _find_blow(case: _Case) -> Heading | None:
    """A blow on a side drives away from it."""
    if case.part is None or case.motion.effect is not Effect.STRIKE:
        return None
    if case.part.phrase in read_lexicon().fronts:
        source = ValueSource(case.meaning.words, "a blow on the front drives it away")
        return Heading(case.brief.directions.away, case.repeat, source)
    total = case.sum(case.part.place.names)
    if total is None:
        return None
    source = ValueSource(case.part.text, "a blow drives away from the side that it hits")
    return Heading(scale(total, -1.0), case.repeat, source)


def _assume(case: _Case) -> Heading:
    """The motion's own direction, else the assumed one with a note."""
    motion, words = case.motion, case.meaning.words
    if motion.effect in _NO_WAY:
        return Heading(None, case.repeat, ValueSource(words, "needs no direction"))
    sides = any("side" in way.phrase and way.names == ("both",) for way in case.meaning.pick(WayKind.SIDES))
    name = "right" if sides and motion.effect is Effect.SCALE else motion.direction or ASSUMED
    missing = "no axis given: it points" if motion.effect is Effect.TURN else "no direction given:"
    source = ValueSource(words, f"{missing} {name} {BY_DEFAULT}")
    notes = () if motion.direction else (f"'{words}': no direction given, assumed {name}.",)
    return Heading(case.sum((name,)), case.repeat, source, notes)


def _find_turn_towards(direction: Vector, brief: SceneBrief) -> Vector:
    """Axis about which the viewer's side (or, for toward and away, the top) moves along ``direction``."""
    toward, up = brief.directions.toward, brief.directions.up
    reference = up if abs(cosine(direction, toward)) > 0.7 else toward
    return normalise(cross(reference, direction)) or up


def find_lean_axis(direction: Vector, brief: SceneBrief) -> Vector:
    """Axis about which the top moves along ``direction``."""
    return normalise(cross(brief.directions.up, direction)) or brief.directions.toward
