"""Return mappings against textbook answers: metal, plasticine and foam."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq

from physagent_jax.mpm import Hencky, Plasticine, Viscoplastic, VonMises
from physagent_jax.mpm.materials import (
    hardening_from_deviator_norm,
    softening_from_deviator_norm,
    yield_stress_from_deviator_norm,
)
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

SIGMA_Y = 0.02 * E
H = 0.3 * E


def metal(hardening=0.0):
    return material("von Mises", 1, yield_stress=SIGMA_Y, hardening=hardening)


def axial_stress(law, strain, history=None):
    """Axial Kirchhoff stress of a bar with free sides at a logarithmic strain, and its history."""

    def point(lateral):
        return after_return(law, diagonal([strain, lateral, lateral]), history)

    lateral = brentq(lambda e: point(e)[0][0, 1, 1], -abs(strain), abs(strain), xtol=1e-15)
    tau, history = point(lateral)
    return tau[0, 0, 0], history


def deviator(tau):
    return tau - np.trace(tau, axis1=-2, axis2=-1)[..., None, None] / 3 * np.eye(3)


def norm(tau):
    return np.linalg.norm(tau, axis=(-2, -1))


def test_hencky_uniaxial_strain(x64):
    tau, _ = after_return(material("Hencky", 1), diagonal([0.8, 0.0, 0.0]))
    np.testing.assert_allclose(np.diag(tau[0]), 0.8 * np.array([LAM + 2 * MU, LAM, LAM]), rtol=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
def test_uniaxial_stress_plateau_is_the_yield_stress(sign, x64):
    np.testing.assert_allclose(axial_stress(metal(), sign * 0.019)[0], sign * 0.019 * E, rtol=1e-10)
    for strain in (0.021, 0.1):
        np.testing.assert_allclose(axial_stress(metal(), sign * strain)[0], sign * SIGMA_Y, rtol=1e-10)


def test_pure_shear_plateau_is_the_yield_stress_over_root_three(x64):
    quarter = np.array([[1, -1, 0], [1, 1, 0], [0, 0, np.sqrt(2)]]) / np.sqrt(2)
    tau, _ = after_return(metal(), quarter @ diagonal([0.2, -0.2, 0.0]) @ quarter.T)
    np.testing.assert_allclose(tau[0, 0, 1], SIGMA_Y / np.sqrt(3), rtol=1e-10)
    np.testing.assert_allclose(tau[0].diagonal(), 0, atol=1e-12 * E)


@pytest.mark.parametrize("sign", [1, -1])
def test_uniaxial_strain_yields_and_then_follows_the_bulk_modulus(sign, x64):
    onset = SIGMA_Y / (2 * MU)
    for strain in (0.99 * onset, 1.01 * onset, 0.3):
        tau, alpha = after_return(metal(), diagonal([sign * strain, 0.0, 0.0]))
        plastic = K * strain + 2 / 3 * SIGMA_Y
        expected = (LAM + 2 * MU) * strain if strain < onset else plastic
        np.testing.assert_allclose(tau[0, 0, 0], sign * expected, rtol=1e-10)
        assert (alpha[0] > 0) == (strain > onset)


def test_hardening_slope_under_uniaxial_stress(x64):
    stresses = [axial_stress(metal(H), strain)[0] for strain in (0.05, 0.15)]
    np.testing.assert_allclose((stresses[1] - stresses[0]) / 0.1, E * H / (E + H), rtol=1e-9)
    np.testing.assert_allclose(stresses[0], SIGMA_Y + E * H / (E + H) * (0.05 - SIGMA_Y / E), rtol=1e-9)


def test_history_is_the_equivalent_plastic_strain(x64):
    sigma, alpha = axial_stress(metal(H), 0.1)
    np.testing.assert_allclose(alpha[0], 0.1 - sigma / E, rtol=1e-9)
    np.testing.assert_allclose(sigma, SIGMA_Y + H * alpha[0], rtol=1e-9)


def test_hardened_metal_yields_at_its_new_yield_stress(x64):
    _, alpha = axial_stress(metal(H), 0.1)
    raised = SIGMA_Y + H * float(alpha[0])
    below, above = (axial_stress(metal(H), f * raised / E, alpha) for f in (0.999, 1.001))
    np.testing.assert_array_equal(below[1], alpha)
    assert above[1][0] > alpha[0]


def test_stress_lands_on_the_yield_surface_from_any_trial_state(x64):
    law = material("von Mises")
    F = random_F()
    history = jnp.linspace(0, 0.2, law.count)
    trial = np.sqrt(1.5) * norm(deviator(np.asarray(stress(law, F, history))))
    tau, alpha = after_return(law, F, history)
    q = np.sqrt(1.5) * norm(deviator(tau))
    limit = law.yield_stress + law.hardening * alpha
    yields = trial > law.yield_stress + law.hardening * history
    assert 3 < yields.sum() < law.count
    np.testing.assert_allclose(q[yields], limit[yields], rtol=1e-11)
    np.testing.assert_allclose(q[~yields], trial[~yields], rtol=1e-9, atol=1e-9 * E)


def shear_path(law, steps, history=None, increment=0.002):
    """Isochoric stretching along a fixed turned axis, in small steps; stresses and histories of all steps."""
    Q = rotations()[: law.count]
    step = Q @ diagonal([increment, -increment / 2, -increment / 2]) @ Q.swapaxes(1, 2)
    F = jnp.broadcast_to(jnp.eye(3), step.shape)
    history = law.initial_history() if history is None else history
    taus, pasts = [], []
    for _ in range(steps):
        F, history = project(law, step @ F, history)
        taus.append(np.asarray(stress(law, F, history))[0])
        pasts.append(float(history[0]))
    return np.stack(taus), np.asarray(pasts), F


def deviator_norm_law(steps, bound, hardening=0.0, softening=0.0, increment=0.002):
    """|dev tau| on `shear_path`'s strains for a bound Y on |dev tau|: Y += hardening d gamma - softening d gamma."""
    eps, history = np.zeros(3), []
    for _ in range(steps):
        eps = eps + increment * np.array([1, -0.5, -0.5])
        size = np.linalg.norm(eps)
        d_gamma = max(size - bound / (2 * MU), 0)
        eps = eps * (1 - d_gamma / size)
        history.append(2 * MU * np.linalg.norm(eps))
        bound = max(bound + (hardening - softening) * d_gamma, 0)
    return np.asarray(history)


