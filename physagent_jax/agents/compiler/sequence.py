"""The events of a sentence in their order, with what the clauses around them change; and what is held."""

from __future__ import annotations

import math
from copy import deepcopy
from dataclasses import replace

from physagent_jax.agents.compiler.builder import ForceFieldBuilder
from physagent_jax.agents.compiler.events import (
    ACROSS,
    ALONG,
    BY_DEFAULT,
    WAYS,
    Event,
    ValueSource,
    WayKind,
    is_landing_meanwhile,
)
from physagent_jax.agents.compiler.interpretation import GOING, interpret, resolve_obstacles
from physagent_jax.agents.compiler.limbs import find_limbs, moves_pot
from physagent_jax.agents.compiler.schedule import follows
from physagent_jax.agents.intent import Clause, Duration, Held, Timing
from physagent_jax.agents.lexicon import Effect, Repeat, read_lexicon
from physagent_jax.agents.lexicon.types import HOLDABLE, is_end
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import MAGNITUDE_MAX
from physagent_jax.forces.part import is_plural
from physagent_jax.motion.attitudes import find_attitude
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.hinges import find_hinge, find_hinged
from physagent_jax.motion.joints import Turning
from physagent_jax.motion.landing import FLIPPED, turn_until_landed
from physagent_jax.motion.limbs import sum_directions
from physagent_jax.motion.schema import Amount, AnchorRequest, SceneBrief
from physagent_jax.motion.slashing import plan_strokes
from physagent_jax.motion.swaying import lies
from physagent_jax.motion.tipping import SLOW
from physagent_jax.motion.vectors import add, dot, normalise, scale

_AWAY = 0.01  # [lengths, metres or degrees] from where nothing has to come back
# Begins of phrases for what comes back by itself.
_ROCKING = tuple("let rock swing sway tip catch steady save regain".split())
_MOMENT = 0.2  # of the clip, below which a hold is but a moment
_LAID = 90.0  # [degrees] that what has fallen over is turned by
_OVER = 120.0  # [degrees] from where on it is turned over
_LEVEL = 0.5  # cosine to the vertical below which what stands falls aside
_ALOFT = (Effect.FALL, Effect.JUMP)  # or thrown, or lifted
_FLYING = (Effect.FALL, Effect.ROLL, Effect.PUSH, Effect.JUMP)  # what has come off
_QUARTER = 90.0  # [degrees] by which it turns to a side, to go there
_VERTICAL = 0.9  # cosine
_PIECES = ("tip", "end", "top", "half", "piece")  # of a part that has broken
_BUCKLING = ("give", "buckle")
_STAYS = ("stay", "remain")
_SETTING = ("put", "set", "place", "lay", "lower", "stand")  # begins of phrases for what is set down
_RESTING = (Effect.STILL, Effect.RELEASE)
_SLASHED = Duration(value=0.8, unit="seconds")  # of each stroke of what is swung
_MOST_FALLS = 4  # that one clip has time for
_MOST_SWINGS = 3  # of a door in one clip
_REBOUNDS = 2  # times that what bounces comes up again
_LOWERING = (Effect.LEAN, Effect.SCALE, Effect.SWELL)
_PLAIN = 0.8  # strength from which on a push is no light one
_BREAKING = (Effect.FALL, Effect.JUMP, Effect.STRIKE, Effect.TOPPLE)
_UPSETTING = (Effect.PUSH, Effect.STRIKE, Effect.LEAN)
_RISING = (Effect.PUSH, Effect.STRIKE, Effect.JUMP)


def make_events(clauses: list[Event], builder: ForceFieldBuilder) -> list[Event]:
    """The events that happen, in order."""
    events: list[Event] = []
    told = [each for event in clauses for each in _open_and_close(event, builder.brief)]
    for event in _put_landings_first(told):
        if event.effect is Effect.HOLD:
            builder.obstacles += resolve_obstacles(event.clause.solids, None, builder.brief)
        elif keeps_end(event, clauses):
            continue  # "while the bottom stays put": what is held
        elif event.clause.negated or any(each.times == 0 for each in event.clause.repetitions):
            builder.notes.append(f"'{event.words}' is negated: it does not happen.")
        else:
            _add_event(events, event, builder)
    events = [part for each in events for part in _part_limbs(each, builder.brief)]
    events = _share_time(_find_releases(events, builder))
    for each in events if builder.soft and all(e.effect is not Effect.SWAY for e in events) else ():
        each.trembles = max(each.trembles, each.motion.palm)
    if builder.bursts and events and not any(each.bursts for each in events):
        events[-1].bursts = events[-1].effect in _BREAKING  # "it is smashed on the floor"
    if any(each.effect not in _RESTING for each in events):
        events = [each for each in events if not _is_only_posture(each, events)]
    return events


def _open_and_close(event: Event, brief: SceneBrief) -> list[Event]:
    """The steps of what opens and closes on a hinge, or is screwed off; what has no hinge goes to and fro."""
    motions, after = read_lexicon().motions, event.verb.after if event.parts and event.verb else None
    words = [after, event.phrase] if after else event.phrase.split(" and ")
    steps = [word if word in motions else word.partition(" ")[0] for word in words]
    limbs = find_limbs(event.parts[0], brief) if event.parts else find_hinged(brief)
    swings = event.effect is Effect.SWAY and len(steps) == 2 and all(each in motions for each in steps)
    if not after and not (swings and any(find_hinge(brief.parts[limb], brief) for limb in limbs)):
        return [event]
    count = next((each.times for each in event.clause.repetitions if each.times), 1)
    plain = event.clause.model_copy(update=dict(repetitions=[]))
    steps *= min(count, _MOST_SWINGS)
    clauses = [plain, *[plain.model_copy(update=dict(order="then"))] * (len(steps) - 1)]
    return [
        replace(deepcopy(event), clause=clause, verb=motions[step], motion=motions[step], phrase=step)
        for clause, step in zip(clauses, steps)
    ]


