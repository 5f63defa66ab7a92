"""3x3 algebra against numpy/scipy, and the polar derivative against finite differences where SVD rules fail."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation

from physagent_jax.mpm.linalg import cofactor, determinant, matmul, polar_rotation, skew


def rotation(seed):
    return Rotation.random(rng=np.random.default_rng(seed)).as_matrix()


CASES = {
    "identity": np.eye(3),
    "two equal stretches": np.diag([2.0, 2.0, 1.0]),
    "rotated, nearly equal": rotation(1) @ np.diag([1.0, 1.0 + 1e-9, 0.5]),
    "generic": rotation(2) @ np.diag([0.3, 1.1, 2.5]) @ rotation(3),
    "strong squeeze": rotation(4) @ np.diag([0.02, 1.0, 3.0]),
}


@pytest.mark.parametrize("F", CASES.values(), ids=CASES.keys())
def test_polar_rotation_matches_scipy(F, x64):
    np.testing.assert_allclose(polar_rotation(jnp.asarray(F)), scipy.linalg.polar(F)[0], atol=1e-12)


@pytest.mark.parametrize("F", CASES.values(), ids=CASES.keys())
def test_polar_derivative_matches_central_differences(F, x64):
    for dF in (np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0.0]]), np.random.default_rng(5).normal(size=(3, 3))):
        _, tangent = jax.jvp(polar_rotation, (jnp.asarray(F),), (jnp.asarray(dF),))
        h = 1e-6
        difference = (scipy.linalg.polar(F + h * dF)[0] - scipy.linalg.polar(F - h * dF)[0]) / (2 * h)
        np.testing.assert_allclose(tangent, difference, atol=2e-5 if F.min() < 0.1 else 1e-8)


def test_polar_rotation_in_single_precision():
    F = np.stack(list(CASES.values())).astype(np.float32)
    expected = np.stack([scipy.linalg.polar(f.astype(float))[0] for f in F])
    np.testing.assert_allclose(polar_rotation(jnp.asarray(F)), expected, atol=3e-5)


def test_products_and_cofactors(x64):
    a, b = np.random.default_rng(0).normal(size=(2, 50, 3, 3))
    np.testing.assert_allclose(matmul(jnp.asarray(a), jnp.asarray(b)), a @ b, atol=1e-14)
    np.testing.assert_allclose(determinant(jnp.asarray(a)), np.linalg.det(a), atol=1e-14)
    cofactors = np.linalg.det(a)[:, None, None] * np.linalg.inv(a).swapaxes(1, 2)
    np.testing.assert_allclose(cofactor(jnp.asarray(a)), cofactors, atol=1e-12)
    w, u = a[:, 0], b[:, 0]
    np.testing.assert_allclose((skew(jnp.asarray(w)) @ u[..., None])[..., 0], np.cross(w, u), atol=1e-14)
