"""A plane of symmetry on a layer of grid nodes: a frictionless wall to second order."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.protocols import Boundary
from physagent_jax.mpm.state import Grid


@register_dataclass
@dataclasses.dataclass(frozen=True)
class SymmetryPlane(Boundary):
    """A plane of symmetry: matter behind it is the mirror image of matter before it.

    A slip wall that only stops its nodes is accurate to first order: the layer of nodes behind it sees but the
    fringe of the matter, with the wrong mass and no mirrored motion. Here that layer's mass and momentum are folded
    onto its mirror layer, normal momentum negated, and its velocity is the mirror layer's, so that linear fields that
    obey the symmetry are reproduced exactly up to the plane. Bilateral: matter does not separate. It must begin at
    the plane and stay before it.

    Attributes:
        node: Domain index of the plane's layer of nodes along ``axis``, int32 scalar.
        axis: 0, 1 or 2, static.
        side: +1 if matter is at larger coordinates, -1 if at smaller ones, static.
    """

    node: jax.Array
    axis: int = dataclasses.field(metadata=dict(static=True))
    side: int = dataclasses.field(metadata=dict(static=True))

    def fold(self, nodes: jax.Array, grid: Grid) -> jax.Array:
        """Momentum and mass with the image's added, shape (nx, ny, nz, 4)."""
        layer = self._count_layers(grid)
        # Not every window reaches behind the plane; what would come round its other end is not an image.
        behind = jnp.where(layer == -1, nodes, 0) * self._make_flip(nodes.dtype, 4)
        image = jnp.roll(behind, 2 * self.side, self.axis)
        nodes = jnp.where(layer == -1, 0, nodes + image)
        return nodes.at[..., self.axis].set(jnp.where(layer[..., 0] == 0, 0, nodes[..., self.axis]))

    def unfold(self, nodes: jax.Array, grid: Grid) -> jax.Array:
        """Momentum and mass of the whole body at the plane and behind it, shape (nx, ny, nz, 4)."""
        layer = self._count_layers(grid)
        image = jnp.roll(nodes * self._make_flip(nodes.dtype, 4), -2 * self.side, self.axis)
        return jnp.where(layer == -1, image, jnp.where(layer == 0, 2 * nodes, nodes))

    def apply(self, velocity: jax.Array, grid: Grid, time: jax.Array) -> jax.Array:
        """No normal velocity on the plane, mirrored velocities behind it."""
        del time
        layer = self._count_layers(grid)
        image = jnp.roll(velocity * self._make_flip(velocity.dtype, 3), -2 * self.side, self.axis)
        velocity = jnp.where(layer == -1, image, velocity)
        return velocity.at[..., self.axis].set(jnp.where(layer[..., 0] == 0, 0, velocity[..., self.axis]))

    def _count_layers(self, grid) -> jax.Array:
        """Layers before the plane (0 on it, negative behind it), broadcastable to nodes and components."""
        return self.side * (grid.node_indices()[self.axis] - self.node)[..., None]

    def _make_flip(self, dtype, components: int) -> jax.Array:
        return jnp.ones(components, dtype).at[self.axis].set(-1)
