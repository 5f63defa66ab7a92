"""The interpretation of a clause: its motion, direction, strength, place and time as values of an event."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from physagent_jax.agents import intent
from physagent_jax.agents.compiler.amounts import MOST, Target, find_target
from physagent_jax.agents.compiler.directions import (
    TOWARDS,
    WAYS,
    Heading,
    resolve_direction,
    sum_directions,
)
from physagent_jax.agents.compiler.events import Event, ValueSource
from physagent_jax.agents.compiler.motions import choose_motion, resolve_strength
from physagent_jax.agents.compiler.words import KnownPart, Meaning, WayKind
from physagent_jax.agents.lexicon import Effect, Motion, Repeat
from physagent_jax.agents.regions import make_end_region, make_middle_region
from physagent_jax.agents.schema import Amount, ObstacleRequest, SceneBrief
from physagent_jax.agents.vectors import normalise, scale
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import Region

# What each kind of way means nothing for; nor does a part for what all of the object does.
_NO_WAYS = (Effect.SWELL, Effect.BURST, Effect.STILL)
_NO_LINES = (*_NO_WAYS, Effect.TOPPLE, Effect.RELEASE)
_NO_SIDES = (Effect.LEAN, Effect.TURN, Effect.ROLL, Effect.FALL, Effect.TOPPLE, Effect.JUMP, *_NO_LINES[2:])
_USELESS = {
    WayKind.TO: _NO_WAYS,
    WayKind.FROM: _NO_WAYS,
    WayKind.LINE: _NO_LINES,
    WayKind.PLANE: _NO_LINES,
    WayKind.SIDES: _NO_SIDES,
    WayKind.AGAIN: (),
}
_WHOLE = (Effect.ROLL, Effect.BURST, Effect.TOPPLE, Effect.JUMP, Effect.FALL)
_ONCE = (Effect.FALL, Effect.TOPPLE, Effect.ROLL, Effect.BURST, Effect.RELEASE, Effect.STILL)
_LIMP = ("plant", "cloth", "animal")  # kinds of objects that droop
_SIDED = (Effect.PUSH, Effect.STRIKE, Effect.SWAY, Effect.SCALE, Effect.SWELL)


@dataclass
class _Draft:
    """An event in the making."""

    meaning: Meaning
    before: Event | None
    brief: SceneBrief
    motion: Motion
    phrase: str
    heading: Heading
    part: KnownPart | None
    target: Target = Target()
    doubts: list[str] = field(default_factory=list)

    def turn(self, vector: Vector | None, why: str) -> None:
        """Sets another direction than the clause alone tells."""
        self.heading = Heading(vector, self.heading.repeat, replace(self.heading.source, why=why))


def interpret(meaning: Meaning, before: Event | None, brief: SceneBrief) -> Event:
    """The event of a clause; ``before`` is what "harder", "back" and "the other way" are measured by."""
    motion, phrase = choose_motion(meaning, brief)
    strength, strength_source = resolve_strength(
        meaning, motion, before if meaning.clause.inherited else None
    )
    part = meaning.parts[0] if meaning.parts else None
    if motion.effect is Effect.FALL and part is not None and part.place.names == ("down",):
        part = None  # "lands on its feet", as it stood
    heading = resolve_direction(meaning, motion, part, _sum_repeats(meaning), brief)
    draft = _Draft(meaning, before, brief, motion, phrase, heading, part, doubts=list(meaning.doubts))
    _act_from_sides(draft)
    _take_over_direction(draft)
    _find_quantities(draft)
    _count_turns(draft)
    _scale_by_dimension(draft)
    _resolve_again(draft)
    draft.doubts += _find_unused(meaning, draft.motion)
    if motion.droops and brief.object_kind not in _LIMP:
        draft.doubts.append(f"How '{meaning.words}' is done is not understood.")
    sources = {
        "action_type": ValueSource(meaning.words, f"'{phrase}' is a {draft.motion.effect.value}"),
        "magnitude": strength_source,
        "vector": draft.heading.source,
        "active_time": _describe_time(meaning),
    }
    if part:
        sources["region"] = ValueSource(part.text, "a part of the object")
    return _make_event(draft, strength, sources)


def _make_event(draft: _Draft, strength: float, sources: dict[str, ValueSource]) -> Event:
    """The event of a finished draft."""
    meaning, vector = draft.meaning, draft.heading.vector
    region, end, excludes = _resolve_part(draft)
    return Event(
        motion=draft.motion,
        phrase=draft.phrase,
        words=meaning.text,
        order=meaning.clause.order,
        direction=vector,
        strength=strength,
        region=region,
        part=end,
        excludes_part=excludes,
        amount=draft.target.amount,
        stays=meaning.stays,
        even=meaning.clause.even,
        obstacles=tuple(resolve_obstacles(meaning.clause.solids, vector, draft.brief)),
        repeat=draft.heading.repeat,
        when=meaning.timing,
        wind=any(each.wind for each in (meaning.cause, meaning.verb) if each is not None),
        elsewhere=meaning.clause.elsewhere,
        sources=sources,
        notes=draft.heading.notes,
        doubts=tuple(draft.doubts),
    )


def _sum_repeats(meaning: Meaning) -> Repeat:
    """All counts of a clause as one: "left and right twice" alternates and counts."""
    sides = bool(meaning.pick(WayKind.SIDES))  # "in both directions, left and right" goes there once
    found = [each for each in meaning.clause.repetitions if not (each.first and sides)]
    count = next((each.times for each in found if each.times is not None), None)
    names = next(((each.first,) for each in found if each.first), ())
    return Repeat(count, any(each.alternating for each in found), names, any(each.often for each in found))


def _act_from_sides(draft: _Draft) -> None:
    """Motions whose kind depends on where they act: from both sides, outward, from one side."""
    meaning, motion, brief = draft.meaning, draft.motion, draft.brief
    sides, told = meaning.pick(WayKind.SIDES), meaning.pick(*WAYS)
    beside = (
        told and sides and sides[0].phrase == "either side"
    )  # "away, by less than a tenth to either side"
    if motion.effect is Effect.BURST:
        motion = replace(motion, effect=Effect.STRIKE) if told else motion
    elif sides and motion.effect in _SIDED and motion.effect is not Effect.SWAY:
        if motion.effect in (Effect.PUSH, Effect.STRIKE) and not beside:
            outward = motion.pulls or sides[0].phrase in ("outward", "outwards", "apart")
            motion = replace(motion, effect=Effect.SCALE, sign=1 if outward else -1)
        if motion.effect in (Effect.SCALE, Effect.SWELL) and sides[0].names == ("all",):
            motion = replace(motion, effect=Effect.SWELL)
    draft.motion = motion
    if motion.effect is Effect.SWELL:
        draft.heading = replace(draft.heading, vector=None)
    elif motion.effect is Effect.SCALE and draft.heading.vector is None:
        draft.heading = replace(draft.heading, vector=sum_directions(("right",), brief))


def _take_over_direction(draft: _Draft) -> None:
    """The direction of the event before, where none is told; and "back" from there."""
    before, effect = draft.before, draft.motion.effect
    if before is None:
        return
    driven = effect is Effect.TOPPLE and before.effect in (Effect.PUSH, Effect.STRIKE)
    likewise = before.effect is effect and (effect is not Effect.SWAY or before.phrase == draft.phrase)
    if draft.heading.notes and (likewise or driven):  # "push it to the right, then push it harder"
        draft.turn(before.direction, "no direction given: as before")
    if before.direction is not None and is_back(draft.meaning):
        draft.turn(scale(before.direction, -1.0), "back where it came from")


def is_back(meaning: Meaning) -> bool:
    """Return whether it goes back where it came from."""
    return any(way.phrase == "back" for way in meaning.pick(WayKind.TO))


def _find_quantities(draft: _Draft) -> None:
    """The target that the clause's quantities set, and what they say that cannot be used."""
    landing = replace(draft.motion, effect=Effect.PUSH) if lands_aside(draft.meaning) else draft.motion
    for quantity in draft.meaning.clause.quantities:
        if quantity.dimension == "strength":
            continue
        found = find_target(quantity, landing, draft.before.amount if draft.before else None)
        if found.usual:
            continue
        if found.amount is None or draft.target.amount is not None:
            words = quantity.text or f"{quantity.value:g} {quantity.unit}"
            draft.doubts.append(f"'{words}' is a quantity that nothing here is measured in.")
        else:
            draft.target = found


