"""Motions that grow evenly from one end of the matter to the other: a stretch, a squeeze, a twist."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.edges import window_value
from physagent_jax.mpm.fields import EDGE, END, START, UNIT
from physagent_jax.mpm.linalg import cross
from physagent_jax.mpm.protocols import Constraint
from physagent_jax.mpm.reductions import find_mass_centre
from physagent_jax.mpm.state import Model
from physagent_jax.mpm.transfer import Stencil


@register_dataclass
@dataclasses.dataclass(frozen=True, kw_only=True)
class _Graded(Constraint):
    """A velocity of all nodes along some directions, during a window; the others stay free.

    Attributes:
        axis: The line along which the motion grows, unit vector, shape (3,).
        start, end: Active for start <= time < end [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    axis: jax.Array = dataclasses.field(metadata=UNIT)
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def find_change(
        self, nodes: jax.Array, velocity: jax.Array, centre: jax.Array, time: jax.Array, mass: jax.Array
    ) -> jax.Array:
        """The change to the wanted velocities [m/s], shape (..., 3), at nodes [m] with masses [kg]."""
        raise NotImplementedError

    def on_grid(
        self,
        model: Model,
        free: jax.Array,
        velocity: jax.Array,
        node_mass: jax.Array,
        s: Stencil,
        time: jax.Array,
    ) -> jax.Array:
        """Impose the motion on every node; particles take it from there exactly, since it is linear in the place."""
        del free
        place = model.grid.place_nodes(velocity.dtype)
        centre = find_mass_centre(s.place_particles(model.grid), model.mass, model.axis)
        change = self.find_change(place, velocity, centre, time, node_mass)
        if self.edge is None:
            share = ((self.start <= time) & (time < self.end)).astype(velocity.dtype)
        else:
            share = window_value(time, self.start, self.end, self.edge)
        return velocity + share * change

    def prescribe(self, model: Model, x: jax.Array) -> jax.Array:
        """The motion as it begins, along its directions [m/s]."""
        centre = find_mass_centre(x, model.mass, model.axis)
        return self.find_change(x, jnp.zeros_like(x), centre, self.start, model.mass)


@register_dataclass
@dataclasses.dataclass(frozen=True, kw_only=True)
class GradedTranslation(_Graded):
    """Even change of length along an axis: u . axis = speed (d - d_0) / (length + speed (t - start)).

    d_0 is the middle of mass, or the fixed end. Across the axis matter is free: it gets thinner or thicker as its
    Poisson's ratio has it, and a thin neck stretches as much as what is thick.

    Attributes:
        speed: Rate at which the length grows [m/s], scalar; 0 = it is held.
        length: At ``start`` [m], scalar.
        point: Place that stays [m], shape (3,); None = the present mass centre.
        limits: Whether it only limits how fast the matter grows, evenly, static: it may grow more slowly, or
            not at all. A limit of each node's own velocity would hold down what trembles.
    """

    speed: jax.Array
    length: jax.Array
    point: jax.Array | None = None
    limits: bool = dataclasses.field(default=False, metadata=dict(static=True))

    def find_change(self, nodes, velocity, centre, time, mass):
        """The change of the component along the axis."""
        fixed = centre if self.point is None else self.point
        elapsed = jnp.clip(time - self.start, 0.0, self.end - self.start)
        rate = self.speed / jnp.maximum(self.length + self.speed * elapsed, 0.02 * self.length)
        arm, along = (nodes - fixed) @ self.axis, velocity @ self.axis
        if self.limits:
            growth = (mass * arm * along).sum() / jnp.maximum(
                (mass * arm**2).sum(), jnp.finfo(along.dtype).tiny
            )
            rate = jnp.minimum(rate, growth)
        return (rate * arm - along)[..., None] * self.axis


@register_dataclass
@dataclasses.dataclass(frozen=True, kw_only=True)
class GradedRotation(_Graded):
    """Even twist about an axis: angular velocity rate (d - d_0) / (length / 2), d_0 the middle of mass.

    Where one end is fixed it is rate (d - d_0) / length from there. Along the axis matter is free, as what is wrung
    gets shorter.

    Attributes:
        rate: Angular velocity of the end in the axis's direction [rad/s], scalar; that of the other end is opposed.
        length: [m], scalar.
        offset: Place of the axis of turning at the ends, minus the mass centre or ``point`` [m], shape (2, 3): the end
            against the axis's direction first, or the fixed one.
        point: Place at the end that stays [m], shape (3,); None = the middle of mass does.
    """

    rate: jax.Array
    length: jax.Array
    offset: jax.Array
    point: jax.Array | None = None

    def find_change(self, nodes, velocity, centre, time, mass):
        """The change of the components across the axis."""
        del time, mass
        arm = nodes - (centre if self.point is None else self.point)
        reach = 0.5 * self.length if self.point is None else self.length
        share = (arm @ self.axis / reach)[..., None]
        there = 0.5 * (1 + share) if self.point is None else jnp.abs(share)
        middle = (1 - there) * self.offset[0] + there * self.offset[1]
        wanted = self.rate * share * cross(jnp.broadcast_to(self.axis, arm.shape), arm - middle)
        change = wanted - velocity
        return change - (change @ self.axis)[..., None] * self.axis
