"""Needles are shortened, everything else is left alone."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.gaussians.cloud import Splats
from physagent_jax.gaussians.covariance import covariance_matrices
from physagent_jax.gaussians.elongation import (
    EASY_STRETCH,
    MOST_RATIO,
    MOST_SHARE,
    MOST_STRETCH,
    cap_elongation,
)

SIZE = 1.0


def deformed(scales, F, seed=0):
    """Gaussians with standard deviations ``scales`` (n, 3) in random directions, under F, as splats."""
    R = Rotation.random(len(scales), random_state=seed).as_matrix()
    M = F @ R * np.asarray(scales)[:, None, :]
    sigma = M @ M.transpose(0, 2, 1)
    zeros = np.zeros((len(scales), 1, 3))
    return Splats(
        means=jnp.zeros((len(scales), 3)),
        covariances=jnp.asarray(sigma[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]], jnp.float32),
        opacities=jnp.ones(len(scales)),
        sh=jnp.asarray(zeros),
        rotations=jnp.tile(jnp.eye(3), (len(scales), 1, 1)),
    )


def deviations(splats):
    return np.sqrt(np.maximum(np.linalg.eigvalsh(covariance_matrices(splats.covariances)), 0))


def captured(count=200, seed=1):
    rng = np.random.default_rng(seed)
    return 0.01 * np.exp(0.8 * rng.normal(size=(count, 3)))


def test_at_rest_and_under_rotation_nothing_changes():
    turn = Rotation.random(random_state=3).as_matrix()
    for F in (np.eye(3), turn, 1.25 * turn):
        splats = deformed(captured(), F)
        np.testing.assert_allclose(
            cap_elongation(splats, captured(), SIZE).covariances, splats.covariances, rtol=2e-3, atol=1e-9
        )


def test_a_needle_of_the_capture_itself_is_kept():
    scales = np.array([[0.3, 0.001, 0.001]])
    splats = deformed(scales, np.eye(3))
    np.testing.assert_array_equal(cap_elongation(splats, scales, SIZE).covariances, splats.covariances)


@pytest.mark.parametrize("stretch", [3.0, 10.0, 1e3])
def test_no_axis_is_longer_than_the_limits(stretch):
    scales = captured()
    squeeze = stretch**-0.5
    splats = cap_elongation(deformed(scales, np.diag([stretch, squeeze, squeeze])), scales, SIZE)
    now, rest = deviations(splats), np.sort(scales, axis=1)
    longest = EASY_STRETCH * rest[:, 2]
    assert (
        now[:, 2] <= np.maximum(longest, np.minimum(MOST_STRETCH * rest[:, 2], MOST_SHARE * SIZE)) * 1.001
    ).all()
    ratio = np.maximum(MOST_RATIO, rest[:, 2] / rest[:, 1])
    assert (now[:, 2] <= np.maximum(longest, ratio * now[:, 1]) * 1.01 + 1e-6).all()
    assert (deviations(deformed(scales, np.diag([stretch, squeeze, squeeze])))[:, 2] > 1.01 * now[:, 2]).any()


def test_a_sheet_that_grows_in_two_directions_is_bounded_in_both():
    scales = np.array([[0.02, 0.02, 0.001]])
    now = deviations(cap_elongation(deformed(scales, 20 * np.eye(3)), scales, SIZE))
    np.testing.assert_allclose(now[0, 1:], [0.04, 0.04], rtol=1e-3)


def test_a_shortened_gaussian_points_the_same_way():
    scales = np.array([[0.02, 0.02, 0.02]])
    along = np.array([0.6, 0.0, 0.8])
    F = np.eye(3) + 4 * np.outer(along, along)
    _, axes = np.linalg.eigh(
        covariance_matrices(cap_elongation(deformed(scales, F), scales, SIZE).covariances)
    )
    assert abs(axes[0, :, 2] @ along) == pytest.approx(1, abs=1e-4)
    np.testing.assert_allclose(
        deviations(cap_elongation(deformed(scales, F), scales, SIZE))[0], [0.02, 0.02, 0.04], rtol=1e-3
    )


def test_round_gaussians_stay_round():
    scales = np.full((3, 3), 0.01)
    now = cap_elongation(deformed(scales, np.diag([9.0, 9.0, 9.0])), scales, SIZE)
    with np.errstate(all="raise"):
        rest = cap_elongation(deformed(scales, np.eye(3), seed=1), scales, SIZE)
        exact = dataclasses.replace(
            rest, covariances=jnp.full((3, 6), 1e-4) * jnp.float32([1, 0, 0, 1, 0, 1])
        )
        assert cap_elongation(exact, scales, SIZE) is exact
    np.testing.assert_allclose(deviations(now), 0.02, rtol=1e-3)