def _count_turns(draft: _Draft) -> None:
    """Counts turns ("spin three times"); a somersault is a whole one."""
    repeat = draft.heading.repeat
    counted = repeat.count is not None and not repeat.alternate and draft.target.amount is None
    if draft.motion.effect is Effect.TURN and counted and repeat.count is not None:
        if not repeat.vague:
            draft.target = Target(Amount(value=min(360.0 * repeat.count, MOST), unit="degrees"))
        if not repeat.vague and 360.0 * repeat.count > MOST:
            draft.doubts.append(f"So many turns ('{draft.meaning.text}') cannot be shown.")
        draft.heading = replace(draft.heading, repeat=replace(repeat, count=None))
    if draft.motion.angle and draft.target.amount is None:
        draft.target = Target(Amount(value=draft.motion.angle, unit="degrees"))


def _scale_by_dimension(draft: _Draft) -> None:
    """Acts along the dimension that a quantity names: "to twice its height"."""
    if draft.target.everywhere:
        draft.motion = replace(draft.motion, effect=Effect.SWELL)
        draft.heading = replace(draft.heading, vector=None)
    elif draft.target.names and not draft.meaning.pick(*WAYS):
        draft.motion = replace(draft.motion, effect=Effect.SCALE)
        vector = normalise(sum_directions(draft.target.names, draft.brief))
        draft.heading = replace(draft.heading, vector=vector)


