"""A turn about the present mass centre: the skill `torque`."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.terms.rigid import mass_centre
from physagent_jax.mpm.edges import window_fraction
from physagent_jax.mpm.fields import EDGE, END, PER_PARTICLE, START
from physagent_jax.mpm.linalg import cross, skew


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Torque:
    """Turns the region about an axis through its present mass centre: axis x r (paper, skill 4).

    Attributes:
        axis: Unit vector (right-hand rule), shape (3,).
        magnitude: Angular acceleration of a rigid body [rad/s^2], scalar.
        start, end: Window [s], scalars.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    axis: jax.Array
    magnitude: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v
        mass = mass if self.weight is None else mass * self.weight
        strength = self.magnitude * window_fraction(time, dt, self.start, self.end, self.edge)
        arm = x - mass_centre(x, mass)
        field = strength * cross(
            jnp.broadcast_to(self.axis, arm.shape), arm
        )  # the part along the axis drops out
        return field if self.weight is None else self.weight[:, None] * field

    def gradient(self, x, time, dt):
        """d acceleration / d x within the region [1/s^2], shape (n, 3, 3) or (3, 3)."""
        del x
        spin = self.magnitude * window_fraction(time, dt, self.start, self.end, self.edge) * skew(self.axis)
        return spin if self.weight is None else self.weight[:, None, None] * spin
