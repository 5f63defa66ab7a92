"""The walls of the domain."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.contact import Points, is_touching
from physagent_jax.mpm.protocols import Boundary
from physagent_jax.mpm.state import Grid


@register_dataclass
@dataclasses.dataclass(frozen=True)
class DomainBox(Boundary):
    """Separating, frictionless walls: within ``padding`` cells of a face, no velocity towards it.

    Attributes:
        padding: Thickness of the walls in cells, static.
    """

    acts_on_points: ClassVar[bool] = True

    padding: int = dataclasses.field(default=3, metadata=dict(static=True))

    def apply(self, velocity: jax.Array, grid: Grid | Points, time: jax.Array) -> jax.Array:
        """Remove outward velocity components in the walls."""
        del time
        if isinstance(grid, Points):
            x, domain = grid.x.reshape(velocity.shape), grid.grid
            low = is_touching(x - self.padding * domain.dx, grid)
            high = is_touching((domain.cells - self.padding) * domain.dx - x, grid)
        else:
            x, y, z = (index[..., None] for index in grid.node_indices())
            axes = jnp.arange(3)
            index = jnp.where(axes == 0, x, jnp.where(axes == 1, y, z))  # along the axis of each component
            low, high = index < self.padding, index > grid.cells - self.padding
        return jnp.where(low & (velocity < 0) | high & (velocity > 0), 0, velocity)
