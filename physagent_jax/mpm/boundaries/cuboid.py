"""A box that moves and takes along the material inside it."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Cuboid:
    """Imposes ``velocity`` on the nodes inside a box, for start <= time < end.

    The box starts at ``point`` at time ``start`` and moves with ``velocity`` until ``end``
    (PhysGaussian's "cuboid", without its reset of the whole grid outside the window).

    Attributes:
        point: Centre at ``start`` [m], shape (3,).
        half_size: Half extents [m], shape (3,).
        velocity: [m/s], shape (3,).
        start, end: Window of activity [s], scalars.
    """

    point: jax.Array
    half_size: jax.Array
    velocity: jax.Array
    start: jax.Array
    end: jax.Array

    def apply(self, velocity: jax.Array, grid, time: jax.Array) -> jax.Array:
        """Overwrites the velocities inside the box."""
        center = self.point + self.velocity * (time - self.start)
        inside = (self.start <= time) & (time < self.end)
        for axis, position in enumerate(grid.node_positions(velocity.dtype)):
            inside = inside & (jnp.abs(position - center[axis]) <= self.half_size[axis])
        return jnp.where(inside[..., None], self.velocity, velocity)
