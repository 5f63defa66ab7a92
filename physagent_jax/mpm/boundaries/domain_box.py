"""The walls of the domain."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.protocols import Boundary
from physagent_jax.mpm.state import Grid


@register_dataclass
@dataclasses.dataclass(frozen=True)
class DomainBox(Boundary):
    """Separating, frictionless walls: within ``padding`` cells of a face, no velocity towards it.

    Attributes:
        padding: Thickness of the walls in cells, static.
    """

    padding: int = dataclasses.field(default=3, metadata=dict(static=True))

    def apply(self, velocity: jax.Array, grid: Grid, time: jax.Array) -> jax.Array:
        """Remove outward velocity components in the walls."""
        del time
        x, y, z = (index[..., None] for index in grid.node_indices())
        axes = jnp.arange(3)
        index = jnp.where(axes == 0, x, jnp.where(axes == 1, y, z))  # along the axis of each component
        outward = (index < self.padding) & (velocity < 0) | (index > grid.cells - self.padding) & (
            velocity > 0
        )
        return jnp.where(outward, 0, velocity)
