"""The direction of a clause, or the axis of its turn.

Directions come from the brief's `DirectionTable` alone; several are added and normalised. A push moves
the object where it is told, whoever pushes or pulls ("pull it to the left" goes left): the sign of
the magnitude is kept for stretching (+) and squeezing (-).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from physagent_jax.agents.compiler.events import BY_DEFAULT, WAYS, Event, KnownPart, ValueSource, WayKind
from physagent_jax.agents.lexicon import Effect, Names, read_lexicon
from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import split_name
from physagent_jax.motion.axes import find_lean_axis, find_turn_towards
from physagent_jax.motion.limbs import sum_directions
from physagent_jax.motion.schema import Amount, SceneBrief
from physagent_jax.motion.swaying import lies
from physagent_jax.motion.tipping import find_own_side
from physagent_jax.motion.vectors import add, cross, dot, normalise, rotate, scale

ASSUMED = "left"
TOWARDS = (Effect.PUSH, Effect.STRIKE, Effect.SCALE, Effect.LEAN, Effect.ROLL, Effect.JUMP, Effect.TOPPLE)
"""Effects that go a way."""
_NO_WAY = (Effect.FALL, Effect.HOLD, Effect.RELEASE, Effect.STILL, Effect.SWELL, Effect.BURST)
_FOOT = 0.9  # cosine to the vertical from which on a side is what it stands on
_LEVEL = 0.5  # cosine to the vertical below which a way is level
_NORMALS: dict[Names, Names] = {("right",): ("up",), ("up",): ("right",)}
"""Turning horizontally is about the vertical."""
_AHEAD = ("ahead", "behind")
_OWN_ENDS = dict(toward="ahead", away="behind")
_INWARDS = 0.1  # cosine to the viewer, above which a circle would lie before the object
_SAME, _ALL_ROUND = 0.99, 360.0  # cosine; [degrees]


class Heading(NamedTuple):
    """Unit direction or axis (None = needs none), the words that led to it, and the rule."""

    vector: Vector | None
    words: str
    why: str


def take_heading(event: Event, brief: SceneBrief) -> None:
    """Set the direction that the clause's words tell, in the order in which they take precedence."""
    rules = (_find_axis, _find_long_axis, _add_ways, _find_line, _find_swing, _find_obstacle, _find_blow)
    found = (rule(event, brief) for rule in rules)
    heading = next((each for each in found if each is not None), None) or _assume(event, brief)
    way = heading.vector
    falls = event.effect is Effect.TOPPLE and way is not None and not event.parts
    event.direction = falls and way and find_own_side(way, brief) or way
    event.sources["vector"] = ValueSource(heading.words, heading.why)


def has_wheels(brief: SceneBrief) -> bool:
    """Return whether it rolls on wheels, and so stays upright when it is rolled."""
    named, wheeled = split_name(brief.object_name), read_lexicon().wheeled
    wheels = ({"wheel", "wheels"} & {*split_name(part.name)} for part in brief.parts)
    return brief.object_kind == "vehicle" or not wheeled.isdisjoint(named) or any(wheels)


def find_side(part: KnownPart, brief: SceneBrief) -> Vector | None:
    """The way to the side that a part tells (unit world vector), of a vehicle its own front or rear; None = none."""
    own = _OWN_ENDS if has_wheels(brief) else {}
    return normalise(sum_directions([own.get(name, name) for name in part.place.names], brief))


def _sum_own(names: Names, event: Event, brief: SceneBrief) -> Vector:
    """The sum of directions by their names; the object's own turn with what it did before."""
    total = sum_directions(names, brief)
    turned = event.facing and not set(_AHEAD).isdisjoint(names)
    return rotate(total, scale(brief.directions.up, event.facing)) if turned else total


