"""Spherical harmonics against scipy's definition, and their rotation against evaluation."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y

from physagent_jax.gaussians import eval_sh, rotate_sh, sh_basis


def directions(count, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def test_basis_equals_real_harmonics_with_condon_shortley_phase(x64):
    """Order m = -l..l; sqrt(2) Im Y for m < 0 and sqrt(2) Re Y for m > 0 of scipy's complex harmonics."""
    d = directions(100)
    theta, phi = np.arccos(d[:, 2]), np.arctan2(d[:, 1], d[:, 0])
    expected = []
    for l in range(4):
        for m in range(-l, l + 1):
            Y = sph_harm_y(l, abs(m), theta, phi)
            expected.append(Y.real if m == 0 else 2**0.5 * (Y.imag if m < 0 else Y.real))
    np.testing.assert_allclose(sh_basis(jnp.asarray(d), 3), np.stack(expected, -1), atol=1e-8)


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_rotated_coefficients_give_the_rotated_function(x64, degree):
    sh = jnp.asarray(np.random.default_rng(1).normal(size=(40, (degree + 1) ** 2, 3)))
    R = Rotation.random(40, random_state=0).as_matrix()
    d = directions(40, seed=2)
    rotated = eval_sh(rotate_sh(sh, jnp.asarray(R)), jnp.asarray(d))
    back = np.einsum("nji,nj->ni", R, d)
    np.testing.assert_allclose(rotated, eval_sh(sh, jnp.asarray(back)), atol=1e-10)
    assert rotate_sh(sh, jnp.asarray(R[0])).shape == sh.shape


def test_identity_changes_nothing_in_single_precision():
    sh = jnp.asarray(np.random.default_rng(1).normal(size=(10, 16, 3)), jnp.float32)
    np.testing.assert_allclose(rotate_sh(sh, jnp.eye(3)), sh, atol=2e-6)
