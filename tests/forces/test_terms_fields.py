"""Attractor, vortex, turbulence and uniform field: mechanics, statistics, exact gradients."""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.envelope import Envelope
from physagent_jax.forces.terms import Attractor, Turbulence, UniformAcceleration, UniformField, Vortex
from physagent_jax.mpm import step
from physagent_jax.mpm.energy import momentum
from tests.mpm.blocks import block

ALWAYS = Envelope.constant()
POINT = np.array([0.3, -0.2, 0.5])


def attractor(strength=1.5, power=2.0, softening=0.0, **rest):
    return Attractor(POINT, strength, power, softening, rest.pop("envelope", ALWAYS), **rest)


def vortex(swirl=2.0, inward=0.7, axial=-0.4, core=0.3, power=1.0, **rest):
    axis = np.array([2.0, -1.0, 2.0]) / 3
    return Vortex(POINT, axis, swirl, inward, axial, core, power, rest.pop("envelope", ALWAYS), **rest)


def turbulence(seed=0, modes=64, dtype=np.float64, **rest):
    defaults = dict(strength=2.5, length_scale=0.4, time_scale=0.8, envelope=ALWAYS)
    return Turbulence.from_seed(seed, modes=modes, dtype=dtype, **{**defaults, **rest})


TERMS = {
    "gravity": attractor(softening=0.2),
    "spring": attractor(power=-1.0),
    "constant pull": attractor(power=0.0, softening=0.3, strength=-1.0),
    "logarithmic": attractor(power=1.0, softening=0.1),
    "vortex": vortex(),
    "vortex without fall-off": vortex(power=0.0),
    "steep vortex": vortex(power=2.5, inward=0.0),
}


@jax.jit
def _evaluate(term, x, time, dt):
    return term.acceleration(x, None, None, time, dt)


def at(term, x, time=0.0, dt=1e-3):
    return _evaluate(term, jnp.asarray(x), time, dt)


def scattered(count=40, seed=0):
    return jnp.asarray(np.random.default_rng(seed).uniform(-1, 1, (count, 3)))


@jax.jit
def gradient(term, x, time, dt):
    return term.gradient(x, time, dt)


@jax.jit
def jacobian(term, x, time, dt):
    """d acceleration / d x of every particle by automatic differentiation, shape (n, 3, 3)."""
    one = lambda y: term.acceleration(y[None], None, None, time, dt)[0]  # noqa: E731
    return jax.vmap(jax.jacfwd(one))(x)


# --- all terms ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*TERMS, "turbulence"])
def test_gradient_is_the_derivative_of_the_acceleration(name, x64):
    term = turbulence() if name == "turbulence" else TERMS[name]
    term = dataclasses.replace(term, envelope=Envelope.ramp(1.0, 0.0, 0.0, 2.0))
    x, time, dt = scattered(), 0.37, 0.01
    expected = jacobian(term, x, time, dt)
    np.testing.assert_allclose(gradient(term, x, time, dt), expected, rtol=1e-10, atol=1e-12)
    weight = jnp.asarray(np.arange(40) % 2, x.dtype)
    half = dataclasses.replace(term, weight=weight)
    np.testing.assert_allclose(
        gradient(half, x, time, dt), weight[:, None, None] * expected, rtol=1e-10, atol=1e-12
    )
    np.testing.assert_allclose(at(half, x, time, dt), weight[:, None] * at(term, x, time, dt), rtol=1e-12)


@pytest.mark.parametrize("name", [*TERMS, "turbulence", "uniform"])
def test_an_envelope_scales_the_whole_term(name, x64):
    term = {"turbulence": turbulence(), "uniform": UniformField(np.array([1.0, 2, 3]), ALWAYS), **TERMS}[name]
    x, time, dt = scattered(), 0.37, 0.01
    swung = dataclasses.replace(term, envelope=Envelope.sine(0.8, 0.3))
    factor = np.sin(2 * np.pi * 0.8 * (time + dt / 2) + 0.3) * np.sinc(0.8 * dt)
    np.testing.assert_allclose(at(swung, x, time, dt), factor * at(term, x, time, dt), rtol=1e-10)
    over = dataclasses.replace(term, envelope=Envelope.constant(0.0, 0.2))
    np.testing.assert_array_equal(at(over, x, time, dt), 0)


