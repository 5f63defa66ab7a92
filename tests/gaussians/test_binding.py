"""Gaussians follow particles: exactly at rest, exactly under affine motion, deterministically."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import (
    GaussianCloud,
    bind,
    covariance_matrices,
    deform,
    eval_sh,
    polar_rotation,
    quats_scales_to_covariances,
    read_ply,
    splats_to_cloud,
)
from physagent_jax.gaussians.binding import bind_pieces
from physagent_jax.scene.compile.buckets import pad_gaussians

pytestmark = pytest.mark.usefixtures("module_least_optimised")  # to compile takes longest


@pytest.fixture
def cloud():
    rng = np.random.default_rng(0)
    quats = rng.normal(size=(60, 4))
    return GaussianCloud(
        means=jnp.asarray(rng.uniform(0, 1, (60, 3)), jnp.float32),
        quats=jnp.asarray(quats / np.linalg.norm(quats, axis=1, keepdims=True), jnp.float32),
        scales=jnp.asarray(rng.uniform(0.01, 0.1, (60, 3)), jnp.float32),
        opacities=jnp.asarray(rng.uniform(0.1, 1, 60), jnp.float32),
        sh=jnp.asarray(rng.normal(size=(60, 16, 3)), jnp.float32),
    )


@pytest.fixture
def particles():
    return np.random.default_rng(1).uniform(0, 1, (300, 3)).astype(np.float32)


def identities(count):
    return jnp.broadcast_to(jnp.eye(3), (count, 3, 3))


def test_rest_pose_of_gaussians_that_are_particles_is_the_cloud(cloud, particles):
    everything = jnp.concatenate([cloud.means, particles])
    binding = bind(cloud.means, everything)
    assert binding.indices.shape == (60, 1)
    splats = deform(cloud, binding, everything, identities(360), np.eye(3))
    np.testing.assert_array_equal(splats.means, cloud.means)
    rest = jax.jit(quats_scales_to_covariances)(cloud.quats, cloud.scales)
    np.testing.assert_allclose(splats.covariances, rest, rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(splats.rotations, identities(60))
    np.testing.assert_array_equal(splats.sh, cloud.sh)
    np.testing.assert_array_equal(splats.opacities, cloud.opacities)


def test_rest_pose_between_particles_is_the_cloud_to_rounding(cloud, particles):
    splats = deform(cloud, bind(cloud.means, particles), jnp.asarray(particles), identities(300), np.eye(3))
    np.testing.assert_allclose(splats.means, cloud.means, atol=3e-7)
    np.testing.assert_allclose(
        splats.covariances, quats_scales_to_covariances(cloud.quats, cloud.scales), rtol=1e-5, atol=1e-9
    )
    np.testing.assert_allclose(splats.rotations, identities(60), atol=1e-6)


@pytest.mark.parametrize("k", [1, 4])
def test_affine_motion_is_followed_exactly(cloud, particles, k):
    A = np.array([[1.2, 0.3, 0], [-0.4, 0.9, 0.2], [0.1, 0, 0.7]])
    t = np.array([0.3, -0.2, 1])
    x, F = (
        jnp.asarray(particles @ A.T + t, jnp.float32),
        jnp.broadcast_to(jnp.asarray(A, jnp.float32), (300, 3, 3)),
    )
    pre = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    splats = jax.jit(deform)(cloud, bind(cloud.means, particles, k=k), x, F, pre)
    np.testing.assert_allclose(splats.means, np.asarray(cloud.means, np.float64) @ A.T + t, atol=1e-6)
    rest = covariance_matrices(quats_scales_to_covariances(cloud.quats, cloud.scales))
    np.testing.assert_allclose(covariance_matrices(splats.covariances), A @ rest @ A.T, atol=1e-8)
    U, _, Vt = np.linalg.svd(A)
    np.testing.assert_allclose(splats.rotations, np.broadcast_to(U @ Vt @ pre, (60, 3, 3)), atol=2e-6)


def test_weights_are_normalised_and_coincident_gaussians_follow_one_particle(cloud, particles):
    particles = particles.copy()
    particles[7] = cloud.means[3]
    binding = bind(cloud.means, particles)
    np.testing.assert_allclose(binding.weights.sum(1), 1, atol=1e-6)
    assert (binding.weights >= 0).all() and binding.indices.shape == (60, 4)
    assert binding.indices[3, 0] == 7
    np.testing.assert_array_equal(binding.weights[3], [1, 0, 0, 0])
    np.testing.assert_array_equal(binding.offsets[3], 0)


def test_binding_is_deterministic_and_copes_with_few_particles(cloud, particles):
    first, second = bind(cloud.means, particles), bind(cloud.means, particles)
    for a, b in zip(jax.tree.leaves(first), jax.tree.leaves(second)):
        np.testing.assert_array_equal(a, b)
    assert bind(cloud.means, particles[:2]).indices.shape == (60, 2)
    assert bind(cloud.means, particles[:1]).indices.shape == (60, 1)
    with pytest.raises(UserError, match="no particles"):
        bind(cloud.means, particles[:0])
    with pytest.raises(UserError, match="`k`"):
        bind(cloud.means, particles, k=0)


def test_gradients_reach_positions_and_deformation(cloud, particles):
    binding = bind(cloud.means, particles)

    def loss(x, F):
        splats = deform(cloud, binding, x, F, jnp.eye(3))
        return sum(jnp.sum(leaf**3) for leaf in (splats.means, splats.covariances, splats.rotations))

    F = identities(300) + 0.1 * jax.random.normal(jax.random.key(0), (300, 3, 3))
    gradients = jax.jit(jax.grad(loss, argnums=(0, 1)))(jnp.asarray(particles), F)
    assert all(jnp.isfinite(g).all() and jnp.abs(g).max() > 0 for g in gradients)


def test_export_has_the_same_shape_and_colours_in_the_world_frame(cloud):
    """A viewer's reading of the exported cloud equals the splats."""
    F = identities(60) + 0.3 * jax.random.normal(jax.random.key(0), (60, 3, 3))
    pre = Rotation.from_euler("xyz", [20, 30, 40], degrees=True).as_matrix()
    splats = deform(cloud, bind(cloud.means, cloud.means), cloud.means, F, pre)
    exported = splats_to_cloud(splats)
    np.testing.assert_allclose(
        quats_scales_to_covariances(exported.quats, exported.scales), splats.covariances, atol=1e-7
    )
    d = np.random.default_rng(2).normal(size=(60, 3))
    d = (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(np.float32)
    captured = jnp.einsum("nji,nj->ni", polar_rotation(F) @ jnp.asarray(pre, jnp.float32), d)
    np.testing.assert_allclose(eval_sh(exported.sh, d), eval_sh(cloud.sh, captured), atol=2e-5)


def test_exported_rest_pose_of_the_robot_is_the_robot(robot_path):
    cloud = read_ply(robot_path)
    splats = deform(cloud, bind(cloud.means, cloud.means), cloud.means, identities(cloud.count), np.eye(3))
    exported = splats_to_cloud(splats)
    np.testing.assert_allclose(np.sort(exported.scales), np.sort(cloud.scales), rtol=1e-2, atol=1e-5)
    np.testing.assert_allclose(exported.sh, cloud.sh, atol=5e-6)


def test_what_fills_a_scene_up_is_not_exported(cloud):
    cloud = jax.tree.map(lambda leaf: leaf[:57], cloud)
    cloud = dataclasses.replace(cloud, opacities=cloud.opacities.at[7].set(0.0))  # the object's own: it stays
    binding = bind(cloud.means, cloud.means)
    filled, bound = pad_gaussians(cloud, binding)
    assert filled.count > cloud.count
    F = identities(cloud.count)
    exported = splats_to_cloud(deform(filled, bound, cloud.means, F, np.eye(3)))
    expected = splats_to_cloud(deform(cloud, binding, cloud.means, F, np.eye(3)))
    assert exported.count == cloud.count
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, atol=1e-6), exported, expected)


