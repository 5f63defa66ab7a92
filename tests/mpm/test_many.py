"""Many simulations at once: `jax.vmap` of `rollout` and `step` gives what a loop over single runs gives."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.mpm import NeoHookean, VonMises, kernels, lame_parameters, rollout, step
from tests.mpm.blocks import block

needs_numba = pytest.mark.skipif(not kernels.use_cpu(), reason="no CPU kernels here")
CHOICES = ["reference", pytest.param("cpu", marks=needs_numba)]
SCENES = [("reference", False), *(pytest.param("cpu", mixed, marks=needs_numba) for mixed in (False, True))]
PUSHES = np.array([[2.0, 0.0, 1.0], [0.0, -30.0, 0.0], [5.0, 5.0, -40.0]])
STIFFNESS = np.array([2e4, 5e4, 1e5])
TOLERANCE = dict(rtol=0, atol=1e-13)


def solid(count, youngs_modulus):
    mu, lam = lame_parameters(youngs_modulus, 0.3)
    return NeoHookean(jnp.full(count, mu), jnp.full(count, lam))


def metal(count, youngs_modulus):
    mu, lam = (jnp.full(count, value) for value in lame_parameters(youngs_modulus, 0.3))
    return VonMises(mu, lam, jnp.full(count, 50.0), jnp.full(count, 1e3))


def scene(choice, *, mixed=False):
    """A block just above the floor, falling and twisting; ``mixed`` = half of it is metal that yields."""
    model, state = block((2, 2, 3), low=(0.4, 0.4, 0.11), dtype=np.float64, kernels=choice)
    count = len(state.x)
    if mixed:
        model = model.replace(materials=(solid(count // 2, 1e5), metal(count // 2, 1e5)))
    history = tuple(material.initial_history() for material in model.materials)
    x = state.x - state.x.mean(0)
    v = 3 * jnp.stack([-x[:, 1], x[:, 0], 0 * x[:, 2]], -1) + jnp.array([0, 0, -1.0])
    return model, dataclasses.replace(state, v=v, history=history)


def pushed(model, push):
    return model.replace(forces=(UniformAcceleration(push, jnp.array(0.0), jnp.array(0.009)),))


def made_of(model, youngs_modulus):
    return model.replace(materials=(solid(len(model.mass), youngs_modulus),))


def run(model, state):
    return rollout(model, state, frame_count=2, substeps=6)


def same(got, runs, **tolerance):
    """Every leaf of ``got`` is the stack of those of single ``runs``."""
    expected = jax.tree.map(lambda *leaves: np.stack(leaves), *runs)
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, **(tolerance or TOLERANCE)), got, expected)


@pytest.mark.parametrize(("choice", "mixed"), SCENES)
def test_force_fields_side_by_side(choice, mixed, x64):
    """Candidate force fields on one shared state, with the neo-Hookean kernel and with that of the SVD."""
    model, state = scene(choice, mixed=mixed)
    got = jax.vmap(lambda push: run(pushed(model, push), state))(PUSHES)
    runs = [run(pushed(model, push), state) for push in PUSHES]
    same(got, runs)
    assert np.ptp(np.asarray(got[0].x), axis=0).max() > 1e-4  # the candidates do differ


@pytest.mark.parametrize("choice", CHOICES)
def test_materials_side_by_side(choice, x64):
    """Candidate stiffnesses, each with a force of its own."""
    model, state = scene(choice)

    def one(youngs_modulus, push):
        return run(made_of(pushed(model, push), youngs_modulus), state)

    same(jax.vmap(one)(STIFFNESS, PUSHES), [one(E, push) for E, push in zip(STIFFNESS, PUSHES)])


def test_whole_models_and_states_side_by_side(x64):
    """Models as stacked pytrees: whatever is an array may differ, masses and time steps included."""
    model, state = scene("auto")
    models = [
        made_of(model, E).replace(mass=f * model.mass, dt=f * model.dt) for E, f in zip(STIFFNESS, (0.8, 1.0))
    ]
    states = [dataclasses.replace(state, v=f * state.v) for f in (1.0, 0.5)]
    stacked = jax.tree.map(lambda *leaves: jnp.stack(leaves), *models)
    starts = jax.tree.map(lambda *leaves: jnp.stack(leaves), *states)
    same(jax.vmap(run)(stacked, starts), [run(*pair) for pair in zip(models, states)])
    advance = jax.jit(step)
    got = jax.jit(jax.vmap(step, in_axes=(0, None)))(stacked, state)
    same(got, [advance(one, state) for one in models])


@pytest.mark.parametrize(
    ("choice", "mixed"),
    [*SCENES[1:2], *(pytest.param(*p.values, marks=(*p.marks, pytest.mark.slow)) for p in SCENES[2:])],
)
@pytest.mark.usefixtures("least_optimised")
def test_gradients_side_by_side(choice, mixed, x64):
    """vmap of grad, and grad of vmap, with respect to force, stiffness and a start that all runs share."""
    model, state = scene(choice, mixed=mixed)

    def loss(push, scale, speed):
        materials = jax.tree.map(lambda a: scale * a, model.materials)
        start = dataclasses.replace(state, v=speed * state.v)
        end, _ = run(pushed(model, push).replace(materials=materials), start)
        return (end.x[:, 0] * end.x[:, 2]).sum() + 1e-2 * (end.F[:, 0, 1] ** 2).sum()

    scales, speed = jnp.array([0.9, 1.0, 0.7]), jnp.array(1.1)
    slope = jax.grad(loss, argnums=(0, 1, 2))
    single = [slope(push, scale, speed) for push, scale in zip(PUSHES, scales)]
    got = jax.vmap(slope, in_axes=(0, 0, None))(PUSHES, scales, speed)
    same(got, single, rtol=1e-10, atol=1e-12)

    def summed(pushes, scales, speed):
        return jax.vmap(loss, in_axes=(0, 0, None))(pushes, scales, speed).sum()

    pushes, stiffer, faster = jax.grad(summed, argnums=(0, 1, 2))(PUSHES, scales, speed)
    same((pushes, stiffer), [one[:2] for one in single], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(faster, sum(one[2] for one in single), rtol=1e-10)