def _part_limbs(event: Event, brief: SceneBrief) -> list[Event]:
    """The limbs of an event one by one: where each stretches along its own line, or one acts after the other."""
    turns = [each for each in event.clause.repetitions if each.in_turn]
    stretched = event.effect is Effect.SCALE and event.motion.sign > 0
    if turns and event.parts and len(event.limbs) < 2 and is_plural(event.parts[0].text):
        event.doubts.append(f"Which parts are meant by '{turns[0].text}' is not known: one is moved.")
    if len(event.limbs) < 2 or not (turns or stretched):
        return [event]
    rest = [each for each in event.clause.repetitions if not each.in_turn]
    later = event.clause.model_copy(update=dict(order="then" if turns else "together", repetitions=rest))
    first, why = later.model_copy(update=dict(order=event.clause.order)), event.sources["vector"].why
    right, parted = brief.directions.right, []
    for limb in sorted(event.limbs, key=lambda limb: turns and dot(brief.parts[limb].side, right)):
        part = brief.parts[limb]
        own = Turning(part, brief, brief.frame_count)
        way = {ALONG: own.arm, ACROSS: own.swing}.get(why, event.direction)
        told = dict(clause=later if parted else first, limbs=(limb,), region=part.moved, direction=way)
        told |= dict(when=Timing(), doubts=[], notes=[]) if parted and turns else {}
        parted.append(replace(event, part=part.side, **told))
    return parted


def _put_landings_first(clauses: list[Event]) -> list[Event]:
    """The clauses in the order of time: what goes on "when it lands" comes after the fall."""
    ordered: list[Event] = []
    for event in clauses:
        if not (ordered and is_landing_meanwhile(ordered[-1], event)):
            ordered.append(event)
            continue
        late = [ordered.pop()]
        while ordered and late[0].clause.order == "and" and is_landing_meanwhile(ordered[-1], event):
            late.insert(0, ordered.pop())  # "it wobbles and bends when it lands"
        if not any(each.effect in _ALOFT or each.motion.gravity for each in ordered):
            ordered.append(event)
        for each in (event, late[0]):
            each.clause = each.clause.model_copy(update=dict(order="then"))
        ordered += late
    return ordered


def _face(event: Event, events: list[Event], brief: SceneBrief) -> None:
    """Tells an event how far the whole object has been turned about the vertical: "it turns left and walks forward"."""
    goes = event.verb is not None and event.verb.effect in (Effect.PUSH, Effect.JUMP)
    for turn in events:
        rise = 0.0 if turn.direction is None else dot(turn.direction, brief.directions.up)
        if turn.effect is not Effect.TURN or turn.parts or turn.limbs or abs(rise) < _VERTICAL:
            continue
        if turn.amount is None and turn.pick(WayKind.TO) and goes and not turn.is_timed:
            turn.amount = Amount(value=_QUARTER, unit="degrees")
        if turn.amount is not None and turn.amount.unit == "degrees":
            event.facing += math.copysign(turn.amount.value, rise)
    event.facing %= 360.0


