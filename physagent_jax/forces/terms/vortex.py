"""A swirl about an axis."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.envelope import Envelope, Scalar
from physagent_jax.forces.regions import confine
from physagent_jax.mpm.fields import PER_PARTICLE, UNIT
from physagent_jax.mpm.linalg import cross, skew


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Vortex:
    """Accelerates around, towards and along an axis through a point; the axis may have any direction.

    With d the part of x - point across the axis and r^2 = d^2 + core^2,

        a = (core / r)^power (swirl axis x d / r - inward d / r + axial axis).

    Within the core swirl and inward grow linearly from 0 on the axis; well outside it all three fall off as
    (core / distance)^power. It is a field of accelerations: nothing but a `Wind` limits the speed, and what
    swirls is held on a circle only if inward provides its centripetal acceleration.

    Attributes:
        point: A point on the axis [m], shape (3,).
        axis: Unit vector, shape (3,).
        swirl: Right-hand about the axis [m/s^2], scalar.
        inward: Towards the axis [m/s^2], scalar; negative = outward.
        axial: Along the axis [m/s^2], scalar.
        core: Radius of the core [m], positive scalar.
        power: Power of the fall-off with distance, scalar; 0 = none.
        envelope: Time profile.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """

    point: jax.Array
    axis: jax.Array = dataclasses.field(metadata=UNIT)
    swirl: Scalar
    inward: Scalar
    axial: Scalar
    core: Scalar
    power: Scalar
    envelope: Envelope
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v, mass
        across, squared, falloff = self._locate(x, time, dt)
        turning = self.swirl * cross(jnp.broadcast_to(self.axis, across.shape), across) - self.inward * across
        field = turning / jnp.sqrt(squared)[:, None] + self.axial * self.axis
        return confine(falloff[:, None] * field, self.weight)

    def gradient(self, x, time, dt):
        """d acceleration / d x [1/s^2], shape (n, 3, 3)."""
        across, squared, falloff = self._locate(x, time, dt)
        projector = jnp.eye(3, dtype=x.dtype) - self.axis[:, None] * self.axis[None, :]
        turn = self.swirl * skew(self.axis) - self.inward * projector
        turning = (turn * across[:, None, :]).sum(-1)
        # d (r^-q) / dx = -q r^-(q + 2) d, with q = power + 1 for the turning part and power for the axial one.
        length = jnp.sqrt(squared)[:, None]
        slope = (self.power + 1) * turning / length + self.power * self.axial * self.axis
        tangent = turn / length[..., None] - slope[:, :, None] * (across / squared[:, None])[:, None, :]
        return confine(falloff[:, None, None] * tangent, self.weight)

    def _locate(self, x: jax.Array, time: jax.Array, dt: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
        """d, shape (n, 3), r^2, shape (n,), and (core / r)^power times the envelope, shape (n,)."""
        arm = x - self.point
        across = arm - (arm * self.axis).sum(-1, keepdims=True) * self.axis
        core = jnp.asarray(self.core, x.dtype)
        squared = (across**2).sum(-1) + core**2
        falloff = (core**2 / squared) ** (0.5 * self.power)
        return across, squared, falloff * self.envelope.mean(time, dt)
