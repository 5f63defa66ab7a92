"""Parts that cases share: a body of any material, and planes that bound it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics
from physagent_jax.mpm import Contact, Grid, HalfSpace, Model, State
from physagent_jax.mpm.materials import Material


def body(
    numerics: Numerics,
    grid: Grid,
    x: np.ndarray,
    volume: float,
    material: Material,
    *,
    rho: float,
    speed: float,
    gravity: Sequence[float] | None = None,
    v: np.ndarray | None = None,
    C: np.ndarray | None = None,
    F: np.ndarray | None = None,
    **model,
) -> tuple[Model, State]:
    """One body, at rest and undeformed unless told otherwise, with the numerics' transfers, step and dtype.

    Args:
        numerics: How it is computed.
        grid: The window.
        x: Positions [m], shape (n, 3).
        volume: Rest volume of each particle [m^3].
        material: With parameters of shape (n,).
        rho: Rest density [kg/m^3].
        speed: Sound speed, for the Courant rule [m/s].
        gravity: [m/s^2]; None = none.
        v: Velocities [m/s], shape (n, 3).
        C: Affine matrices [1/s], shape (n, 3, 3).
        F: Deformation gradients, shape (n, 3, 3).
        model: Further arguments of `Model`.
    """
    dtype, count = numerics.dtype, len(x)
    made = Model(
        grid=grid,
        dt=jnp.asarray(0.0, dtype),
        gravity=None if gravity is None else jnp.asarray(gravity, dtype),
        mass=jnp.full(count, rho * volume, dtype),
        volume=jnp.full(count, volume, dtype),
        materials=(material,),
        **model,
    )
    state = State.at_rest(jnp.asarray(x, dtype), materials=made.materials)
    given = {
        name: jnp.asarray(value, dtype) for name, value in dict(v=v, C=C, F=F).items() if value is not None
    }
    state = dataclasses.replace(state, **given)
    return numerics.finish(made, state, speed), state


def half_space(
    point: Sequence[float], normal: Sequence[float], contact: Contact, dtype, friction: float = 0.0
) -> HalfSpace:
    """A plane that is always there; ``normal`` points out of the solid."""
    numbers = (point, normal, friction, 0.0, jnp.inf)
    return HalfSpace(*(jnp.asarray(number, dtype) for number in numbers), contact=contact)
