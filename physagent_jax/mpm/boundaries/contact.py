"""The contact law that all obstacles share.

A node is in contact or it is not. So what a moving obstacle does is a function of its place with small steps, one for
each node that it reaches, and its derivative leaves the steps out: it is exact at a point (to 1e-6 of a speed), and
about half of the slope over 0.1 m/s for a ball that pushes a block (docs/limits.md). Searches over an obstacle's
speed, place or size should take differences over a fraction of a cell, or methods without gradients.
"""

from __future__ import annotations

import dataclasses
import enum

import jax
import jax.numpy as jnp

from physagent_jax.mpm.state import Grid

TOUCH = 1e-4  # in cells: a node this close is in contact, whatever round-off does to its position


class Contact(enum.Enum):
    """The treatment of velocities, relative to the obstacle, inside the solid.

    STICKY: they vanish.
    SLIP: their normal part vanishes, whichever way it points (bilateral).
    SEPARATE: their normal part vanishes if it points inwards (unilateral); the tangential part then
        loses up to friction * |normal part| (Coulomb).
    """

    STICKY = "sticky"
    SLIP = "slip"
    SEPARATE = "separate"


@dataclasses.dataclass(frozen=True)
class Points:
    """Scattered places that a boundary takes as it takes the nodes of a grid.

    Attributes:
        x: Places [m], shape (k, 3).
        touch: Distance from a surface within which they are in contact [m].
        grid: The grid in whose domain they are.
    """

    x: jax.Array
    touch: float
    grid: Grid

    @property
    def shape(self) -> tuple[int, int, int]:
        """As of a grid: (k, 1, 1)."""
        return (len(self.x), 1, 1)

    def node_positions(self, dtype) -> tuple[jax.Array, jax.Array, jax.Array]:
        """Coordinates [m], each of shape (k, 1, 1)."""
        x, y, z = (each.astype(dtype).reshape(self.shape) for each in self.x.T)
        return x, y, z


def collide(
    velocity: jax.Array,
    inside: jax.Array,
    normal: jax.Array,
    contact: Contact,
    friction: jax.Array,
    obstacle_velocity: jax.Array | None,
) -> jax.Array:
    """Grid velocities after contact.

    The law acts after the momentum update (Jiang et al. 2016, section 12.2), in the frame of the obstacle:
    the normal velocity removed is the normal impulse per mass, and friction takes at most ``friction`` times
    that from the tangential velocity.

    Args:
        velocity: Node velocities [m/s], shape (nx, ny, nz, 3).
        inside: Nodes in contact, shape (nx, ny, nz).
        normal: Unit normals out of the solid, shape (3,) or (nx, ny, nz, 3).
        contact: Kind of contact.
        friction: Coulomb coefficient, scalar; used by SEPARATE.
        obstacle_velocity: Obstacle velocity of the solid at the nodes [m/s], shape (3,) or (nx, ny, nz, 3);
            None = at rest.

    Returns:
        Velocities [m/s], shape (nx, ny, nz, 3); those outside are untouched.
    """
    relative = velocity if obstacle_velocity is None else velocity - obstacle_velocity
    projected = _project(relative, normal, contact, friction)
    if obstacle_velocity is not None:
        projected = projected + obstacle_velocity
    return jnp.where(inside[..., None], projected, velocity)


def _project(velocity: jax.Array, normal: jax.Array, contact: Contact, friction: jax.Array) -> jax.Array:
    if contact is Contact.STICKY:
        return jnp.zeros_like(velocity)
    normal_speed = (velocity * normal).sum(-1, keepdims=True)
    tangential = velocity - normal_speed * normal
    if contact is Contact.SLIP:
        return tangential
    squared = (tangential**2).sum(-1, keepdims=True)
    moving = squared > 0
    speed = jnp.sqrt(jnp.where(moving, squared, 1.0))  # keeps the derivative finite at rest
    kept = jnp.maximum(1 + friction * normal_speed / speed, 0)  # normal_speed < 0 on contact
    return jnp.where(normal_speed < 0, jnp.where(moving, tangential * kept, 0.0), velocity)


def is_touching(distance: jax.Array, places: Grid | Points) -> jax.Array:
    """Return whether places at a signed ``distance`` [m] from the surface (negative inside) belong to the solid."""
    return distance <= (places.touch if isinstance(places, Points) else TOUCH * places.dx)


def is_active(start: jax.Array, end: jax.Array, time: jax.Array) -> jax.Array:
    """Return whether start <= time < end."""
    return (start <= time) & (time < end)


def displace(point: jax.Array, velocity: jax.Array | None, start: jax.Array, time: jax.Array) -> jax.Array:
    """The position of an obstacle's ``point`` [m] at ``time`` [s], if it left at ``start``; shape (3,)."""
    return point if velocity is None else point + velocity * (time - start)


def normalize(vector: jax.Array) -> jax.Array:
    """Normalised vectors, shape (..., 3); zero ones stay zero, with a zero derivative."""
    squared = (vector**2).sum(-1, keepdims=True)
    some = squared > 0
    return jnp.where(some, vector / jnp.sqrt(jnp.where(some, squared, 1.0)), 0.0)
