"""Time profiles: impulses against closed forms and quadrature, windows, derivatives."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import quad

from physagent_jax.forces.envelope import Envelope
from physagent_jax.mpm.edges import window_fraction

START, END = 0.1337, 0.7713
LENGTH = END - START
# Each profile, written down anew as a function of the time since its start, and its integral.
CASES = {
    "constant": (Envelope.constant(START, END), lambda s: 1.0, LENGTH),
    "ramp": (
        Envelope.ramp(0.2, 0.3, START, END),
        lambda s: min(s / 0.2, 1.0, (LENGTH - s) / 0.3),
        LENGTH - 0.25,
    ),
    "rise only": (Envelope.ramp(0.2, 0.0, START, END), lambda s: min(s / 0.2, 1.0), LENGTH - 0.1),
    "fall only": (Envelope.ramp(0.0, 0.3, START, END), lambda s: min(1.0, (LENGTH - s) / 0.3), LENGTH - 0.15),
    "lines that meet": (
        Envelope.ramp(0.5, 1.0, START, END),
        lambda s: min(s / 0.5, LENGTH - s),
        0.5 * LENGTH * LENGTH / 1.5,  # a triangle with its tip at s = LENGTH / 3
    ),
    "pulse": (Envelope.pulse(START, END), lambda s: np.sin(np.pi * s / LENGTH) ** 2, LENGTH / 2),
    "sine": (
        Envelope.sine(1.7, 0.4, START, END),
        lambda s: np.sin(2 * np.pi * 1.7 * s + 0.4),
        (np.cos(0.4) - np.cos(2 * np.pi * 1.7 * LENGTH + 0.4)) / (2 * np.pi * 1.7),
    ),
}
cases = pytest.mark.parametrize("case", CASES)


def impulse(envelope, dt, dtype, until=1.0):
    """The sum of mean * dt over a clip whose clock runs as the simulator's."""
    return _integrate(envelope, jnp.asarray(dt, dtype), round(until / dt))


@jax.jit
def _integrate(envelope, dt, steps):
    def step(_, carry):
        time, total = carry
        return time + dt, total + dt * envelope.mean(time, dt)

    return jax.lax.fori_loop(0, steps, step, (jnp.zeros_like(dt), jnp.zeros_like(dt)))[1]


@cases
@pytest.mark.parametrize("dt", [1e-4, 2.5e-3])
def test_total_impulse_in_single_precision(case, dt):
    envelope, _, integral = CASES[case]
    total = impulse(envelope, dt, np.float32)
    assert total.dtype == jnp.float32
    np.testing.assert_allclose(total, integral, rtol=1e-3)


@cases
@pytest.mark.parametrize("dt", [1e-4, 7e-3, 0.21])
def test_total_impulse_does_not_depend_on_the_step(case, dt, x64):
    """Even steps longer than the ramps deliver the integral: the means are exact."""
    envelope, _, integral = CASES[case]
    np.testing.assert_allclose(impulse(envelope, dt, np.float64, until=1.05), integral, rtol=1e-10)


@cases
@pytest.mark.parametrize(
    "window", [(0.0, 0.1), (0.1, 0.05), (0.2, 0.01), (0.3, 0.3), (0.7, 0.2), (0.0, 1.0), (0.8, 0.1)]
)
def test_mean_is_the_integral_over_the_overlap(case, window, x64):
    envelope, profile, _ = CASES[case]
    time, dt = window
    low, high = max(time, START), min(time + dt, END)
    expected = 0.0
    if high > low:
        kinks = [START + s for s in (0.2, LENGTH - 0.3, LENGTH / 3)]
        inside = [k for k in kinks if low < k < high] or None
        expected = quad(lambda t: profile(t - START), low, high, points=inside, epsabs=1e-13)[0] / dt
    np.testing.assert_allclose(envelope.mean(jnp.asarray(time), jnp.asarray(dt)), expected, atol=1e-12)


def test_a_constant_envelope_is_the_window(x64):
    envelope = Envelope.constant(START, END)
    for time in np.linspace(0, 1, 23):
        for dt in (1e-3, 0.2):
            assert envelope.mean(time, dt) == window_fraction(time, dt, START, END)


def test_an_envelope_without_a_window_begins_at_zero_and_never_ends(x64):
    time, dt = jnp.asarray(1000.95), jnp.asarray(0.1)
    for envelope, late in (
        (Envelope.constant(), 1),
        (Envelope.ramp(0.2), 1),
        (Envelope.sine(0.25), np.sinc(0.025)),
    ):
        np.testing.assert_allclose(envelope.mean(time, dt), late, rtol=1e-9)
        np.testing.assert_array_equal(envelope.mean(jnp.asarray(-0.2), dt), 0)


@cases
def test_derivatives_match_finite_differences(case, x64):
    """With respect to every number of the profile, where the profile has no kink."""
    envelope = jax.tree.map(jnp.asarray, CASES[case][0])

    @jax.jit
    def mean(envelope):
        times = jnp.array([0.11, 0.25, 0.44, 0.61, 0.75])
        return jax.vmap(lambda time: envelope.mean(time, 0.0431))(times).sum()

    leaves, tree = jax.tree.flatten(envelope)
    for index, slope in enumerate(jax.tree.leaves(jax.jit(jax.grad(mean))(envelope))):
        if case in ("rise only", "fall only") and leaves[index] == 0:
            continue  # one-sided: a ramp cannot be shorter than 0
        moved = [
            mean(jax.tree.unflatten(tree, [*leaves[:index], leaves[index] + h, *leaves[index + 1 :]]))
            for h in (1e-6, -1e-6)
        ]
        np.testing.assert_allclose(slope, (moved[0] - moved[1]) / 2e-6, rtol=1e-6, atol=1e-8)


@cases
def test_derivatives_stay_finite_at_the_windows_ends(case):
    envelope = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), CASES[case][0])
    slope = jax.jit(jax.grad(lambda envelope, time: envelope.mean(time, jnp.float32(0.01))))
    for time in (0.0, START, END - 0.01, END, 0.9):
        slopes = slope(envelope, jnp.float32(time))
        assert all(np.isfinite(slope) for slope in jax.tree.leaves(slopes))
