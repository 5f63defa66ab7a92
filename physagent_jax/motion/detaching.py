"""The detachment of a part: it leaves the rest, clear of it, and falls to the ground.

Matter on one grid moves together within the reach of the grid's kernels, so that a part of which only the hold was
taken away would cling to the rest. It is led away from it for a moment instead, and then flies on by itself with that
speed: of the ways that it may go, the one on which it meets least of the rest. A wheel is drawn off, and rolls.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import GAIN_MIN, GRAVITY, MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import ConstraintType, VelocityConstraint
from physagent_jax.motion.hinges import find_box
from physagent_jax.motion.parts import join_rest
from physagent_jax.motion.schema import ExpectedMotion, SceneBrief
from physagent_jax.motion.vectors import (
    add,
    clamp,
    cosine,
    cross,
    dot,
    norm,
    normalise,
    rotate,
    scale,
    subtract,
)

_APART = (
    0.16,
    0.22,
    0.3,
    0.4,
)  # [body lengths] by which it is led away, four cells or more: out of its socket
_NEAR = 0.14  # [body lengths] within which two places cling
_ASIDE = (0.4, 0.7, 1.0)  # [body lengths] that it lands beside where it was
_RISES = (0.0, 0.06, 0.15)  # [body lengths] that it rises first
_POPS = (0.35, 0.5)  # the same of what goes up
_TURNS = (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)  # [degrees] about the upright from its own way
_LEVEL = 0.5  # length of the level part of its arm, from which on that tells a way
_UP = 0.7  # cosine to the upright
_STEPS = 8  # of its flight that are looked at
_MOVED, _REST = 16, 128  # places of it and of the rest that are looked at
_LEAST = 0.2  # [s] that it takes at least
_LOW = 0.1  # of the object's height, up to which a part bears it
_SETTLES = 0.4  # [s] after it has come down
_DELAY = 0.2  # [s] before it leaves
_DRAWN, _DRAWING = 0.22, 0.35  # [body lengths] that a wheel is drawn off its axle, and [s] in which it is
_ROLLED, _ROLLING = 1.2, 1.0  # [body lengths] that it then rolls, and [s] in which, if nothing brakes it
_STARTS = 55.0  # [degrees] of that on which it is led
_LEVELLED = 0.3  # vertical component of its axle up to which it can roll


def detach(
    part: Part, brief: SceneBrief, frame_count: int, motion: ExpectedMotion, held: bool = True
) -> tuple[list[VelocityConstraint], ExpectedMotion]:
    """The constraints by which a part comes off, and the motion as it is then expected.

    Args:
        part: The part.
        brief: The scene.
        frame_count: Length of the clip [frames].
        motion: The motion; its direction tells a way that is not down.
        held: Whether the rest is held.
    """
    up, box = brief.directions.up, find_box(brief)
    first = min(motion.window[0] + brief.count_frames(_DELAY), max(motion.window[1] - 2.0, motion.window[0]))
    # What is beside the joint goes with the nearer of the two: it would tie them together.
    whole = part.moved.model_copy(update=dict(outside=part.rest.inside, rigid=True))
    driver = PartDriver(part.model_copy(update=dict(moved=whole)), brief.frame_dt, frame_count, held)
    if brief.world == "ground" and part.axle is not None and abs(dot(part.axle, up)) < _LEVELLED:
        radius = part.joint[2] * box[2]
        low = min(place[2] for place in part.moved.inside) * box[2]
        if low < 0.5 * radius:
            return _roll_off(driver, brief, motion, first)
    moved = _spread(part.moved.inside, box, _MOVED)
    rest = _spread(part.moved.outside, box, _REST)
    height, gravity = min(dot(each, up) for each in moved), GRAVITY / brief.size
    if brief.world != "ground":  # nothing makes it fall: it goes straight on
        height = _ASIDE[-1]
    rises = _POPS if _goes_up(motion, up) else _RISES
    flight = _choose(
        _Flight(moved, rest, level, reach, rise, height, gravity, up)
        for level, rise, reach in itertools.product(_list_ways(part, brief, motion), rises, _ASIDE)
    )
    speed = norm(flight.velocity)
    led = clamp(brief.count_frames(flight.apart / speed), 1.0, max(motion.window[1] - first, 1.0))
    along = [dot(each, flight.way) for each in (*moved, *rest)]
    length = speed * led * brief.frame_dt / max(max(along) - min(along), 0.1)  # of its width
    made = driver.shift(flight.way, length, (first, first + led), None)
    grounded = brief.world == "ground"
    travel = add([scale(flight.level, flight.reach), scale(up, -height)]) if grounded else flight.way
    ends = first + led + brief.count_frames(flight.seconds + _SETTLES)
    if grounded and rises is _POPS:  # that it goes up is asked, and not that it comes down
        rising = dot(flight.velocity, up) / gravity
        travel = add([scale(flight.way, flight.apart), scale(flight.velocity, 0.5 * rising)])
        ends = first + led + brief.count_frames(rising)
    return [made], _expect(motion, travel, min(ends, frame_count - 1.0))


def unsettles(parts: Sequence[Part], brief: SceneBrief) -> bool:
    """Return whether several pieces of their own are such that the object stands on: without them it falls.

    What is one skin with the rest tears off slowly, and is costly to simulate where nothing holds the rest.
    """
    feet = [each for each in parts if min(place[2] for place in each.moved.inside) < _LOW]
    return brief.world == "ground" and len(feet) > 1 and all(each.moved.rigid for each in feet)


def hold_rest(
    parts: Sequence[Part], leads: Sequence[VelocityConstraint], brief: SceneBrief
) -> VelocityConstraint:
    """The hold of all the rest until its parts have come off: falling meanwhile, it would drag them along.

    Args:
        parts: The parts that come off.
        leads: The constraints by which they do.
        brief: The scene.
    """
    ends = [each.active_time[1] for each in leads if each.active_time is not None]
    return VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_TRANSLATION,
        vector=brief.directions.up,
        magnitude=MAGNITUDE_MIN,
        gain=GAIN_MIN,
        active_time=(0.0, 1.0),
        held_until=max([2.0, *ends]),
        region=join_rest(parts).model_copy(update=dict(label="all that stays")),
    )


def _expect(motion: ExpectedMotion, travel: Vector, end: float) -> ExpectedMotion:
    """The motion of a part that goes along ``travel`` until a frame."""
    told = dict(
        direction=normalise(travel), strength=MAGNITUDE_MAX, window=(motion.window[0], end), sudden=False
    )
    return motion.model_copy(update=told)


def _roll_off(
    driver: PartDriver, brief: SceneBrief, motion: ExpectedMotion, first: float
) -> tuple[list[VelocityConstraint], ExpectedMotion]:
    """As `detach`, of a wheel that stands on the ground: it is drawn off its axle, started, and rolls on by itself."""
    part, up, box = driver.part, brief.directions.up, find_box(brief)
    axle = part.axle or brief.directions.right
    out = scale(axle, 1.0 if dot(part.side, axle) > 0 else -1.0)
    ahead = normalise(cross(out, up)) or brief.directions.right
    told = motion.direction or part.side
    leads = told if abs(dot(told, ahead)) > _LEVEL else part.side  # else to the nearer end
    ahead = ahead if dot(leads, ahead) > 0 else scale(ahead, -1.0)
    drawn, width = first + brief.count_frames(_DRAWING), sum(abs(x) * side for x, side in zip(out, box))
    radius = part.joint[2] * box[2]
    started = math.radians(_STARTS) * radius / (_ROLLED / _ROLLING)  # [s]
    # It turns about the place on which it stands halfway there, and so neither sinks nor rises in the end.
    shift = add((scale(out, _DRAWN), scale(ahead, radius * math.tan(math.radians(0.5 * _STARTS)))))
    pivot = tuple(place + off / side for place, off, side in zip((*part.joint[:2], 0.0), shift, box))
    rolling = dataclasses.replace(driver, part=part.model_copy(update=dict(joint=pivot)))
    window = (drawn, drawn + max(brief.count_frames(started), 1.0))
    made = [
        driver.shift(out, _DRAWN / width, (first, drawn), None),
        rolling.turn(cross(up, ahead), _STARTS, window, None),
    ]
    end = min(window[1] + brief.count_frames(_ROLLING), driver.frame_count - 1.0)
    return made, _expect(motion, add((scale(out, _DRAWN), scale(ahead, 0.7 * _ROLLED))), end)


class _Flight:
    """A flight of a part, which lands ``reach`` aside along ``level`` after it has risen by ``rise`` [body lengths]."""

    def __init__(
        self,
        moved: Sequence[Vector],
        rest: Sequence[Vector],
        level: Vector,
        reach: float,
        rise: float,
        height: float,
        gravity: float,
        up: Vector,
    ):
        speed = math.sqrt(2.0 * gravity * rise)
        self._moved, self._rest, self._down = moved, rest, scale(up, -gravity)
        self.level, self.reach = level, reach
        # What stands on the ground already would be shot along it.
        self.seconds = max((speed + math.sqrt(2.0 * gravity * (rise + height))) / gravity, _LEAST)
        self.velocity: Vector = add([scale(level, reach / self.seconds), scale(up, speed)])
        self.way = normalise(self.velocity) or level
        self.apart = min(_APART, key=lambda each: self._count_near(scale(self.way, each)))

    def count_meetings(self) -> int:
        """The number of places of the part that come near the rest on the way."""
        meetings, led = 0, scale(self.way, self.apart)
        for step in range(_STEPS + 1):
            t = self.seconds * step / _STEPS
            meetings += self._count_near(add([led, scale(self.velocity, t), scale(self._down, 0.5 * t * t)]))
        return meetings

    def _count_near(self, shift: Vector) -> int:
        """The number of places of the part that are near the rest where it is shifted."""
        there = [add([place, shift]) for place in self._moved]
        return sum(any(math.dist(each, other) < _NEAR for other in self._rest) for each in there)


def _choose(flights: Iterable[_Flight]) -> _Flight:
    """The first that meets nothing, or the one that meets least."""
    fewest, best = math.inf, None
    for each in flights:
        meetings = each.count_meetings()
        if meetings < fewest:
            fewest, best = meetings, each
        if not meetings:
            break
    assert best is not None
    return best


def _list_ways(part: Part, brief: SceneBrief, motion: ExpectedMotion) -> list[Vector]:
    """The level ways that it may go, likeliest first: as told, as it points, else where that is seen."""
    up = brief.directions.up

    def flatten(way: Vector) -> Vector:
        return subtract(way, scale(up, dot(way, up)))

    told, arm = flatten(motion.direction or up), flatten(normalise(part.arm) or up)
    if norm(told) > _LEVEL:
        return [normalise(told) or brief.directions.right]
    own = normalise(arm) if norm(arm) > _LEVEL else brief.directions.right
    return [rotate(own or brief.directions.right, scale(up, degrees)) for degrees in _TURNS]


def _goes_up(motion: ExpectedMotion, up: Vector) -> bool:
    return motion.direction is not None and cosine(motion.direction, up) > _UP


def _spread(places: Sequence[Vector], box: Vector, most: int) -> list[Vector]:
    """So many of the places at most [body lengths]."""
    chosen = places[:: -(-len(places) // most)]
    return [(x * box[0], y * box[1], z * box[2]) for x, y, z in chosen]
