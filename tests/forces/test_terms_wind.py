"""Wind drags as the closed forms say, for any step, and never past the air."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from physagent_jax.forces.envelope import Envelope
from physagent_jax.forces.terms import Wind, make_still_air

ALONG = jnp.array([0.6, 0.0, 0.8], jnp.float32)


def wind(speed=5.0, linear_drag=0.0, quadratic_drag=0.0, envelope=None, **rest):
    return Wind(
        np.array([0.6, 0.0, 0.8]), speed, linear_drag, quadratic_drag, envelope or Envelope.constant(), **rest
    )


def blown(term, v, *, dt, steps, gravity=(0, 0, 0), time=0.0):
    """Velocities after ``steps`` of a plain loop, shape (n, 3)."""
    v = jnp.atleast_2d(jnp.asarray(v))
    dt, gravity, time = (jnp.asarray(value, v.dtype) for value in (dt, gravity, time))
    return _integrate(term, v, dt, steps, gravity, time)


@jax.jit
def _integrate(term, v, dt, steps, gravity, time):
    def step(_, carry):
        v, time = carry
        return v + dt * (term.acceleration(jnp.zeros_like(v), v, None, time, dt) + gravity), time + dt

    return jax.lax.fori_loop(0, steps, step, (v, time))[0]


def test_linear_drag_is_an_exponential_approach_for_any_step(x64):
    term, v0 = wind(5.0, linear_drag=3.0), np.array([1.0, -2.0, 0.5])
    air = 5.0 * np.array([0.6, 0.0, 0.8])
    expected = air + (v0 - air) * np.exp(-3.0 * 0.6)
    for steps in (1, 7, 600):
        np.testing.assert_allclose(blown(term, v0, dt=0.6 / steps, steps=steps)[0], expected, rtol=1e-12)


def test_quadratic_drag_is_a_hyperbolic_approach_for_any_step(x64):
    term, v0 = wind(5.0, quadratic_drag=0.7), np.array([1.0, -2.0, 0.5])
    air = 5.0 * np.array([0.6, 0.0, 0.8])
    expected = air + (v0 - air) / (1 + 0.7 * np.linalg.norm(v0 - air) * 2.0)
    for steps in (1, 7, 600):
        np.testing.assert_allclose(blown(term, v0, dt=2.0 / steps, steps=steps)[0], expected, rtol=1e-12)


@pytest.mark.parametrize("k1", [1e-4, 0.02, 0.5])
def test_both_drags_together_match_an_integrator(k1, x64):
    air, v0 = 5.0 * np.array([0.6, 0.0, 0.8]), np.array([1.0, -2.0, 0.5])

    def slope(_, v):
        return k1 * (air - v) + 0.3 * np.linalg.norm(air - v) * (air - v)

    expected = solve_ivp(slope, (0, 1.5), v0, rtol=1e-11, atol=1e-12).y[:, -1]
    got = blown(wind(5.0, k1, 0.3), v0, dt=0.5, steps=3)[0]
    np.testing.assert_allclose(got, expected, rtol=1e-9)


@pytest.mark.parametrize(("k1", "k2"), [(4.0, 0.0), (0.0, 0.25), (1.0, 0.2)])
def test_terminal_velocity_under_gravity(k1, k2, x64):
    """g = k1 v + k2 v^2; forces are added at the same v, so the error is g dt / 2 to first order."""
    exact = 9.8 / k1 if k2 == 0 else (-k1 + np.sqrt(k1**2 + 4 * k2 * 9.8)) / (2 * k2)
    term = make_still_air(k1, k2, Envelope.constant())
    fall = [
        -float(blown(term, np.zeros(3), dt=dt, steps=round(20 / dt), gravity=np.array([0, 0, -9.8]))[0, 2])
        for dt in (2e-3, 1e-3)
    ]
    np.testing.assert_allclose(fall, exact, rtol=5e-3)
    np.testing.assert_allclose([f - exact for f in fall], [9.8e-3, 4.9e-3], rtol=0.02)


@pytest.mark.parametrize(("k1", "k2"), [(1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (1e6, 1e6)])
@pytest.mark.parametrize("dt", [1e-3, 1.0, 100.0])
def test_a_stiff_drag_never_passes_the_air(k1, k2, dt):
    """Single precision; k dt from 1e-3 to 1e8."""
    rng = np.random.default_rng(0)
    v = jnp.asarray(rng.normal(size=(50, 3)) * 4, jnp.float32)
    push = jax.jit(Wind(ALONG, 3.0, k1, k2, Envelope.constant()).acceleration)
    air = 3.0 * np.asarray(ALONG)
    before = np.asarray(v) - air
    for _ in range(4):
        v = v + jnp.float32(dt) * push(jnp.zeros_like(v), v, None, jnp.float32(0), jnp.float32(dt))
        after = np.asarray(v) - air
        round_off = 1e-5
        assert ((after * before).sum(1) >= -round_off * np.linalg.norm(before, axis=1)).all()
        assert (np.linalg.norm(after, axis=1) <= np.linalg.norm(before, axis=1) + round_off).all()
        before = after
    if min(k1, k2) > 1e3 or dt == 100.0 and k1 > 0:
        np.testing.assert_allclose(before, 0, atol=1e-5)


def test_a_gust_that_ramps_up_matches_its_closed_form(x64):
    """v' = k (u t / T - v) from rest: v = (u / T) (t - (1 - exp(-k t)) / k)."""
    k, T = 4.0, 1.0
    term = wind(5.0, linear_drag=k, envelope=Envelope.ramp(T, 0.0, 0.0, T))
    expected = 5.0 / T * (T - (1 - np.exp(-k * T)) / k)
    errors = [float(blown(term, np.zeros(3), dt=T / n, steps=n)[0, 2]) - 0.8 * expected for n in (50, 100)]
    np.testing.assert_allclose(errors[1], 0, atol=2e-4)
    np.testing.assert_allclose(errors[0] / errors[1], 4, rtol=0.02)  # second order in dt


