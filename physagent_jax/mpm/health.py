"""Extremes of the substeps of a frame, by which it is trusted or redone."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import reductions
from physagent_jax.mpm.linalg import determinant
from physagent_jax.mpm.state import Grid, Model


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Health:
    """Extremes over the particles of one substep, or of several; kept on the device, scalars.

    Attributes:
        min_J, max_J: Extremes of det F of the trial deformation, before the return mapping.
        min_increment: Least det(I + dt grad v), by which a substep scales volumes.
        max_speed: [m/s].
        finite: Whether all particles are; those that are not do not count for the extremes.
        outside: Particle-steps with a stencil beyond the grid window, int32.
        beyond: Particle-steps behind the domain's walls, int32.
    """

    min_J: jax.Array
    max_J: jax.Array
    min_increment: jax.Array
    max_speed: jax.Array
    finite: jax.Array
    outside: jax.Array
    beyond: jax.Array

    @staticmethod
    def initial(dtype) -> Health:
        """Before the first substep."""
        one, none = jnp.ones((), dtype), jnp.zeros((), jnp.int32)
        return Health(one, one, one, jnp.zeros((), dtype), jnp.array(True), none, none)

    def __add__(self, later: Health) -> Health:
        """Of these substeps and later ones."""
        return Health(
            jnp.minimum(self.min_J, later.min_J),
            jnp.maximum(self.max_J, later.max_J),
            jnp.minimum(self.min_increment, later.min_increment),
            jnp.maximum(self.max_speed, later.max_speed),
            self.finite & later.finite,
            self.outside + later.outside,
            self.beyond + later.beyond,
        )

    def reduce(self, axis: str | None) -> Health:
        """The same of the particles of all devices along ``axis``; a constant to derivatives."""
        return Health(
            reductions.min_devices(self.min_J, axis),
            reductions.max_devices(self.max_J, axis),
            reductions.min_devices(self.min_increment, axis),
            reductions.max_devices(self.max_speed, axis),
            reductions.all_devices(self.finite, axis),
            reductions.sum_devices(self.outside, axis),
            reductions.sum_devices(self.beyond, axis),
        )

    def is_good(self, model: Model) -> jax.Array:
        """Return whether the substeps so far can be trusted."""
        upright = (self.min_J > 0) & (self.min_increment > 0)
        slow = self.max_speed * model.dt < model.grid.dx
        return self.finite & upright & slow & (self.outside == 0)


def measure_health(wall: int, grid: Grid, x, v, F, strain) -> Health:
    """Of particles after one substep, ``strain`` being dt grad v, shape (n, 3, 3); ``wall`` as in `Model`."""
    # What is only looked at has no derivative: that of the largest speed would be infinite where nothing moves.
    x, v, F, strain = jax.lax.stop_gradient((x, v, F, strain))
    J, increment = determinant(F), determinant(jnp.eye(3, dtype=F.dtype) + strain)
    finite = jnp.isfinite(J + increment + v.sum(-1))
    sane_J, sane_increment = jnp.where(finite, J, 1.0), jnp.where(finite, increment, 1.0)
    speed = jnp.sqrt(jnp.where(finite, (v**2).sum(-1), 0.0).max())
    low, high = wall * grid.dx, (grid.cells - wall) * grid.dx
    beyond = ((x < low) | (x > high)).any(-1).sum(dtype=jnp.int32)
    within = jnp.clip(x, low, high)  # where the walls will stop them
    extremes = sane_J.min(), sane_J.max(), sane_increment.min(), speed, finite.all()
    return Health(*extremes, count_outside(within, grid), beyond)


def count_outside(x: jax.Array, grid: Grid) -> jax.Array:
    """The number of particles whose stencil is not wholly inside the window, int32."""
    low = jnp.floor(x / grid.dx - 0.5).astype(jnp.int32) - grid.origin
    return ((low < 0) | (low + 3 > jnp.asarray(grid.shape))).any(-1).sum(dtype=jnp.int32)
