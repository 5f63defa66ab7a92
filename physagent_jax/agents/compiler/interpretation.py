"""The interpretation of a clause: its motion, direction, strength, place and time as values of an event."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents import intent
from physagent_jax.agents.compiler.amounts import MOST, find_target
from physagent_jax.agents.compiler.directions import TOWARDS, find_side, has_wheels, take_heading
from physagent_jax.agents.compiler.events import (
    ACROSS,
    ALONG,
    BY_DEFAULT,
    WAYS,
    Event,
    KnownPart,
    ValueSource,
    WayKind,
)
from physagent_jax.agents.compiler.limbs import find_limbs, find_roles, moves_pot, sticks_out
from physagent_jax.agents.lexicon import NAMED, Effect, Motion, Names, Place, Repeat, read_lexicon
from physagent_jax.agents.materials import LIMP
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.part import Part, is_plural, split_name
from physagent_jax.forces.slabs import make_end_region, make_middle_region
from physagent_jax.motion.attitudes import has_back_on_top
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.efforts import keep_in_space
from physagent_jax.motion.hinges import find_hinge, find_hinged, slides_open
from physagent_jax.motion.joints import Turning
from physagent_jax.motion.limbs import stands_on_legs, sum_directions
from physagent_jax.motion.parts import explain_guess, explain_missing
from physagent_jax.motion.schema import Amount, ObstacleRequest, SceneBrief
from physagent_jax.motion.swaying import lies, stands_slim
from physagent_jax.motion.vectors import add, clamp, cosine, cross, dot, normalise, scale

# What each kind of way means nothing for; nor does a part for what all of the object does.
_NO_WAYS = (Effect.SWELL, Effect.BURST, Effect.STILL)
_NO_LINES = (*_NO_WAYS, Effect.RELEASE)
_NO_SIDES = (Effect.LEAN, Effect.TURN, Effect.ROLL, Effect.FALL, Effect.TOPPLE, Effect.JUMP, *_NO_LINES[2:])
_USELESS = {
    **dict.fromkeys(WAYS, _NO_WAYS),
    WayKind.LINE: _NO_LINES,
    WayKind.PLANE: _NO_LINES,
    WayKind.SIDES: _NO_SIDES,
    WayKind.AGAIN: (),
}
_WHOLE = (Effect.ROLL, Effect.BURST, Effect.TOPPLE, Effect.JUMP, Effect.FALL)
_ONCE = (Effect.FALL, Effect.TOPPLE, Effect.ROLL, Effect.BURST, Effect.RELEASE, Effect.STILL)
_STEEP = 0.7  # cosine to the vertical
_ALONG = 0.85  # cosine to a limb from which on a way leads along it
_TALL = 1.1  # height over its breadth, from which on what falls over can roll about its own line alone
_UPRIGHT = 0.9  # the same, from which on a part lies above or below
_OWN_PARTS = dict(
    {"give paw": "paw"}, nod="head", wag="tail", flap="wings", wave="arm", salute="arm", clap="arms"
)  # with no other named
_LOOKING = (
    "look around",
    "look about",
    "look left and right",
    "look right and left",
    "look from side to side",
)
_OWN_PARTS |= dict.fromkeys(_LOOKING, "head")
_SAID = ("head", "paw")  # parts within a phrase: "dip its head"
# Seldom pressed aside.
_TOPS = frozenset("hood bonnet roof deck seat saddle cushion mattress shoulder shoulders".split())
_WINGS = frozenset("wing wings fin fins flipper flippers".split())  # what beats, and is not beaten
_SCURRYING = ("scuttle", "scurry", "paddle", "run")  # what legs and fins do by themselves
_OTHERS = frozenset(("other", "another", "one", "each", "next"))  # beside a limb's name: not that of before
_BEARERS = dict(hand="arm", hands="arms", fist="arm", fists="arms", head="neck")
_HALVES = frozenset(("two", "half", "halves"))
_SEVERING = ("break", "snap", "crack", "cut", "chop", "saw", "hack", "shear", "tear", "rip")
_BITING = frozenset("jaw jaws claw claws pincer pincers beak mouth bill teeth gripper grabber".split())
_HALF = 0.5  # of the object, as which no part is that comes off
_NOSES = dict(nose="toward", tail="away")  # words for the ends of a vehicle
_HOPS, _DIPS = 20.0, 12.0  # [degrees] by which an end is raised that hops up, or is lowered that dips
GOING = (Effect.PUSH, Effect.STRIKE, Effect.ROLL)  # what comes to a stop
_CHOP = 60.0  # [degrees] by which a tool leans that is swung down
_BEARING = ("wheel", "wheels", "tyre", "tyres", "tire", "tires")  # by which an end is lifted
_SLAM = 1.3  # strength with which a wall is met that it comes off
_LIMP = ("plant", "cloth", "animal")  # kinds of objects that droop


def interpret(event: Event, before: Event | None, brief: SceneBrief) -> None:
    """Fill in what a clause's words come to; "harder", "back" and "the other way" are measured by ``before``."""
    _aim_at_parts(event, brief)
    event.motion, event.phrase = _choose_motion(event, brief, before)
    event.repeat = _sum_repeats(event)
    _resolve_strength(event, before if event.clause.inherited else None)
    take_heading(event, brief)
    down = event.motion.manner == "bend" and event.direction == brief.directions.down
    if down and not event.parts and stands_slim(brief):
        _turn(event, brief.directions.left, "it bends down over its foot")
        event.strength = min(1.5 * event.strength, MAGNITUDE_MAX)
    event.stays = event.stays or event.motion.quick and event.effect is Effect.SCALE  # a dent
    _act_from_sides(event, brief)
    if before is not None:
        _take_over_direction(event, before, brief)
    _find_quantities(event, before, brief)
    _count_turns(event, brief)
    _resolve_again(event, before)
    event.doubts += _find_unused(event)
    event.sources["action_type"] = ValueSource(event.words, f"'{event.phrase}' is a {event.effect.value}")
    event.sources["active_time"] = _describe_time(event)
    _take_part(event, before, brief)
    partial = bool(event.limbs or event.region and not _breaks_off(event))
    limp = brief.object_kind in _LIMP or bool(event.limbs)
    able = {"": True, "limp": limp, "part": partial, "whole": not partial}
    if not able[event.motion.by] or event.motion.gives and event.clause.solids:
        event.doubts.append(f"How '{event.words}' is done is not understood.")
    event.obstacles += resolve_obstacles(event.clause.solids, event.direction, brief)


