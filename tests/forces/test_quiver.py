"""A quiver drives one mode of the shape, and moves nothing as a whole."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.terms import Quiver
from physagent_jax.forces.terms.quiver import FADES, RATE

SPEED, START, END = 2.0, 0.1, 1.8


def make_box(width, height):
    x = np.random.default_rng(0).uniform(-0.5, 0.5, (4000, 3)) * [width, 0.2, height]
    return jnp.asarray(x), jnp.full(len(x), 1e-3)


def quiver():
    return Quiver(jnp.array([SPEED, 0.0, 0.0]), jnp.asarray(START), jnp.asarray(END))


@pytest.mark.parametrize(("size", "axis"), [((0.3, 1.0), 0), ((1.0, 0.2), 2)], ids=["stands", "lies"])
def test_it_has_no_momentum_and_goes_sideways_or_up_and_down(size, axis, x64):
    x, mass = make_box(*size)
    a = np.asarray(quiver().acceleration(x, jnp.zeros_like(x), mass, jnp.asarray(START), jnp.asarray(1e-3)))
    np.testing.assert_allclose(a.mean(0), 0, atol=1e-9 * np.abs(a).max())
    assert np.abs(a[:, axis]).max() > 0 and not np.delete(a, axis, axis=1).any()
    ends = np.asarray(x)[:, 2 - axis]  # along its longest side
    far, near = np.abs(ends) > 0.45, np.abs(ends) < 0.1
    assert np.abs(a[far, axis]).mean() > 1.5 * np.abs(a[near, axis]).mean()


def test_the_speed_of_its_ends_fades_as_it_goes_to_and_fro(x64):
    """Free matter takes up the wanted speed: |v| exp(-t / FADES) cos(RATE t), a few hundredths of a second late."""
    (x, mass), dt = make_box(0.3, 1.0), 1e-3
    height = x[:, 2] / (x[:, 2] ** 2).sum()

    @jax.jit
    def run(v):
        def advance(v, time):
            v = v + dt * quiver().acceleration(x, v, mass, time, jnp.asarray(dt))
            return v, 0.5 * height @ v[:, 0]

        return jax.lax.scan(advance, v, START + dt * jnp.arange(1500))[1]

    seen = np.abs(run(jnp.zeros_like(x)))
    period = round(2 * np.pi / RATE / dt)
    peaks = np.array([seen[k : k + period].max() for k in range(period, len(seen) - period, period)])
    np.testing.assert_allclose(np.diff(np.log(peaks)), -period * dt / FADES, atol=0.03)
    follows = SPEED * np.exp(-period * dt / FADES)
    assert 0.7 * follows < peaks[0] < 1.05 * follows


def test_it_does_nothing_outside_its_window(x64):
    x, mass = make_box(0.3, 1.0)
    for time in (0.0, END + 0.01):
        assert not quiver().acceleration(x, x, mass, jnp.asarray(time), jnp.asarray(1e-3)).any()