@pytest.mark.parametrize("name", [*TERMS, "turbulence"])
def test_single_precision_stays_single_and_is_finite_at_the_centre(name):
    term = turbulence(dtype=np.float32) if name == "turbulence" else TERMS[name]
    term = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), term)
    x = jnp.asarray(np.stack([POINT, POINT + 1e-12, POINT + 1.0]), jnp.float32)

    def total(term, x):
        field = term.acceleration(x, None, None, jnp.float32(0.1), jnp.float32(1e-3))
        assert field.dtype == jnp.float32
        return (field * jnp.arange(1.0, 4.0, dtype=jnp.float32)).sum()

    slopes = jax.tree.leaves(jax.jit(jax.grad(total, argnums=(0, 1)))(term, x))
    assert all(np.isfinite(np.asarray(slope)).all() for slope in slopes)
    assert np.isfinite(np.asarray(gradient(term, x, jnp.float32(0.1), jnp.float32(1e-3)))).all()


# --- uniform -----------------------------------------------------------------------------------------


def test_a_uniform_field_in_the_simulator_delivers_the_envelopes_integral(x64):
    model, state = block(dt=2e-3, dtype=np.float64)
    pulse = UniformField(jnp.array([0.0, 3.0, 0.0]), Envelope.pulse(0.0131, 0.0752))
    model = model.replace(forces=(pulse,))
    end = jax.jit(lambda s: jax.lax.fori_loop(0, 50, lambda _, s: step(model, s), s))(state)
    change = momentum(model, end) / model.mass.sum()
    np.testing.assert_allclose(change, [0, 3.0 * (0.0752 - 0.0131) / 2, 0], rtol=1e-9, atol=1e-12)


def test_a_uniform_field_with_a_constant_envelope_is_a_uniform_acceleration(x64):
    value, weight = jnp.array([1.0, -2.0, 0.5]), jnp.asarray(np.arange(40) % 3 / 2)
    field = UniformField(value, Envelope.constant(0.2, 0.5), weight)
    same = UniformAcceleration(value, 0.2, 0.5, weight)  # type: ignore[arg-type]
    for time in (0.1, 0.195, 0.3, 0.497):
        np.testing.assert_allclose(
            at(field, scattered(), time, 0.01), at(same, scattered(), time, 0.01), rtol=1e-12
        )


# --- attractor ---------------------------------------------------------------------------------------


def orbit(term, x, v, dt, steps):
    """A plain symplectic (kick-drift-kick) integration of one particle; all positions and velocities."""

    return _integrate(term, jnp.asarray(x), jnp.asarray(v), dt, steps)


@partial(jax.jit, static_argnums=4)
def _integrate(term, x, v, dt, steps):
    def move(carry, _):
        x, v = carry
        v = v + 0.5 * dt * at(term, x[None])[0]
        x = x + dt * v
        v = v + 0.5 * dt * at(term, x[None])[0]
        return (x, v), (x, v)

    return jax.lax.scan(move, (x, v), None, length=steps)[1]


@pytest.mark.parametrize("name", ["gravity", "spring", "constant pull", "logarithmic"])
def test_a_particle_keeps_its_energy(name, x64):
    term = TERMS[name]
    x, v = orbit(term, POINT + np.array([0.5, 0, 0.1]), np.array([0.1, 0.9, -0.3]), 5e-4, 8000)
    kinetic, potential = 0.5 * (v**2).sum(-1), term.potential(x)
    energy = kinetic + potential
    assert np.ptp(kinetic) > 0.1  # the two do exchange
    np.testing.assert_allclose(energy, energy[0], atol=2e-5)


