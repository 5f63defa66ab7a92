"""The rigid part of a body force: its effect on an object as a whole."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.mpm.linalg import cross
from physagent_jax.mpm.reductions import sum_particles


def mass_centre(x: jax.Array, mass: jax.Array) -> jax.Array:
    """Centre of mass [m], shape (3,)."""
    return sum_particles((mass[:, None] * x).sum(0)) / sum_particles(mass.sum())


def remove_rigid_part(field: jax.Array, arm: jax.Array, mass: jax.Array) -> jax.Array:
    """Subtract the rigid acceleration that ``field`` would give a rigid body of these particles.

    Args:
        field: Accelerations [m/s^2], shape (n, 3).
        arm: Positions relative to the mass centre [m], shape (n, 3).
        mass: [kg], shape (n,).

    Returns:
        A field of zero total force and zero total torque, shape (n, 3).
    """
    mean = sum_particles((mass[:, None] * field).sum(0)) / sum_particles(mass.sum())
    torque = sum_particles((mass[:, None] * cross(arm, field)).sum(0))
    second_moment = sum_particles(jnp.einsum("n,ni,nj->ij", mass, arm, arm))
    trace = jnp.trace(second_moment)
    inertia = trace * jnp.eye(3, dtype=arm.dtype) - second_moment
    # All mass on one line has no inertia about it, and no torque either: the floor only avoids 0/0.
    inertia = inertia + (10 * jnp.finfo(arm.dtype).eps * trace) * jnp.eye(3, dtype=arm.dtype)
    angular = jnp.linalg.solve(inertia, torque)
    return field - mean - cross(jnp.broadcast_to(angular, arm.shape), arm)
