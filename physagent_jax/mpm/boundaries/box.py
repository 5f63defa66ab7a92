"""An axis-aligned solid box, or a box-shaped container."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.contact import Contact, collide, displace, is_active, is_touching
from physagent_jax.mpm.fields import END, START
from physagent_jax.mpm.protocols import Boundary
from physagent_jax.mpm.state import Grid


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Box(Boundary):
    """A solid box, or the solid around a box-shaped hollow; active for start <= time < end.

    Inside the solid box the normal is that of the nearest face. A container acts with each of its six walls
    in turn, so that its corners are tight.

    Attributes:
        point: Centre, at ``start`` if it moves [m], shape (3,).
        half_size: Half extents [m], shape (3,).
        friction: Coulomb coefficient, scalar; used by SEPARATE.
        start, end: Window of activity [s], scalars.
        contact: Kind of contact, static.
        container: Whether matter is inside, and the solid outside, static.
        velocity: Velocity of the solid [m/s], shape (3,); None = at rest (skipped).
    """

    acts_on_points: ClassVar[bool] = True

    point: jax.Array
    half_size: jax.Array
    friction: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    contact: Contact = dataclasses.field(default=Contact.SEPARATE, metadata=dict(static=True))
    container: bool = dataclasses.field(default=False, metadata=dict(static=True))
    velocity: jax.Array | None = None

    @property
    def thickness(self) -> float | None:
        """Its shortest side [m]; None = a container."""
        return None if self.container else 2 * float(np.min(self.half_size))

    def apply(self, velocity: jax.Array, grid: Grid, time: jax.Array) -> jax.Array:
        """Velocities after contact with the box."""
        point = displace(self.point, self.velocity, self.start, time)
        active = is_active(self.start, self.end, time)
        offsets = _measure_offsets(grid, velocity.dtype, point)
        beyond = [jnp.abs(offset) - self.half_size[axis] for axis, offset in enumerate(offsets)]
        if not self.container:
            inside = is_touching(_join_faces(beyond), grid) & active
            normal = _find_nearest_face(offsets, beyond)
            return collide(velocity, inside, normal, self.contact, self.friction, self.velocity)
        for axis, (offset, distance) in enumerate(zip(offsets, beyond)):
            wall = jnp.zeros((*offset.shape, 3), velocity.dtype).at[..., axis].set(-_take_sign(offset))
            inside = jnp.broadcast_to(is_touching(-distance, grid) & active, velocity.shape[:-1])
            velocity = collide(velocity, inside, wall, self.contact, self.friction, self.velocity)
        return velocity


def _measure_offsets(grid, dtype, point: jax.Array) -> list[jax.Array]:
    return [x - point[axis] for axis, x in enumerate(grid.node_positions(dtype))]


def _join_faces(beyond: list[jax.Array]) -> jax.Array:
    """Signed distance in the maximum norm: exact inside and on the faces, and of the right sign outside."""
    return jnp.maximum(jnp.maximum(beyond[0], beyond[1]), beyond[2])


def _find_nearest_face(offsets: list[jax.Array], beyond: list[jax.Array]) -> jax.Array:
    first = (beyond[0] >= beyond[1]) & (beyond[0] >= beyond[2])
    second = ~first & (beyond[1] >= beyond[2])
    faces = first, second, ~first & ~second
    return jnp.stack(
        [jnp.where(face, _take_sign(offset), 0.0) for face, offset in zip(faces, offsets)], axis=-1
    )


def _take_sign(offset: jax.Array) -> jax.Array:
    """+1 or -1: the box's own centre planes belong to the upper half."""
    return jnp.where(offset >= 0, jnp.ones_like(offset), -jnp.ones_like(offset))
