"""A plane: sticky, slip, or separating with Coulomb friction."""

from __future__ import annotations

import dataclasses
import enum

import jax
import jax.numpy as jnp


class Contact(enum.Enum):
    """What happens to velocities inside the solid.

    STICKY: they vanish.
    SLIP: their normal part vanishes, whichever way it points (bilateral).
    SEPARATE: their normal part vanishes if it points inwards (unilateral); the tangential part then
        loses up to friction * |normal part| (Coulomb).
    """

    STICKY = "sticky"
    SLIP = "slip"
    SEPARATE = "separate"


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class HalfSpace:
    """The solid half-space behind a plane, active for start <= time < end.

    The friction law acts on grid velocities after the momentum update (Jiang et al. 2016, section 12.2): the
    normal velocity removed is the normal impulse per mass, and friction takes at most ``friction`` times
    that from the tangential velocity.

    Attributes:
        point: A point of the plane [m], shape (3,).
        normal: Unit normal out of the solid, shape (3,).
        friction: Coulomb coefficient, scalar; used by SEPARATE.
        start, end: Window of activity [s], scalars.
        contact: Kind of contact, static.
    """

    point: jax.Array
    normal: jax.Array
    friction: jax.Array
    start: jax.Array
    end: jax.Array
    contact: Contact = dataclasses.field(default=Contact.SEPARATE, metadata=dict(static=True))

    def apply(self, velocity: jax.Array, grid, time: jax.Array) -> jax.Array:
        """Projects the velocities of the nodes behind the plane."""
        x, y, z = grid.node_positions(velocity.dtype)
        n, p = self.normal, self.point
        depth = (x - p[0]) * n[0] + (y - p[1]) * n[1] + (z - p[2]) * n[2]
        # A node on the plane belongs to the solid; the tolerance absorbs round-off in its position.
        inside = (depth <= 1e-4 * grid.dx) & (self.start <= time) & (time < self.end)
        return jnp.where(inside[..., None], self._project(velocity), velocity)

    def _project(self, velocity: jax.Array) -> jax.Array:
        if self.contact is Contact.STICKY:
            return jnp.zeros_like(velocity)
        normal_speed = (velocity * self.normal).sum(-1, keepdims=True)
        tangential = velocity - normal_speed * self.normal
        if self.contact is Contact.SLIP:
            return tangential
        squared = (tangential**2).sum(-1, keepdims=True)
        moving = squared > 0
        speed = jnp.sqrt(jnp.where(moving, squared, 1.0))  # keeps the derivative finite at rest
        kept = jnp.maximum(1 + self.friction * normal_speed / speed, 0)  # normal_speed < 0 on contact
        return jnp.where(normal_speed < 0, jnp.where(moving, tangential * kept, 0.0), velocity)
