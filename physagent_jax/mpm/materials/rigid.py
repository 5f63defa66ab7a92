"""Matter that does not deform."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.fields import COUNT
from physagent_jax.mpm.materials.base import History


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Rigid:
    """No stress, no energy, no limit on the time step; a constraint (`mpm.constraints.RigidBody`) moves it.

    Attributes:
        particles: Particles in the block, static.
    """

    particles: int = dataclasses.field(metadata=COUNT)

    @property
    def count(self) -> int:
        """Particles in the block."""
        return self.particles

    def initial_history(self) -> History:
        """None."""
        return ()

    def energy(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Zero [J/m^3], shape (n,)."""
        return jnp.zeros(F.shape[0], F.dtype)

    def stress(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Zero [Pa], shape (n, 3, 3)."""
        return jnp.zeros_like(F)

    def stiffness(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Zero [Pa], shape (n,)."""
        return jnp.zeros(F.shape[0], F.dtype)

    def project(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History]:
        """F as it is: the constraint keeps it a rotation."""
        del dt
        return F, history