def test_conversions_from_a_bound_on_the_deviator_norm(x64):
    # Each law as its source states it: a bound Y on |dev tau| that changes with d gamma = |d eps_plastic|.
    # The source updates Y after the return, we within it: the difference is of first order in the step.
    bound, xi, theta = 0.03 * E, 0.4, 0.15 * E
    yield_stress = yield_stress_from_deviator_norm(bound)
    hard = material("von Mises", 1, yield_stress=yield_stress, hardening=hardening_from_deviator_norm(MU, xi))
    taus, _, _ = shear_path(hard, 100)
    np.testing.assert_allclose(
        norm(deviator(taus)), deviator_norm_law(100, bound, hardening=2 * MU * xi), rtol=0.03
    )
    soft = material("plasticine", 1, yield_stress=yield_stress, softening=softening_from_deviator_norm(theta))
    taus, _, _ = shear_path(soft, 80)
    reference = deviator_norm_law(80, bound, softening=theta)
    assert reference[-1] < 0.5 * bound
    np.testing.assert_allclose(norm(deviator(taus)), reference, atol=0.02 * bound)
    perfect = material("von Mises", 1, yield_stress=yield_stress, hardening=0.0)
    np.testing.assert_allclose(norm(deviator(shear_path(perfect, 20)[0]))[-1], bound, rtol=1e-10)


def test_plasticine_softens_linearly_to_a_paste_without_deviator_or_tension(x64):
    law = material("plasticine", 1, yield_stress=SIGMA_Y, softening=0.2 * E)
    taus, alpha, F = shear_path(law, 80)
    q = np.sqrt(1.5) * norm(deviator(taus))
    yielded = np.flatnonzero(alpha > 0)[0]
    expected = np.maximum(SIGMA_Y - 0.2 * E * alpha[yielded:], 0)
    np.testing.assert_allclose(q[yielded:], expected, atol=1e-10 * E)
    assert np.all(np.diff(q[yielded:]) <= 1e-12 * E), "it must never harden"
    assert np.all(np.diff(alpha) >= 0)
    assert q[-1] < 1e-12 * E and alpha[-1] > SIGMA_Y / (0.2 * E)
    history = jnp.asarray(alpha[-1:])
    stretched, squeezed = (np.exp(e) * F for e in (0.1, -0.1))
    assert np.abs(after_return(law, stretched, history)[0]).max() < 1e-10 * E
    np.testing.assert_allclose(energy(law, stretched, history), 0, atol=1e-12 * E)
    np.testing.assert_allclose(
        after_return(law, squeezed, history)[0][0], -0.3 * K * np.eye(3), atol=1e-10 * E
    )