def _breaks_off(event: Event) -> bool:
    """Return whether it comes off by itself, as no end of a thing in one piece does.

    What is screwed off is led, and what goes off to a side is pushed there.
    """
    return event.motion.manner == "detach" and not (event.motion.after or event.pick(*WAYS))


def _aim_at_parts(event: Event, brief: SceneBrief) -> None:
    """Makes directions of the parts that it goes towards: "tip it toward its handle" is where that lies."""
    told = [way for way in event.ways if way.place is not None]
    event.ways = [way for way in event.ways if way.place is None]
    for way in told:
        part = KnownPart(way.place or NAMED, way.phrase, way.text)
        sides = [brief.parts[limb].side for limb in find_limbs(part, brief)] or [find_side(part, brief)]
        side = normalise(add(each for each in sides if each is not None))
        if side is None:
            event.unknown_parts.append(way.text)
            event.doubts.append(explain_missing(way.text, brief.parts))
            continue
        steep = abs(dot(side, brief.directions.up)) > _UPRIGHT
        axes = ("up", "down") if steep else ("left", "right", "toward", "away")
        shares = {name: dot(side, getattr(brief.directions, name)) for name in axes}
        names = tuple(name for name, share in shares.items() if share > max(shares.values()) / 2)
        event.ways.append(replace(way, names=names, place=None))


