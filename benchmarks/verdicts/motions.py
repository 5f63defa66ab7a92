"""Motions as scene data: what acts on an object, in body lengths (1 m here) and seconds. Nothing here reads sentences.

A `Motion` is a list of causes, and of claims: what its words say, in numbers that the particles are held against.
The functions at the end put together common ones. Directions are the viewer's: right, up and away are the first, second
and third coordinate, so that one motion serves every camera.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

import numpy as np

from benchmarks.verdicts.claims import (
    Broken,
    Claim,
    Direction,
    Part,
    Reach,
    Resize,
    Shift,
    Turn,
)

GRAVITY = 9.8  # [m/s^2]
FRICTION = 0.2  # of the ground: things that are pushed there slide and do not tip over

RIGHT, LEFT = (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)
UP, DOWN = (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)
AWAY, TOWARD = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
_SLABS = ((0.0, 0.1), (0.28, 0.36))
_SEEN = 0.06  # [L] by which a top has to go for people to see it sway
BLOW = 0.08  # [s] that a blow lasts
TOWED = 30.0  # [1/s] at which a tow takes matter along: faster than friction, tipping or wobbling


@dataclasses.dataclass(frozen=True)
class Push:
    """The same acceleration for all of a part.

    Attributes:
        direction: Direction of the acceleration.
        strength: [L/s^2].
        start, end: [s].
        part: What it acts on: "all" or a third of the object.
        frequency: Frequency of a sine that multiplies it [Hz]; 0 = none.
    """

    direction: Direction
    strength: float
    start: float
    end: float
    part: Part = "all"
    frequency: float = 0.0


@dataclasses.dataclass(frozen=True)
class Spin:
    """An angular acceleration about the part's mass centre.

    Attributes:
        axis: Right-hand rule.
        strength: [degrees/s^2].
        start, end: [s].
        part: As in `Push`.
    """

    axis: Direction
    strength: float
    start: float
    end: float
    part: Part = "all"


@dataclasses.dataclass(frozen=True)
class Grip:
    """A slab at one end of the object that moves with a velocity, whatever the rest does.

    Attributes:
        side: The end, as a direction along one axis.
        velocity: [the object's extent along ``side`` per second].
        start, end: [s].
        low, high: Where the slab begins and ends, as shares of the extent from that end on.
    """

    side: Direction
    velocity: Direction
    start: float
    end: float
    low: float = 0.0
    high: float = 0.12


@dataclasses.dataclass(frozen=True)
class Wring:
    """A slab at one end of the object that turns about the object's axis, whatever the rest does.

    Attributes:
        side: The end, as a direction along one axis; the turn is about that axis too.
        velocity: Right-hand rule about ``side`` [degrees/s].
        start, end: [s].
        depth: Depth of the slab, as a share of the extent.
    """

    side: Direction
    velocity: float
    start: float
    end: float
    depth: float = 0.2


@dataclasses.dataclass(frozen=True)
class Press:
    """A plate at one end of the object that presses it towards its middle, and then stays.

    Attributes:
        side: The end, as a direction along one axis.
        way: Way of the plate, as a share of the extent.
        duration: How long it moves [s].
        hold: Until when it then stays [s].
    """

    side: Direction
    way: float
    duration: float
    hold: float


@dataclasses.dataclass(frozen=True)
class Tow:
    """All matter is drawn to one velocity, as by thick air that moves; friction and wobbling hardly matter.

    Attributes:
        direction: Unit vector.
        speed: [L/s].
        start, end: [s].
    """

    direction: Direction
    speed: float
    start: float
    end: float


@dataclasses.dataclass(frozen=True)
class Burst:
    """All matter is driven out from the object's middle [L/s^2]."""

    strength: float
    start: float
    end: float


Cause = Push | Spin | Grip | Press | Wring | Tow | Burst
Parts = tuple[Cause | Claim, ...]


@dataclasses.dataclass(frozen=True)
class Motion:
    """Motion of a clip.

    Attributes:
        words: What a viewer sees, for people who check labels.
        parts: What acts, and what is to come of it.
        world: "free": floating at rest; "ground": under gravity, on a plane.
        lifted: Clear height above the ground at the start [L].
        held: Whether the object's foot is held.
        seconds: Length of the clip.
        drag: Drag of the air [1/s].
        near: Whether the camera shows the object's surroundings only, so that what goes far leaves the picture.
    """

    words: str
    parts: Parts = ()
    world: Literal["free", "ground"] = "free"
    lifted: float = 0.0
    held: bool = False
    seconds: float = 2.0
    drag: float = 0.0
    near: bool = False

    @property
    def causes(self) -> tuple[Cause, ...]:
        """Forces and constraints that act."""
        return tuple(part for part in self.parts if isinstance(part, Cause))

    @property
    def claims(self) -> tuple[Claim, ...]:
        """Claim on the particles, if the motion is what its words say."""
        return tuple(part for part in self.parts if isinstance(part, Claim))

    def plus(self, words: str, *parts: Cause | Claim) -> Motion:
        """The same motion, and something more."""
        return dataclasses.replace(self, words=f"{self.words}, {words}", parts=self.parts + parts)

    def held_to(self, *claims: Claim) -> Motion:
        """The same motion, of which more is said."""
        return dataclasses.replace(self, parts=self.parts + claims)


def turned(direction: Direction, degrees: float, axis: Direction = AWAY) -> Direction:
    """``direction`` turned about ``axis``; about the line of sight it stays in the picture."""
    v, k, angle = np.asarray(direction), np.asarray(axis), math.radians(degrees)
    out = v * math.cos(angle) + np.cross(k, v) * math.sin(angle) + k * (k @ v) * (1 - math.cos(angle))
    return tuple(float(c) for c in np.round(out, 9) + 0.0)  # type: ignore[return-value]


def opposite(direction: Direction) -> Direction:
    """The other way."""
    x, y, z = direction
    return (0.0 - x, 0.0 - y, 0.0 - z)


def claim_shift(
    direction: Direction, shift: float, start: float = 0.0, end: float = math.inf, share: float = 0.15
) -> Shift:
    """It moves by ``shift`` [L], give or take ``share`` of it and what nobody sees."""
    slack = share * shift + 0.03
    return Shift(direction, shift - slack, shift + slack, start, end)


def glide(direction: Direction, shift: float, start: float = 0.0, duration: float = 2.0) -> Parts:
    """Free: speeds up for half of the time, slows down for the other half, has moved by ``shift`` [L], and rests."""
    strength, middle = 4 * shift / duration**2, start + duration / 2
    return (
        Push(direction, strength, start, middle),
        Push(opposite(direction), strength, middle, start + duration),
        claim_shift(direction, shift, start, start + duration),
    )


def slide(direction: Direction, shift: float, start: float = 0.0, towed: float = 1.2) -> Parts:
    """On the ground: taken along for ``towed`` seconds; friction then stops it after ``shift`` [L] in all.

    A push would have to be as strong as friction to a few per cent, and friction reaches the middle of what is soft
    only once a shear wave has come up from the ground: what is pushed for 0.7 L then goes up to 1.7 L.
    """
    brake, moving = FRICTION * GRAVITY, towed - 1 / TOWED  # v moving + v^2 / (2 brake) = shift
    speed = brake * (math.sqrt(moving**2 + 2 * shift / brake) - moving)
    return (
        Tow(direction, speed + brake / TOWED, start, start + towed),
        claim_shift(direction, shift, start),
    )


def drive(direction: Direction, shift: float, start: float = 0.0, duration: float = 2.0) -> Parts:
    """Free: speeds up all the time and has moved by ``shift`` [L] after ``duration``."""
    push = Push(direction, 2 * shift / duration**2, start, start + duration)
    return push, claim_shift(direction, shift, start, start + duration)


def blow(direction: Direction, speed: float, at: float = 0.0, part: Part = "all") -> Parts:
    """A blow that leaves ``speed`` [L/s], less what gravity or friction takes meanwhile."""
    return (Push(direction, speed / BLOW, at, at + BLOW, part),)


def find_rise(speed: float) -> float:
    """Height to which a blow upwards takes what lies on the ground [L]."""
    left = max(speed - BLOW * GRAVITY, 0.0)
    return 0.5 * left * BLOW + left**2 / (2 * GRAVITY)


def claim_turn(
    axis: Direction, degrees: float, start: float = 0.0, end: float = math.inf, share: float = 0.25
) -> Turn:
    """It turns by ``degrees``, give or take ``share`` of it and what nobody sees."""
    slack = share * degrees + 3
    return Turn(axis, degrees - slack, degrees + slack, start, end)


def turn(axis: Direction, degrees: float, start: float = 0.0, duration: float = 2.0) -> Parts:
    """Free: turns by ``degrees`` about ``axis`` and comes to rest."""
    strength, middle = 4 * degrees / duration**2, start + duration / 2
    return (
        Spin(axis, strength, start, middle),
        Spin(axis, -strength, middle, start + duration),
        claim_turn(axis, degrees, start, start + duration),
    )


def turn_towed(axis: Direction, degrees: float, start: float = 0.0, towed: float = 1.2) -> Parts:
    """Turns by ``degrees`` while it is towed, which brakes every turn at the rate `TOWED`."""
    rate = degrees / (towed - 1 / TOWED)
    return Spin(axis, rate * TOWED, start, start + towed), claim_turn(axis, degrees, start, share=0.35)


def resize(direction: Direction, change: float, duration: float = 1.0, hold: float = 2.0) -> Parts:
    """The extent along ``direction`` changes by ``change`` of itself: ends are gripped and drawn apart, or pressed.

    Args:
        direction: Along an axis.
        change: 0.3 = by 30 % longer; negative = shorter, between plates, as grips would let matter past them.
        duration: How long that takes [s].
        hold: Until when the ends are then held [s].
    """
    claim, sides = Resize(direction, change - 0.06, change + 0.06), (direction, opposite(direction))
    if change < 0:
        return *(Press(side, -0.5 * change, duration, hold) for side in sides), claim
    grips = []
    for side in sides:
        for low, high in _SLABS:  # more than the ends alone, so that all of the object takes part
            share = 0.5 - 0.5 * (low + high) if low else 0.5
            velocity = tuple(change * share / duration * c for c in side)
            grips.append(Grip(side, velocity, 0.0, duration, low, high))  # type: ignore[arg-type]
            grips.append(Grip(side, (0.0, 0.0, 0.0), duration, hold, low, high))
    return *grips, claim


def twist(axis: Direction, degrees: float, duration: float = 1.5) -> Parts:
    """The ends along ``axis`` are turned against each other by ``degrees`` in all, and then held."""
    rate = 0.5 * degrees / duration
    ends = [Wring(side, rate, 0.0, duration) for side in (axis, opposite(axis))]
    held = [dataclasses.replace(end, velocity=0.0, start=duration, end=math.inf) for end in ends]
    claim = Turn(axis, 0.7 * degrees, 1.3 * degrees, part="top", against="bottom")
    return *ends, *held, claim


def sway(direction: Direction, strength: float, cycles: float, frequency: float, start: float = 0.0) -> Parts:
    """A force to and fro, ``cycles`` times; the object's top is seen to go both ways."""
    both = (Reach(way, _SEEN, part="top") for way in (direction, opposite(direction)))
    return Push(direction, strength, start, start + cycles / frequency, frequency=frequency), *both


def explode(start: float = 0.2, strength: float = 400.0) -> Parts:
    """Torn to pieces that fly apart."""
    return Burst(strength, start, start + 0.15), Broken()