def _add_event(events: list[Event], event: Event, builder: ForceFieldBuilder) -> None:
    """Adds what a clause tells."""
    if events and not events[-1].parts and event.clause.parts == events[-1].clause.parts:
        event.parts.clear()  # "lift its front wheels, then drop them": all of that end
    stops = event.effect is Effect.STILL and (event.motion.coasts or event.phrase.startswith("come"))
    if stops and event.clause.order == "together" and any(each.effect in GOING for each in events):
        builder.notes.append(f"'{event.text}': what was set going comes to that by itself.")
        return  # "a gust pushes it, and it spins as it slides to a stop"
    pulled = [e.phrase for e in events[-1].parts] if events and events[-1].motion.pulls else []
    if event.effect is Effect.SCALE and pulled and [e.phrase for e in event.parts] in ([], pulled):
        event.parts = events.pop().parts  # "pulls on his tail and it stretches"
    alike = [each for each in events[-2:] if each.direction == events[-1].direction]
    _face(event, events, builder.brief)
    interpret(event, _find_measure(events, event), builder.brief)
    for each in alike:  # what knocks it over goes the way that it falls
        each.direction = events[-1].direction
    if steps := _slash(event, builder.brief) or _set_down(event, events, builder):
        events += steps
        return
    rests = event.effect is Effect.STILL and event.unknown_parts[:1]
    if rests and -1 < event.text.find(rests[0]) < event.text.find(event.words):
        builder.notes.append(f"'{event.text}': where that is, is not known, and nothing is done to it.")
        event.unknown_parts.clear()
        return  # "while the trunk stays put"
    tips = bool(events) and event.motion.angle > 0 and event.effect is Effect.LEAN
    if tips and events[-1].motion.brief and event.motion.direction == events[-1].motion.direction:
        return  # "its nose dips and its rear lifts up"
    if len(events) > 1 and events[-1].effect is event.effect is Effect.STILL and event.is_bare:
        events[-1].stays |= event.stays
        return  # "it stops, still standing"
    fell = bool(events) and (events[-1].effect in (Effect.FALL, Effect.TOPPLE) or events[-1].motion.gravity)
    if event.phrase == "smash" and event.is_bare and fell:  # "it falls and smashes"
        event.motion, event.phrase, event.direction = read_lexicon().motions["break"], "break", None
    if events and events[-1].phrase == "unscrew" and event.motion.manner == "detach" and event.limbs:
        event = replace(_make_another(event, "unscrew off"), direction=builder.brief.directions.up)
        event.clause = event.clause.model_copy(update=dict(order="then"))  # "it unscrews and comes off"
    severed = bool(events) and events[-1].motion.manner == "detach"
    if severed and event.effect is Effect.LEAN and event.motion.direction == "beside" and not event.parts:
        builder.notes.append(f"'{event.words}' comes of the part that is gone: nothing is made of that.")
        return  # "its wheel comes off and it sags on that side"
    if severed and _is_of_piece(event, events[-1]):
        _send_piece(events[-1], event)
        event.motion = replace(event.motion, manner="detach", gives=False)  # no matter of the rest
        builder.notes.append(f"'{event.words}' is taken to be said of the part that comes off.")
        return  # "its head falls off and rolls away"
    whole = [each.effect for each in events if each.motion.manner != "detach"]
    falls = event.effect is Effect.FALL or not {*_ALOFT, *_UPSETTING}.isdisjoint(whole)
    if events and _is_crushed(events[-1], event):
        slam = events[-1]
        slam.motion = replace(slam.motion, effect=Effect.STRIKE, gives=True)
        slam.strength, slam.doubts = MAGNITUDE_MAX, [*slam.doubts, *event.doubts]
        return  # "it crashes into the wall, and its front crumples": it is of what gives way
    if builder.bursts and event.motion.gives:
        done = [each for each in events if each.effect not in _RESTING][-1:]
        event.bursts = not done or done[0].effect not in _BREAKING
        event.clause = event.clause.model_copy(update=dict(order="then"))
        if done and not event.bursts:  # "it falls and shatters"
            done[0].bursts, done[0].doubts = True, [*done[0].doubts, *event.doubts]
        else:
            events.append(event)
        return
    fall = events[-1] if events and events[-1].effect is Effect.FALL else None
    bursts = fall and event.effect is Effect.BURST
    yields = event.motion.gives or bursts and builder.breaks or fall and _yields(event, builder.soft)
    if event.motion.manner == "split" and events and falls:
        event.clause = event.clause.model_copy(update=dict(order="then"))  # "it falls and breaks in two"
    if yields and falls and any(each.effect not in _RESTING for each in events):
        events[-1].doubts += event.doubts
        events[-1].trembles = max(events[-1].trembles, builder.soft and not event.motion.gives)
        return  # "it falls and shatters", "it falls and flattens"
    bounces = event.verb is not None and event.verb.bounces and event.effect in (Effect.FALL, Effect.JUMP)
    springs = bounces or event.effect is Effect.RELEASE and event.phrase.startswith("bounce")
    if springs and events and events[-1].effect is Effect.STRIKE and _lands(events[-1], builder.brief):
        fall = events[-1] = _make_another(events[-1], "drop")  # "it is thrown down and bounces back up"
    if bounces or fall and springs:
        bouncing = fall or event
        bouncing.rebounds, bouncing.repeat = event.repeat.count or _REBOUNDS, event.repeat
        if fall:
            return  # "it drops and bounces twice", "it falls and bounces back up"
    acted = next((each for each in reversed(events) if each.effect is not Effect.RELEASE), None)
    if builder.soft and acted and _trembles(event):
        lands = acted is events[-1] and acted.effect is Effect.FALL
        acted.trembles = max(event.strength, _PLAIN) if lands else 0.0
        pressed = acted.effect is Effect.SCALE and acted.motion.sign < 0 and event.effect is Effect.SWAY
        if acted.trembles or pressed:
            builder.notes.append(f"'{event.words}': what is soft does so by itself.")
        if acted.trembles or pressed and acted is not events[-1]:
            return  # led to and fro, it would hang where it has bounced to
        event = _make_another(event, "spring back") if pressed else event
    lowered = all(each.effect in _LOWERING for each in events) and event.motion.lands
    buckles = bool(events) and events[-1].motion.gives and events[-1].phrase.startswith(_BUCKLING)
    if buckles and event.effect is Effect.TOPPLE:
        events.pop().motion = event.motion  # "its legs give way and it falls on its side"
    if events and event.effect is Effect.FALL and (events[-1].motion.gives or lowered):
        if not event.goes_aside:
            return  # "it sags until its belly touches the ground"
        collapsed = events.pop()  # "it collapses and falls to the left": it falls over
        collapsed.motion = replace(collapsed.motion, gives=False)
    if events and events[-1].motion.gives and event.motion.by == "limp" and not event.parts:
        return  # "it goes soft and droops"
    if events and _rises_again(events[-1], event):
        event = _make_another(event, "spring back")
    _measure_return(event, events)
    event = _put_under_gravity(event, builder.gravity)
    level = event.direction is not None and abs(dot(event.direction, builder.brief.directions.up)) < _LEVEL
    aloft = any(e.effect in _ALOFT or e.motion.gravity or _is_lifted([e], builder) for e in events)
    before = events[-1] if events else None
    ends = before and is_end(before.motion, event.motion) and event.clause.order != "together"
    lowered = _is_dropped(event, builder) or event.motion.puts_back and not aloft
    lowered |= event.phrase == "come back down" and not aloft
    rests = next((each for each in reversed(events) if each.effect is not Effect.STILL), None)
    lean = _find_held_lean(events, builder) if lowered and rests and rests.limbs else None
    if lean and event.is_bare and event.phrase == "come down":
        event = _bring_back(lean, event)  # "it rears up, waves its paws and comes down"
    elif rests and rests.effect is Effect.LEAN and event.is_bare and lowered:
        event = _make_another(event, "let go")  # "lift its front end, then drop it"
    lower = all(way.names == ("down",) for way in event.ways) and not event.clause.quantities
    upright = before is not None and _is_upright(before)
    soon = event.clause.order != "then" or upright
    ends = ends or before and (before.effect in _UPSETTING or upright) and lower and soon
    topples = event.motion.topples or event.phrase == "go" and upright
    level = _level_out(event, builder.brief) or level if topples else level
    if topples and (level or ends) and builder.grounded and not aloft:  # it stands
        way = event.direction if level else _find_level_way(events, builder)
        event = replace(event, motion=read_lexicon().motions["fall over"], phrase="fall over", direction=way)
        leans = before is not None and before.effect is Effect.LEAN and before.sources["vector"]
        event.sources |= {} if level else {"vector": leans or ValueSource(event.words, BY_DEFAULT)}
    elif event.phrase == "collapse" and builder.grounded and not events:
        event = replace(_make_another(event, "sag"), direction=builder.brief.directions.up)  # where it stands
    poked = before and before.motion.pokes and builder.soft  # a finger goes into it
    if before and _goes_over(before, event):
        event = _join_fall(events.pop(), event)
    elif before and _sets_rocking(before, event) and builder.grounded and not (builder.anchored or poked):
        builder.notes.append(f"'{before.words}' sets it rocking: pushed as well, it would slide or fall.")
        event = _join_push(events.pop(), event)
    if _ends_flight(events, event):
        if len(events) > 1:
            events[-1].clause = events[-1].clause.model_copy(update=dict(order="together"))
        events[-1] = _turn_until_landed(events[-1], event, builder.brief)
        return  # "it flips in the air and lands", "it is thrown up, spins and lands on its side"
    if events and events[-1].motion.leaps and event.effect is not Effect.TURN and event.clause.order == "and":
        event.clause = event.clause.model_copy(update=dict(order="then"))  # "... and slides"
    thrown = bool(events) and (events[-1].motion.gravity or events[-1].effect is Effect.JUMP)
    if thrown and event.phrase in ("come back down", "go back down"):
        event = _make_another(event, "land")  # "toss it up and let it come back down"
    if events and events[-1].effect is Effect.FALL and event.effect is Effect.FALL:
        last = events[-1]
        if event.is_bare:
            pose = event.clause.pose or last.clause.pose
            last.clause = last.clause.model_copy(update=dict(pose=pose))
            return  # "it drops and bounces"
        if event.lands_aside and last.direction is None:
            last.direction, last.amount = event.direction, event.amount
            last.doubts += event.doubts
            last.sources |= event.sources
            return  # "drop it; as it reaches the ground it is farther to the right"
    above = event.is_upwards and not event.clause.quantities  # "from a metre up"
    if event.effect is Effect.FALL and builder.gravity is None and above:
        builder.gravity = "up"  # "it falls upwards"
    # All of what stands is dropped, and nothing before has raised it: "turn it, then drop it".
    stood = before and event.clause.order == "then" and not (aloft or any(each.limbs for each in events))
    if stood and _is_dropped(event, builder):
        events.append(_make_lift(event, builder))
        builder.notes.append(f"'{event.words}': it stands on the ground, so it is lifted first.")
    if (turn := _turn_for_landing(event, events, builder)) is not None:
        events.append(turn)
        event.clause, event.motion = turn.clause, replace(event.motion, pose="")
        if turn.clause.order == "together":
            return  # "throw it up so that it lands on its side"
    events.append(event)
    _drop_again(events, builder)


