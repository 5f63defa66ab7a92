"""Leaps that follow each other: the velocity that a launch ends with, and leaps of equal height."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.terms import Launch, Touchdown
from physagent_jax.mpm import step
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
