"""The bound of the time step.

An explicit MPM step is limited first by its worst-supported particle, one alone on its nodes, not by the
bulk's sound speed. For quadratic B-splines and MLS stress, C' = -(4 / dx^2) tau(F) / rho0 whatever the
particle's place in its cell, so with the largest Kirchhoff tangent k = d tau / d ln lambda the symplectic
step is stable up to

    dt_c = dx sqrt(rho0 / k),   k = 3 lam + 2 mu = E / (1 - 2 nu) at rest,

a little below dx / c_p. Viscosity eta, which acts on C of the step before, tightens this to the smaller root of
dt^2 (4 k / rho0 dx^2) + 2 dt (8 eta / rho0 dx^2) = 4.

The classical stress form strains particles with sum v_i grad w_i but keeps C. With q = 4 dt^2 k / (rho0 dx^2) and
m = dx^2/4 sum |grad w|^2 / w, at most 3/2 per axis (between two nodes), a lone particle is stable up to
q = 4 / (2 m - 1): the bound is 1 / sqrt(2) of the above.

Stretch stiffens k (twice for a neo-Hookean stretched by 1.4), so the bound is taken at the current F.
Advection and the velocity gradient add their own limits. No formula guarantees stability for APIC (Bai &
Schroeder 2022); `simulate` therefore also checks every frame.
"""

from __future__ import annotations

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.mpm.reductions import max_devices, min_devices
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.step import body_acceleration, map_materials

SAFETY = 0.9  # of the bound, for the automatic step: APIC loses energy with every step, so that long ones err least
ADVECTION_LIMIT = 0.5  # cells a particle may cross in one substep
CLASSICAL_SHARE = 0.5**0.5  # bound of the classical stress form over that of MLS (see above)
GRADIENT_LIMIT = 0.3  # of |grad v| dt: det(I + dt grad v) > 0 needs < 1


def stable_dt(model: Model, state: State) -> jax.Array:
    """The closed-form bound dt_c [s] at the current deformation, least over the particles; inf if nothing is stiff."""
    return _compute_stable_dt(_drop_window_shape(model), state)


@jax.jit
def _compute_stable_dt(model: Model, state: State) -> jax.Array:
    stiffness = map_materials(model, state, lambda material, F, history: material.stiffness(F, history))
    inertia = model.mass / model.volume * model.grid.dx**2  # [Pa s^2]
    damping = 0.0 if model.viscosity is None else 16 * model.viscosity / inertia
    bound = 8 / (damping + jnp.sqrt(damping**2 + 64 * stiffness / inertia))
    if model.axis is not None:
        bound = jnp.where(model.mass > 0, bound, jnp.inf)  # padding
    return min_devices(bound.min(), model.axis) * (1.0 if model.stress_form == "mls" else CLASSICAL_SHARE)


def kinematic_dt(model: Model, state: State, horizon: jax.Array | np.ndarray) -> jax.Array:
    """The advection and velocity-gradient limits [s], with the speed that forces can add within ``horizon`` [s]."""
    return _compute_kinematic_dt(_drop_window_shape(model), state, horizon)


@jax.jit
def _compute_kinematic_dt(model: Model, state: State, horizon: jax.Array) -> jax.Array:
    acceleration = jnp.broadcast_to(body_acceleration(model, state), state.v.shape)
    speed = jnp.linalg.norm(state.v, axis=-1) + horizon * jnp.linalg.norm(acceleration, axis=-1)
    gradient = jnp.sqrt((state.C**2).sum((-1, -2)))
    tiny = jnp.finfo(state.x.dtype).tiny
    return jnp.minimum(
        ADVECTION_LIMIT * model.grid.dx / jnp.maximum(max_devices(speed.max(), model.axis), tiny),
        GRADIENT_LIMIT / jnp.maximum(max_devices(gradient.max(), model.axis), tiny),
    )


def _drop_window_shape(model: Model) -> Model:
    """The model without its window's shape, on which no bound depends: a larger one need not be compiled for."""
    return model.replace(grid=dataclasses.replace(model.grid, shape=(0, 0, 0)))


def divide_frame(frame_dt: float, dt: float) -> int:
    """Substeps of at most ``dt`` [s] that fit ``frame_dt`` [s] exactly."""
    return max(1, math.ceil(frame_dt / dt * (1 - 1e-6)))


def check_explicit_dt(dt: float, bound: float) -> None:
    """Refuse an explicit substep above the stable bound.

    Raises:
        UserError: ``dt`` exceeds ``bound``.
    """
    if dt > bound:
        raise UserError(
            f"`substep_dt` = {dt:.3g} s is above the stable bound of {bound:.3g} s for this material and grid",
            do=f'Use `substep_dt` <= {0.9 * bound:.2g}, or "auto", or a softer, denser or less damped material, or '
            "fewer grid cells; `force_substep` runs it nevertheless",
        )
