"""Force terms of a scene beyond the agents' skills: wind, attractor, vortex, turbulence, a uniform push.

All are accelerations, so that neither the number of particles nor their density changes the motion. Points
are absolute [m]; regions are fractions of the object's rest bounding box, as in a force field.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from physagent_jax.core.strict import Direction, Seed, Strict
from physagent_jax.forces.schema import Region
from physagent_jax.scene.config.common import (
    FOREVER,
    Acceleration,
    AccelerationComponent,
    Duration,
    Length,
    Point,
    Rate,
    Time,
    Windowed,
)

_STRONGEST = 1e9  # [m/s^2], pull of an attractor on what is at its point
_SHORTEST_RAMP = 1e-9  # [s]

# --- time profiles: 0 outside [start, end) [s] ---------------------------------------------------------


def _check_ramp(value: float) -> float:
    if 0 < value < _SHORTEST_RAMP:
        raise ValueError(f"a ramp lasts 0 s, or {_SHORTEST_RAMP:g} s and more")
    return value


Ramp = Annotated[Time, AfterValidator(_check_ramp)]


class ConstantEnvelope(Windowed):
    """1 within [start, end) [s]."""

    kind: Literal["constant"] = "constant"


class RampEnvelope(Windowed):
    """Rises linearly from 0 to 1 over ``rise`` [s], falls linearly to 0 over the last ``fall`` [s]."""

    kind: Literal["ramp"] = "ramp"
    rise: Ramp = 0.0
    fall: Ramp = 0.0

    @model_validator(mode="after")
    def _check_fit(self) -> RampEnvelope:
        if self.fall > 0 and self.end >= FOREVER:
            raise ValueError("`fall` needs an `end` to fall to")
        if self.rise + self.fall > self.end - self.start + 1e-9:
            raise ValueError(
                f"`rise` + `fall` = {self.rise + self.fall:g} s must fit between `start` and `end` "
                f"({self.end - self.start:g} s)"
            )
        return self


class PulseEnvelope(Windowed):
    """One smooth bump over [start, end) [s]: sin^2, 1 in the middle, with an integral of half the window."""

    kind: Literal["pulse"] = "pulse"

    @model_validator(mode="after")
    def _check_end(self) -> PulseEnvelope:
        if self.end >= FOREVER:
            raise ValueError("`end` is missing: a pulse fills its window, so the window must close")
        return self


class SineEnvelope(Windowed):
    """sin(2 pi ``frequency`` (t - start) + ``phase``) within [start, end) [s]; between -1 and 1.

    Attributes:
        frequency: [Hz].
        phase: [rad].
    """

    kind: Literal["sine"] = "sine"
    frequency: Annotated[float, Field(ge=1e-9, le=1e6)]
    phase: Annotated[float, Field(ge=-1e3, le=1e3)] = 0.0


Envelope = Annotated[
    ConstantEnvelope | RampEnvelope | PulseEnvelope | SineEnvelope, Field(discriminator="kind")
]

# --- terms -------------------------------------------------------------------------------------------


class _Term(Strict):
    """The base of all terms.

    Attributes:
        envelope: Strength over time.
        region: Which particles; None = the whole object.
    """

    envelope: Envelope = ConstantEnvelope()
    region: Region | None = None


class Wind(_Term):
    """Drag towards moving air: dv/dt = linear_drag w + quadratic_drag |w| w, w = speed direction - v.

    The envelope scales the air's speed; the drag acts within its window. Speed 0 is the drag of still air.

    Attributes:
        direction: Where the wind blows to; normalised on input.
        speed: Speed of the air [m/s].
        linear_drag: [1/s].
        quadratic_drag: [1/m]; of a body of frontal area A and mass m, rho_air C_d A / (2 m).
        center, radius: It blows only within ``radius`` [m] of the line through ``center`` [m] along
            ``direction``; None = everywhere.
    """

    kind: Literal["wind"] = "wind"
    direction: Direction | None = None
    speed: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    linear_drag: Rate = 0.0
    quadratic_drag: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    center: Point | None = None
    radius: Length | None = None

    @model_validator(mode="after")
    def _check_complete(self) -> Wind:
        if self.linear_drag == 0 and self.quadratic_drag == 0:
            raise ValueError("`linear_drag` and `quadratic_drag` are both 0: the wind would move nothing")
        if (self.center is None) != (self.radius is None):
            raise ValueError("`center` and `radius` belong together: give both or neither")
        if self.direction is None and (self.speed > 0 or self.center is not None):
            raise ValueError("`direction` is missing: a wind that blows needs one, and so does its cylinder")
        return self


class Attractor(_Term):
    """Pulls towards a point: ``strength`` / r^``power`` with r^2 = distance^2 + softening^2, in metres.

    Attributes:
        point: [m].
        strength: Acceleration at a distance of 1 m [m/s^2]; positive attracts, negative repels.
        power: 2 = gravity, 0 = the same everywhere, -1 = a spring.
        softening: Keeps the pull finite at the point [m]; not less than a grid cell is advisable.
    """

    kind: Literal["attractor"] = "attractor"
    point: Point
    strength: AccelerationComponent
    power: float = Field(default=2.0, ge=-1, le=6)
    softening: Length = 0.1

    @model_validator(mode="after")
    def _check_bounds(self) -> Attractor:
        if self.power > 0 and abs(self.strength) > _STRONGEST * self.softening**self.power:
            pull = abs(self.strength) / self.softening**self.power
            raise ValueError(
                f"the pull at the point is {pull:.3g} m/s^2, more than {_STRONGEST:g}: raise `softening`"
            )
        return self


class Vortex(_Term):
    """Accelerates around, towards and along an axis through a point.

    Attributes:
        point: A point on the axis [m].
        axis: Any direction (right-hand rule); normalised on input.
        swirl: Around the axis [m/s^2].
        inward: Towards the axis [m/s^2]; negative = outward.
        axial: Along the axis [m/s^2].
        core: Radius within which swirl and inward fade to 0 on the axis [m].
        power: Outside the core all three fall off as (core / distance)^power; 0 = not at all.
    """

    kind: Literal["vortex"] = "vortex"
    point: Point
    axis: Direction
    swirl: AccelerationComponent = 0.0
    inward: AccelerationComponent = 0.0
    axial: AccelerationComponent = 0.0
    core: Length = 0.25
    power: float = Field(default=1.0, ge=0, le=6)

    @model_validator(mode="after")
    def _check_effect(self) -> Vortex:
        if self.swirl == self.inward == self.axial == 0:
            raise ValueError("`swirl`, `inward` and `axial` are all 0: the vortex would move nothing")
        return self


class Turbulence(_Term):
    """A random, divergence-free acceleration; the same seed gives the same field.

    Attributes:
        strength: Root mean square [m/s^2].
        length_scale: Correlation length [m].
        time_scale: Correlation time [s].
        seed: Seed of the field.
        modes: Waves that make it up; the cost is proportional to them.
    """

    kind: Literal["turbulence"] = "turbulence"
    strength: Annotated[float, Field(gt=0, le=1e6)]
    length_scale: Length
    time_scale: Duration
    seed: Seed = 0
    modes: int = Field(default=32, ge=1, le=512)


class Uniform(_Term):
    """One acceleration [m/s^2] for all particles of the region."""

    kind: Literal["uniform"] = "uniform"
    acceleration: Acceleration


ForceTerm = Annotated[Wind | Attractor | Vortex | Turbulence | Uniform, Field(discriminator="kind")]
