"""Motions as scene data: what acts on an object, in body lengths (1 m here) and seconds. Nothing here reads sentences.

A `Motion` is a list of causes; the functions at the end put together common ones. Directions are the viewer's: right,
up and away are the first, second and third coordinate, so that one motion serves every camera.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

import numpy as np

GRAVITY = 9.8  # [m/s^2]
FRICTION = 0.2  # of the ground: things that are pushed there slide and do not tip over

Direction = tuple[float, float, float]
RIGHT, LEFT = (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)
UP, DOWN = (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)
AWAY, TOWARD = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
_SLABS = ((0.0, 0.1), (0.28, 0.36))
Part = Literal["all", "top", "bottom", "left", "right"]


@dataclasses.dataclass(frozen=True)
class Push:
    """The same acceleration for all of a part.

    Attributes:
        direction: Of the acceleration.
        strength: [L/s^2].
        start, end: [s].
        part: What it acts on: "all" or a third of the object.
        frequency: Of a sine that multiplies it [Hz]; 0 = none.
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
class Burst:
    """All matter is driven out from the object's middle [L/s^2]."""

    strength: float
    start: float
    end: float


Cause = Push | Spin | Grip | Burst


@dataclasses.dataclass(frozen=True)
class Motion:
    """What happens in a clip.

    Attributes:
        words: What a viewer sees, for people who check labels.
        causes: What acts.
        world: "free": floating at rest; "ground": under gravity, on a plane.
        lifted: Clear height above the ground at the start [L].
        held: Whether the object's foot is held.
        seconds: Length of the clip.
        drag: Of the air [1/s].
        near: Whether the camera shows the object's surroundings only, so that what goes far leaves the picture.
    """

    words: str
    causes: tuple[Cause, ...] = ()
    world: Literal["free", "ground"] = "free"
    lifted: float = 0.0
    held: bool = False
    seconds: float = 2.0
    drag: float = 0.0
    near: bool = False

    def plus(self, words: str, *causes: Cause) -> Motion:
        """The same motion, and something more."""
        return dataclasses.replace(
            self, words=f"{self.words}, {words}" if self.words else words, causes=self.causes + causes
        )


def turned(direction: Direction, degrees: float, axis: Direction = AWAY) -> Direction:
    """``direction`` turned about ``axis``; about the line of sight it stays in the picture."""
    v, k, angle = np.asarray(direction), np.asarray(axis), math.radians(degrees)
    out = v * math.cos(angle) + np.cross(k, v) * math.sin(angle) + k * (k @ v) * (1 - math.cos(angle))
    return tuple(float(c) for c in np.round(out, 9) + 0.0)  # type: ignore[return-value]


def opposite(direction: Direction) -> Direction:
    """The other way."""
    x, y, z = direction
    return (0.0 - x, 0.0 - y, 0.0 - z)


def glide(direction: Direction, shift: float, start: float = 0.0, duration: float = 2.0) -> tuple[Cause, ...]:
    """Free: speeds up for half of the time, slows down for the other half, has moved by ``shift`` [L], and rests."""
    strength, middle = 4 * shift / duration**2, start + duration / 2
    return (
        Push(direction, strength, start, middle),
        Push(opposite(direction), strength, middle, start + duration),
    )


def slide(direction: Direction, shift: float, start: float = 0.0, pushed: float = 0.7) -> tuple[Cause, ...]:
    """On the ground: pushed for ``pushed`` seconds against friction, which then stops it after ``shift`` [L] in all."""
    brake = FRICTION * GRAVITY  # a t^2 / 2 + (a t)^2 / (2 brake) = shift
    strength = brake * (math.sqrt(0.25 + 2 * shift / (brake * pushed**2)) - 0.5)
    return (Push(direction, brake + strength, start, start + pushed),)


def drive(direction: Direction, shift: float, start: float = 0.0, duration: float = 2.0) -> tuple[Cause, ...]:
    """Free: speeds up all the time and has moved by ``shift`` [L] after ``duration``."""
    return (Push(direction, 2 * shift / duration**2, start, start + duration),)


def blow(direction: Direction, speed: float, at: float = 0.0, part: Part = "all") -> tuple[Cause, ...]:
    """A blow that leaves ``speed`` [L/s]."""
    return (Push(direction, speed / 0.08, at, at + 0.08, part),)


def turn(
    axis: Direction, degrees: float, start: float = 0.0, duration: float = 2.0, part: Part = "all"
) -> tuple[Cause, ...]:
    """Turns by ``degrees`` about ``axis`` and comes to rest."""
    strength, middle = 4 * degrees / duration**2, start + duration / 2
    return (
        Spin(axis, strength, start, middle, part),
        Spin(axis, -strength, middle, start + duration, part),
    )


def resize(
    direction: Direction, change: float, duration: float = 1.0, hold: float = 2.0
) -> tuple[Cause, ...]:
    """Both ends are drawn apart (or together) until the extent along ``direction`` has changed by ``change`` of itself.

    Args:
        direction: Along an axis.
        change: 0.3 = by 30 % longer; negative = shorter.
        duration: How long that takes [s].
        hold: Until when the ends are then held [s].
    """
    causes = []
    for side in (direction, opposite(direction)):
        for low, high in _SLABS:  # more than the ends alone, so that all of the object takes part
            share = 0.5 - 0.5 * (low + high) if low else 0.5
            velocity = tuple(change * share / duration * c for c in side)
            causes.append(Grip(side, velocity, 0.0, duration, low, high))  # type: ignore[arg-type]
            causes.append(Grip(side, (0.0, 0.0, 0.0), duration, hold, low, high))
    return tuple(causes)


def twist(axis: Direction, degrees: float, duration: float = 2.0) -> tuple[Cause, ...]:
    """Top and bottom are turned against each other."""
    strength = 4 * degrees / duration**2
    return (
        Spin(axis, strength, 0.0, duration / 2, "top"),
        Spin(axis, -strength, 0.0, duration / 2, "bottom"),
    )


def sway(
    direction: Direction, strength: float, cycles: float, frequency: float, start: float = 0.0
) -> tuple[Cause, ...]:
    """A force to and fro, ``cycles`` times; it ends after whole cycles."""
    return (Push(direction, strength, start, start + cycles / frequency, frequency=frequency),)


def explode(start: float = 0.2, strength: float = 400.0) -> tuple[Cause, ...]:
    """Torn to pieces that fly apart."""
    return (Burst(strength, start, start + 0.15),)
