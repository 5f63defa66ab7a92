"""A plane with the solid behind it."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.contact import Contact, collide, displace, is_active, is_touching
from physagent_jax.mpm.edges import window_value
from physagent_jax.mpm.fields import EDGE, END, START
from physagent_jax.mpm.protocols import Boundary
from physagent_jax.mpm.state import Grid


@register_dataclass
@dataclasses.dataclass(frozen=True)
class HalfSpace(Boundary):
    """The solid half-space behind a plane, active for start <= time < end.

    Attributes:
        point: A point of the plane, at ``start`` if it moves [m], shape (3,).
        normal: Unit normal out of the solid, shape (3,).
        friction: Coulomb coefficient, scalar; used by SEPARATE.
        start, end: Window of activity [s], scalars.
        contact: Kind of contact, static.
        velocity: Velocity of the solid [m/s], shape (3,); None = at rest (skipped).
        edge: Width of the window's smooth edges [s], scalar: contact then comes and goes by shares; None = hard.
    """

    acts_on_points: ClassVar[bool] = True

    point: jax.Array
    normal: jax.Array
    friction: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    contact: Contact = dataclasses.field(default=Contact.SEPARATE, metadata=dict(static=True))
    velocity: jax.Array | None = None
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def apply(self, velocity: jax.Array, grid: Grid, time: jax.Array) -> jax.Array:
        """Velocities after contact with what lies behind the plane."""
        x, y, z = grid.node_positions(velocity.dtype)
        n, p = self.normal, displace(self.point, self.velocity, self.start, time)
        distance = (x - p[0]) * n[0] + (y - p[1]) * n[1] + (z - p[2]) * n[2]
        inside = is_touching(distance, grid)
        if self.edge is None:
            inside = inside & is_active(self.start, self.end, time)
            return collide(velocity, inside, n, self.contact, self.friction, self.velocity)
        share = window_value(time, self.start, self.end, self.edge)
        met = collide(velocity, inside, n, self.contact, self.friction, self.velocity)
        return velocity + share * (met - velocity)