def test_splats_that_nobody_sees_make_an_empty_cloud(cloud):
    cloud = dataclasses.replace(cloud, opacities=jnp.zeros(cloud.count))
    splats = deform(cloud, bind(cloud.means, cloud.means), cloud.means, identities(cloud.count), np.eye(3))
    assert splats_to_cloud(splats).count == 0


def test_pieces_keep_what_belongs_to_them():
    """Of two slabs that touch, one is lifted: Gaussians in the plane between go with their own."""
    rng = np.random.default_rng(0)
    particles = rng.uniform(0, 1, (400, 3)) - (0.5, 0.5, 0)
    particles[200:, 2] *= -1
    above = np.arange(400) < 200
    means = np.concatenate([rng.uniform(-0.5, 0.5, (60, 2)), np.zeros((60, 1))], axis=1)
    piece = np.arange(60) % 2
    binding = bind_pieces(means, particles, piece, above.astype(int))
    lifted = particles + above[:, None] * (0.0, 0.0, 2.0)
    predictions = lifted[np.asarray(binding.indices)] + np.asarray(binding.offsets)
    places = (np.asarray(binding.weights)[..., None] * predictions).sum(1)
    np.testing.assert_allclose(places[:, 2], 2.0 * piece, atol=1e-5)
    alone = bind_pieces(means, particles, piece, np.zeros(400, int))  # a piece without particles
    np.testing.assert_allclose(np.asarray(alone.weights).sum(1), 1.0, atol=1e-6)
