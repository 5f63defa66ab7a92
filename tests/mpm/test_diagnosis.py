"""The message about a frame that is given up."""

from __future__ import annotations

import warnings

import jax.numpy as jnp
import numpy as np

from physagent_jax.mpm import Grid, Model, NeoHookean, State
from physagent_jax.mpm.diagnosis import Breach, Fault, explain_failure


def test_a_load_beyond_single_precision_is_told_without_noise():
    x = jnp.asarray(np.stack(np.meshgrid(*[[0.4, 0.5, 0.6]] * 3), -1).reshape(-1, 3), jnp.float32)
    ones = jnp.ones(len(x), jnp.float32)
    law = NeoHookean(1e4 * ones, 1e4 * ones)
    gravity = jnp.asarray([0, 0, -1e6], jnp.float32)
    model = Model(Grid.whole(1.0, 10), jnp.float32(1e-3), gravity, 1e4 * ones, 1e-37 * ones, (law,))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        error = explain_failure(1, [Breach(Fault.CRUSHED, "crushed")], False, model, State.at_rest(x))
    # rho |g| L = 1e41 kg/m^3 x 1e6 m/s^2 x 0.2 m
    assert "a pressure of some 2e+46 Pa" in str(error)