def _find_axis(event: Event, brief: SceneBrief) -> Heading | None:
    """Rotation axis from "about the vertical axis", "horizontally", "clockwise", "seen from above".

    Counter-clockwise is right-handed about the axis that points at whoever looks: at the viewer for
    turns in the picture plane, up (seen from above) for spinning and twisting.
    """
    motion = event.motion
    turning, seen_from = event.clause.turning, event.clause.seen_from
    lines = [*event.pick(WayKind.LINE), *event.pick(WayKind.PLANE)]
    if motion.effect is not Effect.TURN or not (lines or turning or seen_from):
        return None
    told = event.pick(WayKind.TO)
    if lines:
        names = lines[0].names
        sideways = lines[0].kind is WayKind.PLANE and names == ("right",)
        if sideways and (motion.tumbles or motion.direction == "own"):  # "rolls over sideways"
            names = ("own",) if motion.direction == "own" else ("toward",)
        axis = sum_directions(_NORMALS.get(names, names) if lines[0].kind is WayKind.PLANE else names, brief)
    elif motion.wrings and brief.long_axis is not None and not (told or seen_from):
        axis = brief.long_axis
    else:
        usual = "toward" if motion.picture else motion.direction or "toward"
        axis = sum_directions((seen_from or usual,), brief)
    towards = find_turn_towards(sum_directions(told[0].names, brief), brief) if told else axis
    backwards = turning == "clockwise" if turning else dot(axis, towards) < 0
    seen = f"seen from {seen_from}" if seen_from else ""
    words = [turning or "", seen, *(way.text for way in (*lines, *told))]
    why = "counter-clockwise is right-handed about the axis towards whoever looks"
    return Heading(normalise(scale(axis, -1.0 if backwards else 1.0)), " ".join(filter(None, words)), why)


def _find_long_axis(event: Event, brief: SceneBrief) -> Heading | None:
    wrung = event.motion.wrings and not (event.parts or event.pick(*WAYS))
    if not wrung or brief.long_axis is None:
        return None
    return Heading(brief.long_axis, "", "the object is longest along it")


def _add_ways(event: Event, brief: SceneBrief) -> Heading | None:
    """The sum of all ways that are told."""
    motion, up = event.motion, brief.directions.up
    rolls = event.effect is Effect.ROLL and brief.world == "ground"  # "rolls down to the left"
    told = [way for way in event.pick(*WAYS) if not rolls or way.names != ("down",)]
    if not told:
        return None
    pulled_from = motion.pulls and not event.pick(WayKind.TO)  # "pull it from left to right"
    drives = event.effect in TOWARDS and not event.parts and has_wheels(brief)
    goes = motion.direction in _AHEAD or drives or bool(event.facing)
    own = read_lexicon().own_ways if goes else {}  # "walks forward"
    distinct = dict.fromkeys((way.kind, own.get(way.phrase, way.names)) for way in told)
    parts = [
        scale(_sum_own(names, event, brief), -1.0 if kind is WayKind.FROM and not pulled_from else 1.0)
        for kind, names in distinct
    ]
    total = normalise(add(parts))
    if total is None:  # "to the left and to the right": an axis for stretching, to and fro for the rest
        total = normalise(parts[0])
        both = motion.effect is Effect.SCALE or event.pick(WayKind.SIDES)  # "its ends apart"
        event.repeat = replace(event.repeat, alternate=not both)
    rises = motion.effect is Effect.PUSH and motion.direction == "up" and not motion.floats
    lifted = rises and not event.parts and bool(event.pick(WayKind.TO))
    if lifted and total is not None and abs(dot(total, up)) < _LEVEL:
        total = normalise(add([total, up]))  # "it takes off to the right"
    why = "the viewer's directions, added" if len(told) > 1 else "the viewer's direction"
    around = [each for each in event.clause.quantities if each.unit == "degrees" and each.value == _ALL_ROUND]
    goes = total is not None and dot(total, brief.directions.away) > _SAME and (around or not event.is_back)
    halfway = goes and not (motion.tumbles or event.clause.inherited)
    if motion.effect is Effect.TURN and halfway:  # "all the way round to the back"; "turn it back" returns
        quantities = [each for each in event.clause.quantities if each not in around]
        event.clause = event.clause.model_copy(update=dict(quantities=quantities))
        event.amount = event.amount or Amount(value=180.0, unit="degrees")
        return Heading(up, " ".join(way.text for way in told), "what faces the viewer turns to the back")
    if motion.effect is Effect.TURN and total is not None:
        tumbles = motion.tumbles and abs(dot(total, up)) < 0.7
        total = find_lean_axis(total, brief) if tumbles else find_turn_towards(total, brief)
        why = f"{'the top' if tumbles else 'the side that faces the viewer'} turns this way"
    return Heading(total, " ".join(way.text for way in told), why)


