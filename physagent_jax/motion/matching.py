"""The actions and constraints of a force field that are meant to cause an expected motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import (
    Action,
    ActionType,
    BoxRegion,
    ConstraintType,
    ForceField,
    HalfSpaceRegion,
    Region,
    VelocityConstraint,
)
from physagent_jax.forces.skills import Skill, get_skill, list_skills
from physagent_jax.forces.slabs import make_end_region
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.swaying import FOOT, HALF
from physagent_jax.motion.vectors import cosine, scale

POINTED = 0.95  # cosine from which a vector points where the sentence says
_ALIGNED = 0.5
_PARALLEL = 0.7  # cosine of two lines
_NO_WAY = (0.0, 0.0, 0.0)
AXIAL = (MotionKind.STRETCH, MotionKind.SQUEEZE)


@dataclass(frozen=True)
class Cause:
    """One entry of a force field.

    Attributes:
        group: "actions" or "constraints".
        index: Place in the group.
        item: The entry.
    """

    group: str
    index: int
    item: Action | VelocityConstraint

    @property
    def name(self) -> str:
        """Place in the JSON, like "actions[0]"."""
        return f"{self.group}[{self.index}]"

    @property
    def skill(self) -> Skill:
        """Its skill."""
        return get_skill(self.item)

    @property
    def turns_limb(self) -> bool:
        """Return whether it turns a part about its joint, or presses it alone, whatever way that moves the part."""
        pressed = self.skill.deforms == "plates" and self.item.region is not None
        return isinstance(self.item, VelocityConstraint) and (self.item.pivot is not None or pressed)

    @property
    def leads_part(self) -> bool:
        """Return whether a part goes as far as is prescribed, whatever it takes to bring it there."""
        return isinstance(self.item, VelocityConstraint) and self.item.region is not None

    @property
    def bends_over(self) -> bool:
        """Return whether it bends the whole, over its foot or about its middle, whatever way that moves it."""
        bend = getattr(self.item, "bend", None)
        return bend is not None and (bend.rest == FOOT or bend.rest.label == HALF)

    @property
    def pushes(self) -> bool:
        """Return whether it is a force that lasts and moves the whole of its particles along a direction."""
        return self.group == "actions" and "move" in self.skill.causes and not self.skill.is_sudden

    @property
    def carries(self) -> bool:
        """Return whether it leads or turns all of the object in a time of its own."""
        whole = self.item.region is None and self.item.active_time is not None
        return whole and self.skill.prescribes and self.skill.deforms != "plates"

    @property
    def lets_go(self) -> float:
        """Frame at which a constraint leaves what it led to itself; infinity if it acts to the end."""
        held = getattr(self.item, "held_until", None)
        return held or (self.item.active_time or (0.0, math.inf))[1]

    @property
    def identity(self) -> tuple:
        """Its numbers but for its strength: the magnitude, the gain, or the time for which it is led."""
        window = self.item.active_time
        begin = None if window is None else window[0]
        end = None if self.skill.prescribes or window is None else window[1]
        return self.skill.name, self.item.vector, self.item.magnitude > 0, self.item.region, begin, end

    def get_effort(self, last: float) -> float:
        """The amount that the response grows with: abs(M) and k, times the frames where a velocity is prescribed.

        Args:
            last: The clip's last frame.
        """
        first, end = self.item.active_time or (0.0, last)
        return abs(self.item.magnitude) * self.item.gain * (end - first if self.skill.prescribes else 1.0)

    def prescribe(self, **fields: Any) -> VelocityConstraint:
        """The velocity constraint that does its work, with these fields."""
        name = self.skill.prescribed_by or self.skill.name
        return VelocityConstraint(constraint_type=ConstraintType(name), **fields)

    @property
    def direction(self) -> Vector:
        """The vector with the magnitude's sign."""
        return scale(self.item.vector, 1.0 if self.item.magnitude > 0 else -1.0)


def find_action_type(kind: MotionKind, sudden: bool = False) -> ActionType:
    """The skill by which forces bring about a motion; the first of the library's, or a blow where it is sudden."""
    fitting = (s for s in list_skills("actions") if s.is_sudden is sudden and (sudden or kind in s.causes))
    return ActionType(next(fitting).name)


def list_causes(force_field: ForceField) -> list[Cause]:
    """Every entry of a force field."""
    groups = ("actions", "constraints")
    return [Cause(group, i, item) for group in groups for i, item in enumerate(getattr(force_field, group))]


