"""What acts on grid velocities: walls and obstacles."""

from __future__ import annotations

import enum
from typing import Annotated, Literal

from pydantic import Field, field_validator

from physagent_jax.forces.schema import unit_vector
from physagent_jax.scene.config.common import NonNegative, Windowed
from physagent_jax.strict import Strict, Vector


class Surface(enum.StrEnum):
    """What a half-space does to grid velocities inside it."""

    STICKY = "sticky"  # no motion at all
    SLIP = "slip"  # no normal motion, either way (bilateral)
    SEPARATE = "separate"  # no motion into it (unilateral), Coulomb friction on contact


class DomainBox(Strict):
    """Separating slip walls around the domain, ``padding`` cells thick; particles are stopped there."""

    kind: Literal["domain_box"] = "domain_box"
    padding: int = Field(default=3, ge=2, le=16)


class HalfSpace(Windowed):
    """A plane; ``normal`` points out of the solid. Acts on grid nodes behind it within [start, end) [s]."""

    kind: Literal["half_space"] = "half_space"
    point: Vector
    normal: Vector
    surface: Surface = Surface.SEPARATE
    friction: NonNegative = 0.0

    @field_validator("normal")
    @classmethod
    def _unit(cls, value: Vector) -> Vector:
        return unit_vector(value)


class Cuboid(Windowed):
    """A box that moves with ``velocity`` and imposes it on the grid nodes inside, within [start, end) [s]."""

    kind: Literal["cuboid"] = "cuboid"
    point: Vector
    half_size: Vector
    velocity: Vector = (0.0, 0.0, 0.0)


Boundary = Annotated[DomainBox | HalfSpace | Cuboid, Field(discriminator="kind")]
