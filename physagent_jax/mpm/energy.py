"""Energies and momenta of a state: what must be conserved, and what the report plots."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.mpm.linalg import cross
from physagent_jax.mpm.reductions import sum_devices
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.step import kirchhoff_stress, map_materials


def kinetic_energy(model: Model, state: State) -> jax.Array:
    """Kinetic energy with the affine part, sum m (|v|^2 / 2 + dx^2 |C|^2 / 8) [J] (Jiang et al. 2015)."""
    affine = (state.C**2).sum((-1, -2)) * (model.grid.dx**2 / 4)
    return 0.5 * sum_devices((model.mass * ((state.v**2).sum(-1) + affine)).sum(), model.axis)


def elastic_energy(model: Model, state: State) -> jax.Array:
    """Strain energy, sum V0 psi(F) [J]."""
    density = map_materials(model, state, lambda material, F, history: material.energy(F, history))
    return sum_devices((model.volume * density).sum(), model.axis)


def gravitational_energy(model: Model, state: State) -> jax.Array:
    """Potential energy -sum m g . x in uniform gravity, zero at the domain's origin [J]."""
    if model.gravity is None:
        return jnp.zeros((), state.x.dtype)
    return -sum_devices((model.mass[:, None] * state.x * model.gravity).sum(), model.axis)


def total_energy(model: Model, state: State) -> jax.Array:
    """Kinetic, elastic and gravitational energy at one instant [J].

    The scheme is a leapfrog: velocities belong to half a substep before the positions. Advanced by half a
    substep, T changes by dt/2 times the power of gravity less that of the stress; without this the sum would
    swing by several per cent at steps near the stable bound although no energy is gained.
    """
    power = -(model.volume[:, None, None] * kirchhoff_stress(model, state) * state.C).sum()
    if model.gravity is not None:
        power = power + (model.mass[:, None] * model.gravity * state.v).sum()
    parts = kinetic_energy(model, state) + elastic_energy(model, state) + gravitational_energy(model, state)
    return parts + 0.5 * model.dt * sum_devices(power, model.axis)


def momentum(model: Model, state: State) -> jax.Array:
    """Linear momentum [kg m/s], shape (3,)."""
    return sum_devices((model.mass[:, None] * state.v).sum(0), model.axis)


def angular_momentum(model: Model, state: State, about: jax.Array) -> jax.Array:
    """Angular momentum [kg m^2/s], shape (3,), with the affine term m dx^2/4 axial(C) that APIC conserves."""
    C = state.C
    axial = jnp.stack([C[:, 2, 1] - C[:, 1, 2], C[:, 0, 2] - C[:, 2, 0], C[:, 1, 0] - C[:, 0, 1]], -1)
    spin = cross(state.x - about, state.v) + (model.grid.dx**2 / 4) * axial
    return sum_devices((model.mass[:, None] * spin).sum(0), model.axis)
