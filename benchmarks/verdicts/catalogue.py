"""All clips: sentences, and motions that are right or wrong for them. Written by hand; no parser is asked.

A label says whether a person who reads the sentence and watches the clip would call it a success:

- A plain "push" or "move" is right from 0.35 L to 1.2 L in two seconds; under 0.07 L nobody would call it pushed.
- "Gently" is right from 0.12 L to 0.35 L, and wrong above 1 L; "violently" is right above 1.2 L, and wrong below 0.3 L.
- A number in the sentence is right within 15 % and wrong at half and at twice of it.
- A plain "spin" is right from 90 to 250 degrees, wrong under 15; a stretch or squeeze from 20 to 50 %, wrong under 5 %.
- A direction is wrong from 60 degrees off.
- What was not asked for makes it wrong if nobody could overlook it: half a turn, a second shift as large as the first,
  break-up. A ball that rolls where it is pushed is right.
- A twist is right if one end is turned against the other by 50 degrees or more.
- Where people would disagree there is no clip.

Whether a clip's motion is the labelled one is measured before it is judged (`claims`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from benchmarks.verdicts import motions as m
from benchmarks.verdicts.claims import Gone, Reach, Shift, Still, Turn
from benchmarks.verdicts.clip import Clip, Wrong
from benchmarks.verdicts.motions import AWAY, DOWN, LEFT, RIGHT, TOWARD, UP, Motion
from benchmarks.verdicts.things import list_things

Right = Mapping[str, Motion]
Fault = tuple[tuple[Wrong, str], Motion]

STILL = Motion("nothing moves", (Still(),))
RESTS = Motion("stands still on the ground", (Still(),), world="ground")
BROKEN = Motion("flies to pieces", m.explode())
_WORDS = {LEFT: "left", RIGHT: "right", UP: "up", DOWN: "down", AWAY: "away", TOWARD: "toward the viewer"}


def _glide(direction: m.Direction, shift: float, **options) -> Motion:
    way = _WORDS.get(direction, "slantwise")
    return Motion(f"moves {way} by {shift:g} L", m.glide(direction, shift), **options)


def _turn(axis: m.Direction, degrees: float, what: str = "") -> Motion:
    names = {
        UP: "counterclockwise from above",
        DOWN: "clockwise from above",
        AWAY: "clockwise in the picture",
    }
    return Motion(f"turns {names.get(axis, what)} by {degrees:g} degrees", m.turn(axis, degrees))


def _resize(direction: m.Direction, change: float) -> Motion:
    way = "in height" if direction == UP else "in width"
    return Motion(f"changes {way} by {100 * change:+.0f} %", m.resize(direction, change))


def _slide(direction: m.Direction, shift: float) -> Motion:
    way = _WORDS.get(direction, "slantwise")
    return Motion(f"slides {way} by {shift:g} L", m.slide(direction, shift), world="ground")


def _hop(speed: float) -> Motion:
    rise = m.find_rise(speed)
    claim = Reach(UP, 0.8 * rise - 0.05, 1.2 * rise + 0.05)
    words = f"is thrown up by {rise:.2g} L and falls back"
    return Motion(words, (*m.blow(UP, speed), claim), world="ground")


def _fall(height: float) -> Motion:
    claim = Reach(DOWN, height - 0.03, height + 0.25)  # what is soft goes on as it is squashed
    return Motion(f"falls from {height:g} L", (claim,), world="ground", lifted=height)


def _fault(kind: Wrong, motion: Motion, name: str = "") -> Fault:
    return (kind, name or kind.replace(" ", "-")), motion


# --- what free objects are told -----------------------------------------------------------------------------


def _push(thing: str) -> Iterator[Clip]:
    away = _glide(LEFT, 0.7)
    yield from _clips(
        thing,
        "push-left",
        f"push the {thing} to the left",
        {
            "plain": away,
            "short": _glide(LEFT, 0.45),
            "keeps-going": Motion("is driven left by 1 L", m.drive(LEFT, 1.0)),
        },
        [
            _fault("still", STILL),
            _fault("mirrored", _glide(RIGHT, 0.7)),
            _fault("turned by 60", _glide(m.turned(LEFT, 60), 0.7)),
            _fault("turned by 90", _glide(UP, 0.7)),
            _fault("too weak", _glide(LEFT, 0.05)),
            _fault("out of the picture", Motion("is gone at once", (*m.drive(LEFT, 6.0), Gone()), near=True)),
            _fault("kind", _turn(UP, 120), "turns"),
            _fault("collateral", away.plus("turning over by 170 degrees", *m.turn(AWAY, 170)), "turns-too"),
            _fault("broken up", away.plus("flying to pieces", *m.explode(0.6))),
        ],
    )
    yield from _clips(
        thing,
        "move-right",
        f"move the {thing} to the right",
        {"plain": _glide(RIGHT, 0.7)},
        [
            _fault("mirrored", away),
            _fault("turned by 90", _glide(UP, 0.7)),
            _fault("kind", _turn(DOWN, 120), "turns"),
        ],
    )


def _lift(thing: str) -> Iterator[Clip]:
    yield from _clips(
        thing,
        "lift",
        f"lift the {thing} straight up",
        {"plain": _glide(UP, 0.7)},
        [
            _fault("still", STILL),
            _fault("mirrored", _glide(DOWN, 0.7)),
            _fault("turned by 90", _glide(LEFT, 0.7)),
            _fault("kind", _turn(UP, 120), "turns"),
            _fault("turned by 60", _glide(m.turned(UP, 60), 0.7)),
        ],
    )


def _pull(thing: str) -> Iterator[Clip]:
    yield from _clips(
        thing,
        "pull-toward",
        f"pull the {thing} towards the camera",
        {"plain": _glide(TOWARD, 0.7)},
        [
            _fault("mirrored", _glide(AWAY, 0.7)),
            _fault("turned by 90", _glide(LEFT, 0.7)),
            _fault("still", STILL),
        ],
    )


def _spin(thing: str) -> Iterator[Clip]:
    plain = _turn(DOWN, 120)
    tilted = _turn(m.turned(DOWN, 60), 120, "about a tilted axis")
    yield from _clips(
        thing,
        "spin-clockwise",
        f"spin the {thing} clockwise about the vertical axis",
        {"plain": plain, "fast": _turn(DOWN, 220)},
        [
            _fault("still", STILL),
            _fault("mirrored", _turn(UP, 120)),
            _fault("turned by 60", tilted),
            _fault("turned by 90", _turn(AWAY, 120)),
            _fault("too weak", _turn(DOWN, 8)),
            _fault("kind", _glide(LEFT, 0.7), "moves"),
            _fault("collateral", plain.plus("rising by 0.8 L", *m.glide(UP, 0.8)), "rises-too"),
        ],
    )


def _strength(thing: str) -> Iterator[Clip]:
    gentle, violent = _glide(RIGHT, 0.22), Motion("is driven right by 1.5 L", m.drive(RIGHT, 1.5))
    yield from _clips(
        thing,
        "push-gently",
        f"push the {thing} gently to the right",
        {"plain": gentle, "less": _glide(RIGHT, 0.15)},
        [
            _fault("too strong", violent),
            _fault("mirrored", _glide(LEFT, 0.22)),
            _fault("still", STILL),
        ],
    )
    yield from _clips(
        thing,
        "push-violently",
        f"push the {thing} violently to the right",
        {"plain": violent},
        [
            _fault("too weak", gentle),
            _fault("mirrored", Motion("is driven left by 1.5 L", m.drive(LEFT, 1.5))),
            _fault("still", STILL),
        ],
    )


def _amounts(thing: str) -> Iterator[Clip]:
    half, quarter = Shift(LEFT, 0.425, 0.575), Turn(UP, 76.5, 103.5)  # within the 15 % that are right
    yield from _clips(
        thing,
        "half-length",
        f"move the {thing} to the left by half its length",
        {"plain": _glide(LEFT, 0.5).held_to(half), "nearly": _glide(LEFT, 0.46).held_to(half)},
        [
            _fault("too weak", _glide(LEFT, 0.22)),
            _fault("too strong", _glide(LEFT, 1.0)),
            _fault("mirrored", _glide(RIGHT, 0.5)),
        ],
    )
    yield from _clips(
        thing,
        "quarter-turn",
        f"rotate the {thing} by 90 degrees counterclockwise about the vertical axis",
        {"plain": _turn(UP, 90).held_to(quarter), "nearly": _turn(UP, 97).held_to(quarter)},
        [
            _fault("too weak", _turn(UP, 42)),
            _fault("too strong", _turn(UP, 180)),
            _fault("mirrored", _turn(DOWN, 90)),
        ],
    )


def _sequence(thing: str) -> Iterator[Clip]:
    def two(words: str, *parts: m.Cause | m.Claim) -> Motion:
        return Motion(words, parts, seconds=3.0)

    def left(start: float, length: float = 1.5) -> m.Parts:
        return m.glide(LEFT, 0.6, start, length)

    def up(start: float, length: float = 1.5) -> m.Parts:
        return m.glide(UP, 0.6, start, length)

    def right(start: float) -> m.Parts:
        return m.glide(RIGHT, 0.6, start, 1.5)

    def spin(axis: m.Direction, start: float) -> m.Parts:
        return m.turn(axis, 110, start, 1.5)

    both = tuple(part for part in (*left(0, 3.0), *up(0, 3.0)) if isinstance(part, m.Push))
    slantwise = (*both, m.claim_shift((-(0.5**0.5), 0.5**0.5, 0.0), 0.6 * 2**0.5))
    yield from _clips(
        thing,
        "left-then-up",
        f"push the {thing} to the left, then lift it up",
        {
            "plain": two("moves left, then up", *left(0), *up(1.5)),
            "earlier": two("moves left, then soon up", *left(0, 1.2), *up(1.3, 1.4)),
        },
        [
            _fault("order", two("moves up, then left", *up(0), *left(1.5)), "swapped"),
            _fault("order", two("moves left and up at once", *slantwise), "at-once"),
            _fault("order", two("moves left only", *left(0)), "first-only"),
            _fault("mirrored", two("moves right, then up", *right(0), *up(1.5))),
        ],
    )
    yield from _clips(
        thing,
        "right-then-spin",
        f"push the {thing} to the right, then spin it clockwise about the vertical axis",
        {"plain": two("moves right, then turns clockwise", *right(0), *spin(DOWN, 1.5))},
        [
            _fault("order", two("turns clockwise, then moves right", *spin(DOWN, 0), *right(1.5)), "swapped"),
            _fault("mirrored", two("moves right, then turns the other way", *right(0), *spin(UP, 1.5))),
            _fault("order", two("moves right only", *right(0)), "first-only"),
        ],
    )
    yield from _clips(
        thing,
        "left-then-back",
        f"push the {thing} to the left, then push it to the right",
        {"plain": two("moves left, then right", *left(0), *right(1.5))},
        [
            _fault("order", two("moves right, then left", *right(0), *left(1.5)), "swapped"),
            _fault("order", two("moves left only", *left(0)), "first-only"),
        ],
    )
    late = f"after one second, push the {thing} to the left"
    yield from _clips(
        thing,
        "late",
        late,
        {"plain": two("waits a second, then moves left", *m.glide(LEFT, 0.6, 1.0, 2.0))},
        [
            _fault("window", two("moves left at once, then rests", *m.glide(LEFT, 0.6, 0.0, 1.0))),
            _fault("mirrored", two("waits a second, then moves right", *m.glide(RIGHT, 0.6, 1.0, 2.0))),
        ],
    )


# --- what changes shape -------------------------------------------------------------------------------------


def _stretch(thing: str) -> Iterator[Clip]:
    plain = _resize(UP, 0.3)
    yield from _clips(
        thing,
        "stretch",
        f"stretch the {thing} vertically",
        {"plain": plain, "more": _resize(UP, 0.45)},
        [
            _fault("still", STILL),
            _fault("mirrored", _resize(UP, -0.3), "squeezed"),
            _fault("turned by 90", _resize(RIGHT, 0.3)),
            _fault("too weak", _resize(UP, 0.02)),
            _fault("kind", _glide(UP, 0.7), "rises"),
            _fault("broken up", BROKEN),
        ],
    )


def _squeeze(thing: str) -> Iterator[Clip]:
    yield from _clips(
        thing,
        "squeeze",
        f"squeeze the {thing} from the left and the right",
        {"plain": _resize(RIGHT, -0.3), "less": _resize(RIGHT, -0.22)},
        [
            _fault("still", STILL),
            _fault("mirrored", _resize(RIGHT, 0.3), "stretched"),
            _fault("turned by 90", _resize(UP, -0.3)),
            _fault("kind", _glide(LEFT, 0.7), "moves"),
        ],
    )
    yield from _clips(
        thing,
        "half-height",
        f"squash the {thing} to half its height",
        {"plain": _resize(UP, -0.5)},
        [_fault("too weak", _resize(UP, -0.2)), _fault("mirrored", _resize(UP, 0.4))],
    )


def _twist(thing: str) -> Iterator[Clip]:
    yield from _clips(
        thing,
        "twist",
        f"twist the {thing}",
        {"plain": Motion("top and bottom turn against each other", m.twist(UP, 70))},
        [
            _fault("still", STILL),
            _fault("kind", _turn(UP, 120), "turns-whole"),
            _fault("kind", _glide(LEFT, 0.7), "moves"),
        ],
    )


# --- what stands on the ground --------------------------------------------------------------------------------


def _shove(thing: str) -> Iterator[Clip]:
    plain = _slide(LEFT, 0.7)
    gone = _slide(LEFT, 3.0).plus("is soon gone", Gone())
    yield from _clips(
        thing,
        "shove-left",
        f"push the {thing} to the left",
        {"plain": plain, "short": _slide(LEFT, 0.45)},
        [
            _fault("still", RESTS),
            _fault("mirrored", _slide(RIGHT, 0.7)),
            _fault("turned by 60", _slide(m.turned(LEFT, 60, UP), 0.7)),
            _fault("turned by 90", _slide(AWAY, 0.7)),
            _fault("too weak", _slide(LEFT, 0.05)),
            _fault("kind", _hop(3.0), "hops"),
            _fault("collateral", plain.plus("turning by 170 degrees", *m.turn_towed(UP, 170)), "turns-too"),
            _fault("out of the picture", dataclasses.replace(gone, near=True)),
        ],
    )


def _drop(thing: str) -> Iterator[Clip]:
    yield from _clips(
        thing,
        "drop",
        f"drop the {thing}",
        {
            "half": _fall(0.5),
            "high": _fall(0.9),
        },
        [
            _fault("still", RESTS),
            _fault("mirrored", _glide(UP, 0.7), "rises"),
            _fault("turned by 90", _slide(LEFT, 0.7), "slides"),
        ],
    )


def _throw(thing: str) -> Iterator[Clip]:
    yield from _clips(
        thing,
        "throw-up",
        f"throw the {thing} up into the air",
        {"plain": _hop(3.0), "higher": _hop(3.8)},
        [
            _fault("still", RESTS),
            _fault("turned by 90", _slide(LEFT, 0.7), "slides"),
            _fault("too weak", _hop(0.6)),
        ],
    )


def _kick(thing: str) -> Iterator[Clip]:
    def kicked(direction: m.Direction, speed: float) -> Motion:
        way = _WORDS[direction]
        claim = Shift(direction, 0.3, 1.25)
        return Motion(f"is hit {way} with {speed:g} L/s", (*m.blow(direction, speed), claim), world="ground")

    yield from _clips(
        thing,
        "kick",
        f"kick the {thing} to the right",
        {"plain": kicked(RIGHT, 1.8), "harder": kicked(RIGHT, 2.1)},
        [
            _fault("still", RESTS),
            _fault("mirrored", kicked(LEFT, 1.8)),
            _fault("turned by 90", kicked(AWAY, 1.8)),
            _fault("kind", _hop(3.0), "hops"),
        ],
    )


def _rest(thing: str) -> Iterator[Clip]:
    yield from _clips(
        thing,
        "rest",
        f"the {thing} stays still",
        {"plain": RESTS},
        [
            _fault("kind", _slide(LEFT, 0.45), "slides"),
            _fault("kind", _hop(3.0), "hops"),
        ],
    )


# --- what is held at its foot -----------------------------------------------------------------------------------


_FIRM = {"board": 4.0, "bottle": 3.5}  # times the force that bends a plant, so that a viewer sees them bend


def _held(thing: str) -> Iterator[Clip]:
    firm = _FIRM.get(thing, 1.0)

    def held(words: str, *parts: m.Cause | m.Claim, seconds: float = 3.0, drag: float = 1.5) -> Motion:
        return Motion(words, parts, held=True, seconds=seconds, drag=drag)

    def bend(direction: m.Direction, end: float = 1.4, strength: float = 5.0) -> m.Push:
        return m.Push(direction, firm * strength, 0.0, end)

    def back(direction: m.Direction, end: float = 1.4) -> m.Parts:
        return bend(direction, end), Reach(direction, 0.1, part="top", end=end, back=0.5)

    def stay(direction: m.Direction, end: float) -> m.Parts:
        return bend(direction, end), Shift(
            direction, 0.1, 1.0, part="top", aside=0.6
        )  # a top sinks as it leans

    def swing(direction: m.Direction) -> m.Parts:
        return m.sway(direction, firm * 4.0, 2.5, 0.9)

    still = held("nothing moves", Still())
    hair = (bend(LEFT, 1.4, 0.15), Reach(LEFT, 0.0, 0.03, part="top"))
    left, right = (
        held("bends left and comes back", *back(LEFT)),
        held("bends right and comes back", *back(RIGHT)),
    )
    away = held("bends away and comes back", *back(AWAY))
    yield from _clips(
        thing,
        "wind",
        f"a strong wind bends the {thing} to the left, then lets go",
        {"plain": left, "longer": held("bends left and comes back late", *back(LEFT, 1.8))},
        [
            _fault("still", still),
            _fault("mirrored", right),
            _fault("turned by 90", away),
            _fault("too weak", held("bends left by a hair", *hair)),
            _fault("ending", held("bends left and stays bent", *stay(LEFT, 3.0))),
            _fault("kind", dataclasses.replace(_turn(UP, 120), seconds=3.0), "turns"),
        ],
    )
    yield from _clips(
        thing,
        "bend-right",
        f"bend the {thing} to the right",
        {"plain": held("bends right and stays bent", *stay(RIGHT, 2.0), seconds=2.0)},
        [
            _fault("mirrored", held("bends left and stays bent", *stay(LEFT, 2.0), seconds=2.0)),
            _fault("still", dataclasses.replace(still, seconds=2.0)),
            _fault("turned by 90", held("bends away and stays bent", *stay(AWAY, 2.0), seconds=2.0)),
        ],
    )
    yield from _clips(
        thing,
        "sway",
        f"the {thing} sways left and right",
        {
            "twice": held("sways left and right", *swing(RIGHT)),
            "mirror": held("sways", *swing(LEFT)),
        },
        [
            _fault("still", still),
            _fault("turned by 90", held("sways away and toward", *swing(AWAY))),
            _fault("kind", held("bends left and stays bent", *stay(LEFT, 3.0)), "bends-once"),
        ],
    )

    def hit(direction: m.Direction) -> Motion:
        blow = m.blow(direction, 3.5 * firm**0.5, 0.2, "top")
        claim = Reach(direction, 0.08, part="top", end=1.0)
        return held(f"the top is knocked {_WORDS[direction]}", *blow, claim, drag=3.0, seconds=2.0)

    yield from _clips(
        thing,
        "hit-top",
        f"hit the top of the {thing} from the right",
        {"plain": hit(LEFT)},
        [
            _fault("mirrored", hit(RIGHT)),
            _fault("turned by 90", hit(AWAY)),
            _fault("still", dataclasses.replace(still, seconds=2.0)),
        ],
    )


def _part(thing: str) -> Iterator[Clip]:
    def end(part: m.Part, direction: m.Direction) -> Motion:
        way = _WORDS[direction]
        push = m.Push(direction, 1.8, 0.0, 1.0, part)
        other: m.Part = "bottom" if part == "top" else "top"
        over = AWAY if (direction == RIGHT) == (part == "top") else TOWARD
        claims = (
            Shift(direction, 0.1, 1.5, end=0.8, part=part, against=other, aside=0.6),
            Turn(over, 40.0, 250.0),
        )
        return Motion(f"the {part} is pushed {way}, the object tips", (push, *claims))

    yield from _clips(
        thing,
        "push-top",
        f"push the top of the {thing} to the left",
        {"plain": end("top", LEFT)},
        [
            _fault("part", end("bottom", LEFT), "bottom"),
            _fault("mirrored", end("top", RIGHT)),
            _fault("still", STILL),
        ],
    )


# --- who is told what -------------------------------------------------------------------------------------------

_FREE = (_push, _lift, _pull, _spin, _strength, _amounts, _sequence)
_SHAPE = (_stretch, _squeeze, _twist)
_GROUND = (_shove, _drop, _throw, _kick, _rest)
_TOLD: dict[str, tuple[Callable[[str], Iterator[Clip]], ...]] = {
    "robot": _FREE,
    "plant": (_held,),
    "loaf": (_push, _spin, _amounts, _stretch, _squeeze, _shove, _drop, _kick),
    "jelly": (_pull, _strength, *_SHAPE, _shove, _drop, _throw, _rest),
    "crate": (_lift, _spin, _amounts, _stretch, _twist, *_GROUND, _sequence),
    "ball": (_push, _pull, _stretch, _drop, _throw, _rest),
    "board": (_spin, _lift, _part, _held, _stretch, _twist, _strength),
    "bottle": (_push, _part, _held, _squeeze, _drop, _shove),
    "guitar": (_push, _spin, _amounts, _sequence),
    "cow": (_push, _pull, _spin, _shove, _drop, _throw, _kick),
    "bunny": (_strength, _stretch, _squeeze, _shove, _drop, _rest),
}
_QUICK = 64


def list_clips(data: Path | None, quick: bool = False) -> list[Clip]:
    """All clips that can be had with this folder of data, in an order in which any beginning is a fair sample."""
    clips = [clip for thing in list_things(data) for told in _TOLD[thing] for clip in told(thing)]
    clips = sorted(clips, key=lambda clip: clip.turn)
    return clips[:_QUICK] if quick else clips


def _clips(thing: str, tag: str, sentence: str, right: Right, wrong: list[Fault]) -> Iterator[Clip]:
    """A sentence with its motions; where the object is told to be is where the right ones are."""
    told = next(iter(right.values()))
    for variant, motion in right.items():
        yield Clip(thing, sentence, motion, tag, variant, None, told.world, told.held)
    for (kind, variant), motion in wrong:
        yield Clip(thing, sentence, motion, tag, variant, kind, told.world, told.held)
