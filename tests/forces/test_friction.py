"""A push over the ground overcomes friction along its way and holds the object upright, with rigid fields alone."""

import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.terms import PushCompensation

pytestmark = pytest.mark.usefixtures(
    "least_optimised"
)  # derivatives of small scenes: to compile takes longest

FRICTION, LEVER, WAY = 3.9, 0.4, np.array([-0.6, 0.8, 0.0])


@pytest.fixture
def block(x64):
    generator = np.random.default_rng(0)
    x = generator.uniform(-1, 1, (400, 3)) * [0.3, 0.2, 0.5]
    mass = generator.uniform(1, 2, 400)
    return x - np.average(x, axis=0, weights=mass), mass


def find_field(block, v, *, speed=0.0, lever=LEVER, time=0.25, feet=None):
    x, mass = block
    numbers = [jnp.asarray(n) for n in (WAY, FRICTION, 2.0, speed, lever, 0.0, 0.0, 1.0)]
    a = PushCompensation(*numbers, feet=feet).acceleration(
        jnp.asarray(x), jnp.asarray(v), jnp.asarray(mass), jnp.asarray(time), jnp.asarray(1e-4)
    )
    return np.asarray(a)


def act(block, v, **more):
    x, mass = block
    a = find_field(block, v, **more)
    force, moment = (
        (mass[:, None] * a).sum(0) / mass.sum(),
        (mass[:, None] * np.cross(x, a)).sum(0) / mass.sum(),
    )
    return force, moment


def carried(block, speed, spin=(0.0, 0.0, 0.0)):
    return speed * WAY + np.cross(np.asarray(spin), block[0])


def test_on_its_way_it_adds_friction_and_friction_s_moment(block):
    force, moment = act(block, carried(block, 0.5))  # 2 m/s^2 for 0.25 s
    assert force == pytest.approx(FRICTION * WAY)
    assert moment == pytest.approx(np.cross([0, 0, -LEVER], force), rel=1e-3, abs=1e-4)


def test_at_the_feet_it_does_the_same_and_leaves_the_rest_in_peace(block):
    x, mass = block
    lever = float(-x[:, 2].min())
    feet = np.exp(-(x[:, 2] + lever) / 0.02)
    feet = jnp.asarray(feet / np.average(feet, weights=mass))
    even, low = (act(block, carried(block, 0.5), lever=lever, feet=weights) for weights in (None, feet))
    for one, other in zip(even, low):
        np.testing.assert_allclose(other, one, rtol=1e-3, atol=1e-3)
    wide, height = abs(x @ WAY) > 0.2, x[:, 2] + lever
    even, low = (
        find_field(block, carried(block, 0.5), lever=lever, feet=weights) for weights in (None, feet)
    )
    assert abs(even[wide & (height > 0.2), 2]).mean() > 0.5 * FRICTION
    assert abs(low[wide & (height > 0.2), 2]).mean() < 0.1 * FRICTION


def test_a_brake_lets_friction_help_no_more_than_it_says(block):
    """Set out with 1 m/s against its way, it still moves so after 0.25 s: friction is overcome that way."""
    force, _ = act(block, carried(block, -0.5), speed=-1.0)
    assert force == pytest.approx(-FRICTION * WAY)


def test_it_never_brakes_nor_drives_beyond_twice_friction(block):
    assert act(block, carried(block, 9.0))[0] == pytest.approx(np.zeros(3))
    assert act(block, carried(block, -9.0))[0] == pytest.approx(2 * FRICTION * WAY)


def test_what_begins_to_tip_is_held_and_what_may_turn_is_not(block):
    spin = np.array([0.02, -0.01, 0.015])
    upright = act(block, carried(block, 0.5))[1]
    held = act(block, carried(block, 0.5, spin))[1]
    assert (held - upright) @ spin < 0
    assert act(block, carried(block, 0.5, spin), lever=0.0)[1] == pytest.approx(np.zeros(3), abs=1e-9)