@pytest.mark.parametrize("name", ["gravity", "spring", "constant pull", "logarithmic"])
def test_the_acceleration_is_downhill(name, x64):
    term, x = TERMS[name], scattered()
    slope = jax.grad(lambda x: term.potential(x).sum())(x)
    np.testing.assert_allclose(at(term, x), -slope, rtol=1e-9, atol=1e-12)


def test_an_ellipse_closes_after_keplers_period(x64):
    """T = 2 pi sqrt(a^3 / GM), eccentricity 0.5, from the far end of the ellipse."""
    a, e, gm = 0.6, 0.5, 1.5
    far, speed = a * (1 + e), np.sqrt(gm / a * (1 - e) / (1 + e))
    start, steps = POINT + np.array([0, far, 0]), 8000
    period = 2 * np.pi * np.sqrt(a**3 / gm)
    x, v = orbit(attractor(gm), start, np.array([0, 0, speed]), period / steps, steps)
    np.testing.assert_allclose(x[-1], start, atol=1e-5 * far)
    np.testing.assert_allclose(v[-1], [0, 0, speed], atol=1e-5 * speed)
    near = np.linalg.norm(np.asarray(x) - POINT, axis=1).min()
    np.testing.assert_allclose(near, a * (1 - e), rtol=1e-5)


def test_positive_strength_attracts_with_its_value_at_one_metre(x64):
    x = POINT + np.array([[1.0, 0, 0], [0, 2.0, 0]])
    np.testing.assert_allclose(at(attractor(1.5), x), [[-1.5, 0, 0], [0, -1.5 / 4, 0]], atol=1e-12)
    np.testing.assert_allclose(at(attractor(-1.5, power=3.0), x)[1], [0, 1.5 / 8, 0], atol=1e-12)


# --- vortex ------------------------------------------------------------------------------------------


def test_far_from_its_core_a_vortex_has_the_stated_components(x64):
    term = vortex(swirl=2.0, inward=0.7, axial=-0.4, core=1e-3, power=1.0)
    axis = np.array([2.0, -1.0, 2.0]) / 3
    out = np.array([1.0, 2.0, 0.0]) / np.sqrt(5)
    around = np.cross(axis, out)
    x = POINT + 0.8 * axis + 0.25 * out
    field = np.asarray(at(term, x[None])[0]) * (0.25 / 1e-3)
    np.testing.assert_allclose([field @ around, -field @ out, field @ axis], [2.0, 0.7, -0.4], rtol=1e-4)


def test_on_its_axis_a_vortex_only_pushes_along_it(x64):
    axis = np.array([2.0, -1.0, 2.0]) / 3
    np.testing.assert_allclose(at(vortex(), (POINT - 0.4 * axis)[None])[0], -0.4 * axis, atol=1e-12)


def test_inward_pull_balances_a_circle(x64):
    """Without fall-off, a particle at radius R with v^2 = inward R d / r keeps its radius; R = d >> core."""
    term = vortex(swirl=0.0, inward=0.9, axial=0.0, core=1e-4, power=0.0)
    axis, out = np.array([2.0, -1.0, 2.0]) / 3, np.array([1.0, 2.0, 0.0]) / np.sqrt(5)
    speed = np.sqrt(0.9 * 0.5)
    x, _ = orbit(term, POINT + 0.5 * out, speed * np.cross(axis, out), 1e-3, 3000)
    arm = np.asarray(x) - POINT
    np.testing.assert_allclose(np.linalg.norm(arm, axis=1), 0.5, rtol=1e-5)
    np.testing.assert_allclose(arm @ axis, 0, atol=1e-12)


