"""Body-force terms: what the skills compile to. Pytrees; every magnitude is a differentiable leaf.

All are accelerations, evaluated at the particles and accumulated on the grid by P2G, so that a region is
exact and the total force is that of the particles. Each implements `mpm.protocols.BodyForce`.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.mpm.linalg import cross, skew
from physagent_jax.mpm.protocols import window_fraction


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class UniformAcceleration:
    """One acceleration for every particle of a region: push, pull, wind and, within a brief window, a blow.

    Attributes:
        value: [m/s^2], shape (3,).
        start, end: Window [s], scalars.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """

    value: jax.Array
    start: jax.Array
    end: jax.Array
    weight: jax.Array | None = None

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v, mass
        value = self.value * window_fraction(time, dt, self.start, self.end)
        return jnp.broadcast_to(value, x.shape) if self.weight is None else self.weight[:, None] * value

    def gradient(self, x, time, dt):
        """None: uniform."""
        del x, time, dt


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Stretch:
    """Pulls the two sides of the mass centre's plane apart (or together, if negative).

    The field is k sgn((x - x_c) . axis) axis (paper, skill 2) less its rigid part: an object whose halves differ
    would otherwise drift and spin, which a stretch does not ask for. Its momentum and angular
    momentum stay unchanged. The pull grows linearly over ``ramp`` seconds, so that the object follows
    without ringing; it ends at once.

    Attributes:
        axis: Unit vector, shape (3,).
        magnitude: Acceleration on either side [m/s^2], scalar.
        start, end: Window [s], scalars.
        ramp: [s], scalar.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """

    axis: jax.Array
    magnitude: jax.Array
    start: jax.Array
    end: jax.Array
    ramp: jax.Array
    weight: jax.Array | None = None

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v
        mass = mass if self.weight is None else mass * self.weight
        growth = jnp.clip((time + 0.5 * dt - self.start) / self.ramp, 0.0, 1.0)
        strength = self.magnitude * growth * window_fraction(time, dt, self.start, self.end)
        arm = x - mass_centre(x, mass)
        side = jnp.sign((arm * self.axis).sum(-1))
        field = strength * without_rigid_part(side[:, None] * self.axis, arm, mass)
        return field if self.weight is None else self.weight[:, None] * field

    def gradient(self, x, time, dt):
        """None: uniform on either side, but for the small rigid part."""
        del x, time, dt


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Torque:
    """Turns the region about an axis through its present mass centre: axis x r (paper, skill 4).

    Attributes:
        axis: Unit vector (right-hand rule), shape (3,).
        magnitude: Angular acceleration of a rigid body [rad/s^2], scalar.
        start, end: Window [s], scalars.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """

    axis: jax.Array
    magnitude: jax.Array
    start: jax.Array
    end: jax.Array
    weight: jax.Array | None = None

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v
        mass = mass if self.weight is None else mass * self.weight
        strength = self.magnitude * window_fraction(time, dt, self.start, self.end)
        arm = x - mass_centre(x, mass)
        field = strength * cross(
            jnp.broadcast_to(self.axis, arm.shape), arm
        )  # the part along the axis drops out
        return field if self.weight is None else self.weight[:, None] * field

    def gradient(self, x, time, dt):
        """D acceleration / d x within the region [1/s^2], shape (n, 3, 3) or (3, 3)."""
        del x
        spin = self.magnitude * window_fraction(time, dt, self.start, self.end) * skew(self.axis)
        return spin if self.weight is None else self.weight[:, None, None] * spin


def mass_centre(x: jax.Array, mass: jax.Array) -> jax.Array:
    """Centre of mass [m], shape (3,)."""
    return (mass[:, None] * x).sum(0) / mass.sum()


def without_rigid_part(field: jax.Array, arm: jax.Array, mass: jax.Array) -> jax.Array:
    """Subtracts the rigid acceleration that ``field`` would give a rigid body of these particles.

    Args:
        field: Accelerations [m/s^2], shape (n, 3).
        arm: Positions relative to the mass centre [m], shape (n, 3).
        mass: [kg], shape (n,).

    Returns:
        A field of zero total force and zero total torque, shape (n, 3).
    """
    mean = (mass[:, None] * field).sum(0) / mass.sum()
    torque = (mass[:, None] * cross(arm, field)).sum(0)
    second_moment = jnp.einsum("n,ni,nj->ij", mass, arm, arm)
    trace = jnp.trace(second_moment)
    inertia = trace * jnp.eye(3, dtype=arm.dtype) - second_moment
    # All mass on one line has no inertia about it, and no torque either: the floor only avoids 0/0.
    inertia = inertia + (10 * jnp.finfo(arm.dtype).eps * trace) * jnp.eye(3, dtype=arm.dtype)
    angular = jnp.linalg.solve(inertia, torque)
    return field - mean - cross(jnp.broadcast_to(angular, arm.shape), arm)
