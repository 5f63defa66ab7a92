"""Sand, snow and fluid against closed forms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from physagent_jax.mpm import FixedCorotated
from physagent_jax.mpm.materials.base import TORN
from tests.mpm.single_points import (
    LAM,
    MU,
    E,
    K,
    after_return,
    diagonal,
    energy,
    material,
    project,
    random_F,
    rotations,
    stress,
)

ANGLES = np.deg2rad([5.0, 20.0, 35.0, 50.0])


def principal(tau):
    return np.linalg.eigvalsh(tau)


@pytest.mark.parametrize("angle", ANGLES)
def test_sand_triaxial_compression_meets_mohr_coulomb(angle, x64):
    tau, _ = after_return(material("sand", 1, friction_angle=angle), diagonal([-0.3, 0.1, 0.1]))
    t1, t2, t3 = principal(tau[0])
    np.testing.assert_allclose(t2, t3, rtol=1e-10)
    np.testing.assert_allclose(t1 / t3, (1 + np.sin(angle)) / (1 - np.sin(angle)), rtol=1e-10)


@pytest.mark.parametrize("angle", ANGLES)
def test_sand_shear_strength_over_pressure(angle, x64):
    tau, _ = after_return(
        material("sand", 1, friction_angle=angle), diagonal([0.3 - 0.01, -0.01, -0.3 - 0.01])
    )
    low, middle, high = principal(tau[0])
    pressure = -(low + middle + high) / 3
    np.testing.assert_allclose(middle, -pressure, rtol=1e-9)
    ratio = 2 * np.sqrt(3) * np.sin(angle) / (3 - np.sin(angle))
    np.testing.assert_allclose((high - low) / 2 / pressure, ratio, rtol=1e-10)


@pytest.mark.parametrize("angle", [0.0, *ANGLES])
def test_cohesive_soil_uniaxial_compressive_strength_is_mohr_coulombs(angle, x64):
    c = 0.01 * E
    law = material("sand", 1, friction_angle=angle, cohesion=c)

    def tau(lateral):
        return after_return(law, diagonal([-0.3, lateral, lateral]))[0][0]

    # The flow keeps the volume, so that the sides must move outward for them to be free of stress.
    lateral = brentq(lambda e: tau(e)[1, 1], 0, 0.16, xtol=1e-15)
    np.testing.assert_allclose(tau(lateral)[0, 0], -2 * c * np.cos(angle) / (1 - np.sin(angle)), rtol=1e-9)


def test_sand_return_keeps_volume_under_pressure(x64):
    F = diagonal([-0.2, 0.05, 0.03])
    new, gained = project(material("sand", 1), F, jnp.zeros(1))
    np.testing.assert_allclose(np.linalg.det(new), np.linalg.det(F), rtol=1e-13)
    np.testing.assert_array_equal(gained, 0)


def test_sand_without_cohesion_is_free_of_stress_under_tension_and_remembers_the_volume(x64):
    for name in ("sand", "slurry"):
        law = material(name)
        F = 1.05 * random_F(0.05)
        assert 0 < np.log(np.linalg.det(F)).min() < np.log(TORN) < np.log(np.linalg.det(F)).max()
        new, gained = project(law, F, law.initial_history())
        np.testing.assert_allclose(stress(law, new, gained), 0, atol=1e-12 * E)
        np.testing.assert_allclose(gained, np.log(np.minimum(np.linalg.det(F), TORN)), rtol=1e-12)


def test_cohesive_soil_tears_at_the_apex(x64):
    angle, c = 0.5, 0.02 * E
    law = material("sand", 1, friction_angle=angle, cohesion=c)
    tau, gained = after_return(law, diagonal([0.15, 0.05, 0.0]))
    apex = 3 * c / np.tan(angle)  # k / alpha
    np.testing.assert_allclose(tau[0], apex / 3 * np.eye(3), atol=1e-11 * E)
    np.testing.assert_allclose(gained, 0.2 - apex / (3 * K), rtol=1e-12)


def test_clay_without_friction_has_no_apex_and_slurry_only_pressure(x64):
    clay = material("clay", 1)
    tau, gained = after_return(clay, diagonal([0.9, 0.5, 0.4]))
    np.testing.assert_allclose(np.trace(tau[0]), 3 * K * 1.8, rtol=1e-10)
    deviation = tau[0] - np.trace(tau[0]) / 3 * np.eye(3)
    np.testing.assert_allclose(np.linalg.norm(deviation), 2 * np.sqrt(2 / 3) * 0.05 * E, rtol=1e-10)
    assert gained[0] == 0
    tau, _ = after_return(material("slurry", 1), diagonal([0.1, -0.2, -0.05]))
    np.testing.assert_allclose(tau[0], -0.15 * K * np.eye(3), atol=1e-11 * E)


@pytest.mark.parametrize("cohesion", [0.0, 0.02 * E])
def test_volume_gained_in_tension_is_given_back_before_pressure_builds(cohesion, x64):
    law = material("sand", 1, cohesion=cohesion)
    step = 0.008
    F, history, total, energies = jnp.eye(3)[None], jnp.zeros(1), 0.0, []
    path = [step] * 20 + [-step] * 25
    for d in path:
        F, history = project(law, np.exp(d / 3) * F, history)
        total += d
        trace = float(np.log(np.linalg.det(np.asarray(F)))[0])
        np.testing.assert_allclose(trace + history[0], total, atol=1e-13)  # volume is never lost
        assert history[0] >= 0
        energies.append(float(energy(law, F, history)[0]))
    np.testing.assert_allclose(trace, -0.04, atol=1e-12)
    tau = stress(law, F, history)
    np.testing.assert_allclose(tau[0], -0.04 * K * np.eye(3), atol=1e-10 * E)
    # While the gap closes nothing resists, and the stored energy never grows.
    closing = np.asarray(energies[20:40])
    assert np.all(np.diff(closing) <= 1e-12 * E)
    np.testing.assert_allclose(closing[-1], 0, atol=1e-12 * E)


def test_scattered_sand_resists_when_it_is_pressed_together_again(x64):
    law = material("sand", 1)
    F, history = project(law, diagonal([1.0, 1.0, 1.0]), jnp.zeros(1))
    for pressed in (np.log(TORN), 0.01):  # the first closes the gap that it remembers
        F, history = project(law, np.exp(-pressed / 3) * F, history)
    np.testing.assert_allclose(stress(law, F, history)[0], -0.01 * K * np.eye(3), atol=1e-10 * E)


def test_snow_clamps_the_singular_values_and_keeps_the_total_volume(x64):
    law = material("snow")
    F = random_F()
    history = jnp.linspace(0.8, 1.2, law.count)
    new, past = project(law, F, history)
    s, trial = np.linalg.svd(new)[1], np.linalg.svd(F)[1]
    np.testing.assert_allclose(s, np.clip(trial, 1 - 0.03, 1 + 0.01), atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(new) * past, np.linalg.det(F) * history, rtol=1e-12)


def test_snow_hardens_exponentially_up_to_the_cap_and_weakens_when_spread(x64):
    F = diagonal([-0.02, 0.005, 0.0])
    jelly = FixedCorotated(jnp.array([MU]), jnp.array([LAM]))
    for ratio, factor in ((1.0, 1.0), (0.95, np.exp(0.45)), (0.8, 4.0), (1e-6, 4.0), (1.3, np.exp(-2.7))):
        law, history = material("snow", 1), jnp.array([ratio])
        np.testing.assert_allclose(law.hardening_factor(history), factor, rtol=1e-12)
        np.testing.assert_allclose(stress(law, F, history), factor * jelly.stress(F), rtol=1e-12)
        np.testing.assert_allclose(energy(law, F, history), factor * jelly.energy(F), rtol=1e-12)


def test_snow_compaction_hardens_it(x64):
    law = material("snow", 1)
    F, history, factors = jnp.eye(3)[None], jnp.ones(1), []
    for _ in range(20):
        F, history = project(law, np.exp(-0.02) * F, history)
        factors.append(float(law.hardening_factor(history)[0]))
    assert np.all(np.diff(factors) >= 0) and factors[0] == 1.0 and factors[-1] == 4.0
    np.testing.assert_allclose(np.linalg.svd(F)[1], 0.97, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.det(F) * history, np.exp(-0.02 * 60), rtol=1e-12)


def test_snow_stiffness_holds_for_compacted_snow_to_come(x64):
    law = material("snow")
    F, fresh = project(law, random_F(), law.initial_history())
    now = law.stiffness(F, fresh)
    compacted = FixedCorotated(4 * law.mu, 4 * law.lam)
    assert np.all(now >= compacted.stiffness(F) * (1 - 1e-12))


@pytest.mark.parametrize("exponent", [1.0, 2.0, 7.0])
@pytest.mark.parametrize("tension", [False, True])
def test_fluid_follows_taits_equation_and_its_energy_is_the_work_of_the_pressure(exponent, tension, x64):
    law = material("fluid", 3, exponent=exponent, tension=tension)
    J = np.array([0.8, 1.0, 1.1])

    def pressure(J):
        return K / exponent * (J**-exponent - 1) if J < 1 or tension else 0.0

    expected = np.array([pressure(j) for j in J])
    F = rotations()[:3] @ diagonal([0.3, -0.1, -0.2]) * np.cbrt(J)[:, None, None]
    np.testing.assert_allclose(law.pressure(jnp.asarray(J)), expected, rtol=1e-12, atol=1e-12 * E)
    tau = stress(law, F, ())
    np.testing.assert_allclose(tau, -(J * expected)[:, None, None] * np.eye(3), rtol=1e-10, atol=1e-10 * E)
    work = [-quad(pressure, 1.0, j, epsabs=1e-12)[0] for j in J]
    np.testing.assert_allclose(energy(law, F, ()), work, rtol=1e-9, atol=1e-10 * E)
    assert np.all((law.pressure(jnp.asarray(J)) >= 0) | tension)


def test_fluid_bulk_modulus_at_rest(x64):
    law = material("fluid", 1)
    slope = jax.grad(lambda J: law.pressure(J).sum())(jnp.array([1 - 1e-9]))
    np.testing.assert_allclose(slope, -K, rtol=1e-6)


def test_fluid_forgets_shear_but_not_volume(x64):
    law = material("fluid")
    F = random_F()
    new, _ = project(law, F, ())
    J = np.linalg.det(F)
    assert J.min() < 1 and J.max() > TORN
    kept = J if law.tension else np.minimum(J, TORN)
    np.testing.assert_allclose(new, np.cbrt(kept)[:, None, None] * np.eye(3), rtol=1e-12, atol=1e-14)
    inverted, _ = project(law, F @ np.diag([1.0, -1, 1]), ())
    np.testing.assert_allclose(np.linalg.det(inverted), -J, rtol=1e-12)


@pytest.mark.parametrize("angle", ANGLES)
def test_what_is_brittle_breaks_at_its_strength_and_bears_no_tension_afterwards(angle, x64):
    """Uniaxial tension fails at 6 c cos(phi) / (3 + sin(phi)): put tau = diag(t, 0, 0) into the cone."""
    c = 0.05 * E
    glass = material("glass", 1, friction_angle=angle, cohesion=c)
    strength = 6 * c * np.cos(angle) / (3 + np.sin(angle))
    axial = strength / E * np.array([1.0, -LAM / (2 * (LAM + MU)), -LAM / (2 * (LAM + MU))])
    below, above = (jnp.diag(jnp.exp(share * axial))[None] for share in (0.999, 1.001))
    whole, history = glass.project(below, glass.initial_history(), 1e-3)
    np.testing.assert_allclose(principal(glass.stress(whole, history)[0])[-1], 0.999 * strength, rtol=1e-9)
    broken, history = glass.project(above, history, 1e-3)
    np.testing.assert_allclose(glass.stress(broken, history), 0.0, atol=1e-9 * c)
    again, _ = glass.project(below, history, 1e-3)
    np.testing.assert_allclose(glass.stress(again, history), 0.0, atol=1e-9 * c)
