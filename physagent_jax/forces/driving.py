"""A part that is driven: turned about its joint or moved, so far in so long."""

from __future__ import annotations

import dataclasses
import math

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
from physagent_jax.forces.schema import ConstraintType, VelocityConstraint


@dataclasses.dataclass(frozen=True)
class PartDriver:
    """Makes the constraints that drive a part.

    Attributes:
        part: The part.
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip.
        held: Whether the object is held somewhere, which M = 1 goes by.
    """

    part: Part
    frame_dt: float
    frame_count: int
    held: bool = True

    def turn(self, axis: Vector, degrees: float, window: tuple[float, float], stop: float | None):
        """The rotation about the joint, or about the middle of what is seated.

        Args:
            axis: Unit vector.
            degrees: Angle [degrees].
            window: First and last frame.
            stop: Frame until which it is then held; None = it is let go.
        """
        return self._make(
            ConstraintType.PARTICLE_ROTATION,
            axis,
            math.radians(degrees) / TURN,
            window,
            stop,
            self.part.joint,
        )

    def shift(self, way: Vector, length: float, window: tuple[float, float], stop: float | None):
        """The translation along a unit vector by a length [body lengths]; else as `turn`."""
        return self._make(
            ConstraintType.PARTICLE_TRANSLATION, way, length / PRESCRIBED_TRAVEL, window, stop, None
        )

    def press(self, way: Vector, depth: float, window: tuple[float, float], stop: float | None):
        """The plate of the part's size that presses it along a unit vector by a share of its extent; else as `turn`."""
        return self._make(ConstraintType.MOVING_PLATE, way, depth / PRESCRIBED_TRAVEL, window, stop, None)

    def _make(self, kind, vector: Vector, share: float, window, stop, pivot) -> VelocityConstraint:
        """The constraint that does ``share`` in its window of what M = 1 does in the reference time."""
        seconds, duration = (
            (count * self.frame_dt) for count in (window[1] - window[0], self.frame_count - 1)
        )
        effort = share * find_reference_time(self.held, duration) / seconds
        size = min(max(abs(effort), MAGNITUDE_MIN), MAGNITUDE_MAX)
        x, y, z = vector
        return VelocityConstraint(
            constraint_type=kind,
            vector=vector if effort >= 0 else (-x, -y, -z),
            magnitude=round(size, 3),
            gain=round(min(max(abs(effort) / size, GAIN_MIN), GAIN_MAX), 4),
            active_time=window,
            held_until=stop,
            region=self.part.moved,
            pivot=pivot,
        )
