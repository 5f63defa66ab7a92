"""The ledger balances: what forces and boundaries put in is where the energy and the momentum went."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.terms import Torque, UniformAcceleration
from physagent_jax.mpm import DomainBox, HalfSpace, simulate
from physagent_jax.mpm.boundaries import Contact
from physagent_jax.mpm.constraints import PrescribedMotion
from physagent_jax.mpm.energy import kinetic_energy, momentum, total_energy
from tests.mpm.blocks import block

FOREVER = jnp.asarray(1e9)


def simulate_frames(model, state, frame_count=6, frame_dt=0.01, **options):
    frames = list(simulate(model, state, frame_count=frame_count, frame_dt=frame_dt, ledger=True, **options))
    return frames, sum_of(frames)


def sum_of(frames):
    total = frames[0].exchange
    for frame in frames[1:]:
        total = total + frame.exchange
    return total


def test_frames_carry_no_exchange_unless_asked(x64):
    model, state = block(dtype=np.float64)
    frames = list(simulate(model, state, frame_count=2, frame_dt=0.01))
    assert all(frame.exchange is None for frame in frames)


def test_uniform_push_does_the_work_of_a_rigid_body(x64):
    push = UniformAcceleration(jnp.array([2.0, 0.0, 0.5]), jnp.zeros(()), FOREVER)
    model, state = block(dtype=np.float64, forces=(push,))
    frames, total = simulate_frames(model, state)
    mass, duration = float(model.mass.sum()), 0.05
    np.testing.assert_allclose(total.force_work, 0.5 * mass * (2.0**2 + 0.5**2) * duration**2, rtol=1e-12)
    np.testing.assert_allclose(
        total.force_impulse, mass * duration * np.array([2.0, 0, 0.5]), atol=1e-12 * mass
    )
    np.testing.assert_allclose(total.boundary_impulse, 0, atol=1e-12 * mass)
    np.testing.assert_allclose(kinetic_energy(model, frames[-1].state), total.force_work, rtol=1e-10)


def test_torque_works_on_the_affine_motion_too(x64):
    """A block turned from rest: all but the transfers' own loss of the work is found as kinetic energy."""
    torque = Torque(jnp.array([0.0, 0.0, 1.0]), jnp.asarray(5.0), jnp.zeros(()), FOREVER)
    model, state = block(dtype=np.float64, forces=(torque,), youngs_modulus=1e6)
    frames, total = simulate_frames(model, state)
    arm = np.asarray(state.x) - np.average(state.x, axis=0)
    inertia = (np.asarray(model.mass) * ((arm[:, :2] ** 2).sum(1) + 2 * model.grid.dx**2 / 4)).sum()
    np.testing.assert_allclose(total.force_work, 0.5 * inertia * (5.0 * 0.05) ** 2, rtol=5e-3)
    loss = float(total.numerical_loss)
    assert abs(loss) < 1e-3 * float(total.force_work)


def test_momentum_balance_is_exact_with_walls_and_gravity(x64):
    model, state = block(
        dtype=np.float64,
        low=(0.4, 0.4, 0.16),
        gravity=jnp.array([0.3, 0.0, -9.8]),
        boundaries=(DomainBox(3),),
    )
    state = dataclasses.replace(state, v=state.v + jnp.array([0.5, 0.0, -1.0]))
    frames, total = simulate_frames(model, state, frame_count=12)
    change = momentum(model, frames[-1].state) - momentum(model, state)
    np.testing.assert_allclose(change, total.force_impulse + total.boundary_impulse, atol=1e-12)
    assert float(total.boundary_impulse[2]) > 0


def test_friction_takes_the_kinetic_energy_of_a_sliding_block(x64):
    floor = HalfSpace(
        jnp.array([0.0, 0.0, 0.2]), jnp.array([0.0, 0.0, 1.0]), jnp.asarray(0.4), jnp.zeros(()), FOREVER,
        Contact.SEPARATE,
    )  # fmt: skip
    model, state = block(
        dtype=np.float64, low=(0.3, 0.4, 0.2), gravity=jnp.array([0.0, 0.0, -9.8]), boundaries=(floor,),
        youngs_modulus=1e6, damping_rate=0.0,
    )  # fmt: skip
    state = dataclasses.replace(state, v=state.v.at[:, 0].set(1.0))
    frames, total = simulate_frames(model, state, frame_count=11)
    lost = float(kinetic_energy(model, state) - kinetic_energy(model, frames[-1].state))
    assert float(total.boundary_work) < 0
    np.testing.assert_allclose(total.boundary_impulse[0], -0.4 * total.boundary_impulse[2], rtol=1e-3)
    np.testing.assert_allclose(lost, -float(total.boundary_work), rtol=0.1)


def test_prescribed_motion_puts_in_the_energy_it_gives(x64):
    model, state = block(dtype=np.float64)
    grip = PrescribedMotion(
        jnp.arange(len(state.x)),
        jnp.array([0.7, 0.0, 0.0]),
        jnp.zeros(3),
        jnp.zeros(3),
        jnp.zeros(()),
        FOREVER,
    )
    frames, total = simulate_frames(model.replace(constraints=(grip,)), state)
    np.testing.assert_allclose(total.boundary_work, 0.5 * float(model.mass.sum()) * 0.7**2, rtol=1e-10)
    np.testing.assert_allclose(total.boundary_impulse[0], float(model.mass.sum()) * 0.7, rtol=1e-10)
    np.testing.assert_allclose(kinetic_energy(model, frames[-1].state), total.boundary_work, rtol=1e-8)


def test_free_motion_never_gains_energy(x64):
    """An expanding, turning block: the remainder of the balance is a loss in every frame."""
    model, state = block(dtype=np.float64, youngs_modulus=1e4)
    x = state.x - state.x.mean(0)
    state = dataclasses.replace(
        state, v=jnp.stack([2 * x[:, 0] - 3 * x[:, 1], 3 * x[:, 0] + x[:, 1], -2 * x[:, 2]], -1)
    )
    frames, total = simulate_frames(model, state, frame_count=30, frame_dt=0.02)
    losses = [float(frame.exchange.numerical_loss) for frame in frames[1:]]
    assert min(losses) > 0
    np.testing.assert_allclose(
        sum(losses), total_energy(model, state) - total_energy(model, frames[-1].state), rtol=0.05
    )
    assert float(total.force_work) == 0.0
    assert abs(float(total.boundary_work)) < 1e-12


@pytest.mark.parametrize("viscosity", [1.0, 20.0])
def test_viscosity_dissipates_what_the_ledger_says(viscosity, x64):
    """A shearing block: with viscosity the extra loss of energy is the ledger's viscous dissipation."""
    lost, dissipated = [], []
    for eta in (None, viscosity):
        model, state = block(dtype=np.float64, youngs_modulus=1e3)
        shear = 3.0 * (state.x[:, 2] - state.x[:, 2].mean())
        state = dataclasses.replace(state, v=state.v.at[:, 0].set(shear), C=state.C.at[:, 0, 2].set(3.0))
        if eta is not None:
            model = model.replace(viscosity=jnp.full(len(state.x), eta))
        frames, total = simulate_frames(model, state, substep_dt=5e-4)
        lost.append(float(total.viscous_dissipation + total.numerical_loss))
        dissipated.append(float(total.viscous_dissipation))
    assert dissipated[0] == 0.0
    assert dissipated[1] > 0
    np.testing.assert_allclose(lost[1] - lost[0], dissipated[1], rtol=0.1)
