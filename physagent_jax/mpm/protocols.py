"""What plugs into `Model`: body forces and boundaries. Implementations are registered dataclasses (pytrees)."""

from __future__ import annotations

from typing import Protocol

import jax
import jax.numpy as jnp


class BodyForce(Protocol):
    """An external acceleration field; forces per unit mass, so particle count does not change the motion.

    For runs on several devices (`mpm.sharding`): what there is one of per particle is called ``weight``, and sums over
    particles go through `mpm.reductions.summed`.

    ``start`` and ``end`` [s], of the force or of its ``envelope``, are taken for its window: `mpm.simulate` leaves it
    out of frames that do not meet it (`mpm.plan`), and likewise boundaries and constraints. What acts at other times
    must not use these names.
    """

    def acceleration(
        self, x: jax.Array, v: jax.Array, mass: jax.Array, time: jax.Array, dt: jax.Array
    ) -> jax.Array:
        """Mean acceleration over [time, time + dt] at the particles [m/s^2], shape (n, 3)."""
        ...

    def gradient(self, x: jax.Array, time: jax.Array, dt: jax.Array) -> jax.Array | None:
        """d acceleration / d x [1/s^2], shape (n, 3, 3) or (3, 3); None = uniform across a cell.

        P2G carries it like C. A torque needs it: APIC particles have a moment of inertia of their own
        (m dx^2 / 2 about each axis), which forces at their centres alone would leave unturned.
        """
        ...


class Boundary(Protocol):
    """A condition on grid velocities."""

    def apply(self, velocity: jax.Array, grid, time: jax.Array) -> jax.Array:
        """Velocities after the boundary [m/s], shape (nx, ny, nz, 3)."""
        ...


def window_fraction(time: jax.Array, dt: jax.Array, start: jax.Array, end: jax.Array) -> jax.Array:
    """The share of the substep [time, time + dt] that lies in [start, end).

    Consecutive substeps telescope, so an impulse delivers exactly its total whatever dt is.
    """
    overlap = jnp.minimum(time + dt, end) - jnp.maximum(time, start)
    return jnp.clip(overlap / dt, 0.0, 1.0)
