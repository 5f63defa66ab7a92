"""The rigid part of a body force: its effect on an object as a whole."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.mpm.linalg import cofactor, cross, determinant, matvec
from physagent_jax.mpm.reductions import sum_particles

ROUND = 1e-4  # share of the mean squared extent added to the inertia: all mass on a line has none about it


def mass_centre(x: jax.Array, mass: jax.Array) -> jax.Array:
    """Centre of mass [m], shape (3,)."""
    return sum_particles((mass[:, None] * x).sum(0)) / sum_particles(mass.sum())


def find_turn(moment: jax.Array, r: jax.Array, mass: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Turn a rigid body by a moment.

    Args:
        moment: Moment over the body's mass [m^2/s^2], shape (3,).
        r: Positions relative to the mass centre [m], shape (n, 3).
        mass: [kg], shape (n,).

    Returns:
        Angular acceleration [rad/s^2], shape (3,), and the mean squared distance from the centre [m^2].
    """
    tiny = jnp.finfo(r.dtype).tiny
    second = sum_particles((mass[:, None] * r).T @ r) / sum_particles(mass.sum())
    spread = jnp.trace(second)
    inertia = (spread * (1 + ROUND) + tiny) * jnp.eye(3, dtype=r.dtype) - second
    return matvec(cofactor(inertia), moment) / jnp.maximum(determinant(inertia), tiny), spread  # symmetric


def limit(vector: jax.Array, most: jax.Array) -> jax.Array:
    """``vector``, shortened to a length of at most ``most``."""
    return vector * jnp.minimum(1.0, most / jnp.sqrt((vector**2).sum() + jnp.finfo(vector.dtype).tiny))


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