def _choose_motion(event: Event, brief: SceneBrief, before: Event | None) -> tuple[Motion, str]:
    """The clause's motion as what stands beside it makes it, and the phrase that it then goes by."""
    motion, phrase = _join_cause(event)
    motions, effect = read_lexicon().motions, motion.effect
    told, repeats = event.pick(*WAYS), event.clause.repetitions
    counted = any((each.times or 1) > 1 for each in repeats)
    hops = (effect is Effect.JUMP or motion.bounces) and all(e.first in (None, "up", "down") for e in repeats)
    if effect is Effect.ROLL and (event.clause.turning or event.clause.seen_from) and not told:
        return replace(motion, effect=Effect.TURN, direction="toward"), phrase  # rolls on the spot
    turned = any(each.unit == "degrees" for each in event.clause.quantities)
    rounds = any(each.dimension == "round" for each in event.clause.quantities)
    if effect is Effect.PUSH and rounds and not (told or event.parts or brief.anchored):
        return replace(motions["do laps"], strength=motion.strength), phrase  # "runs in a circle"
    if effect is Effect.ROLL and turned and not told:
        return motions["roll over"], "roll over"  # "the plane rolls 180 degrees"
    sways = brief.anchored is not None or brief.object_kind == "plant"  # what is free is blown away
    if effect is Effect.PUSH and any(each.rebounds for each in event.clause.solids):
        # It is to be fast where it meets the wall, and free behind it.
        return replace(motion, effect=Effect.STRIKE, strength=max(motion.strength, _SLAM)), phrase
    if event.verb is None and motion.wind and not told and sways:
        return replace(motions["sway"], strength=motion.strength), "sway"
    if hops and any(each.alternating for each in repeats):
        leap = motions["jump"] if motion.bounces else motion  # "jumps up and down", "bounces up and down"
        return replace(leap, strokes=max(leap.strokes, motions["bob"].cycles)), phrase
    swings = any(each.alternating for each in repeats)
    if not swings and (tips := _tips_at_end(event, motion, brief)):  # "its rear hops up", "its nose dips"
        raised = "behind" if (_find_end(event) == ("toward",)) == (tips == "up") else "ahead"
        event.parts, event.ways = [], []
        angle, falls_back = (_HOPS, effect is not Effect.PUSH) if tips == "up" else (_DIPS, True)
        return replace(motions["rear up"], direction=raised, angle=angle, brief=falls_back), phrase
    if not swings and motion.tumbles and event.is_upwards:
        return replace(motions["toss"], tumbles=True), phrase  # "flip it into the air"
    if phrase == "swing" and _is_brought_down(event, brief):  # "swing the axe down"
        event.ways = [way for way in event.ways if way.names not in (("up",), ("down",))]
        pace = event.clause.pace if counted else "sudden"
        event.clause = event.clause.model_copy(update=dict(pace=pace))
        return replace(motions["tip"], angle=_CHOP), phrase
    head, part = phrase.partition(" ")[0], event.parts[0].text.lower().split() if event.parts else [""]
    severed = motion.manner == "detach" and not event.parts
    snaps = head == "snap" and not phrase.endswith("off") and (phrase != head or before is not None)
    sent = phrase == "swing" and not repeats and event.pick(WayKind.TO) and (event.parts or event.is_upwards)
    stops = effect is Effect.STILL and not (before and before.effect in GOING)
    limp = motion.by == "limp" and brief.object_kind != "cloth" and not event.parts
    rules = (
        # "Is tossed to and fro", "the boat rolls from side to side", "it waddles left and right".
        ("shuttle", swings and effect is Effect.STRIKE and motion.gravity),
        ("bob", swings and (effect in (Effect.FALL, Effect.JUMP) or motion.gravity)),
        ("rock", swings and (effect is Effect.ROLL or motion.steps)),
        ("burst", head == "burst" and motion.manner == "hinge" and not (event.parts or find_hinged(brief))),
        ("jump", motion.bounces and (counted or event.is_upwards)),  # "it bounces three times"
        ("roll", phrase == "tumble" and event.goes_aside and before is None),  # "tumbles to the right"
        ("fall over", severed and head in _SEVERING and brief.object_kind == "plant"),  # "is sawn off"
        ("clack", phrase == "snap" and part[-1] in _BITING),  # "it snaps its claws"
        ("split", severed and not _HALVES.isdisjoint(phrase.split())),  # "the sword snaps in two"
        ("break", snaps and motion.manner and not event.parts),
        (head, severed and head in motions),  # "the robot falls off"
        ("fly off", motion.manner == "detach" and event.is_in_wind),  # not up
        # "Swings its arm forward", "stretches its arms forward": once.
        ("raise" if event.is_upwards else "move", sent or _reaches_out(event, motion, brief)),
        ("flap", phrase == "beat" and not _WINGS.isdisjoint(part)),
        ("press", phrase == "push" and before is None and _is_pressed(event, brief)),  # "down from above"
        ("turn", phrase == "steer" and event.parts),  # "steer the front wheels to the left"
        ("wiggle", (motion.steps or phrase in _SCURRYING) and _is_of_limbs(event, brief)),  # "legs scuttle"
        ("lower", _drops_limb(event, motion, brief)),  # "drops its arm"
        ("break off", phrase == "break" and event.parts and event.parts[0].place.names != ("down",)),
        ("move", motion.coasts and told),  # "it coasts to the left"
        ("cruise", motion.coasts and stops),  # "it skids to a stop"; else it goes on
        ("bend", limp and stands_slim(brief)),  # "the lamp droops"
        ("cruise", (effect is Effect.ROLL or motion.steps) and has_wheels(brief)),  # its wheels turn
    )
    if chosen := next((word for word, holds in rules if holds), ""):
        across = chosen == "split" and stands_slim(brief) and "middle" not in phrase  # its top breaks off
        return replace(motions[chosen], direction="up") if across else motions[chosen], chosen
    if effect is Effect.FALL and motion.by == "whole" and event.parts and head in motions:
        return replace(motions[head], direction="down"), head  # "bang the lid down"
    if motion.gives and _droops(event, brief):  # "slumps to one side", "the plant sags"
        return replace(motions["droop"], manner="bend", by=""), phrase
    if effect is Effect.TOPPLE and _is_on_its_back(event, brief):
        event.ways = [way for way in event.ways if way.text.lower() != "back"]
        return motions["turn over"], "turn over"
    if effect is Effect.SWELL and (told or event.pick(WayKind.LINE, WayKind.PLANE)):
        return replace(motion, effect=Effect.SCALE), phrase  # "expands horizontally", "grows upwards"
    return motion, phrase


def _is_brought_down(event: Event, brief: SceneBrief) -> bool:
    """Return whether a tool is swung down, about its lower end: "swing it down as though chopping"."""
    down = any(way.names == ("down",) for way in event.pick(WayKind.TO))
    wielded = brief.object_kind == "tool" or any("handle" in part.roles[:1] for part in brief.parts)
    return down and wielded and not (event.parts or event.is_upwards)


def _is_pressed(event: Event, brief: SceneBrief) -> bool:
    """Return whether what stands on the ground is pushed onto it from above."""
    told = {way.names for way in event.ways}
    stands = brief.world == "ground" and brief.anchored is None and not event.parts and not event.is_in_wind
    return stands and told == {("up",), ("down",)}


