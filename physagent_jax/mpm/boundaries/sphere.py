"""A ball, or a spherical container."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.contact import Contact, collide, displace, is_active, is_touching, normalize
from physagent_jax.mpm.fields import END, START
from physagent_jax.mpm.protocols import Boundary
from physagent_jax.mpm.state import Grid


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Sphere(Boundary):
    """A solid ball, or the solid around a spherical hollow; active for start <= time < end.

    Attributes:
        point: Centre, at ``start`` if it moves [m], shape (3,).
        radius: [m], scalar.
        friction: Coulomb coefficient, scalar; used by SEPARATE.
        start, end: Window of activity [s], scalars.
        contact: Kind of contact, static.
        container: Whether matter is inside, and the solid outside, static.
        velocity: Velocity of the solid [m/s], shape (3,); None = at rest (skipped).
    """

    acts_on_points: ClassVar[bool] = True

    point: jax.Array
    radius: jax.Array
    friction: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    contact: Contact = dataclasses.field(default=Contact.SEPARATE, metadata=dict(static=True))
    container: bool = dataclasses.field(default=False, metadata=dict(static=True))
    velocity: jax.Array | None = None

    @property
    def thickness(self) -> float | None:
        """Its diameter [m]; None = a container."""
        return None if self.container else 2 * float(self.radius)

    def apply(self, velocity: jax.Array, grid: Grid, time: jax.Array) -> jax.Array:
        """Velocities after contact with the sphere."""
        x, y, z = grid.node_positions(velocity.dtype)
        p = displace(self.point, self.velocity, self.start, time)
        offset = jnp.stack(jnp.broadcast_arrays(x - p[0], y - p[1], z - p[2]), axis=-1)
        outwards = normalize(offset)
        distance = (offset * outwards).sum(-1) - self.radius
        if self.container:
            distance, outwards = -distance, -outwards
        inside = is_touching(distance, grid) & is_active(self.start, self.end, time)
        return collide(velocity, inside, outwards, self.contact, self.friction, self.velocity)
