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
        """Removes outward velocity components in the walls."""
        del time
        components = []
        for axis, index in enumerate(grid.node_indices()):
            component = velocity[..., axis]
            component = jnp.where(index < self.padding, jnp.maximum(component, 0), component)
            component = jnp.where(index > grid.cells - self.padding, jnp.minimum(component, 0), component)
            components.append(component)
        return jnp.stack(components, axis=-1)