def _ends_flight(events: list[Event], event: Event) -> bool:
    """Return whether it comes down with an event, having turned aloft till then."""
    *_, rise, turn = (None, None, *events)
    if turn is None or turn.effect is not Effect.TURN or turn.parts or turn.limbs:
        return False
    thrown = rise is not None and (rise.effect is Effect.JUMP or rise.motion.gravity)
    lands = event.effect is Effect.FALL and not event.goes_aside or event.motion.alone == "fall"
    lies = event.phrase.startswith(("land", "topple")) or event.motion.generic
    lies &= event.effect is Effect.TOPPLE or event.effect is Effect.TURN and event.motion.angle == FLIPPED
    return (turn.motion.leaps or thrown) and (lands or lies)


def _turn_for_landing(event: Event, events: list[Event], builder: ForceFieldBuilder) -> Event | None:
    """The turn aloft after which what was lifted or thrown lands as it is said to; None if it lands as it was."""
    pose, last = event.clause.pose or event.motion.pose, events[-1] if events else None
    thrown = last is not None and (last.motion.gravity or last.effect is Effect.JUMP)
    if event.effect is not Effect.FALL or pose in ("", "down") or not (thrown or _is_lifted(events, builder)):
        return None
    x, y = find_attitude(pose, builder.brief)
    plain = dict(pose="", quantities=[], repetitions=[], order="together" if thrown else "then")
    told = Amount(value=math.hypot(x, y), unit="degrees")
    turn = _make_another(event, "turn", tumbles=thrown)
    builder.notes.append(f"'{event.text}': it is turned in the air, so that it lands so.")
    clause, way = event.clause.model_copy(update=plain), normalise((x, y, 0.0))
    return replace(turn, clause=clause, when=Timing(), direction=way, amount=told, strength=1.0)


def _turn_until_landed(turn: Event, event: Event, brief: SceneBrief) -> Event:
    """The turn aloft that ends as it is said to land, whatever it lands on."""
    turn.doubts += event.doubts
    over, told, own = event.effect is Effect.TURN or event.clause.pose == "up", turn.amount, turn.direction
    side = event.direction if over else event.direction and find_lean_axis(event.direction, brief)
    if not (over or event.effect is Effect.TOPPLE) or side is None and own is None:
        return turn
    degrees = told.value if told and told.unit == "degrees" else 0.0
    own = (
        side if turn.motion.picture and side else own
    )  # the picture's axis is none of its own: it would reel
    axis, degrees = turn_until_landed(degrees, own, side, over, brief)
    motion, amount = replace(turn.motion, manner="", tumbles=True), Amount(value=degrees, unit="degrees")
    return replace(turn, direction=axis, amount=amount, motion=motion)


