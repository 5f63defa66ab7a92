"""Parts that manufactured solutions share: an exact map, the force that makes it true, and the distance from it.

A map x(X, t) solves the equations of motion of a material under the body force b = x_tt - Div P(F) / rho0.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import State

Field = Callable[[jax.Array, jax.Array], jax.Array]
"""A vector field of one particle: (rest position of shape (3,), time) -> shape (3,)."""


@register_dataclass
@dataclasses.dataclass(frozen=True)
class ManufacturedForce:
    """b(X, t) at the particles (`mpm.protocols.BodyForce`).

    It has no gradient on purpose. Where stress balances a curved force, both should be smoothed alike on
    their way to the grid. Quadratic B-splines add dx^2 / 8 of its second derivative to a field of plain particle
    values, and 0.108 dx^2 (MLS) or dx^2 / 8 (gradient form) to the stress divergence, which (nearly) cancels. A
    force that carries its gradient is off by -dx^2 / 8, and the vortex by 3.5 times as much (10 cells, MLS).

    Attributes:
        X: Rest positions [m], shape (n, 3).
        field: b [m/s^2], static.
    """

    X: jax.Array
    field: Field = dataclasses.field(metadata=dict(static=True))

    def acceleration(
        self, x: jax.Array, v: jax.Array, mass: jax.Array, time: jax.Array, dt: jax.Array
    ) -> jax.Array:
        """The force where the particles are in the rest pose, which is exact wherever they have got to."""
        return jax.vmap(self.field, (0, None))(self.X, time)

    def gradient(self, x: jax.Array, time: jax.Array, dt: jax.Array) -> None:
        """None: see above."""
        return None


def positions(motion: Field, X: np.ndarray, times: Sequence[float] | np.ndarray) -> np.ndarray:
    """Exact positions at several times [m], shape (len(times), n, 3)."""
    return np.asarray(_compute_positions(motion, jnp.asarray(X), jnp.asarray(times)))


@partial(jax.jit, static_argnums=0)
def _compute_positions(motion: Field, X: jax.Array, times: jax.Array) -> jax.Array:
    return jax.vmap(jax.vmap(motion, (0, None)), (None, 0))(X, times)


def set_in_motion(state: State, motion: Field, X: np.ndarray, dt: float) -> State:
    """``state`` with the exact F of t = 0, and the exact v and C of half a step before.

    The simulator moves particles with the velocity at the end of the step. That makes it a leapfrog of second
    order, provided that velocities live half a step before positions.
    """
    F, v, C = _compute_start(motion, jnp.asarray(X, state.x.dtype), jnp.asarray(-dt / 2, state.x.dtype))
    return dataclasses.replace(state, F=F, v=v, C=C)


@partial(jax.jit, static_argnums=0)
def _compute_start(motion: Field, X: jax.Array, t: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    def at(X):
        F, rate = jax.jvp(lambda t: jax.jacfwd(motion)(X, t), (t,), (jnp.ones_like(t),))
        return jax.jacfwd(motion)(X, jnp.zeros_like(t)), jax.jacfwd(motion, 1)(X, t), rate @ jnp.linalg.inv(F)

    return jax.vmap(at)(X)


def distance_from(exact: np.ndarray) -> Callable[..., jax.Array]:
    """Watch the RMS distance [m] from each of several exact configurations (s, n, 3), shape (s,).

    Sample k of a run is meant for configuration k: its error is on the diagonal of `Signal.values`.
    """

    def observe(x, v, C, F):
        return ((x - exact.astype(x.dtype)) ** 2).sum(-1).mean(-1) ** 0.5

    return observe