def _reaches_out(event: Event, motion: Motion, brief: SceneBrief) -> bool:
    """Return whether it brings its own limbs to where it stretches them: "it stretches both arms forward"."""
    told = event.parts and event.pick(WayKind.TO) and not event.clause.quantities
    if motion.effect is not Effect.SCALE or not told:
        return False
    limb = find_roles(event.parts[0].phrase)[:1] in (["arm"], ["leg"], ["wing"])
    own = motion.sign > 0 and event.words.lower().endswith(("s", "ing"))
    return own and limb and bool(find_limbs(event.parts[0], brief))


def _tips_at_end(event: Event, motion: Motion, brief: SceneBrief) -> str:
    """The way in which one end of a vehicle goes, "up" or "down": it tips over its wheels; else empty."""
    way = "up" if event.is_upwards or motion.effect is Effect.JUMP else motion.direction or ""
    told = {each.names for each in event.pick(*WAYS)} <= {(way,)}
    goes = motion.effect is Effect.JUMP or motion.effect in (Effect.PUSH, Effect.STRIKE) and told
    if not (goes and way in ("up", "down") and has_wheels(brief) and brief.world == "ground"):
        return ""
    if event.parts and (end := _NOSES.get(event.parts[0].phrase)):
        event.parts = [KnownPart(Place((end,)), "end", "end"), *event.parts[1:]]
    placed = _find_end(event) in (("toward",), ("away",)) and len(event.parts) == 1
    placed = placed and (event.parts[0].text.endswith(_BEARING) or not find_limbs(event.parts[0], brief))
    return way if placed and not motion.manner else ""


def _find_end(event: Event) -> Names:
    """The end of the object where the first part is, by its place or the adjective in its name."""
    told = read_lexicon().part_adjectives
    return next((p.place.names or told.get(p.phrase.rpartition(" ")[0], ()) for p in event.parts), ())


def _is_of_limbs(event: Event, brief: SceneBrief) -> bool:
    """Return whether a motion is said of limbs that stand before it, and no way: "its legs scuttle"."""
    if not event.parts or event.pick(*WAYS):
        return False
    part, verb = (event.text.lower().find(each.lower()) for each in (event.parts[0].text, event.words))
    return -1 < part < verb and bool(find_limbs(event.parts[0], brief))


def _droops(event: Event, brief: SceneBrief) -> bool:
    """Return whether what sags hangs down rather than gives way: "the plant sags", "its ears sag"."""
    limb = bool(event.parts and find_limbs(event.parts[0], brief))
    if event.phrase.split()[0] not in ("sag", "slump", "flop"):
        return limb and event.phrase.startswith("give")  # "its arm gives out"
    return limb or bool(event.ways) or brief.object_kind in LIMP


def _drops_limb(event: Event, motion: Motion, brief: SceneBrief) -> bool:
    """Return whether it is a limb that falls, on its joint."""
    limb = event.parts and event.parts[0].place.names != ("down",) and find_limbs(event.parts[0], brief)
    return motion.drops and motion.by != "whole" and bool(limb)


def _means_same(event: Event, before: Event, brief: SceneBrief) -> bool:
    """Return whether the limb of the motion before is meant: "raises its right arm ..., then drops the arm"."""
    part = event.parts[0]
    told = part.place.names or is_plural(part.text) or not _OTHERS.isdisjoint(event.text.lower().split())
    if told or not event.limbs or len(before.limbs) != 1:
        return False
    one, other = (brief.parts[each.limbs[0]] for each in (event, before))
    return (one.roles[:1] or split_name(one.name)[-1:]) == (other.roles[:1] or split_name(other.name)[-1:])


def _join_cause(event: Event) -> tuple[Motion, str]:
    """The motion; a wind that "hits" pushes, a cause of generic motion ("sends it") gives its own kind."""
    cause, verb = event.cause, event.verb
    if verb is None:
        assert cause is not None
        return cause, event.cause_phrase
    if cause is None:
        return verb, event.phrase
    quakes = cause.effect is Effect.SWAY and event.phrase in ("hit", "strike")  # "an earthquake hits"
    struck = verb.effect is Effect.STRIKE and (cause.wind or cause.skill is not None)  # "a vortex hits it"
    if (verb.generic and verb.effect is Effect.PUSH) or struck or quakes:
        return cause, event.cause_phrase
    skill = cause.skill if verb.effect is cause.effect else verb.skill  # "a vortex spins it"
    cycles = max(verb.cycles, cause.cycles)  # "it shakes in an earthquake"
    brief = verb.brief or cause.brief and verb.effect is not Effect.ROLL  # what is set rolling rolls on
    return replace(verb, brief=brief, skill=skill, cycles=cycles), event.phrase


def _is_on_its_back(event: Event, brief: SceneBrief) -> bool:
    """Return whether it is to lie on its back, which is on top."""
    way = any(each.phrase == "away" and each.text.lower() == "back" for each in event.ways)
    return has_back_on_top(brief) and (way or event.motion.bound and event.motion.direction == "away")