def _slash(event: Event, brief: SceneBrief) -> list[Event]:
    """The strokes of something that is swung by one end, from one side to the other; none of other motions."""
    if event.motion.manner != "slash" or event.direction is None or event.limbs:
        return []
    count = min(next((each.times for each in event.clause.repetitions if each.times), 1), _MOST_SWINGS)
    clause = event.clause.model_copy(update=dict(quantities=[], repetitions=[], order="then"))
    told = dict(clause=clause, repeat=Repeat(), when=Timing(lasts=_SLASHED))
    return [
        replace(event, direction=axis, amount=Amount(value=angle, unit="degrees"), means=drawn, **told)
        for axis, angle, drawn in plan_strokes(event.direction, count, brief)
    ]


def _set_down(event: Event, events: list[Event], builder: ForceFieldBuilder) -> list[Event]:
    """The turn in the air and the lowering of what was lifted and is "set down on its side"; none of other motions."""
    brief, up = builder.brief, builder.brief.directions.up
    moves = [e for e in events if e.effect in (*_ALOFT, Effect.PUSH) and abs((e.direction or up)[2]) > _LEVEL]
    known = event.effect in (Effect.TURN, Effect.TOPPLE, Effect.RELEASE) and event.phrase.startswith(_SETTING)
    if not (known and _is_lifted(moves, builder)):
        return []
    over = [replace(e, direction=scale(e.direction or up, -1.0)) for e in events if _is_turned_over(e)]
    turned = over[-1:] if event.effect is Effect.RELEASE else [event]  # "the right way up"
    if event.effect is Effect.TOPPLE:
        turned = [_raise(replace(event, direction=scale(event.direction or up, -1.0)), event, brief)]
    elif event.motion.direction == "own" and over:
        turned = []  # "flipped, and set down on its head"
    lowered = replace(_make_another(event, "set down"), direction=brief.directions.down, amount=None)
    clause = event.clause.model_copy(update=dict(order="then"))
    return [replace(each, clause=clause) for each in (*turned, lowered)]


def _is_of_piece(event: Event, before: Event) -> bool:
    """Return whether a motion is one of the part that has come off: "its head falls off, bounces and rolls away"."""
    if not event.parts:
        return event.effect in _FLYING or event.motion.tumbles
    lowered = event.direction is not None and event.direction[2] < -_LEVEL
    falls = event.effect is Effect.FALL or event.effect is Effect.LEAN and lowered
    piece = event.parts[0].phrase.split()[-1] in _PIECES  # "the blade snaps, and its tip falls down"
    same = event.parts[0] == before.parts[0] if before.parts else False
    return event.effect not in _RESTING and event.effect is not Effect.HOLD and (same or piece and falls)


def _send_piece(piece: Event, event: Event) -> None:
    """Sends a part that comes off where it is then said to go or to land: "flies off and lands behind him"."""
    told = not piece.sources["vector"].why.endswith(BY_DEFAULT)
    if event.direction is None or told or all(way.text.lower() == "away" for way in event.pick(WayKind.TO)):
        return
    piece.direction = normalise(add(filter(None, (piece.direction, event.direction)))) or event.direction
    piece.notes, piece.sources["vector"] = [], event.sources["vector"]


def _drop_again(events: list[Event], builder: ForceFieldBuilder) -> None:
    """Adds the other falls of what is dropped several times, each after a lift."""
    event, told = events[-1], [each.text for each in events[-1].clause.repetitions]
    count, turned = event.repeat.count or 1, event.repeat.alternate
    if count < 2 or count > _MOST_FALLS or turned or not _is_dropped(event, builder) or event.rebounds:
        return
    doubts = [doubt for doubt in event.doubts if not any(f"What '{text}' means" in doubt for text in told)]
    plain = event.clause.model_copy(update=dict(order="then", repetitions=[]))
    events[-1] = once = replace(event, repeat=Repeat(), doubts=doubts)
    for _ in range(count - 1):
        events.append(_make_lift(once, builder))
        events.append(replace(once, clause=plain, doubts=[]))


def _make_lift(event: Event, builder: ForceFieldBuilder) -> Event:
    """The lift that has to come before a fall."""
    plain = event.clause.model_copy(update=dict(pose=None, quantities=[], repetitions=[], order="then"))
    told = dict(clause=plain, when=Timing(), amount=None, direction=builder.brief.directions.up)
    return replace(_make_another(event, "lift"), means=True, **told)


def _is_dropped(event: Event, builder: ForceFieldBuilder) -> bool:
    """Return whether all of what stands is dropped."""
    return event.motion.drops and not (event.parts or event.limbs or builder.anchored) and builder.grounded


def _rises_again(before: Event, event: Event) -> bool:
    """Return whether what was pressed, or a limb, comes up by itself: "squash it, and let it rise again"."""
    pressed = before.effect is Effect.SCALE and before.motion.sign < 0 and not before.motion.gives
    bare = all(way.phrase == "up" for way in event.ways) and not (event.clause.quantities or event.limbs)
    springs = bool(before.limbs) and event.phrase == "spring up"
    return bare and (pressed and event.phrase == "rise" or springs)


def _yields(event: Event, soft: bool) -> bool:
    """Return whether a change of shape is what the ground does as it is met.

    It is told of no later time; or of what is soft, as of something that happens: "it lands, gets squashed, ...".
    """
    shapes = event.effect is Effect.SCALE and (soft or event.motion.sign < 0)
    shapes |= soft and event.effect is Effect.LEAN and event.motion.manner == "bend"
    happens = soft and event.words.split()[0].lower() != event.phrase.split()[0] and not event.clause.cause
    return shapes and (happens or event.clause.order != "then") and not (event.ways or event.parts)


def _is_crushed(before: Event, event: Event) -> bool:
    """Return whether a change of shape, of all of it or of a part, is what a wall does that was met before."""
    meets = bool(before.clause.solids) and before.effect in (Effect.PUSH, Effect.STRIKE) and not before.parts
    shapes = event.effect in (Effect.SCALE, Effect.SWELL) and event.motion.sign < 0
    return meets and (shapes or event.motion.gives) and not event.ways