def test_swirl_turns_a_block_of_matter_right_handedly(x64):
    """In the simulator, a vortex about a block's own axis adds the moment of its swirl to the angular momentum."""
    model, state = block(dt=2e-3, dtype=np.float64)
    center = np.asarray(state.x).mean(0)
    term = Vortex(center, np.array([0.0, 0.0, 1.0]), 0.8, 0.0, 0.0, 10.0, 1.0, ALWAYS)
    model = model.replace(forces=(term,))
    end = jax.jit(lambda s: jax.lax.fori_loop(0, 20, lambda _, s: step(model, s), s))(state)
    arm = np.asarray(state.x) - center
    # The core is far wider than the block: a rigid spin-up at 0.08 rad/s^2. An APIC particle turns as well, with
    # its own moment of inertia, m dx^2 / 2.
    spin = np.einsum("n,nij->ij", np.asarray(model.mass), np.asarray(end.C))
    turned = np.cross(arm, np.asarray(end.v))[:, 2] * np.asarray(model.mass)
    inertia = ((arm[:, :2] ** 2).sum(1) * np.asarray(model.mass)).sum()
    np.testing.assert_allclose(turned.sum() / inertia, 0.08 * 0.04, rtol=1e-2)
    np.testing.assert_allclose(0.5 * (spin[1, 0] - spin[0, 1]) / model.mass.sum(), 0.08 * 0.04, rtol=1e-2)


# --- turbulence --------------------------------------------------------------------------------------


def test_turbulence_has_no_divergence(x64):
    gradients = np.asarray(jacobian(turbulence(), scattered(), 0.3, 1e-3))
    size = np.linalg.norm(gradients, axis=(1, 2)).max()
    assert size > 1
    np.testing.assert_allclose(np.trace(gradients, axis1=1, axis2=2), 0, atol=1e-13 * size)


def test_a_seed_gives_one_field_and_another_seed_another(x64):
    x = scattered()
    a, b, other = (np.asarray(at(turbulence(seed), x)) for seed in (3, 3, 4))
    np.testing.assert_array_equal(a, b)
    assert np.abs((a * other).sum()) < 0.5 * (a * a).sum()


def sampled(shift=(0.0, 0.0, 0.0), lag=0.0, seeds=96, **rest):
    """Fields of many seeds at random points, and the same at points and times further on, shape (seeds, n, 3)."""
    x = np.random.default_rng(11).uniform(-3, 3, (64, 3))
    terms = [turbulence(seed, **rest) for seed in range(seeds)]
    here = np.stack([np.asarray(at(term, x, 0.2)) for term in terms])
    there = np.stack([np.asarray(at(term, x + np.asarray(shift), 0.2 + lag)) for term in terms])
    return here, there


def test_root_mean_square_is_the_strength(x64):
    here, _ = sampled()
    np.testing.assert_allclose(np.sqrt((here**2).sum(-1).mean()), 2.5, rtol=0.01)
    np.testing.assert_allclose((here**2).mean((0, 1)), 2.5**2 / 3, rtol=0.05)  # isotropic
    np.testing.assert_allclose(here.mean((0, 1)), 0, atol=0.05 * 2.5)


@pytest.mark.parametrize("distance", [0.2, 0.4, 0.8])
def test_correlation_over_distance(distance, x64):
    """Length scale 0.4: exp(-q) along, (1 - q) exp(-q) across the line between the points."""
    here, there = sampled(shift=(distance, 0.0, 0.0))
    q = 0.5 * (distance / 0.4) ** 2
    correlation = (here * there).mean((0, 1)) / (2.5**2 / 3)
    np.testing.assert_allclose(correlation[0], np.exp(-q), atol=0.06)
    np.testing.assert_allclose(correlation[1:], (1 - q) * np.exp(-q), atol=0.06)


@pytest.mark.parametrize("lag", [0.4, 0.8, 1.6])
def test_correlation_over_time(lag, x64):
    here, there = sampled(lag=lag)
    correlation = (here * there).sum(-1).mean() / 2.5**2
    np.testing.assert_allclose(correlation, np.exp(-0.5 * (lag / 0.8) ** 2), atol=0.04)


def test_scales_of_turbulence_stretch_the_same_field(x64):
    """Twice the length and time scales, at twice the place and time: the same acceleration."""
    x = scattered()
    wide = turbulence(length_scale=0.8, time_scale=1.6)
    np.testing.assert_allclose(at(wide, 2 * x, 0.6, 2e-3), at(turbulence(), x, 0.3, 1e-3), rtol=1e-10)