def test_nothing_is_dragged_outside_the_window(x64):
    """Before and after its window a wind does nothing; a step that straddles the end drags for its share."""
    term = wind(5.0, linear_drag=2.0, envelope=Envelope.constant(0.5, 1.03))
    v0 = np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(blown(term, v0, dt=0.1, steps=5)[0], v0)
    np.testing.assert_array_equal(blown(term, v0, dt=0.1, steps=5, time=1.1)[0], v0)
    air = 5.0 * np.array([0.6, 0.0, 0.8])
    whole = blown(term, v0, dt=0.1, steps=16)[0]
    np.testing.assert_allclose(whole, air + (v0 - air) * np.exp(-2.0 * 0.53), rtol=1e-12)


def test_still_air_stops_and_keeps_the_direction(x64):
    v0 = np.array([1.0, -2.0, 0.5])
    v = np.asarray(blown(make_still_air(0.3, 0.4, Envelope.constant()), v0, dt=0.5, steps=20)[0])
    np.testing.assert_allclose(np.cross(v, v0), 0, atol=1e-12)
    assert 0 < v @ v0 < 0.02 * (v0 @ v0)


def test_a_cylinder_and_a_region_confine_the_wind(x64):
    """The cylinder is unbounded along the wind; only what is within its radius and region is blown."""
    center, along = np.array([1.0, 1.0, 1.0]), np.array([0.6, 0.0, 0.8])
    across = np.array([-0.8, 0.0, 0.6])
    x = jnp.asarray(
        [
            center + 7 * along + 0.29 * across,
            center - 3 * along + 0.31 * across,
            center + np.array([0, 0.2, 0]),
        ]
    )
    everywhere = wind(5.0, 2.0)
    jet = wind(5.0, 2.0, center=center, radius=0.3, weight=jnp.array([1.0, 1.0, 0.0]))
    v = jnp.zeros_like(x)
    full = np.asarray(everywhere.acceleration(x, v, None, 0.0, 0.01))
    np.testing.assert_array_equal(jet.acceleration(x, v, None, 0.0, 0.01), full * [[1], [0], [0]])
    assert (np.linalg.norm(full, axis=1) > 1).all()


def test_derivatives_match_finite_differences_and_exist_at_rest_in_the_air(x64):
    rng = np.random.default_rng(1)
    x, v = jnp.asarray(rng.normal(size=(6, 3))), jnp.asarray(rng.normal(size=(6, 3)))
    probe = jnp.asarray(rng.normal(size=(6, 3)))

    @jax.jit
    def loss(speed, k1, k2, v):
        field = wind(speed, k1, k2).acceleration(x, v, None, 0.0, 0.3)
        return (probe * field).sum()

    slopes = jax.jit(jax.grad(loss, argnums=(0, 1, 2, 3)))
    for k1 in (0.05, 0.2, 2.0):
        for argument, here in enumerate(at := (2.0, k1, 0.4, v)):
            slope = slopes(*at)[argument]
            h = 1e-6 * jnp.ones_like(here)
            up, down = ((*at[:argument], here + s * h, *at[argument + 1 :]) for s in (1, -1))
            np.testing.assert_allclose(slope.sum(), (loss(*up) - loss(*down)) / 2e-6, rtol=1e-6, atol=1e-8)
    still = slopes(0.0, 0.0, 0.0, jnp.zeros_like(v))
    assert all(np.isfinite(np.asarray(slope)).all() for slope in still)