def _lands(event: Event, brief: SceneBrief) -> bool:
    """Return whether it is thrown down."""
    return event.motion.gravity and dot(event.direction or (0, 0, 0), brief.directions.down) > _LEVEL


def _trembles(event: Event) -> bool:
    """Return whether it goes to and fro by no way that is told, or comes back: "it wobbles as it lands"."""
    if event.effect is Effect.RELEASE:
        return not event.parts
    wobbles = event.effect is Effect.SWAY and (event.motion.wobbles or event.motion.jiggles)
    aside = event.ways and not event.is_back  # "and wobbles back into shape"
    return wobbles and not (aside or event.parts or event.repeat.count)


def _goes_over(before: Event, event: Event) -> bool:
    """Return whether a lean, or a push until then, is how it tips over: "it tilts to the left and falls over"."""
    # "It loses its balance on its tip and falls over."
    placed = before.parts and before.effect is not Effect.TOPPLE
    whole = not (placed or before.repeat.count or before.amount or before.stays)
    untold = any(each.sources["vector"].why.endswith(BY_DEFAULT) for each in (before, event))
    same = untold or dot(before.direction or (0, 0, 0), event.direction or (0, 0, 0)) > _LEVEL
    timed = before.is_timed or event.is_timed or event.clause.pace == "sudden"
    until = event.clause.order == "together" or "so" in before.clause.strength
    slowly = event.clause.order != "then" or before.strength < SLOW
    # "Someone shoves it and it falls over."
    pushed = before.effect is Effect.PUSH and not before.motion.generic
    until |= (before.is_in_wind or pushed) and event.clause.order != "then"
    goes = before.motion.manner == "rock" and slowly if before.effect is Effect.LEAN else until
    goes = goes if before.effect in (Effect.LEAN, Effect.PUSH) else before.effect is Effect.TOPPLE
    return event.effect is Effect.TOPPLE and goes and whole and same and not timed


def _sets_rocking(before: Event, event: Event) -> bool:
    """Return whether a light push, or a blow anywhere, makes it rock where it stands: "a nudge, it rocks a bit"."""
    pushed, motion = before.effect in (Effect.PUSH, Effect.STRIKE) and before.strength <= 1, before.motion
    hit = bool(before.parts) and before.effect is Effect.STRIKE  # "a ball hits its rim"
    told = before.parts and not hit or before.amount or before.is_timed or before.repeat.count
    slides = before.clause.elsewhere and before.effect is Effect.PUSH  # "it slides aside when nudged"
    goes = motion.gravity or motion.hauls or before.is_in_wind or slides
    level = hit or before.direction is not None and abs(before.direction[2]) < _LEVEL
    rocks = event.motion.manner == "rock" or event.motion.jiggles
    rocks &= event.effect is Effect.SWAY and not (event.parts or event.is_timed)
    soon = {"and": True, "then": before.strength < _PLAIN}.get(event.clause.order, False)
    return pushed and not (told or goes) and level and rocks and soon


def _keep_order(before: Event, event: Event) -> Clause:
    """The event's clause, as late as what leads to it: "it leaps, then is pushed and falls over"."""
    later = before.clause.order == "then"
    return event.clause.model_copy(update=dict(order="then")) if later else event.clause


def _join_push(before: Event, event: Event) -> Event:
    """The rocking along the way of the push that sets it going, unless it tells its own, or that is upright."""
    own = not event.sources["vector"].why.endswith(BY_DEFAULT)
    own |= before.direction is None or abs(before.direction[2]) >= _LEVEL
    way = {} if own else dict(direction=before.direction, notes=before.notes)
    sources = event.sources if own else event.sources | {"vector": before.sources["vector"]}
    motion = replace(event.motion, manner="rock")
    doubts = [*before.doubts, *event.doubts]
    clause = _keep_order(before, event)
    nudged = before.motion.touches
    return replace(event, clause=clause, motion=motion, doubts=doubts, sources=sources, nudged=nudged, **way)


def _join_fall(before: Event, event: Event) -> Event:
    """The fall over with the way and, where it tells none of its own, the strength of what leads to it."""
    assumed = [each.sources["vector"].why.endswith(BY_DEFAULT) for each in (before, event)]
    own = not assumed[1] or all(assumed)  # what lies falls over its long side, wherever it is pushed
    told = {key: before.sources[key] for key in ("vector", "magnitude")}
    way = {} if own else dict(direction=before.direction, notes=before.notes, sources=event.sources | told)
    clause = _keep_order(before, event)
    strength = event.strength if event.strengths else before.strength
    return replace(event, clause=clause, strength=strength, nudged=before.motion.touches, **way)


def _is_upright(event: Event) -> bool:
    """Return whether all of it stands or leans, from where what "goes down" tips over."""
    stands = event.effect is Effect.STILL and event.phrase in ("balance", "stand upright", "stay upright")
    return not event.parts and (stands or event.effect in (Effect.LEAN, Effect.TOPPLE))


def _level_out(event: Event, brief: SceneBrief) -> bool:
    """Levels the way of what goes down to a side, and returns whether it does: "falls backward onto the floor"."""
    way, up = event.direction, brief.directions.up
    if way is None or not event.goes_aside or dot(way, up) > -_LEVEL:
        return False
    event.direction = normalise(add((way, scale(up, -dot(way, up)))))
    return event.direction is not None


def _find_level_way(events: list[Event], builder: ForceFieldBuilder) -> Vector:
    """The level way of the last event that has one, else the left; of what lies, across it."""
    table, brief = builder.brief.directions, builder.brief
    ways = [e.direction for e in events if e.direction and e.effect is not Effect.TURN]
    level = (way for way in reversed(ways) if abs(dot(way, table.up)) < _LEVEL)
    leans = bool(events) and events[-1].effect is Effect.LEAN  # "it leans to the left and falls"
    return sum_directions(("beside",), brief) if lies(brief) and not leans else next(level, table.left)


