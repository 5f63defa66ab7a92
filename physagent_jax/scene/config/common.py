"""Types that the parts of a scene share: quantities with their ranges, and windows of time.

The ranges are wide enough for whatever a continuum simulation in metres can mean, and narrow enough that float32
can hold what is computed from them (`core.strict` has the general rule).
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from physagent_jax.core.strict import Strict

FOREVER = 1e9  # [s]; the end of a window that never closes
_FARTHEST = 1e6  # [m]
_LEAST_WINDOW = 1e-6  # of a window's end: float32 tells times apart by a tenth of that

SignedAxis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
SplatEncoding = Literal["log-logit", "plain-plain", "log-plain", "plain-logit"]  # of scales, of opacities
Axis = Literal[0, 1, 2]
Path = Annotated[str, Field(max_length=4096)]

Coordinate = Annotated[float, Field(ge=-_FARTHEST, le=_FARTHEST)]  # [m]
Point = tuple[Coordinate, Coordinate, Coordinate]
Length = Annotated[float, Field(ge=1e-6, le=_FARTHEST)]  # [m]
HalfExtent = Annotated[float, Field(ge=0, le=_FARTHEST)]  # [m]; 0 = a plane
HalfSize = tuple[HalfExtent, HalfExtent, HalfExtent]
Time = Annotated[float, Field(ge=0, le=FOREVER)]  # [s]
Duration = Annotated[float, Field(ge=1e-9, le=FOREVER)]  # [s]
Speed = Annotated[float, Field(ge=-1e6, le=1e6)]  # [m/s]
Velocity = tuple[Speed, Speed, Speed]
AngularVelocity = Annotated[float, Field(ge=-1e6, le=1e6)]  # [rad/s]
AccelerationComponent = Annotated[float, Field(ge=-1e6, le=1e6)]  # [m/s^2]
Acceleration = tuple[AccelerationComponent, AccelerationComponent, AccelerationComponent]
Rate = Annotated[float, Field(ge=0, le=1e9)]  # [1/s]
Degrees = Annotated[float, Field(ge=-36_000, le=36_000)]  # a hundred turns either way
Rotations = Annotated[tuple[Degrees, ...], Field(max_length=16)]
RotationAxes = Annotated[tuple[Axis, ...], Field(max_length=16)]
Friction = Annotated[float, Field(ge=0, le=10)]  # Coulomb; rubber on rough ground has 1.2


class Windowed(Strict):
    """Active for start <= time < end [s]."""

    start: Time = 0.0
    end: Time = FOREVER

    @model_validator(mode="after")
    def _check_order(self):
        if self.end <= self.start:
            raise ValueError(f"`end` must exceed `start` (got start={self.start}, end={self.end})")
        check_window(self.start, self.end - self.start)
        return self


def check_window(start: float, duration: float) -> None:
    """Refuse a window that single precision cannot tell from none.

    Raises:
        ValueError: It is shorter than a nanosecond, or than a millionth of its end.
    """
    least = max(1e-9, _LEAST_WINDOW * (start + duration))
    if duration < least:
        raise ValueError(
            f"a window of {duration:g} s from {start:g} s on is too short: use {least:g} s or more"
        )
