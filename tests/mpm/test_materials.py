"""Single-point tests of the constitutive models: energy, small-strain moduli, objectivity, stiffness bound."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from physagent_jax.mpm import FixedCorotated, NeoHookean, lame_parameters

MODELS = [NeoHookean, FixedCorotated]
E, NU = 1.7e5, 0.31
MU, LAM = lame_parameters(E, NU)


def solid(model, count=1):
    return model(jnp.full(count, MU), jnp.full(count, LAM))


def random_F(count, spread=0.3):
    rng = np.random.default_rng(0)
    F = np.eye(3) + spread * rng.uniform(-1, 1, (count, 3, 3))
    return jnp.asarray(F[np.linalg.det(F) > 0.1])


def stress(model, F):
    return np.asarray(solid(model).stress(jnp.asarray(F)[None]))[0]


@pytest.mark.parametrize("model", MODELS)
def test_stress_is_the_gradient_of_the_energy(model, x64):
    F = random_F(64)
    material = solid(model, len(F))
    P = jax.grad(lambda F: material.energy(F).sum())(F)
    np.testing.assert_allclose(material.stress(F), P @ jnp.swapaxes(F, 1, 2), atol=1e-9 * E)


@pytest.mark.parametrize("model", MODELS)
def test_energy_gradient_matches_finite_differences(model, x64):
    F, dF, h = random_F(1)[0], np.random.default_rng(1).normal(size=(3, 3)), 1e-6
    material = solid(model)
    difference = (material.energy((F + h * dF)[None]) - material.energy((F - h * dF)[None]))[0] / (2 * h)
    P = stress(model, F) @ np.linalg.inv(F).T
    np.testing.assert_allclose((P * dF).sum(), difference, rtol=1e-8)


@pytest.mark.parametrize("model", MODELS)
def test_no_stress_at_rest_or_under_rotation(model, x64):
    for R in (np.eye(3), Rotation.from_rotvec([0.3, -1.2, 0.7]).as_matrix()):
        np.testing.assert_allclose(stress(model, R), 0, atol=1e-9 * E)


@pytest.mark.parametrize("model", MODELS)
def test_frame_indifference_isotropy_and_symmetry(model, x64):
    Q = Rotation.from_rotvec([1.0, 0.4, -2.0]).as_matrix()
    for F in np.asarray(random_F(8)):
        tau = stress(model, F)
        np.testing.assert_allclose(stress(model, Q @ F), Q @ tau @ Q.T, atol=1e-9 * E)
        np.testing.assert_allclose(stress(model, F @ Q), tau, atol=1e-9 * E)
        np.testing.assert_allclose(tau, tau.T, atol=1e-9 * E)


@pytest.mark.parametrize("model", MODELS)
def test_small_uniaxial_stress_gives_youngs_modulus_and_poissons_ratio(model, x64):
    strain = 1e-5
    lateral = brentq(lambda e: stress(model, np.diag([1 + strain, 1 + e, 1 + e]))[1, 1], -strain, 0)
    axial = stress(model, np.diag([1 + strain, 1 + lateral, 1 + lateral]))[0, 0]
    np.testing.assert_allclose(-lateral / strain, NU, rtol=1e-4)
    np.testing.assert_allclose(axial / strain, E, rtol=1e-4)


@pytest.mark.parametrize("model", MODELS)
def test_stiffness_bounds_the_kirchhoff_tangent(model, x64):
    rng = np.random.default_rng(2)
    for stretches in [np.ones(3), *rng.uniform(0.5, 2.0, (12, 3))]:
        h = 1e-6
        columns = []
        for j in range(3):
            up, down = stretches.copy(), stretches.copy()
            up[j], down[j] = up[j] * np.exp(h), down[j] * np.exp(-h)
            columns.append(np.diag(stress(model, np.diag(up)) - stress(model, np.diag(down))) / (2 * h))
        largest = np.linalg.eigvals(np.stack(columns, 1)).real.max()
        bound = float(solid(model).stiffness(jnp.asarray(np.diag(stretches))[None])[0])
        assert bound >= largest * (1 - 1e-6)
        if np.all(stretches == 1):
            np.testing.assert_allclose(bound, E / (1 - 2 * NU), rtol=1e-9)
            np.testing.assert_allclose(largest, bound, rtol=1e-6)
