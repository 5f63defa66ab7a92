"""The same acceleration for all particles of a region."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.envelope import Envelope
from physagent_jax.forces.regions import confine
from physagent_jax.mpm.edges import window_fraction
from physagent_jax.mpm.fields import EDGE, END, PER_PARTICLE, START


@register_dataclass
@dataclasses.dataclass(frozen=True)
class UniformAcceleration:
    """One acceleration for every particle of a region: push, pull, wind and, within a brief window, a blow.

    Attributes:
        value: [m/s^2], shape (3,).
        start, end: Window [s], scalars.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    value: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v, mass
        value = self.value * window_fraction(time, dt, self.start, self.end, self.edge)
        return jnp.broadcast_to(value, x.shape) if self.weight is None else self.weight[:, None] * value

    def gradient(self, x, time, dt):
        """None: uniform."""
        del x, time, dt


@register_dataclass
@dataclasses.dataclass(frozen=True)
class UniformField:
    """One acceleration for every particle of a region, with a time profile.

    `UniformAcceleration` is the same with a constant envelope; the skills use it.

    Attributes:
        value: Where the envelope is 1 [m/s^2], shape (3,).
        envelope: Time profile.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """

    value: jax.Array
    envelope: Envelope
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v, mass
        return confine(jnp.broadcast_to(self.value * self.envelope.mean(time, dt), x.shape), self.weight)

    def gradient(self, x, time, dt):
        """None: uniform."""
        del x, time, dt
