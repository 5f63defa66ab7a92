"""Leaps that follow each other: the velocity that a launch ends with, and leaps of equal height."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.calibration import GAIN_MIN, MAGNITUDE_MIN
from physagent_jax.forces.terms import Launch, Touchdown
from physagent_jax.mpm import step
from tests.forces.test_balance import compile_entries
from tests.mpm.blocks import block


@pytest.mark.parametrize("before", [0.0, -2.0, 0.9, 4.0])
def test_it_ends_with_its_speed_whatever_went_before(before, x64):
    model, state = block((3, 3, 3), dtype=np.float64, kernels="reference")
    launch = Launch(jnp.array([0.0, 0.0, 1.5]), jnp.array(0.01), jnp.array(0.03))
    model = dataclasses.replace(model, forces=(launch,))
    first = jnp.array([0.3, 0.0, before])
    state, run = dataclasses.replace(state, v=jnp.broadcast_to(first, state.x.shape)), jax.jit(step)
    for index in range(40):
        if index == 9:
            assert np.allclose(state.v, first, atol=1e-9)
        state = run(model, state)
    assert np.allclose(state.v.mean(0), [0.3, 0.0, 1.5], atol=1e-6)
    assert np.ptp(state.v, axis=0).max() < 1e-6


@pytest.mark.parametrize(("speed", "after"), [(3.0, 1.5 - 9.8 * 0.05), (-1.0, -1.0)])
def test_what_springs_up_by_itself_as_well_goes_no_higher(speed, after, x64):
    """Rubber went on with its own rebound, and was thrown up again before it had come down."""
    up = jnp.array([0.0, 0.0, 1.0])
    launch = Launch(1.5 * up, jnp.array(0.0), jnp.array(0.02), jnp.array(9.8))
    x, mass = jnp.zeros((4, 3)), jnp.ones(4)
    change = launch.acceleration(x, jnp.broadcast_to(speed * up, x.shape), mass, 0.07, 1e-3) * 1e-3
    assert np.allclose(speed * up + change, after * up)
    late = launch.acceleration(x, jnp.broadcast_to(3.0 * up, x.shape), mass, 0.02 + 1.5 / 9.8 + 1e-3, 1e-3)
    assert np.allclose(late, 0.0)


@pytest.mark.parametrize(
    ("before", "after"), [(3.0, [0.0, 0.0, 0.35]), (0.2, [0.0, 0.0, 0.2]), (-2.0, [0.3, 0.0, -2.0])]
)
def test_a_rebound_is_slowed_and_a_fall_is_not(before, after, x64):
    """In the window, and as a whole: what moves within it goes on. What has landed slides no farther."""
    model, state = block((3, 3, 3), dtype=np.float64, kernels="reference", gravity=(0.0, 0.0, 0.0))
    up = jnp.array([0.0, 0.0, 1.0])
    limit = Touchdown(jnp.array(0.35), up, jnp.array(0.01), jnp.array(0.03))
    model = dataclasses.replace(model, forces=(limit,))
    first = jnp.array([0.3, 0.0, before])
    state, run = dataclasses.replace(state, v=jnp.broadcast_to(first, state.x.shape)), jax.jit(step)
    for index in range(40):
        if index == 9:
            assert np.allclose(state.v, first, atol=1e-9)
        state = run(model, state)
    assert np.allclose(state.v.mean(0), after, atol=1e-6)
    assert np.ptp(state.v, axis=0).max() < 1e-6


@pytest.mark.parametrize("magnitude", [MAGNITUDE_MIN, 1.6])
def test_the_speed_of_a_rebound_goes_by_the_magnitude_and_not_by_the_gain_that_marks_it(magnitude):
    """It got up at 0.03 m/s: what is soft crept up where it had been pressed together, and did not wobble."""
    stop = dict(constraint_type="enforce_particle_translation", vector=(0, 0, -1), magnitude=magnitude)
    stop |= dict(gain=GAIN_MIN, active_time=(10, 11), held_until=40)
    limit, _ = compile_entries(constraints=[stop])[0]  # and what keeps it upright
    assert float(limit.value) == pytest.approx(0.35 * magnitude / MAGNITUDE_MIN)