def _resolve_strength(event: Event, before: Event | None) -> None:
    """Base strength of motion and cause times the intensities; degrees widen the next one's distance from 1."""
    clause, motion, degree, absolute = event.clause, event.motion, 1.0, []
    value = motion.strength
    if event.cause is not None and event.verb is not None and event.cause not in (motion, event.verb):
        value *= event.cause.strength
    shares = [each for each in clause.quantities if each.dimension == "strength"]
    told = [*event.strengths, *(("relative", each.value) for each in shares)]
    for kind, factor in told:
        if kind == "degree":
            degree = factor
        elif kind == "absolute":
            value *= 1.0 + (factor - 1.0) * degree
            degree = 1.0
            absolute.append(factor)
        else:
            value = factor * (before.strength if before else value)
    # A word for how strong it is outweighs the motion's own strength.
    if absolute and degree == 1.0 and motion.strength >= 0.8:
        if min(absolute) >= 1.3:
            value = max(value, 1.2)
        elif max(absolute) <= 0.6:
            value = min(value, 0.7)
    event.strength = round(clamp(value, MAGNITUDE_MIN, MAGNITUDE_MAX), 3)
    plain = event.strength == 1.0
    words, why = event.words, "no intensity word: plain" if plain else "the word's own strength"
    if told:
        words, why = ", ".join([*clause.strength, *(each.text for each in shares)]), "intensity words"
    event.sources["magnitude"] = ValueSource(words, why)


def _sum_repeats(event: Event) -> Repeat:
    """All counts of a clause as one: "left and right twice" alternates and counts."""
    sides = bool(event.pick(WayKind.SIDES))  # "in both directions, left and right" goes there once
    found = [each for each in event.clause.repetitions if not (each.first and sides)]
    count = next((each.times for each in found if each.times is not None), None)
    names = next(((each.first,) for each in found if each.first), ())
    often = any(each.often for each in found)
    if event.effect is Effect.JUMP:  # "up and down": it comes down by itself
        return Repeat(count, vague=often)
    alternate = any(each.alternating for each in found) or event.phrase in _LOOKING
    return Repeat(count, alternate, names, often)


def _act_from_sides(event: Event, brief: SceneBrief) -> None:
    """Motions whose kind depends on where they act: from both sides, outward, from one side."""
    sides, told = event.pick(WayKind.SIDES), event.pick(*WAYS)
    limbs = event.parts and find_limbs(event.parts[0], brief)
    all_around = bool(sides) and sides[0].names == ("all",)
    # "Stretch its ears to twice their length".
    sized = any(each.unit == "share" for each in event.clause.quantities)
    spread = len(limbs) > 1 and event.effect is Effect.SCALE and event.motion.sign > 0 and not (told or sized)
    if event.effect is Effect.BURST and told:
        event.motion = replace(event.motion, effect=Effect.STRIKE)
    elif spread or limbs and all_around and event.effect in (Effect.PUSH, Effect.LEAN):
        event.radial = -1 if sides and sides[0].phrase.startswith("in") else 1
        event.ways = [way for way in event.ways if way not in sides]
        event.motion = replace(event.motion, effect=Effect.PUSH) if spread else event.motion
        _turn(event, event.direction, "from or to the middle of the object")
    elif sides:
        beside = told and sides[0].phrase == "either side"  # "away, by less than a tenth to either side"
        if event.effect in (Effect.PUSH, Effect.STRIKE) and not beside:
            outward = event.motion.pulls or sides[0].phrase in ("outward", "outwards", "apart")
            sign = 1 if outward else -1  # of all sides at once, whatever acts there
            event.motion = replace(event.motion, effect=Effect.SCALE, sign=sign, skill=None)
        if event.effect is Effect.SCALE and all(each.names == ("all",) for each in sides):
            event.motion = replace(event.motion, effect=Effect.SWELL)
    if event.effect is Effect.SWELL:
        event.direction = None
    elif event.effect is Effect.SCALE and event.direction is None:
        event.direction = brief.directions.right


def _turn(event: Event, vector: Vector | None, why: str) -> None:
    """Sets another direction than the clause alone tells."""
    event.direction, event.notes = vector, []
    event.sources["vector"] = replace(event.sources["vector"], why=why)


def _lies_on_its_side(event: Event) -> bool:
    """Return whether it falls onto its side, and no other way is told."""
    told = [way.names for way in event.pick(WayKind.TO)] or [(event.motion.direction,)]
    return told == [("beside",)]


def _roll_sideways(event: Event, before: Event, brief: SceneBrief) -> None:
    """Lets what is tall fall over across the way that it then rolls: it cannot roll along itself."""
    first, then = before.direction, event.direction
    fell, rolled = (each.sources["vector"].why.endswith(BY_DEFAULT) for each in (before, event))
    fell |= _lies_on_its_side(before)  # whichever that is
    if first and then and (fell or rolled) and abs(cosine(then, first)) > _STEEP:
        changed, other = (before, then) if fell else (event, first)
        across = normalise(cross(other, brief.directions.up))
        if across and dot(across, brief.directions.toward) < 0:
            across = scale(across, -1.0)
        _turn(changed, across, f"it rolls across itself {BY_DEFAULT}")


