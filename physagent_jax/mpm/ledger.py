"""The energy and momentum ledger: what forces and boundaries put in, what plasticity and viscosity take out.

With E = `energy.total_energy`, over a frame

    E(end) - E(start) = force_work + boundary_work - plastic_dissipation - viscous_dissipation - numerical_loss
    P(end) - P(start) = force_impulse + boundary_impulse

The numerical loss is what remains. APIC loses energy in every transfer, most at short wavelengths, and matter that
meets a wall loses its velocity towards it at once; a loss below zero by more than round-off means instability.
The momentum balance is exact to round-off.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.mpm.energy import kinetic_energy, total_energy
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.step import Trace, body_gradient, external_acceleration, per_material, viscous_stress


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Exchange:
    """What was exchanged with the surroundings, summed over substeps. Scalars but for the impulses, shape (3,).

    Attributes:
        force_work: By body forces other than gravity [J].
        boundary_work: By walls, obstacles and prescribed motions (friction: negative) [J].
        plastic_dissipation: Strain energy given up by return mappings [J].
        viscous_dissipation: By viscosity [J].
        numerical_loss: What closes the balance [J]; known per frame only, zero for a substep.
        force_impulse: By gravity and body forces [kg m/s].
        boundary_impulse: By walls, obstacles and prescribed motions [kg m/s].
    """

    force_work: jax.Array
    boundary_work: jax.Array
    plastic_dissipation: jax.Array
    viscous_dissipation: jax.Array
    numerical_loss: jax.Array
    force_impulse: jax.Array
    boundary_impulse: jax.Array

    @staticmethod
    def none(dtype) -> Exchange:
        """Nothing yet."""
        zero, vector = jnp.zeros((), dtype), jnp.zeros(3, dtype)
        return Exchange(zero, zero, zero, zero, zero, vector, vector)

    def __add__(self, other: Exchange) -> Exchange:
        return jax.tree.map(jnp.add, self, other)


def exchange(model: Model, before: State, trace: Trace, after: State) -> Exchange:
    """The exchange of one substep, from its `step.Trace`."""
    held = kinetic_energy(model, trace.held) - kinetic_energy(model, trace.pushed)
    placed = kinetic_energy(model, after) - kinetic_energy(model, trace.gathered)
    # A wall works on what moves along it or with it: impulse times the velocity after. The mean of before and
    # after would book the stress's push into a resting wall, and the wall's answer, as work.
    kick = trace.node_mass[..., None] * (trace.velocity - trace.free)
    met = (kick * trace.velocity).sum()
    kicks = (
        kick.sum((0, 1, 2))
        + _momentum_change(model, trace.pushed, trace.held)
        + _momentum_change(model, trace.gathered, after)
    )
    return Exchange(
        force_work=_force_work(model, before, trace.pushed),
        boundary_work=held + met + placed,
        plastic_dissipation=_plastic(model, before, trace),
        viscous_dissipation=_viscous(model, before, trace),
        numerical_loss=jnp.zeros((), before.x.dtype),
        force_impulse=_momentum_change(model, before, trace.pushed),
        boundary_impulse=kicks,
    )


def balanced(model: Model, start: State, end: State, total: Exchange) -> Exchange:
    """``total`` with the numerical loss between two states."""
    supplied = total.force_work + total.boundary_work - total.plastic_dissipation - total.viscous_dissipation
    loss = total_energy(model, start) - total_energy(model, end) + supplied
    return dataclasses.replace(total, numerical_loss=loss)


def _momentum_change(model: Model, one: State, other: State) -> jax.Array:
    return (model.mass[:, None] * (other.v - one.v)).sum(0)


def _force_work(model: Model, before: State, pushed: State) -> jax.Array:
    """The sum of dt a . v at mid-step, and its counterpart for the field's gradient and C."""
    if not model.forces:
        return jnp.zeros((), before.x.dtype)
    middle = 0.5 * (before.v + pushed.v)
    work = (model.mass[:, None] * external_acceleration(model, before) * middle).sum()
    rate = body_gradient(model, before) * (pushed.C - 0.5 * model.dt * body_gradient(model, before))
    return model.dt * (work + (model.grid.dx**2 / 4) * (model.mass[:, None, None] * rate).sum())


def _plastic(model: Model, before: State, trace: Trace) -> jax.Array:
    """Strain energy before less after the return mapping; the history is part of the state after."""
    trial = dataclasses.replace(trace.gathered, F=trace.trial, history=before.history)

    def density(state):
        return per_material(model, state, lambda material, F, history: material.energy(F, history))

    return (model.volume * (density(trial) - density(trace.gathered))).sum()


def _viscous(model: Model, before: State, trace: Trace) -> jax.Array:
    if model.viscosity is None:
        return jnp.zeros((), before.x.dtype)
    tau = viscous_stress(model.viscosity, before.F, trace.strain_rate)
    return model.dt * (model.volume[:, None, None] * tau * trace.gathered.C).sum()