def _resolve_again(draft: _Draft) -> None:
    """Goes "the other way" or "the same way" as the event before."""
    ways, before = draft.meaning.pick(WayKind.AGAIN), draft.before
    if not ways:
        return
    known = before is not None and before.direction is not None
    if ways[0].names == ("same",):
        known = known and before is not None and before.effect in TOWARDS and draft.motion.effect in TOWARDS
    else:
        known = known and before is not None and before.effect is draft.motion.effect
    if not known or before is None or before.direction is None:
        draft.doubts.append(f"Which way '{ways[0].text}' is, is not understood.")
    elif ways[0].names == ("same",):
        draft.turn(before.direction, "the same way as before")
    else:
        draft.turn(scale(before.direction, -1.0), "the other way than before")


def _find_unused(meaning: Meaning, motion: Motion) -> list[str]:
    """Find words about place, direction and number that mean nothing for the clause's motion."""
    clause, effect = meaning.clause, motion.effect
    unused = [way.text for way in meaning.ways if effect in _USELESS[way.kind]]
    if effect in _WHOLE:
        lands = motion.lands  # "lands on its feet"
        parts = [*meaning.parts, *meaning.excluded]
        unused += [part.text for part in parts if not (lands and part.place.names == ("down",))]
    if (clause.turning or clause.seen_from) and effect is not Effect.TURN:
        unused.append(clause.turning or f"seen from {clause.seen_from}")
    counts = [each for each in clause.repetitions if each.times]
    unused += [each.text for each in counts[1:]]
    if effect in _ONCE:
        unused += [each.text for each in clause.repetitions if (each.times or 1) > 1 or each.alternating]
    return [f"What '{words}' means for '{meaning.words}' is not understood." for words in unused]


def lands_aside(meaning: Meaning) -> bool:
    """Return whether it tells where something comes down: "as it reaches the ground it is farther to the right"."""
    lands = meaning.verb is not None and meaning.verb.lands and not meaning.clause.negated
    return lands and any(way.names not in (("up",), ("down",)) for way in meaning.pick(WayKind.TO))


def _resolve_part(draft: _Draft) -> tuple[Region | None, Vector | None, bool]:
    """(region, named end, whether that end is excepted)."""
    meaning, part, brief = draft.meaning, draft.part, draft.brief
    named = {each.place.names for each in meaning.parts}
    opposite = draft.motion.effect is Effect.TURN and len(named) == 2  # "one end against the other"
    if len(meaning.parts) + len(meaning.excluded) > 1 and not opposite:
        words = ", ".join(each.text for each in (*meaning.parts, *meaning.excluded))
        draft.doubts.append(f"Of several parts ({words}) only the first is used.")
    if part is not None:
        end = normalise(sum_directions(part.place.names, brief))
        if end is not None:
            return make_end_region(end, part.place.start), end, False
        region = make_middle_region(brief.directions.up)
        if region is None:
            draft.doubts.append("The middle is not a box here, because world up is oblique to the axes.")
        return region, None, False
    if not meaning.excluded:
        return None, None, False
    place = meaning.excluded[0].place
    end = normalise(sum_directions(place.names, brief))
    if end is None:
        draft.doubts.append(f"All but '{meaning.excluded[0].text}' cannot be acted on.")
        return None, None, False
    return make_end_region(scale(end, -1.0), 1.0 - place.start), end, True


def resolve_obstacles(
    solids: tuple[intent.Solid, ...], way: Vector | None, brief: SceneBrief
) -> list[ObstacleRequest]:
    """The walls and blocks that a clause names; those without a place of their own stand in the way."""
    found = []
    for solid in solids:
        sides = normalise(sum_directions(solid.sides, brief)) or way
        for direction in (sides, normalise(sum_directions(solid.opposite, brief))):
            if direction is not None:
                words = solid.text or solid.kind
                found.append(ObstacleRequest(kind=solid.kind, direction=direction, words=words))
    return found


def _describe_time(meaning: Meaning) -> ValueSource:
    told = [each for each in (meaning.timing.starts, meaning.timing.lasts) if each is not None]
    if not told:
        return ValueSource(meaning.words, "its share of the sequence")
    words = dict.fromkeys(each.text or f"{each.value:g} {each.unit}" for each in told)
    return ValueSource(", ".join(words), "time as told")