def _take_over_direction(event: Event, before: Event, brief: SceneBrief) -> None:
    """The direction of the event before, where none is told; and "back" from there. What lies tips over aside."""
    pushed = before.effect in (Effect.PUSH, Effect.STRIKE)
    driven = event.effect is Effect.TOPPLE and pushed and not lies(brief)
    driven |= event.effect is Effect.TOPPLE and before.motion.manner == "rock" and before.motion.angle > 0
    likewise = before.effect is event.effect
    likewise &= event.effect is not Effect.SWAY or before.phrase == event.phrase
    slides = before.effect is Effect.TOPPLE and event.effect is Effect.PUSH and event.motion.generic
    carried = event.motion.generic and event.effect is Effect.PUSH or event.effect is Effect.ROLL
    carried &= pushed and before.direction is not None and abs(before.direction[2]) < _STEEP
    if event.notes and (likewise or driven or slides or carried):  # "it is hit from the left and slides"
        _turn(event, before.direction, "no direction given: as before")
    elif before.effect is Effect.PUSH and event.phrase == "cruise" and before.notes and not before.parts:
        _turn(before, event.direction, "the way that it then goes")  # "push the car and it rolls forward"
    width, height, depth = brief.extents
    rolls = before.effect is Effect.TOPPLE and event.effect is Effect.ROLL
    if rolls and (height > _TALL * max(width, depth) or _lies_on_its_side(before)):
        _roll_sideways(event, before, brief)
    tumbles = event.effect is Effect.TURN and event.motion.tumbles and pushed
    assumed = event.sources["vector"].why.endswith(BY_DEFAULT)
    if tumbles and assumed and before.direction and abs(before.direction[2]) < _STEEP:
        _turn(event, find_lean_axis(before.direction, brief), "it tumbles the way that it goes")
    staggers = before.is_blow and event.clause.order == "and"  # "it is shoved and staggers back"
    if before.direction is not None and event.is_back and not staggers:
        _turn(event, scale(before.direction, -1.0), "back where it came from")


def _find_quantities(event: Event, before: Event | None, brief: SceneBrief) -> None:
    """The target that the clause's quantities set, its axis, and what they say that cannot be used."""
    motion = replace(event.motion, effect=Effect.PUSH) if event.lands_aside else event.motion
    for quantity in event.clause.quantities:
        if quantity.dimension == "strength":
            continue
        found = find_target(quantity, motion, before.amount if before else None, brief)
        if found.amount is None or event.amount is not None:
            words = quantity.text or f"{quantity.value:g} {quantity.unit}"
            event.doubts.append(f"'{words}' is a quantity that nothing here is measured in.")
            continue
        falls = event.effect is Effect.FALL  # from as high as there is room (`blows`)
        event.amount = amount = found.amount if falls else keep_in_space(found.amount, event.direction, brief)
        if amount is not found.amount:
            room = f"{amount.value:.2g} {amount.unit}"
            event.notes.append(f"'{event.text}': there is room for {room} that way.")
        if found.everywhere:
            event.motion, event.direction = replace(motion, effect=Effect.SWELL), None
        elif found.names and not event.pick(*WAYS):  # "to twice its height"
            event.motion = replace(motion, effect=Effect.SCALE)
            event.direction = normalise(sum_directions(found.names, brief))


def _count_turns(event: Event, brief: SceneBrief) -> None:
    """Counts turns ("spin three times"); a somersault is a whole one, and what is free turns around by half of one."""
    repeat, angle = event.repeat, event.motion.angle
    free = brief.world == "ground" and brief.anchored is None and not (event.parts or event.is_timed)
    loose = any(not {"lid", "knob"}.isdisjoint(find_roles(each.phrase)) for each in event.parts)
    free |= loose and angle > 360.0 and not event.is_timed  # "the lid turns round and round"
    if event.motion.direction == "up" and (repeat.alternate or event.is_in_wind or not free):
        angle = 0.0
    counts = event.effect is Effect.TURN and repeat.count is not None and not repeat.alternate
    if counts and event.amount is None:
        event.repeat = replace(repeat, count=None)
        tumbles = repeat.vague and event.motion.direction != "up" and not loose  # "over and over"
        angle = angle if tumbles else 360.0 * (repeat.count or 0)
    if angle > MOST:
        event.doubts.append(f"So many turns ('{event.text}') cannot be shown.")
    if angle and event.amount is None:
        event.amount = Amount(value=min(angle, MOST), unit="degrees")


def _resolve_again(event: Event, before: Event | None) -> None:
    """Goes "the other way" or "the same way" as the event before."""
    ways = event.pick(WayKind.AGAIN)
    if not ways:
        return
    same = ways[0].names == ("same",)
    kinds = {event.effect, before.effect} if before else set()
    alike = kinds <= {*TOWARDS} if same else len(kinds) == 1
    if before is None or before.direction is None or not alike:
        event.doubts.append(f"Which way '{ways[0].text}' is, is not understood.")
    else:
        why = "the same way as before" if same else "the other way than before"
        _turn(event, scale(before.direction, 1.0 if same else -1.0), why)


