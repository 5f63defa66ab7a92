"""Motions that friction, weight or damping oppose go as far as M says: integrated step by step."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.opposition import find_righting, oppose_blow, oppose_push
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import Opposition

LEFT, UP, T, L = np.array([-1.0, 0, 0]), np.array([0.0, 0, 1]), 2.0, 1.3


def scaled(damping_rate=0.0, **values):
    opposition = Opposition(**values, damping_rate=damping_rate, travel=L, time=T)
    return make_closed_form_scaling(
        extent=L,
        youngs_modulus=1e5,
        density=300,
        duration=T,
        damping_rate=damping_rate,
        opposition=opposition,
    )


def slide(speed, c, damping=0.0, *, until=T, dt=1e-5):
    """Way of what sets out with ``speed`` against a deceleration c."""
    x, v, t = 0.0, speed, 0.0
    while v > 0 and t < until:
        v -= (c + damping * v) * dt
        x, t = x + v * dt, t + dt
    return x


@pytest.mark.parametrize("magnitude", [0.4, 1.0, 1.6, -1.0])
@pytest.mark.parametrize("c", [0.02, 0.6, 3.92])
def test_a_blow_over_the_ground_goes_as_far_as_it_says(c, magnitude):
    scaling = scaled(friction=c)
    speed = oppose_blow(scaling.opposition, scaling.impulse, magnitude, LEFT)
    assert np.sign(speed) == np.sign(magnitude)
    assert slide(abs(speed), c) == pytest.approx(abs(magnitude) * L, rel=1e-3)


@pytest.mark.parametrize("magnitude", [0.4, 1.0, 1.6])
def test_a_throw_rises_as_high_as_it_says(magnitude):
    scaling = scaled(weight=9.8, friction=3.9)
    speed = oppose_blow(scaling.opposition, scaling.impulse, magnitude, UP)
    assert speed**2 / (2 * 9.8) == pytest.approx(magnitude * L)
    down = oppose_blow(scaling.opposition, scaling.impulse, -magnitude, UP)
    assert down == pytest.approx(-magnitude * L / T)  # nothing opposes what is pressed onto the ground


@pytest.mark.parametrize("damping", [0.5, 2.5])
def test_damping_is_made_up_for(damping):
    scaling = scaled(damping)
    assert slide(oppose_blow(None, scaling.impulse, 1.0, LEFT), 0.0, damping) == pytest.approx(L, rel=1e-3)
    assert slide(1e-12, -scaling.translation, damping) == pytest.approx(L, rel=1e-3)
    both = scaled(damping, friction=3.92)
    speed = oppose_blow(both.opposition, both.impulse, 1.0, LEFT)
    assert slide(speed, 3.92, damping) == pytest.approx(L, rel=0.15)


def test_a_push_is_left_with_what_it_says():
    scaling = scaled(friction=3.92, weight=9.8, turning=5.0, tipping=7.0)
    for magnitude in (0.4, 1.6, -1.0):
        push = oppose_push(scaling.opposition, scaling.translation, magnitude, LEFT)
        assert push == pytest.approx(magnitude * 2 * L / T**2)  # friction is overcome while it acts
    lifted = oppose_push(scaling.opposition, scaling.translation, 1.0, UP)
    assert lifted - 9.8 == pytest.approx(2 * L / T**2)
    for axis, righting in ((UP, 5.0), (LEFT, 7.0), (np.array([0, 0.6, 0.8]), 5 * 0.64 + 7 * 0.36)):
        assert find_righting(scaling.opposition, axis) == pytest.approx(righting)


def test_traced_numbers_give_the_same_with_derivatives():
    scaling = scaled(friction=3.92, weight=9.8)

    def speed(magnitude, direction):
        return oppose_blow(scaling.opposition, scaling.impulse, magnitude, direction)

    value, slope = jax.jit(jax.value_and_grad(speed))(jnp.float32(0.9), jnp.asarray(LEFT, jnp.float32))
    assert value == pytest.approx(speed(0.9, LEFT), rel=1e-5)
    assert slope == pytest.approx((speed(0.91, LEFT) - speed(0.89, LEFT)) / 0.02, rel=1e-3)
