"""Schemas of walls and obstacles, which act on grid velocities."""

from __future__ import annotations

import enum
from typing import Annotated, Literal

from pydantic import Field, model_validator

from physagent_jax.core.strict import Direction, Strict
from physagent_jax.scene.config.common import (
    Friction,
    HalfSize,
    Length,
    Path,
    Point,
    RotationAxes,
    Rotations,
    Velocity,
    Windowed,
)


class Surface(enum.StrEnum):
    """The treatment of grid velocities inside an obstacle, relative to its own."""

    STICKY = "sticky"  # no motion at all
    SLIP = "slip"  # no normal motion, either way (bilateral)
    SEPARATE = "separate"  # no motion into it (unilateral), Coulomb friction on contact


class DomainBox(Strict):
    """Separating slip walls around the domain, ``padding`` cells thick; particles are stopped there."""

    kind: Literal["domain_box"] = "domain_box"
    padding: int = Field(default=3, ge=2, le=16)


class Obstacle(Windowed):
    """A solid that grid velocities meet within [start, end) [s].

    Attributes:
        surface: Kind of contact.
        friction: Coulomb coefficient of a separating surface.
        velocity: With which the solid moves on from where it is at ``start`` [m/s].
    """

    surface: Surface = Surface.SEPARATE
    friction: Friction = 0.0
    velocity: Velocity = (0.0, 0.0, 0.0)


class HalfSpace(Obstacle):
    """A plane; ``normal`` points out of the solid, which is what lies behind it."""

    kind: Literal["half_space"] = "half_space"
    point: Point
    normal: Direction


class Sphere(Obstacle):
    """A ball about ``point``; as a ``container``, the solid around a spherical hollow."""

    kind: Literal["sphere"] = "sphere"
    point: Point
    radius: Length
    container: bool = False


class Box(Obstacle):
    """A solid box of ``point`` +- ``half_size`` [m]; as a ``container``, the solid around such a hollow."""

    kind: Literal["box"] = "box"
    point: Point
    half_size: tuple[Length, Length, Length]
    container: bool = False


class Mesh(Obstacle):
    """The solid within a closed mesh: world = scale * rotation @ file + position.

    Attributes:
        path: .obj, .ply with faces, .glb, .stl; absolute or relative to the scene file. It must be watertight.
        scale: World metres per unit of the file [m].
        position: Where the file's origin is [m].
        rotation_degrees, rotation_axes: Rotations about fixed axes (0, 1, 2), applied in order.
    """

    kind: Literal["mesh"] = "mesh"
    path: Path
    scale: Annotated[float, Field(ge=1e-9, le=1e9)] = 1.0
    position: Point = (0.0, 0.0, 0.0)
    rotation_degrees: Rotations = ()
    rotation_axes: RotationAxes = ()

    @model_validator(mode="after")
    def _check_paired(self) -> Mesh:
        if len(self.rotation_degrees) != len(self.rotation_axes):
            raise ValueError("`rotation_degrees` and `rotation_axes` must have equal length")
        return self


class Cuboid(Windowed):
    """A box that moves with ``velocity`` and imposes it on the grid nodes inside, within [start, end) [s]."""

    kind: Literal["cuboid"] = "cuboid"
    point: Point
    half_size: HalfSize
    velocity: Velocity = (0.0, 0.0, 0.0)


Boundary = Annotated[DomainBox | HalfSpace | Sphere | Box | Mesh | Cuboid, Field(discriminator="kind")]