def _find_unused(event: Event) -> list[str]:
    """Find words about place, direction and number that mean nothing for the clause's motion."""
    clause, effect = event.clause, event.effect
    unused = [way.text for way in event.ways if effect in _USELESS[way.kind]]
    if effect in _WHOLE:
        # "Lands on its feet", "its pedestal topples over".
        lands = event.motion.lands or effect is Effect.TOPPLE
        parts = [*event.parts, *event.excluded]
        unused += [part.text for part in parts if not (lands and part.place.names == ("down",))]
    if (clause.turning or clause.seen_from) and effect is not Effect.TURN:
        unused.append(clause.turning or f"seen from {clause.seen_from}")
    unused += [each.text for each in clause.repetitions if each.times][1:]
    if effect in _ONCE:
        unused += [each.text for each in clause.repetitions if (each.times or 1) > 1 or each.alternating]
    return [f"What '{words}' means for '{event.words}' is not understood." for words in unused]


def _take_part(event: Event, before: Event | None, brief: SceneBrief) -> None:
    """The region that is acted on, and the end that is named or excepted."""
    hinged = event.motion.manner == "hinge" and not (event.parts or event.excluded) and find_hinged(brief)
    if hinged:  # "close the laptop"
        event.parts = [KnownPart(NAMED, brief.parts[hinged[0]].name, event.words)]
    own = _OWN_PARTS.get(event.phrase) or next((each for each in _SAID if f"~ {each}" in event.phrase), "")
    if own and not (event.parts or event.excluded):
        part = KnownPart(read_lexicon().parts[own], own, own)
        event.parts = [part] if find_limbs(part, brief) else []
    if moves_pot(event, brief):
        event.parts = []
    named = [*event.parts, *event.excluded]
    opposite = event.effect is Effect.TURN and len({each.place.names for each in event.parts}) == 2
    texts = dict.fromkeys(each.text for each in named)
    if len(texts) > 1 and not opposite:  # "one end against the other"
        event.doubts.append(f"Of several parts ({', '.join(texts)}) only the first is used.")
    whole = event.effect in (Effect.FALL, Effect.TOPPLE)
    if not named or whole and named[0].place.names == ("down",) and event.parts:
        return  # "lands on its feet", as it stood
    place, event.excludes_part, ends = named[0].place, not event.parts, []
    if event.parts and not (event.is_blow and named[0].phrase in read_lexicon().fronts):
        # A blow on the belly drives all of it away.
        event.limbs = hinged or _find_bearers(named[0], event, brief) or find_limbs(named[0], brief)
        leaves = event.motion.manner == "detach" or event.motion.draws or event.phrase == "unscrew"
        if not event.limbs and leaves and (side := find_side(named[0], brief)):
            ends = [(p.share, k) for k, p in enumerate(brief.parts) if cosine(p.side, side) > _UPRIGHT]
            ends = sorted(each for each in ends if each[0] < _HALF)[-1:]
            event.limbs = tuple(k for _, k in ends)  # "the top comes off": what is there
        if before is not None and _means_same(event, before, brief):
            event.limbs = before.limbs
        if before is not None and before.limbs and named[0].text.startswith("other "):
            alike = find_limbs(replace(named[0], text=f"each {named[0].phrase}"), brief)
            others = [k for k in alike if k not in before.limbs]  # the next one: "then another, and another"
            event.limbs = tuple(sorted(others, key=lambda k: k < before.limbs[0])[:1])
            event.doubts += [] if others else [f"Which part '{named[0].text}' is, is not known."]
    if event.effect is Effect.TURN:  # of all wheels, a steering wheel has no axle
        event.limbs = tuple(k for k in event.limbs if brief.parts[k].axle) or event.limbs
    if event.limbs:
        text, roles = named[0].text, find_roles(named[0].phrase)
        chosen = () if ends else event.limbs
        doubt = (
            explain_guess(text, brief.parts, chosen, plural=is_plural(text), roles=roles) if chosen else None
        )
        # It only has to stay where it is.
        (event.notes if event.effect is Effect.STILL else event.doubts).extend(filter(None, [doubt]))
        part = brief.parts[event.limbs[0]]
        event.region, event.part = part.moved, part.side
        event.sources["region"] = ValueSource(named[0].text, part.moved.label or "a part of the object")
        if _swing_on_hinge(event, brief):
            return
        limb = Turning(part, brief, brief.frame_count)
        assumed = event.sources["vector"].why.endswith(BY_DEFAULT)
        beside = any("side to side" in each.text.lower() for each in event.clause.repetitions)
        assumed |= beside and not {"tail", "head"}.isdisjoint(roles[:1])  # to its own sides
        wide = "tail" in (*roles[:1], *part.roles[:1]) and bool(event.pick(WayKind.PLANE))
        wide |= event.effect is Effect.LEAN and abs(dot(event.direction or limb.swing, limb.arm)) > _ALONG
        flattens = abs(dot(event.direction or limb.out, brief.directions.up)) > _STEEP
        kicks = event.effect is Effect.STRIKE and "leg" in roles[:1] and not event.pick(*WAYS)
        if kicks or assumed and event.effect is Effect.SWAY and (beside or event.motion.direction is None):
            _turn(event, limb.swing, ACROSS)
        elif wide and not flattens and event.effect in (Effect.LEAN, Effect.PUSH):  # no bend along itself
            near = dot(limb.swing, brief.directions.toward) >= 0
            _turn(event, scale(limb.swing, 1.0 if near else -1.0), "across the part, to who looks")
        elif assumed and (event.motion.wrings or part.axle and event.effect is Effect.TURN):
            _turn(event, part.axle or limb.arm, "about the part's own line")
        elif assumed and (event.motion.draws or event.effect is Effect.SCALE and event.motion.sign > 0):
            _turn(event, limb.arm, ALONG)
        elif assumed and _meets_face(event, part, limb.arm, brief):  # "poke its eye"
            leaves = event.motion.pulls or event.motion.manner == "detach"
            _turn(event, scale(limb.arm, 1.0 if leaves else -1.0), "out of or into the part's face")
        elif (
            event.effect is Effect.SCALE and event.motion.sign < 0 and flattens
        ):  # a part gives way downwards
            event.motion = replace(event.motion, effect=Effect.PUSH, sign=1, skill=None)
            down = brief.directions.down
            juts = part.origin == "place" and dot(part.side, down) < _STEEP  # a foot goes onto the ground
            juts &= _TOPS.isdisjoint(split_name(part.name))
            event.direction = scale(limb.arm, -1.0) if juts else down
        return
    nowhere = place.role and (not place.names or place.names == ("up",) and stands_on_legs(brief.parts))
    shown = event.parts and sticks_out(named[0])
    event.unknown_parts += [named[0].text] * bool(nowhere or shown)
    if nowhere or shown and brief.parts:
        event.doubts.append(explain_missing(named[0].text, brief.parts))
    if nowhere:
        return
    event.part = find_side(named[0], brief)
    if not event.excludes_part:
        event.sources["region"] = ValueSource(named[0].text, "a part of the object")
    if event.part is None and event.excludes_part:
        event.excludes_part = False
        event.doubts.append(f"All but '{named[0].text}' cannot be acted on.")
    elif event.part is None:
        event.region = make_middle_region(brief.directions.up)
        if event.region is None:
            event.doubts.append("The middle is not a box here, because world up is oblique to the axes.")
    elif event.excludes_part:
        event.region = make_end_region(scale(event.part, -1.0), 1.0 - place.start)
    else:
        event.region = make_end_region(event.part, place.start)


