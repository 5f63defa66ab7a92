"""The motion of a part that sticks out: which part is meant, and how it turns about its joint.

A limb is moved by what is prescribed: it turns about its joint so that its tip goes where it is to go, or moves along
itself where the way leads along it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import (
    GAIN_MAX,
    GAIN_MIN,
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    PRESCRIBED_TRAVEL,
    TURN,
    find_reference_time,
)
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion, ConstraintType, VelocityConstraint
from physagent_jax.motion.schema import ExpectedMotion, SceneBrief
from physagent_jax.motion.vectors import add, clamp, cosine, cross, dot, norm, normalise, scale, subtract

_PLAIN = 45.0  # [degrees] that a plain word turns a limb by
_LEAST, _MOST = 15.0, 80.0  # [degrees]
_ALONG = 0.85  # cosine to the limb from which on a way leads along it
_REACH = 0.3  # of its length, by which a plain word moves a limb along itself
_LIFTED = 1.0  # the same of a lid, which lies loose and comes off
_THERE = 0.2  # cosine to a side from which on a limb is on it
_MOST_SEEDS = 256  # of a region
PLACES = ("top", "bottom", "side")
"""Roles that tell a part's place alone: a word for another part takes it where it is the only one there."""


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
    heads = [each for each in parts if each.roles[0] == "head"]
    if len(heads) != 1 or sum(each.roles[0] == "leg" for each in parts) < 3:
        return None
    return normalise((heads[0].side[0], heads[0].side[1], 0.0))


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
    """

    part: Part
    brief: SceneBrief
    frame_count: int

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
        self, way: Vector, angle: float, window: tuple[float, float], stop: float | None
    ) -> VelocityConstraint:
        """The limb turned by an angle [degrees] so that its tip goes ``way``, or moved along itself.

        Args:
            way: Unit world vector.
            angle: [degrees]; negative = the other way.
            window: First and last frame.
            stop: Frame until which it is held there; None = not.
        """
        arm = normalise(self.part.arm) or self.brief.directions.up
        if abs(dot(arm, way)) < _ALONG:
            axis = normalise(cross(arm, subtract(way, scale(arm, dot(arm, way))))) or self.brief.directions.up
            return self.rotate(axis, angle, window, stop)
        reach = _LIFTED if self.part.roles[0] == "lid" else _REACH
        length = reach * norm(self.part.arm) * angle / _PLAIN
        return self._make(ConstraintType.PARTICLE_TRANSLATION, way, length, PRESCRIBED_TRAVEL, window, stop)

    def rotate(
        self, axis: Vector, angle: float, window: tuple[float, float], stop: float | None
    ) -> VelocityConstraint:
        """The limb turned about an axis through its joint; arguments as of `bring`."""
        return self._make(ConstraintType.PARTICLE_ROTATION, axis, math.radians(angle), TURN, window, stop)

    def _make(
        self,
        kind: ConstraintType,
        vector: Vector,
        wanted: float,
        usual: float,
        window: tuple[float, float],
        stop: float | None,
    ) -> VelocityConstraint:
        """The constraint that does ``wanted`` in its window, where M = 1 does ``usual`` in the reference time."""
        seconds = (window[1] - window[0]) * self.brief.frame_dt
        duration = (self.frame_count - 1) * self.brief.frame_dt
        effort = wanted / (usual * seconds / find_reference_time(True, duration))
        size = clamp(abs(effort), MAGNITUDE_MIN, MAGNITUDE_MAX)
        return VelocityConstraint(
            constraint_type=kind,
            vector=vector if effort >= 0 else scale(vector, -1.0),
            magnitude=round(size, 3),
            gain=round(clamp(abs(effort) / size, GAIN_MIN, GAIN_MAX), 4),
            active_time=window,
            held_until=stop,
            region=self.part.moved,
            pivot=self.part.joint if kind is ConstraintType.PARTICLE_ROTATION else None,
        )


def join_rest(limbs: Sequence[Part]) -> CellsRegion:
    """The particles that belong to none of the limbs."""
    outside = tuple(seed for limb in limbs for seed in limb.rest.outside)
    inside = tuple(
        seed for limb in limbs for seed in limb.rest.inside if all(_is_in_rest(seed, each) for each in limbs)
    )
    return CellsRegion(inside=_thin(inside or limbs[0].rest.inside), outside=_thin(outside))


def _thin(seeds: tuple[Vector, ...]) -> tuple[Vector, ...]:
    """At most as many of the seeds as a region holds, evenly."""
    return seeds[:: -(-len(seeds) // _MOST_SEEDS)]


def _is_in_rest(seed: Vector, limb: Part) -> bool:
    def find_nearest(seeds) -> float:
        return min(norm(subtract(seed, each)) for each in seeds)

    return find_nearest(limb.rest.inside) < find_nearest(limb.rest.outside)