def find_new_places(before: ForceField, after: ForceField) -> dict[str, str]:
    """The place in ``after`` of each action of ``before``: its new place, or its first constraint."""
    places = {}
    for index, action in enumerate(before.actions):
        here = next((i for i, other in enumerate(after.actions) if other is action), None)
        begin = (action.active_time or (0.0,))[0]
        new = [Cause("constraints", i, c) for i, c in enumerate(after.constraints)][len(before.constraints) :]
        alike = [c for c in new if abs(cosine(c.item.vector, action.vector)) > _PARALLEL]
        heirs = [c for c in alike if (c.item.active_time or (0.0,))[0] == begin]
        if here is not None:
            places[f"actions[{index}]"] = f"actions[{here}]"
        elif heirs:  # of two ends that turn or move against each other the one that goes the action's way
            heir = max(heirs, key=lambda c: cosine(c.item.vector, action.vector))
            places[f"actions[{index}]"] = heir.name
    return places


def redirect(cause: Cause, expectation: ExpectedMotion) -> dict[str, Any]:
    """Changes that make an entry go where the sentence says: the sign alone of what goes exactly the other way."""
    told, size = expectation.direction, cause.item.magnitude
    if told is None or expectation.kind in AXIAL or cosine(cause.direction, told) < -POINTED:
        return {"magnitude": -size}
    return {"vector": told, "magnitude": abs(size)}


def overlaps(cause: Cause, window: tuple[float, float]) -> bool:
    """Return whether a cause acts inside a window; absent times mean the whole clip."""
    if cause.item.active_time is None:
        return True
    first, last = cause.item.active_time
    return first < window[1] and last > window[0]


