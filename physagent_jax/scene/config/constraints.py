"""Schemas of constraints on chosen particles."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from physagent_jax.core.strict import Direction, Numbers, Strict
from physagent_jax.forces.schema import Region
from physagent_jax.scene.config.common import (
    AngularVelocity,
    Coordinate,
    Duration,
    HalfSize,
    Length,
    Path,
    Point,
    Speed,
    Time,
    Velocity,
    Windowed,
    check_window,
)


class ParticleTranslation(Windowed):
    """Particles that rest in a box move with ``velocity`` [m/s] within [start, end) [s]."""

    kind: Literal["particle_translation"] = "particle_translation"
    point: Point
    half_size: HalfSize
    velocity: Velocity


class ParticleRotation(Windowed):
    """Particles that rest in a cylinder turn about its axis and slide along it within [start, end) [s].

    Attributes:
        point: Centre [m].
        normal: Axis (right-hand rule).
        half_height, radius: Cylinder [m].
        angular_velocity: [rad/s].
        axial_velocity: [m/s].
    """

    kind: Literal["particle_rotation"] = "particle_rotation"
    point: Point
    normal: Direction
    half_height: Length
    radius: Length
    angular_velocity: AngularVelocity = 0.0
    axial_velocity: Speed = 0.0


class ParticleImpulse(Strict):
    """A velocity change of the particles that rest in a box, spread over [start, start + duration] [s].

    Give ``delta_velocity`` [m/s] (independent of particle mass), or ``force`` [N per particle] as
    PhysGaussian does (then delta v = force * duration / particle mass).
    """

    kind: Literal["particle_impulse"] = "particle_impulse"
    point: Point
    half_size: HalfSize
    delta_velocity: Velocity | None = None
    force: Numbers | None = None
    start: Time = 0.0
    duration: Duration = 1e-4

    @model_validator(mode="after")
    def _check_one(self) -> ParticleImpulse:
        if (self.delta_velocity is None) == (self.force is None):
            raise ValueError("give exactly one of `delta_velocity` and `force`")
        check_window(self.start, self.duration)
        return self


class ParticleRelease(Windowed):
    """Particles held still from ``start`` on and let go layer by layer, the last ones at ``end`` [s].

    Layer i (of 0 to ``layers`` - 1) is let go at end * (i + 1) / layers, as in PhysGaussian.

    Attributes:
        normal: Axis along which the layers are stacked.
        start_position: Coordinate along ``normal`` of the first layer to go [m].
        end_position: Coordinate of the last one [m]. The layers lie on both sides of it, out to the distance of
            ``start_position``; what rests farther away is free.
        layers: How many.
    """

    kind: Literal["particle_release"] = "particle_release"
    normal: Direction
    start_position: Coordinate
    end_position: Coordinate
    layers: int = Field(ge=1, le=10_000)

    @model_validator(mode="after")
    def _check_apart(self) -> ParticleRelease:
        if self.start_position == self.end_position:
            raise ValueError("`start_position` and `end_position` must differ")
        return self


Constraint = Annotated[
    ParticleTranslation | ParticleRotation | ParticleImpulse | ParticleRelease, Field(discriminator="kind")
]


class Anchor(Strict):
    """The particles that are held for the whole clip.

    Attributes:
        kind: "none", "base" / "top" (the slab of ``fraction`` of the height at the foot / head), "box"
            (absolute ``point`` +- ``half_size`` [m]), "mask" (Gaussian indices in ``mask_path``, .npy) or "region".
        fraction: Thickness of the slab over the object's height.
        point, half_size: The box.
        mask_path: ``.npy`` of bool per loaded Gaussian, shape (n,).
        region: Particles that rest in it, in fractions of the object's box.
        reason: Why, for the report.
    """

    kind: Literal["none", "base", "top", "box", "mask", "region"] = "none"
    fraction: float = Field(default=0.12, gt=0, le=1)
    point: Point | None = None
    half_size: HalfSize | None = None
    mask_path: Path | None = None
    region: Region | None = None
    reason: str = ""

    @model_validator(mode="after")
    def _check_complete(self) -> Anchor:
        if self.kind == "box" and (self.point is None or self.half_size is None):
            raise ValueError('anchor kind "box" needs `point` and `half_size`')
        if self.kind == "mask" and self.mask_path is None:
            raise ValueError('anchor kind "mask" needs `mask_path`')
        if self.kind == "region" and self.region is None:
            raise ValueError('anchor kind "region" needs `region`')
        return self
