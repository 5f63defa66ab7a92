"""A plate that moves into the material: one jaw of a press, or a stamp that is smaller than the object."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.contact import displace
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
        edges: Two vectors across the normal, each over the square of its length: (x - point) @ edges lies within
            [-1, 1] on the plate [1/m], shape (2, 3); None = it has no edges.
        depth: Thickness of a plate with edges [m], scalar.
    """

    face: HalfSpace
    edges: jax.Array | None = None
    depth: jax.Array | None = None

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
        met = self.face.apply(velocity, model.grid, time)
        if self.edges is None or self.depth is None:
            return met
        point = displace(self.face.point, self.face.velocity, self.face.start, time)
        arm = jnp.stack(jnp.broadcast_arrays(*model.grid.node_positions(velocity.dtype)), axis=-1) - point
        inside = (jnp.abs(arm @ self.edges.T) <= 1).all(-1) & (arm @ self.face.normal >= -self.depth)
        return jnp.where(inside[..., None], met, velocity)

    def prescribe(self, model: Model, x: jax.Array) -> jax.Array:
        """The plate's velocity, as if it moved all [m/s]."""
        del model
        return (
            jnp.zeros_like(x) if self.face.velocity is None else jnp.broadcast_to(self.face.velocity, x.shape)
        )
