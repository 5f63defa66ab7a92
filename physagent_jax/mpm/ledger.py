"""The energy and momentum ledger: what forces and boundaries put in, what plasticity and viscosity take out.

With E = `energy.total_energy`, over a frame

    E(end) - E(start) = force_work + boundary_work - plastic_dissipation - viscous_dissipation - numerical_loss
    P(end) - P(start) = force_impulse + boundary_impulse

The numerical loss is what remains. APIC loses energy in every transfer, most at short wavelengths; a loss below zero
by more than the error of the time integration means instability. The momentum balance is exact to round-off.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.energy import kinetic_energy, total_energy
from physagent_jax.mpm.linalg import cofactor, determinant, matmul, transpose
from physagent_jax.mpm.materials import viscous_stress
from physagent_jax.mpm.reductions import sum_devices
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.step import StepTrace, damp_affine, map_materials


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Exchange:
    """The exchange with the surroundings, summed over substeps. Scalars but for the impulses, shape (3,).

    Attributes:
        force_work: By body forces other than gravity [J].
        boundary_work: By walls, obstacles, prescribed motions and the drag of `Model.damping_rate` [J].
        plastic_dissipation: By return mappings: stress times plastic strain [J].
        viscous_dissipation: By viscosity [J].
        numerical_loss: What closes the balance [J]; known per frame only, zero for a substep.
        force_impulse: By gravity and body forces [kg m/s].
        boundary_impulse: By walls, obstacles, prescribed motions and that drag [kg m/s].
    """

    force_work: jax.Array
    boundary_work: jax.Array
    plastic_dissipation: jax.Array
    viscous_dissipation: jax.Array
    numerical_loss: jax.Array
    force_impulse: jax.Array
    boundary_impulse: jax.Array

    @staticmethod
    def zeros(dtype) -> Exchange:
        """Nothing yet."""
        zero, vector = jnp.zeros((), dtype), jnp.zeros(3, dtype)
        return Exchange(zero, zero, zero, zero, zero, vector, vector)

    def __add__(self, other: Exchange) -> Exchange:
        return jax.tree.map(jnp.add, self, other)


def measure_exchange(model: Model, before: State, trace: StepTrace, after: State) -> Exchange:
    """The exchange of one substep, from its `step.StepTrace`.

    Within a step all impulses (stress, forces, walls) act together, and each works on the mean of the velocities
    before and after all of them. Work booked on any other velocity would leave a remainder for every pair of
    impulses that cancel, such as a pull and the stress that balances it. Boundaries are the exception: their work is
    impulse times the velocity after it. P2G leaks momentum into the nodes of a wall that the wall takes out again, in
    every step; on the mean velocity that exchange would be work to and fro, although the wall rests.
    """
    if trace.node_mass is None or trace.free_velocity is None or trace.velocity is None:
        raise ValueError("what is exchanged is measured on a grid: `gridless.use_grid(model)` keeps it")
    begun = dataclasses.replace(before, C=damp_affine(model, before.C))
    gathered, after_forces = trace.gathered, trace.after_forces
    weightless = after_forces
    if model.gravity is not None:  # its work is in the potential
        weightless = dataclasses.replace(after_forces, v=after_forces.v - model.dt * model.gravity)
    impulse = trace.node_mass[..., None] * (trace.velocity - trace.free_velocity)
    opposing = impulse
    if (
        trace.sharpening is not None
    ):  # no boundary's work, and no momentum but where images of matter lie behind planes
        opposing = impulse - trace.node_mass[..., None] * trace.sharpening
    grid_work = (opposing * trace.velocity).sum()
    constraint_work = _measure_work(model, begun, gathered, after_forces, trace.after_constraints)
    projection_work = kinetic_energy(model, after) - kinetic_energy(model, gathered)
    boundary_impulse = (
        impulse.sum((0, 1, 2))
        + _measure_momentum_change(model, after_forces, trace.after_constraints)
        + _measure_momentum_change(model, gathered, after)
    )
    return Exchange(
        force_work=_measure_work(model, begun, gathered, begun, weightless),
        boundary_work=constraint_work + grid_work + projection_work,
        plastic_dissipation=_measure_plastic(model, before, trace),
        viscous_dissipation=_measure_viscous(model, before, trace),
        numerical_loss=jnp.zeros((), before.x.dtype),
        force_impulse=_measure_momentum_change(model, before, after_forces),
        boundary_impulse=boundary_impulse,
    )


def balance(model: Model, start: State, end: State, total: Exchange) -> Exchange:
    """``total`` with the numerical loss between two states."""
    supplied = total.force_work + total.boundary_work - total.plastic_dissipation - total.viscous_dissipation
    loss = total_energy(model, start) - total_energy(model, end) + supplied
    return dataclasses.replace(total, numerical_loss=loss)


def _measure_work(model: Model, begun: State, gathered: State, one: State, other: State) -> jax.Array:
    """Of the impulses that take ``one`` to ``other``, in a step from ``begun`` to ``gathered``; C included."""
    v = (other.v - one.v) * 0.5 * (begun.v + gathered.v)
    C = (other.C - one.C) * 0.5 * (begun.C + gathered.C)
    return sum_devices(
        (model.mass * (v.sum(-1) + (model.grid.dx**2 / 4) * C.sum((-1, -2)))).sum(), model.axis
    )


def _measure_momentum_change(model: Model, one: State, other: State) -> jax.Array:
    return sum_devices((model.mass[:, None] * (other.v - one.v)).sum(0), model.axis)


def _measure_plastic(model: Model, before: State, trace: StepTrace) -> jax.Array:
    """Mean stress of the step times the plastic strain, and the energy that the changed history sets free.

    Not the energy that the return mapping takes off the trial state: nobody has put in the part of that which is
    beyond the yield surface. Torn sand, free of stress and of energy, would dissipate for ever.
    """

    def stress(state: State) -> jax.Array:
        return map_materials(model, state, lambda material, F, history: material.stress(F, history))

    def density(state: State) -> jax.Array:
        return map_materials(model, state, lambda material, F, history: material.energy(F, history))

    end = trace.gathered
    inverse = transpose(cofactor(end.F)) / determinant(end.F)[:, None, None]
    strain = matmul(trace.trial - end.F, inverse)
    dissipated = 0.5 * ((stress(before) + stress(end)) * strain).sum((-1, -2))
    if jax.tree.leaves(end.history):
        dissipated = dissipated + density(dataclasses.replace(end, history=before.history)) - density(end)
    return sum_devices((model.volume * dissipated).sum(), model.axis)


def _measure_viscous(model: Model, before: State, trace: StepTrace) -> jax.Array:
    if model.viscosity is None:
        return jnp.zeros((), before.x.dtype)
    end = trace.gathered
    tau = viscous_stress(model.viscosity, before.C, before.F) + viscous_stress(model.viscosity, end.C, end.F)
    return 0.5 * model.dt * sum_devices((model.volume[:, None, None] * tau * end.C).sum(), model.axis)
