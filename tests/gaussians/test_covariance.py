"""Rotations and covariances against scipy and numpy; the polar rotation against the SVD."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.gaussians import (
    covariance_matrices,
    decompose_covariances,
    matrix_to_quat,
    polar_rotation,
    quat_to_matrix,
    quats_scales_to_covariances,
    transform_covariances,
)
from physagent_jax.kernels import programs


def test_covariances_of_another_number_of_gaussians_are_one_more_program():
    before = programs.compiled_count
    quats_scales_to_covariances(*jax.device_put((np.ones((173, 4)), np.ones((173, 3)))))
    assert programs.compiled_count == before + 1


@pytest.fixture
def rotations():
    return Rotation.random(200, random_state=0)


def test_quaternions_and_matrices_agree_with_scipy(x64, rotations):
    quats = rotations.as_quat(canonical=True, scalar_first=True)
    np.testing.assert_allclose(quat_to_matrix(jnp.asarray(quats)), rotations.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(matrix_to_quat(rotations.as_matrix()), quats, atol=1e-14)


def test_covariances_equal_matrix_products(x64, rotations):
    rng = np.random.default_rng(0)
    scales, F = np.exp(rng.normal(size=(200, 3))), rng.normal(size=(200, 3, 3))
    R = rotations.as_matrix()
    sigma = R @ (scales[:, :, None] ** 2 * np.eye(3)) @ R.transpose(0, 2, 1)
    packed = quats_scales_to_covariances(
        jnp.asarray(rotations.as_quat(scalar_first=True)), jnp.asarray(scales)
    )
    np.testing.assert_allclose(covariance_matrices(packed), sigma, rtol=1e-10, atol=1e-12)
    deformed = covariance_matrices(transform_covariances(jnp.asarray(F), packed))
    np.testing.assert_allclose(deformed, F @ sigma @ F.transpose(0, 2, 1), rtol=1e-9, atol=1e-10)


def test_decomposition_inverts_the_composition(rotations):
    scales = np.exp(np.random.default_rng(1).uniform(-4, 0, (200, 3)))
    packed = quats_scales_to_covariances(
        jnp.asarray(rotations.as_quat(scalar_first=True), jnp.float32), jnp.asarray(scales, jnp.float32)
    )
    quats, found = decompose_covariances(packed)
    np.testing.assert_allclose(np.linalg.norm(quats, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(found, np.sort(scales, axis=1), rtol=5e-3)
    again = quats_scales_to_covariances(jnp.asarray(quats, jnp.float32), jnp.asarray(found, jnp.float32))
    np.testing.assert_allclose(again, packed, atol=3e-7)


def test_decomposition_of_flat_and_vanishing_gaussians_is_finite():
    packed = np.array([[1, 0, 0, 1, 0, -1e-9], [0, 0, 0, 0, 0, 0]])
    quats, scales = decompose_covariances(packed)
    assert np.isfinite(quats).all() and np.isfinite(scales).all() and (scales >= 0).all()


def svd_rotation(F):
    U, _, Vt = np.linalg.svd(F)
    U[..., 2] *= np.linalg.det(U @ Vt)[..., None]
    return U @ Vt


def test_polar_rotation_equals_the_svd_also_when_inverted_or_flat():
    """The answer is unique to float32 accuracy; det F < 0 gives U diag(1, 1, -1) V^T."""
    rng = np.random.default_rng(2)
    F = rng.normal(size=(5000, 3, 3))
    F[:1000] = Rotation.random(1000, random_state=1).as_matrix() @ (
        np.eye(3) + 0.1 * rng.normal(size=(1000, 3, 3))
    )
    F[0], F[1], F[2], F[3] = (
        np.diag([10, 0.1, 0.1]),
        np.diag([1, 1, 0]),
        np.diag([2, 1, -0.5]),
        1e-4 * np.eye(3),
    )
    s = np.linalg.svd(F, compute_uv=False)
    unique = s[:, 1] + np.sign(np.linalg.det(F)) * s[:, 2] > 0.02 * s[:, 0]
    assert unique.sum() > 4500 and (np.linalg.det(F) < 0).sum() > 1000
    R = np.asarray(polar_rotation(jnp.asarray(F, jnp.float32)))
    np.testing.assert_allclose(R[unique], svd_rotation(F)[unique], atol=1e-4)
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.broadcast_to(np.eye(3), R.shape), atol=2e-6)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=2e-6)


def test_polar_rotation_of_identity_and_zero_is_the_identity_exactly():
    F = jnp.stack([jnp.eye(3), jnp.zeros((3, 3)), 3 * jnp.eye(3)])
    np.testing.assert_array_equal(polar_rotation(F), np.broadcast_to(np.eye(3), (3, 3, 3)))


def test_polar_rotation_has_the_derivative_of_the_svd(x64):
    """Central differences of the SVD's answer, with positive and negative determinants."""
    rng = np.random.default_rng(3)
    F, dF = np.eye(3) + 0.3 * rng.normal(size=(2, 50, 3, 3))
    F[:10, 2] *= -1
    h = 1e-6
    expected = (svd_rotation(F + h * dF) - svd_rotation(F - h * dF)) / (2 * h)
    _, derivative = jax.jit(lambda F, dF: jax.jvp(polar_rotation, (F,), (dF,)))(F, dF)
    np.testing.assert_allclose(derivative, expected, rtol=1e-5, atol=1e-5)


def test_polar_rotation_has_finite_gradients_where_it_jumps():
    F = jnp.stack([jnp.zeros((3, 3)), jnp.diag(jnp.array([1.0, 0, 0])), -jnp.eye(3)])
    weights = jnp.arange(9.0).reshape(3, 3)
    gradient = jax.jit(jax.grad(lambda F: jnp.sum(polar_rotation(F) * weights)))(F)
    assert jnp.isfinite(gradient).all()
