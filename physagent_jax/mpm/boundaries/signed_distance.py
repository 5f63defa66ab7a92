"""An obstacle of any shape, given by its signed distance on a regular grid."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.contact import Contact, collide, displace, is_active, is_touching, normalize
from physagent_jax.mpm.fields import END, START
from physagent_jax.mpm.protocols import Boundary
from physagent_jax.mpm.state import Grid


@register_dataclass
@dataclasses.dataclass(frozen=True)
class SignedDistance(Boundary):
    """The solid where phi <= 0; active for start <= time < end.

    Between samples phi is trilinear, and the normal is the normalised central difference of that interpolant
    over one spacing either way: continuous, and of second order also where nodes and samples coincide.
    Beyond the samples the nearest ones count, so a body should be sampled with a margin.

    Attributes:
        values: phi, negative inside the solid [m], shape (a, b, c), at least two a side.
        origin: Position of values[0, 0, 0], at ``start`` if it moves [m], shape (3,).
        friction: Coulomb coefficient, scalar; used by SEPARATE.
        start, end: Window of activity [s], scalars.
        spacing: Distance between samples [m], static.
        contact: Kind of contact, static.
        velocity: Velocity of the solid, which does not turn [m/s], shape (3,); None = at rest (skipped).
        thickness: Least thickness of its walls [m], for the warning of thin obstacles, static; None = not known.
    """

    values: jax.Array
    origin: jax.Array
    friction: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    spacing: float = dataclasses.field(metadata=dict(static=True))
    contact: Contact = dataclasses.field(default=Contact.SEPARATE, metadata=dict(static=True))
    velocity: jax.Array | None = None
    thickness: float | None = dataclasses.field(default=None, metadata=dict(static=True))

    def apply(self, velocity: jax.Array, grid: Grid, time: jax.Array) -> jax.Array:
        """Velocities after contact with the solid."""
        distance, normal = self.distance_and_normal(grid.node_positions(velocity.dtype), time)
        inside = is_touching(distance, grid) & is_active(self.start, self.end, time)
        return collide(velocity, inside, normal, self.contact, self.friction, self.velocity)

    def distance_and_normal(
        self, positions: tuple[jax.Array, jax.Array, jax.Array], time: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """Distances phi [m], shape (nx, ny, nz), and unit normals, shape (nx, ny, nz, 3), at the nodes of a grid.

        Args:
            positions: Coordinates along the axes [m], each of one axis's length (`Grid.node_positions`).
            time: [s].
        """
        origin = displace(self.origin, self.velocity, self.start, time)
        gradient = jnp.gradient(self.values, self.spacing)
        fields = jnp.stack([self.values, *gradient], axis=-1)
        # The nodes form a grid along the same axes, so the interpolation is one lerp per axis, not eight gathers.
        for axis, coordinate in enumerate(positions):
            fields = _interpolate(fields, (coordinate.ravel() - origin[axis]) / self.spacing, axis)
        return fields[..., 0], normalize(fields[..., 1:])


def _interpolate(fields: jax.Array, at: jax.Array, axis: int) -> jax.Array:
    """Linear interpolation along one axis at fractional indices ``at``."""
    last = fields.shape[axis] - 1
    at = jnp.clip(at, 0, last)
    low = jnp.clip(jnp.floor(at).astype(jnp.int32), 0, last - 1)
    shape = [1] * fields.ndim
    shape[axis] = -1
    share = (at - low).reshape(shape)
    below, above = (jnp.take(fields, i, axis=axis, mode="clip") for i in (low, low + 1))
    return below + share * (above - below)
