"""A point that attracts or repels."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.envelope import Envelope, Scalar
from physagent_jax.forces.regions import confine
from physagent_jax.mpm.fields import PER_PARTICLE


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Attractor:
    """Pulls towards a point: a = -strength d / r^(power + 1), with d = x - point and r^2 = d^2 + softening^2.

    A positive strength attracts, a negative one repels (some simulators count the other way). Lengths are
    in metres: 1 m away the acceleration is ``strength``, softening aside. Power 2 is gravity, with
    strength = G M; power 0 pulls equally everywhere, power -1 is a spring. The pull vanishes at the point itself,
    and is largest near a distance of ``softening``, which should not be less than a grid cell.

    Attributes:
        point: [m], shape (3,).
        strength: Acceleration at a distance of 1 m [m/s^2], scalar.
        power: Power of the fall-off with distance, scalar.
        softening: [m], scalar.
        envelope: Time profile.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """

    point: jax.Array
    strength: Scalar
    power: Scalar
    softening: Scalar
    envelope: Envelope
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v, mass
        arm, squared = self._find_arm(x)
        pull = self.strength * self.envelope.mean(time, dt) * squared ** (-0.5 * (self.power + 1))
        return confine(-pull[:, None] * arm, self.weight)

    def gradient(self, x, time, dt):
        """d acceleration / d x [1/s^2], shape (n, 3, 3)."""
        arm, squared = self._find_arm(x)
        pull = self.strength * self.envelope.mean(time, dt) * squared ** (-0.5 * (self.power + 1))
        steepness = ((self.power + 1) / squared)[:, None, None]
        tangent = jnp.eye(3, dtype=x.dtype) - steepness * arm[:, :, None] * arm[:, None, :]
        return confine(-pull[:, None, None] * tangent, self.weight)

    def potential(self, x: jax.Array) -> jax.Array:
        """Potential energy per unit mass [m^2/s^2], shape (n,), 0 where r = 1 m: acceleration = -grad potential.

        It is that of an envelope of 1, everywhere: neither the envelope nor the region enters.
        """
        _, squared = self._find_arm(x)
        # (r^q - 1) / q with q = 1 - power is log r at q = 0.
        logarithm = 0.5 * jnp.log(squared)
        q = jnp.asarray(1.0 - self.power, x.dtype)
        exponent = jnp.where(q == 0, 1.0, q)
        return self.strength * jnp.where(q == 0, logarithm, jnp.expm1(exponent * logarithm) / exponent)

    def _find_arm(self, x: jax.Array) -> tuple[jax.Array, jax.Array]:
        """d, shape (n, 3), and r^2, shape (n,)."""
        arm = x - self.point
        squared = (arm**2).sum(-1) + jnp.asarray(self.softening, x.dtype) ** 2
        # Only a particle at an unsoftened point has r = 0; d = 0 already makes its acceleration 0.
        return arm, jnp.where(squared > 0, squared, 1.0)