def _is_only_posture(event: Event, events: list[Event]) -> bool:
    """Return whether "standing" is no wish for stillness: "the robot standing on the ground is pushed"."""
    last = event is events[-1] and event.clause.order == "then"
    return event.effect is Effect.STILL and event.motion.generic and not last and not event.is_timed


def _find_measure(events: list[Event], event: Event) -> Event | None:
    """The last event with a direction; for what comes "back" or goes on the same way, the last like it."""
    directed = [each for each in events if each.direction is not None]
    turns = event.effect is Effect.TURN
    if event.motion.coasts:  # "it is pushed, spins around and slides to a stop"
        directed = [each for each in directed if each.effect in GOING] or directed
    if event.is_back:
        directed = [each for each in directed if (each.effect is Effect.TURN) == turns] or directed
    if any(way.names == ("same",) for way in event.pick(WayKind.AGAIN)):
        directed = [each for each in directed if each.effect is not Effect.TURN] or directed
    return directed[-1] if directed else None


def _measure_return(event: Event, events: list[Event]) -> None:
    """The distance of a return, where the distance away was told."""
    way, told = event.direction, event.amount is not None or event.clause.quantities
    if told or not event.is_back or way is None:
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
    told = bool(event.pick(*WAYS))
    falls = event.clause.cause == "gravity" and gravity in ("down", None)
    if falls and event.effect is Effect.PUSH and (not told or event.motion.pulls):
        return _make_another(event, "fall")
    if gravity == "none" and event.motion.floats and not told:
        return _make_another(event, "motionless", generic=True)
    return event


def _find_releases(events: list[Event], builder: ForceFieldBuilder) -> list[Event]:
    """Letting go of something at rest lets it fall; letting go before a fall is part of the fall."""
    result, idle = [], all(each.effect in _RESTING for each in events)
    for event, after in zip(events, [*events[1:], None]):
        returned = event.motion.puts_back or event.is_back
        returned &= bool(result) and result[-1].effect is Effect.TOPPLE
        limb = bool(next((each.limbs for each in reversed(result) if each.effect not in _RESTING), ()))
        if event.effect is not Effect.RELEASE and not returned:
            let_go = limb and result[-1].motion.lets_go and not event.parts and event.clause.order != "then"
            if not (let_go and event.effect in (Effect.FALL, Effect.TOPPLE)):
                result.append(event)  # else "lift its arm, let go so it falls back down": the arm does
            continue
        if result and result[-1].effect is Effect.RELEASE:
            continue  # "release it and let it swing back" is one release
        acted = any(each.effect not in _RESTING for each in result)
        lean = None if limb else _find_held_lean(result, builder)
        falls = after is not None and after.effect in (Effect.FALL, Effect.TOPPLE)
        if event.motion.alone == "fall" and limb:
            result.append(event)
        elif event.motion.alone == "fall" and _is_lifted(result, builder):
            result.append(_make_another(event, "fall"))
        elif lean and not (falls and after and after.clause.order != "then"):
            result.append(_bring_back(lean, event))
        elif falls:
            continue
        elif acted and _is_turned_over(result[-1]) and not event.motion.lets_go:
            back = scale(result[-1].direction, -1.0) if result[-1].direction else None
            result.append(replace(result[-1], clause=event.clause, when=event.when, direction=back))
        elif acted and result[-1].effect is Effect.TOPPLE and not event.motion.lets_go:
            if event.phrase.startswith(_ROCKING):  # "tip it over, then let it rock back upright"
                result[-1:] = [replace(result[-1], motion=read_lexicon().motions["tip"], phrase="tip"), event]
            else:
                result.append(_raise(result[-1], event, builder.brief))
        elif acted:
            result.append(event)
        elif event.motion.alone and after is not None and after.clause.order == "together":
            continue  # "it recoils as it is hit"
        elif (phrase := event.motion.alone) and (event.motion.lets_go or idle):
            motion = read_lexicon().motions[phrase]
            usual = getattr(builder.brief.directions, motion.direction) if motion.direction else None
            usual = builder.brief.directions.left if motion.effect is Effect.SWAY else usual
            way, strength = event.direction or usual, event.strength * motion.strength
            result.append(replace(event, motion=motion, phrase=phrase, direction=way, strength=strength))
            builder.notes.append(f"'{event.text}': nothing acts before it, so it is read as '{phrase}'.")
        else:
            builder.unsure.append(f"What '{event.text}' comes back from is not understood.")
    return result


def _is_turned_over(event: Event) -> bool:
    """Return whether all of it was turned over, so that it does not come back by itself: "then set it upright"."""
    told = event.amount is not None and event.amount.unit == "degrees" and event.amount.value > _OVER
    level = event.direction is not None and abs(event.direction[2]) < _LEVEL
    return event.effect is Effect.TURN and told and level and not (event.parts or event.limbs)


def _find_held_lean(events: list[Event], builder: ForceFieldBuilder) -> Event | None:
    """The lean in which all of it was kept as it rested or moved a limb: "it rears up, waits, and comes down"."""
    whole = [each for each in events if not (each.limbs or each.effect is Effect.STILL)]
    lean = whole[-1] if whole and whole[-1] is not events[-1] and not builder.anchored else None
    held = lean is not None and lean.effect is Effect.LEAN and lean.direction and not lean.parts
    return lean if held and builder.grounded else None


def _bring_back(lean: Event, event: Event) -> Event:
    """The turn by which what leant comes back."""
    way, motion = scale(lean.direction or (0, 0, 0), -1.0), replace(lean.motion, puts_back=True)
    return replace(lean, clause=event.clause, when=event.when, direction=way, motion=motion)