def _find_line(event: Event, brief: SceneBrief) -> Heading | None:
    lines = event.pick(WayKind.LINE, WayKind.PLANE)
    if not lines or event.repeat.names and event.effect is Effect.SCALE:
        return None
    aside = lines[0].kind is WayKind.PLANE and lines[0].names == ("right",)
    across = aside and event.motion.effect is Effect.TOPPLE and lies(brief)  # "tips over sideways"
    names = ("beside",) if across else lines[0].names
    return Heading(normalise(sum_directions(names, brief)), lines[0].text, "an axis by name")


def _find_swing(event: Event, brief: SceneBrief) -> Heading | None:
    """The first swing of "left and right"; what lies rocks about its line, whichever way that points."""
    rolls = event.motion.manner == "rock" and event.repeat.names and lies(brief)
    total = normalise(sum_directions(("beside",) if rolls else event.repeat.names, brief))
    if total is None:
        return None
    if event.effect is Effect.TURN:
        total = find_turn_towards(total, brief)
    words = next(each.text or each.first or "" for each in event.clause.repetitions if each.first)
    event.repeat = replace(event.repeat, alternate=event.effect is not Effect.SCALE)
    return Heading(total, words, "to and fro, this way first")


def _find_obstacle(event: Event, brief: SceneBrief) -> Heading | None:
    """Towards the wall that it meets."""
    solids = event.clause.solids
    if not solids or event.effect not in TOWARDS:
        return None
    words, told = solids[0].text or solids[0].kind, normalise(sum_directions(solids[0].sides, brief))
    usual = "ahead" if has_wheels(brief) else ASSUMED
    event.notes += [] if told else [f"'{words}': no side given, assumed {usual}."]
    return Heading(told or _sum_own((usual,), event, brief), words, "towards what is in the way")


def _find_blow(event: Event, brief: SceneBrief) -> Heading | None:
    """A blow on a side drives away from it."""
    dents = event.motion.quick and event.motion.sign < 0
    if not event.parts or not (dents or event.is_blow):
        return None
    part = event.parts[0]
    if part.phrase in read_lexicon().fronts:
        return Heading(brief.directions.away, event.words, "a blow on the front drives it away")
    side = find_side(part, brief)
    if side and dot(side, brief.directions.down) > _FOOT:
        return None  # it stands on the ground
    return side and Heading(scale(side, -1.0), part.text, "a blow drives away from the side that it hits")


def _assume(event: Event, brief: SceneBrief) -> Heading:
    """The motion's own direction, else the assumed one with a note."""
    motion = event.motion
    if motion.effect in _NO_WAY:
        return Heading(None, event.words, "needs no direction")
    sides = any("side" in way.phrase and way.names == ("both",) for way in event.pick(WayKind.SIDES))
    falls = (motion.manner == "rock" or motion.effect is Effect.TOPPLE) and lies(brief)
    usual = motion.direction or ("beside" if falls else ASSUMED)
    name = "right" if sides and motion.effect is Effect.SCALE else usual
    missing = "no axis given: it points" if motion.effect is Effect.TURN else "no direction given:"
    event.notes += [] if motion.direction else [f"'{event.words}': no direction given, assumed {name}."]
    vector = normalise(_sum_own((name,), event, brief))
    if motion.manner == "circle" and vector:  # it begins and ends in front, where the viewer sees it best
        inwards = cross(vector, sum_directions(("ahead",), brief))
        vector = scale(vector, -1.0) if dot(inwards, brief.directions.toward) > _INWARDS else vector
    if motion.effect is Effect.TURN and vector and name in _AHEAD:
        vector = find_lean_axis(vector, brief)  # "a backflip"
    return Heading(vector, event.words, f"{missing} {name} {'' if motion.bound else BY_DEFAULT}".strip())
