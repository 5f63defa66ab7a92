"""A plate that moves into the material: one jaw of a press."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.half_space import HalfSpace
from physagent_jax.mpm.protocols import Constraint
from physagent_jax.mpm.state import Model
from physagent_jax.mpm.transfer import Stencil


@register_dataclass
@dataclasses.dataclass(frozen=True)
class MovingPlate(Constraint):
    """Contact with a moving half-space that comes and goes with a force field.

    The same contact as a boundary of the scene; as a constraint it is one of a force field's entries.

    Attributes:
        face: The plate: the solid half-space behind it, when it acts, and how it moves.
    """

    face: HalfSpace

    def on_grid(
        self,
        model: Model,
        free: jax.Array,
        velocity: jax.Array,
        node_mass: jax.Array,
        s: Stencil,
        time: jax.Array,
    ) -> jax.Array:
        """Node velocities after contact with the plate [m/s], shape (nx, ny, nz, 3)."""
        del free, node_mass, s
        return self.face.apply(velocity, model.grid, time)

    def prescribe(self, model: Model, x: jax.Array) -> jax.Array:
        """The plate's velocity, as if it moved all [m/s]."""
        del model
        return (
            jnp.zeros_like(x) if self.face.velocity is None else jnp.broadcast_to(self.face.velocity, x.shape)
        )
