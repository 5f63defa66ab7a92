"""The motion of a part that sticks out: which part is meant, and how it turns about its joint.

A limb is moved by what is prescribed: it turns about its joint so that its tip goes where it is to go, or moves along
itself where the way leads along it.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import VelocityConstraint
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import add, clamp, cosine, cross, dot, norm, normalise, scale, subtract

_PLAIN = 45.0  # [degrees] that a plain word turns a limb by
_LEAST, _MOST = 15.0, 80.0  # [degrees]
_ALONG = 0.85  # cosine to the limb from which on a way leads along it
_REACH = 0.3  # of its length, by which a plain word moves a limb along itself
_LIFTED = 1.0  # the same of a lid, which lies loose and comes off
_LEVEL = 0.5  # cosine to the vertical below which a line is level
_THERE = 0.2  # cosine to a side from which on a limb is on it
Window = tuple[float, float]
PLACES = ("top", "bottom", "side")
"""Roles that tell a part's place alone: a word for another part takes it where it is the only one there."""
LOOSE = frozenset((*PLACES, "lid", "knob"))
"""Roles of what may sit loose on the rest."""


def choose_parts(
    parts: Sequence[Part], roles: Sequence[str], side: Vector | None, plural: bool
) -> tuple[int, ...]:
    """Places of the parts that a word means.

    Args:
        parts: The object's parts.
        roles: Roles that the word may mean, likeliest first: the first that the object has is meant.
        side: Where the part is (world vector); None = not told. One part is chosen then.
        plural: Whether all of them are meant.

    Returns:
        Places in ``parts``, likeliest first; empty if there is none, or several of which only the place is known.
    """
    for role in roles:
        fitting = [index for index, each in enumerate(parts) if role in each.roles]
        fitting = [index for index in fitting if parts[index].name] or fitting  # what is named goes first
        nearness = {index: _find_nearness(parts[index], side) for index in fitting}
        fitting = [index for index in fitting if nearness[index] > _THERE]
        fitting.sort(key=lambda index: (-nearness[index], -parts[index].share))
        if role in PLACES and len(fitting) > 1 and not plural:
            continue
        if fitting:
            return tuple(fitting if plural else fitting[:1])
    return ()


def _find_nearness(part: Part, side: Vector | None) -> float:
    """Cosine between where a part is and a side, seen from above if that is level; 1 if no side is told."""
    if side is None or not norm(side):
        return 1.0
    level = abs(side[2]) < 1e-6 * norm(side)
    return cosine((part.side[0], part.side[1], 0.0 if level else part.side[2]), side)


def find_front(parts: Sequence[Part]) -> Vector | None:
    """The level way in which an animal looks: where its head is, seen from its middle; None if that is not known."""
    heads = [each for each in parts if "head" in each.roles[:1]]
    if len(heads) != 1 or sum("leg" in each.roles[:1] for each in parts) < 3:
        return None
    return normalise((heads[0].side[0], heads[0].side[1], 0.0))


def find_level_line(brief: SceneBrief) -> Vector:
    """The level line through something from end to end, about which it rolls over (unit vector).

    It is longest along it, or looks along it, or has two like parts on either side of it (wings); else it points at the
    viewer.
    """
    long = brief.long_axis
    if long is not None and abs(long[2]) < _LEVEL:
        return long
    pairs = [
        (math.dist(one.side, other.side), add([one.side, scale(other.side, -1.0)]))
        for one, other in itertools.combinations(brief.parts, 2)
        if one.roles[:1] == other.roles[:1] and "leg" not in one.roles[:1]
    ]
    across = max(pairs, default=(0.0, (0.0, 0.0, 0.0)))[1]
    beside = normalise(cross(brief.directions.up, across))
    return find_front(brief.parts) or (beside if abs(across[2]) < _LEVEL else None) or brief.directions.toward


def find_swing(part: Part, brief: SceneBrief) -> Vector:
    """The level way across a limb; the viewer's right where it stands upright."""
    return normalise(cross(brief.directions.up, part.arm)) or brief.directions.right


def find_angle(motion: ExpectedMotion) -> float:
    """Angle that a limb turns by [degrees]."""
    if motion.amount is not None and motion.amount.unit == "degrees":
        return motion.amount.value
    return clamp(_PLAIN * motion.strength, _LEAST, _MOST)


@dataclasses.dataclass(frozen=True)
class Turning:
    """The turning of one limb in a clip, as constraints.

    Attributes:
        part: The limb.
        brief: The scene.
        frame_count: Length of the clip [frames].
        slides: Whether it sits loose on the rest, as a lid does, and is moved rather than turned.
    """

    part: Part
    brief: SceneBrief
    frame_count: int
    slides: bool = False

    def find_course(self, way: Vector, angle: float) -> Vector:
        """The way that the tip goes: ``way``, but what hangs and is raised swings out, and cannot go into the body.

        Args:
            way: Unit world vector.
            angle: The angle that it turns by [degrees].
        """
        arm, up, turn = normalise(self.part.arm), self.brief.directions.up, math.radians(angle)
        if arm is None or dot(arm, way) > -_ALONG or abs(dot(way, up)) < _ALONG:
            return way
        aside = (self.part.side[0], self.part.side[1], 0.0)
        out = find_front(self.brief.parts) or normalise(aside) or self.brief.directions.right
        return normalise(add((scale(out, math.sin(turn)), scale(way, 1.0 - math.cos(turn))))) or way

    def bring(
        self, way: Vector, motion: ExpectedMotion, angle: float, window: Window, stop: float | None
    ) -> VelocityConstraint:
        """The limb turned by an angle [degrees] so that its tip goes ``way``, or moved along itself.

        Args:
            way: Unit world vector.
            motion: For the length that the sentence tells.
            angle: [degrees]; negative = the other way.
            window: First and last frame.
            stop: Frame until which it is held there; None = not.
        """
        arm = normalise(self.part.arm) or self.brief.directions.up
        if abs(dot(arm, way)) < _ALONG and not self.slides:
            axis = normalise(cross(arm, subtract(way, scale(arm, dot(arm, way))))) or self.brief.directions.up
            return self.driver.turn(axis, angle, window, stop)
        told = motion.amount if motion.kind is MotionKind.MOVE else None
        if told is not None and told.unit in ("lengths", "metres"):
            size = self.brief.size if told.unit == "metres" else 1.0
            return self.driver.shift(way, told.value / size, window, stop)
        reach = _LIFTED if "lid" in self.part.roles[:1] else _REACH
        return self.driver.shift(way, reach * norm(self.part.arm) * angle / _PLAIN, window, stop)

    @property
    def driver(self) -> PartDriver:
        """Makes the constraints."""
        return PartDriver(self.part, self.brief.frame_dt, self.frame_count)