def _meets_face(event: Event, part: Part, out: Vector, brief: SceneBrief) -> bool:
    """Return whether a blow, a push or a pull without a way goes into what faces aside and has no joint of its own."""
    acts = event.effect is Effect.STRIKE or event.effect is Effect.PUSH and not event.motion.generic
    return acts and part.seated and abs(dot(out, brief.directions.up)) < _STEEP


def _find_bearers(part: KnownPart, event: Event, brief: SceneBrief) -> tuple[int, ...]:
    """The arms that wave, raise or lower hands, the neck that does a head; none if nothing of that is asked."""
    *side, noun = part.phrase.split()
    bearer, steep = _BEARERS.get(noun), abs(dot(event.direction or (0, 0, 0), brief.directions.up))
    waved = event.phrase.startswith("wave") or event.effect in (Effect.PUSH, Effect.LEAN)
    waved &= bearer != "neck" or event.effect is Effect.PUSH and steep >= _STEEP
    if bearer is None or not waved:
        return ()
    phrase, text = (" ".join((*words, bearer)) for words in (side, part.text.lower().split()[:-1]))
    limbs = find_limbs(KnownPart(part.place, phrase, text), brief)
    return limbs if bearer != "neck" or any(brief.parts[k].name == bearer for k in limbs) else ()


def _swing_on_hinge(event: Event, brief: SceneBrief) -> bool:
    """Return whether what opens or closes has a hinge, about which it then turns."""
    if event.motion.manner != "hinge":
        return False
    part = brief.parts[event.limbs[0]]
    if (hinge := find_hinge(part, brief)) is None:
        event.motion = replace(event.motion, manner="") if slides_open(part) else event.motion
        return False
    event.motion, opens = replace(event.motion, effect=Effect.TURN), event.motion.direction == "up"
    _turn(event, scale(hinge.axis, -1.0 if opens else 1.0), "about its hinge")
    return True


def resolve_obstacles(
    solids: tuple[intent.Solid, ...], way: Vector | None, brief: SceneBrief
) -> list[ObstacleRequest]:
    """The walls and blocks that a clause names; those without a place of their own stand in the way."""
    found = []
    for solid in solids:
        sides = normalise(sum_directions(solid.sides, brief)) or way
        ways = filter(None, (sides, normalise(sum_directions(solid.opposite, brief))))
        words = solid.text or solid.kind
        found += [ObstacleRequest(kind=solid.kind, direction=each, words=words) for each in ways]
    return found


def _describe_time(event: Event) -> ValueSource:
    told = [each for each in (event.when.starts, event.when.lasts) if each is not None]
    if not told:
        return ValueSource(event.words, "its share of the sequence")
    words = dict.fromkeys(each.text or f"{each.value:g} {each.unit}" for each in told)
    return ValueSource(", ".join(words), "time as told")
