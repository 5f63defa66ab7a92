"""The part of the object that a motion is about, as the region of a force."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.matching import Cause
from physagent_jax.agents.schema import ExpectedMotion
from physagent_jax.agents.vectors import scale
from physagent_jax.forces.schema import HalfSpaceRegion

_MIDDLE = (0.5, 0.5, 0.5)


def make_part_region(expectation: ExpectedMotion) -> HalfSpaceRegion | None:
    """The half of the object on the side of a motion's end; None if the motion is about the whole, or about no end."""
    if expectation.part is None:
        return None
    side = scale(expectation.part, -1.0) if expectation.excludes_part else expectation.part
    return HalfSpaceRegion(point=_MIDDLE, normal=side)


def bound_to_part(expectation: ExpectedMotion, causes: Sequence[Cause]) -> list:
    """The entries of causes that act on the whole object, each bounded to the part; all others as they are."""
    region = make_part_region(expectation)
    return [
        cause.item.model_copy(update={"region": region})
        if region is not None and cause.item.region is None
        else cause.item
        for cause in causes
    ]
