"""Particles whose motion is prescribed: held fixed, translated, or turned about an axis."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.mpm.linalg import cross, skew
from physagent_jax.mpm.state import Grid, State
from physagent_jax.mpm.transfer import Stencil, scatter_mass


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class PrescribedMotion:
    """A rigid velocity field u(x) = velocity + angular_velocity x (x - center) for some particles.

    It acts three times in a step: on the particles before P2G, on the grid nodes that carry mostly their
    mass (otherwise the free neighbours would drag the shared nodes along, and the clamp would be soft),
    and on the particles after G2P, so that they follow the prescribed path exactly.

    Attributes:
        particles: Indices, int32, shape (k,).
        velocity: [m/s], shape (3,).
        angular_velocity: [rad/s], shape (3,).
        center: A point of the axis [m], shape (3,).
        start, end: Active for start <= time < end [s], scalars.
    """

    particles: jax.Array
    velocity: jax.Array
    angular_velocity: jax.Array
    center: jax.Array
    start: jax.Array
    end: jax.Array

    @staticmethod
    def fixed(particles: jax.Array, dtype=jnp.float32) -> PrescribedMotion:
        """Holds ``particles`` where they are, for ever."""
        zero, forever = jnp.zeros(3, dtype), jnp.asarray(jnp.inf, dtype)
        return PrescribedMotion(particles, zero, zero, zero, jnp.zeros((), dtype), forever)

    def active(self, time: jax.Array) -> jax.Array:
        """Whether the constraint acts at ``time`` [s]."""
        return (self.start <= time) & (time < self.end)

    def field(self, x: jax.Array) -> jax.Array:
        """u(x) [m/s], shape (..., 3)."""
        return self.velocity + cross(jnp.broadcast_to(self.angular_velocity, x.shape), x - self.center)

    def displaced(self, x: jax.Array, dt: jax.Array) -> jax.Array:
        """Positions after ``dt`` [s]: an exact rotation about the axis and a translation."""
        return self.center + rotate(x - self.center, self.angular_velocity * dt) + self.velocity * dt


def before_p2g(constraints, state: State) -> State:
    """Gives the constrained particles their velocity and velocity gradient."""
    v, C = state.v, state.C
    for c in constraints:
        active, p = c.active(state.time), c.particles
        v = v.at[p].set(jnp.where(active, c.field(state.x[p]), v[p]))
        C = C.at[p].set(jnp.where(active, skew(c.angular_velocity), C[p]))
    return dataclasses.replace(state, v=v, C=C)


def on_grid(
    constraints,
    velocity: jax.Array,
    node_mass: jax.Array,
    s: Stencil,
    grid: Grid,
    mass: jax.Array,
    time: jax.Array,
) -> jax.Array:
    """Imposes u on the nodes more than half of whose mass is constrained."""
    x, y, z = grid.node_positions(velocity.dtype)
    nodes = jnp.stack(jnp.broadcast_arrays(x, y, z), axis=-1)
    for c in constraints:
        own = s.take(c.particles)
        share = scatter_mass(own, grid, mass[c.particles])
        held = c.active(time) & (share > 0.5 * node_mass)
        velocity = jnp.where(held[..., None], c.field(nodes), velocity)
    return velocity


def after_g2p(constraints, before: State, after: State, dt: jax.Array) -> State:
    """Puts the constrained particles exactly where the prescription has them."""
    x, v = after.x, after.v
    for c in constraints:
        active, p = c.active(before.time), c.particles
        target = c.displaced(before.x[p], dt)
        x = x.at[p].set(jnp.where(active, target, x[p]))
        v = v.at[p].set(jnp.where(active, c.field(target), v[p]))
    return dataclasses.replace(after, x=x, v=v)


def rotate(x: jax.Array, rotation_vector: jax.Array) -> jax.Array:
    """Rotates ``x`` (..., 3) by a rotation vector [rad], shape (3,) (Rodrigues' formula)."""
    squared = (rotation_vector**2).sum()
    turning = squared > 0
    angle = jnp.sqrt(jnp.where(turning, squared, 1.0))  # keeps the derivative finite at zero
    axis = rotation_vector / angle
    along = (x * axis).sum(-1, keepdims=True) * axis
    turned = along + (x - along) * jnp.cos(angle) + cross(jnp.broadcast_to(axis, x.shape), x) * jnp.sin(angle)
    return jnp.where(turning, turned, x)
