"""A part of an object where forces may act. Pure data, no arrays."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from physagent_jax.core.strict import Direction, Numbers, Strict
from physagent_jax.forces.schema import CellsRegion

PartRole = Literal[
    "head",
    "ear",
    "horn",
    "arm",
    "wing",
    "leg",
    "tail",
    "handle",
    "spout",
    "lid",
    "knob",
    "back",
    "top",
    "bottom",
    "side",
]


class Part(Strict):
    """A part that sticks out of the object.

    Attributes:
        roles: What it may be, surest first: "ear" and "horn" come in pairs on a head, "arm" in pairs elsewhere, "wing"
            is a flat one; "leg" stands on the ground with another, "back" on legs; "handle" is a loop, "spout" is
            across from it; "tail" is across from the head; "lid" and "knob" are on top. "top", "bottom" and "side"
            tell its place alone.
        moved: Particles that move with it: all but those next to its joint.
        rest: Particles of the rest of the object.
        joint: Where it joins the rest (bounding-box fractions).
        arm: From there to its tip [body lengths].
        side: Where it is, seen from the object's middle (unit world vector).
        share: Share of the object's volume.
    """

    roles: tuple[PartRole, ...]
    moved: CellsRegion
    rest: CellsRegion
    joint: Numbers
    arm: Numbers
    side: Direction
    share: float = Field(ge=0, le=1)