def share_time(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    """Return whether two expected motions share a part of their windows."""
    return one.window[0] < other.window[1] and one.window[1] > other.window[0]


def is_last_rest(rest: ExpectedMotion, expectations: Sequence[ExpectedMotion]) -> bool:
    """Return whether all that is asked ends in a rest of the whole; one that is told how long it lasts is longer."""
    whole = rest.kind is MotionKind.STILL and rest.part is None and rest.limb is None and not rest.stays
    others = [other for other in expectations if other is not rest]
    return whole and bool(others) and all(each.window[1] <= rest.window[0] + 0.5 for each in others)


def is_thrown_up(
    expectation: ExpectedMotion, expectations: Sequence[ExpectedMotion], brief: SceneBrief
) -> bool:
    """Return whether it leaps or is thrown upwards and is to come down again."""
    if not expectation.sudden or expectation.direction is None:
        return False
    upwards = cosine(expectation.direction, brief.directions.up) > _ALIGNED
    return upwards and any(other.kind is MotionKind.FALL for other in expectations)


def find_causes(expectation: ExpectedMotion, force_field: ForceField) -> list[Cause]:
    """Entries of a fitting type that act in the window: those along the expected line, else all of them."""
    acting = [c for c in list_causes(force_field) if overlaps(c, expectation.window)]
    if turning := [c for c in acting if _turns_what_is_meant(c, expectation)]:
        return turning + (_list_swings(turning[-1], force_field) if expectation.released else [])
    fitting = [c for c in acting if expectation.kind in c.skill.causes]
    if expectation.kind in AXIAL:  # a translation of something else than an end does neither
        fitting = [c for c in fitting if c.group == "actions" or _moves_ends(c) is not None]
    if expectation.direction is None:
        return fitting
    aligned = [c for c in fitting if abs(cosine(c.item.vector, expectation.direction)) >= _ALIGNED]
    return aligned or fitting


def _list_swings(bent: Cause, force_field: ForceField) -> list[Cause]:
    """The turns by which what was bent springs back: each begins where the one before lets go."""
    swings: list[Cause] = []
    for cause in list_causes(force_field):
        begin = (cause.item.active_time or (0.0,))[0]
        follows = abs(begin - (swings[-1] if swings else bent).lets_go) < 1.0 and cause.name != bent.name
        swings += [cause] if cause.bends_over and follows else []
    return swings


def _turns_what_is_meant(cause: Cause, expectation: ExpectedMotion) -> bool:
    """Return whether a limb is meant and it turns one, or all of what stands and it bends that."""
    if expectation.limb is not None:
        return cause.turns_limb
    return cause.bends_over and expectation.kind in (MotionKind.MOVE, MotionKind.SWAY)


def find_own_causes(
    expectation: ExpectedMotion, expectations: Sequence[ExpectedMotion], force_field: ForceField
) -> list[Cause]:
    """Causes of an expected motion without those that serve another one: they are not to be turned from it."""
    causes = find_causes(expectation, force_field)
    if all(agrees(cause, expectation) for cause in causes):
        return causes  # whatever else they serve
    others = [e for e in expectations if e is not expectation and e.kind is not MotionKind.SWAY]
    served = {c.name for e in others for c in find_causes(e, force_field) if agrees(c, e)}
    return [c for c in causes if c.name not in served or agrees(c, expectation)]


def find_misfits(
    expectation: ExpectedMotion, expectations: Sequence[ExpectedMotion], force_field: ForceField
) -> list[Cause]:
    """Actions in the window whose type cannot cause this motion and that no other expectation needs."""
    others = [e for e in expectations if e is not expectation]
    needed = {c.name for e in others for c in find_causes(e, force_field)}
    acting = [c for c in list_causes(force_field) if overlaps(c, expectation.window)]
    misfits = [c for c in acting if c.group == "actions" and expectation.kind not in c.skill.causes]
    return [c for c in misfits if c.name not in needed]


def _moves_ends(cause: Cause) -> MotionKind | None:
    """Return whether a constraint moves an end of the object outwards or inwards; None = neither."""
    if cause.skill.deforms == "plates":
        return MotionKind.SQUEEZE
    region = cause.item.region
    if cause.skill.deforms is None or region is None:
        return None
    along = max((cosine(cause.direction, side) for side in _list_ends(region)), key=abs, default=0.0)
    if abs(along) < _ALIGNED:
        return None
    return MotionKind.STRETCH if along > 0 else MotionKind.SQUEEZE


def _list_ends(region: Region) -> list[Vector]:
    """Outward directions in which a region reaches an end of the object and not the other one."""
    if isinstance(region, HalfSpaceRegion):
        return [region.normal]
    if not isinstance(region, BoxRegion):
        return []
    axes = zip(region.low, region.high, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    return [scale(axis, 1.0 if high >= 1 else -1.0) for low, high, axis in axes if (low <= 0) != (high >= 1)]


def find_strays(expectations: Sequence[ExpectedMotion], force_field: ForceField) -> list[Cause]:
    """Entries that nothing in the sentence asks for; none while an expectation lacks a cause, which they may become.

    What acts the other way along the line of a cause that has ended is its brake, or the other half of a swing. What a
    finger or a hand does was asked for, whatever comes of it.
    """
    serving: list[Cause] = []
    for expectation in expectations:
        if expectation.kind in (MotionKind.STILL, MotionKind.FALL):
            continue
        own = [c for c in find_causes(expectation, force_field) if agrees(c, expectation)]
        if not own:
            return []
        serving += own
        if expectation.kind is MotionKind.SWAY:
            serving += find_causes(expectation, force_field)
    names = {cause.name for cause in serving}
    others = [cause for cause in list_causes(force_field) if cause.name not in names]
    return [cause for cause in others if not (cause.item.touched or _brakes(cause, serving))]


def _brakes(cause: Cause, serving: Sequence[Cause]) -> bool:
    """Return whether it begins where one of ``serving`` ends, and acts against it."""
    against = [c.item.active_time for c in serving if cosine(cause.direction, c.direction) < -_ALIGNED]
    window = cause.item.active_time
    return window is not None and any(time is not None and time[1] <= window[0] + 0.5 for time in against)


def agrees(cause: Cause, expectation: ExpectedMotion) -> bool:
    """Return whether a cause drives the motion the way that the sentence says (its sign, for stretch and squeeze)."""
    if _turns_what_is_meant(cause, expectation):
        return True
    if expectation.kind in AXIAL:
        if cause.group == "constraints":
            return _moves_ends(cause) is expectation.kind
        return (cause.item.magnitude > 0) == (expectation.kind is MotionKind.STRETCH)
    return expectation.direction is None or cosine(cause.direction, expectation.direction) >= _ALIGNED


def share_line(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    """Return whether two motions go along one line, either way."""
    return abs(cosine(one.direction or _NO_WAY, other.direction or _NO_WAY)) > _PARALLEL


def is_turned_against(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    """Return whether two ends turn against each other."""
    turns = one.kind is other.kind is MotionKind.ROTATE and other is not one and share_time(one, other)
    pairs = (one.part, other.part), (one.direction, other.direction)
    return turns and all(cosine(a or _NO_WAY, b or _NO_WAY) < -_PARALLEL for a, b in pairs)


def make_part_region(expectation: ExpectedMotion) -> HalfSpaceRegion | None:
    """The half of the object on the side of a motion's end; None if the motion is about the whole, or about no end."""
    if expectation.part is None:
        return None
    return make_end_region(scale(expectation.part, -1.0 if expectation.excludes_part else 1.0), 0.5)