def test_perfectly_plastic_limits_agree(x64):
    F = random_F()
    reference, alpha = after_return(material("von Mises", hardening=0.0), F)
    soft, softened = after_return(material("plasticine", softening=0.0), F)
    np.testing.assert_allclose(soft, reference, atol=1e-11 * E)
    np.testing.assert_allclose(softened, alpha, atol=1e-14)
    foam, _ = after_return(material("foam", plastic_viscosity=0.0), F)
    np.testing.assert_allclose(foam, reference, atol=1e-11 * E)


@pytest.mark.parametrize("softening", [3 * MU, 3 * MU * (1 - 1e-12), 10 * MU])
def test_softening_steeper_than_elastic_unloading_breaks_at_the_first_yield(softening, x64):
    law = material("plasticine", 1, yield_stress=SIGMA_Y, softening=softening)
    onset = SIGMA_Y / (3 * MU)
    whole, alpha = after_return(law, diagonal(np.array([1, -0.5, -0.5]) * 0.99 * onset))
    assert alpha[0] == 0 and np.sqrt(1.5) * norm(deviator(whole)) > 0.9 * SIGMA_Y
    broken, alpha = after_return(law, diagonal(np.array([1, -0.5, -0.5]) * 1.01 * onset))
    assert norm(deviator(broken)) < 1e-12 * E
    np.testing.assert_allclose(alpha, 1.01 * onset, rtol=1e-9)


@pytest.mark.parametrize("name", ["von Mises", "plasticine", "foam"])
def test_no_yield_stress_at_all_is_a_fluid_in_shear(name, x64):
    changes: dict[str, Any] = dict(yield_stress=0.0) | (dict(hardening=0.0) if name == "von Mises" else {})
    if name == "foam":
        changes["plastic_viscosity"] = 0.0
    tau, _ = after_return(material(name, **changes), random_F())
    assert np.abs(deviator(tau)).max() < 1e-12 * E


def test_foam_without_viscosity_returns_at_once_and_with_infinite_viscosity_is_elastic(x64):
    F = random_F()
    elastic = np.asarray(stress(material("Hencky"), F, ()))
    for viscosity, reference in (
        (0.0, after_return(material("von Mises", hardening=0.0), F)[0]),
        (1e-30, after_return(material("von Mises", hardening=0.0), F)[0]),
        (1e30, elastic),
        (np.inf, elastic),
    ):
        tau, _ = after_return(material("foam", plastic_viscosity=viscosity), F)
        np.testing.assert_allclose(tau, reference, atol=1e-10 * E)


def test_foam_overstress_relaxes_with_the_time_constant_eta_over_2_mu(x64):
    eta = 2 * MU * 0.05
    law = material("foam", 1, yield_stress=SIGMA_Y, plastic_viscosity=eta)
    F = diagonal([0.2, -0.05, 0.0])
    bound = np.sqrt(2 / 3) * SIGMA_Y
    start = norm(deviator(np.asarray(stress(law, F, ()))))[0] - bound
    for dt, steps in ((0.01, 7), (0.07, 1)):  # exact for a held strain, whatever the step
        current = F
        for _ in range(steps):
            current, _ = project(law, current, (), dt)
        excess = norm(deviator(np.asarray(stress(law, current, ()))))[0] - bound
        np.testing.assert_allclose(excess / start, np.exp(-0.07 / 0.05), rtol=1e-10)
    below = diagonal([0.5 * SIGMA_Y / (2 * MU), 0.0, 0.0])
    np.testing.assert_array_equal(project(law, below, (), 10.0)[0], below)


def test_materials_share_hencky_elasticity(x64):
    F = random_F()
    reference = material("Hencky")
    assert isinstance(reference, Hencky)
    for kind, name in ((VonMises, "von Mises"), (Plasticine, "plasticine"), (Viscoplastic, "foam")):
        law = material(name)
        assert isinstance(law, kind)
        history = law.initial_history()
        np.testing.assert_allclose(stress(law, F, history), stress(reference, F, ()), atol=1e-11 * E)
        np.testing.assert_allclose(energy(law, F, history), energy(reference, F, ()), atol=1e-11 * E)