def _raise(fallen: Event, event: Event, brief: SceneBrief) -> Event:
    """The turn that sets upright again what has fallen over as a whole: "it falls over, then gets up again"."""
    if fallen.direction is None or fallen.parts or fallen.limbs:
        return event
    axis, laid = scale(find_lean_axis(fallen.direction, brief), -1.0), Amount(value=_LAID, unit="degrees")
    motion = replace(read_lexicon().motions["turn"], puts_back=True)
    return replace(event, motion=motion, phrase="turn", direction=axis, amount=laid)


def _is_lifted(events: list[Event], builder: ForceFieldBuilder) -> bool:
    """Return whether the last motion raised an object that gravity acts on, and nothing holds."""
    last = next((each for each in reversed(events) if each.effect is not Effect.STILL), None)
    if last is None or last.effect is not Effect.PUSH or last.direction is None:
        return False
    raised = dot(last.direction, builder.brief.directions.up) > 0.5
    return raised and builder.grounded and not builder.anchored


def apply_holding(clauses: list[Event], held: Held | None) -> list[Event]:
    """Holding what was just moved keeps it there; holding what is then let go is no anchor."""
    result: list[Event] = []
    for index, event in enumerate(clauses):
        last = result[-1] if result else None
        after = next((each for each in clauses[index + 1 :] if not each.clause.negated), None)
        hovers = last is not None and event.motion.floats and last.motion.direction == "up"
        if hovers and after is not None and not event.ways:
            event, hovers = _wait(event), False  # "it rises, hovers, then drops"
        elif last is None and event.motion.floats and _falls_later(event, after):
            result.append(replace(event, when=Timing()))  # "it hovers for a second": it has risen by then
            event = _wait(event)
        if last is not None and (event.stays or hovers) and event.is_bare and event.effect is last.effect:
            last.stays = True  # "compress it and keep it compressed", "it takes off and hovers"
            continue
        if _hangs_in_the_air(event, last):
            if after is not None and after.effect is Effect.FALL:
                continue  # "thrown up, it hangs there and falls": so does all that turns back
            event = _wait(event)
        holds = event.effect is Effect.HOLD and event.motion.holds == "base"
        if holds and held is None and not (event.parts or event.clause.negated):
            result += _hold(event, last, after)
        else:
            result.append(event)
    return result


def _falls_later(event: Event, after: Event | None) -> bool:
    """Return whether it is up for a time that is told, and then falls."""
    return event.is_timed and not event.ways and after is not None and after.effect is Effect.FALL


def _hold(event: Event, last: Event | None, after: Event | None) -> list[Event]:
    """A bare hold as an anchor, as a time of rest, or (nothing) as a property of what was done before."""
    moved = last is not None and not last.clause.negated and last.effect in HOLDABLE
    let_go = after is not None and after.effect is Effect.RELEASE and after.is_bare
    raised = last is not None and last.effect is Effect.PUSH and not last.parts
    raised &= last is not None and last.motion.direction == "up" and event.is_timed
    let_go &= not raised  # "lift it, hold it there for a second, then let go": it is up there so long
    if moved and last is not None and let_go and not last.is_timed:
        lasts = event.when.lasts  # "hold it for a second, then release it"; a moment is no time to get there
        last.when = Timing() if lasts and lasts.unit == "clip" and lasts.value < _MOMENT else event.when
    elif after is not None and event.is_timed:
        return [_wait(event)]  # "hold it for a second, then"
    elif moved and last is not None and event.clause.order != "together":
        last.stays = after is None
    elif last is not None and event.phrase.split()[0] in _STAYS and event.clause.order != "together":
        return [_wait(event)]  # "it rolls over there and stays there": nobody holds it
    elif last is not None and (last.effect is Effect.FALL or last.motion.gravity):
        last.notes.append(f"'{event.text}': nothing holds it where it comes down.")
    elif after is None or after.effect not in (Effect.FALL, Effect.RELEASE):
        return [event]
    return []


def choose_anchor(told: Held | None, clauses: list[Event], brief: SceneBrief) -> AnchorRequest:
    """Choose the hold: an adjective ("rooted"), a motion ("hold the pot"), or an end that "does not move"."""
    if told is not None:
        return AnchorRequest(kind=told.end, words=told.text, described=told.described)
    for event in clauses:
        if event.effect is Effect.HOLD:
            end = "none" if event.clause.negated else _find_held_end(event, event.motion.holds)
        elif keeps_end(event, clauses):
            end = _find_held_end(event, None)
        elif moves_pot(event, brief):
            end = "none"
        else:
            continue
        return AnchorRequest.model_validate({"kind": end, "words": event.text})
    return AnchorRequest()


def keeps_end(event: Event, clauses: list[Event]) -> bool:
    """Return whether a clause says of an end that it is still while the rest moves."""
    still = event.effect is Effect.STILL and not event.clause.negated
    beside = event is clauses[0] or event.clause.order != "then"
    return still and beside and _find_held_end(event, None) is not None


def _find_held_end(event: Event, otherwise: str | None) -> str | None:
    """The end that a clause names: "base" or "top"; other parts cannot be held."""
    if not event.parts:
        return otherwise
    names = event.parts[0].place.names
    return "base" if "down" in names else "top" if "up" in names else None


def _hangs_in_the_air(event: Event, last: Event | None) -> bool:
    """Return whether what hangs has just been moved, and nothing is told that it hangs from."""
    if event.motion.holds != "top" or event.clause.negated or event.clause.order == "together":
        return False
    if last is None or last.clause.negated or event.pick(WayKind.FROM, WayKind.PLANE):
        return False
    return last.effect in (*_RISING, Effect.LEAN)  # thrown up, or reared up


def _wait(event: Event) -> Event:
    """The same for a time in which nothing moves."""
    wait = read_lexicon().motions["wait"]
    return replace(event, motion=wait, verb=wait, phrase="wait", cause=None)
