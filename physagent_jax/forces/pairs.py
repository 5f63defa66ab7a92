"""Pairs of velocity constraints that act on two ends: what lies between them follows in proportion.

Two opposed translations of the ends, or two opposed plates, change the length of the whole; two opposed rotations wring
it. Moved as slabs, ends would tear off what is thin between them; with a motion that grows evenly from end to end every
section is strained alike, and nothing is toppled. One plate that presses towards the ground or the fixture has that for
its partner, and so has an end of what is held that is turned. Two pieces of their own come apart instead.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import (
    CellsRegion,
    ForceField,
    HalfSpaceRegion,
    Region,
    SkillScaling,
    VelocityConstraint,
)
from physagent_jax.forces.skills import get_skill

_OPPOSED, _ALONG = -0.99, 0.999  # cosines
_ROUND_OFF = 1e-6  # of a place
_UPRIGHT = 0.7  # cosine


@dataclasses.dataclass(frozen=True)
class Pair:
    """Two ends of an object that act together, or one against what bears it.

    Attributes:
        first: Place in ``constraints`` of the end that lies in the direction of ``sign`` times its own vector.
        second: Place of the other end; None = the ground or the fixture is there.
        sign: 1 where the first one's vector points out of the object, -1 where it points into it.
    """

    first: int
    second: int | None
    sign: float


def find_pairs(field: ForceField, scaling: SkillScaling, rest: np.ndarray) -> list[Pair]:
    """The pairs of a force field's constraints; each belongs to one at most.

    Args:
        field: The force field.
        scaling: What M = 1 means; tells whether the ground or a fixture bears the object.
        rest: Rest positions of the particles [m], shape (n, 3).
    """
    pairs: list[Pair] = []
    taken: set[int] = set()
    for i, one in enumerate(field.constraints):
        for j, other in enumerate(field.constraints[i + 1 :], i + 1):
            if {i, j} & taken or not _match(one, other):
                continue
            sign = _find_sign(one, other, rest)
            if sign is not None:
                pairs.append(Pair(i, j, sign))
                taken |= {i, j}
    opposition = scaling.opposition
    grounded = opposition is not None and opposition.friction > 0
    for i, one in enumerate(field.constraints):
        up = one.vector[2] * np.sign(one.magnitude)
        borne = (grounded and up < -_UPRIGHT) or (scaling.holding is not None and abs(up) > _UPRIGHT)
        if i not in taken and get_skill(one).deforms == "plates" and one.region is None and borne:
            pairs.append(Pair(i, None, -1.0))
        if i not in taken and scaling.holding is not None and one.region is not None and _turns(one):
            way = np.sign(one.magnitude) * np.asarray(one.vector)
            pairs += [Pair(i, None, s) for s in (1.0, -1.0) if _is_end(one.region, rest, s * way)]
    return pairs


def _turns(one: VelocityConstraint) -> bool:
    """Return whether it turns what it is on about its own middle."""
    return get_skill(one).prescribes and get_skill(one).is_axis and one.pivot is None


def _match(one: VelocityConstraint, other: VelocityConstraint) -> bool:
    skill = get_skill(one)
    ends = skill.deforms is not None or _turns(one)
    same = one.constraint_type == other.constraint_type and one.object == other.object
    same &= not any(isinstance(each.region, CellsRegion) and each.region.rigid for each in (one, other))
    together = one.active_time == other.active_time and one.held_until == other.held_until
    ways = np.sign(one.magnitude) * np.sign(other.magnitude) * np.dot(one.vector, other.vector)
    return ends and same and together and ways < _OPPOSED


def _find_sign(one: VelocityConstraint, other: VelocityConstraint, rest: np.ndarray) -> float | None:
    """1 if the first acts on the end in its vector's direction, -1 on the other end, None if these are no two ends."""
    way = np.sign(one.magnitude) * np.asarray(one.vector)
    if get_skill(one).deforms == "plates":
        return -1.0 if one.region is None and other.region is None else None
    if one.region is None or other.region is None:
        return None
    for sign, (high, low) in ((1.0, (one.region, other.region)), (-1.0, (other.region, one.region))):
        if _is_end(high, rest, way) and _is_end(low, rest, -way):
            return sign
    return None


def _is_end(region: Region, rest: np.ndarray, way: np.ndarray) -> bool:
    """Return whether a region is all that lies beyond a plane across a way, and no more than a half.

    Regions are in fractions of the bounding box: across an oblique way, a plane there is none in metres.
    """
    if isinstance(region, HalfSpaceRegion) and np.dot(region.normal, way) > _ALONG:
        return bool((np.asarray(region.point) - 0.5) @ np.asarray(region.normal) > -_ROUND_OFF)
    mask, height = make_region_mask(region, rest), rest @ way
    border = height[mask].min()
    middle = 0.5 * (height.min() + height.max())
    return bool((mask == (height >= border)).mean() > 0.98 and border > middle - _ROUND_OFF)
