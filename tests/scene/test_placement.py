import dataclasses

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.covariance import covariance_matrices, quats_scales_to_covariances
from physagent_jax.gaussians.formats import read_ply
from physagent_jax.scene.config import Domain, Source
from physagent_jax.scene.placement import find_extra_rotation, find_up_rotation, place
from tests.scene.clouds import cloud_of

AXES = {
    "+x": (1, 0, 0),
    "-x": (-1, 0, 0),
    "+y": (0, 1, 0),
    "-y": (0, -1, 0),
    "+z": (0, 0, 1),
    "-z": (0, 0, -1),
}


def random_cloud(n=200, seed=0):
    rng = np.random.default_rng(seed)
    quats = rng.normal(size=(n, 4))
    cloud = cloud_of(
        rng.uniform(-1, 1, (n, 3)) * [3, 1, 2] + [10, 20, 30],
        quats=quats / np.linalg.norm(quats, axis=1)[:, None],
    )
    return dataclasses.replace(cloud, scales=rng.uniform(0.01, 0.1, (n, 3)).astype(np.float32))


@pytest.mark.parametrize("up", AXES)
def test_every_up_axis_is_rotated_onto_z_by_a_proper_rotation(up):
    rotation = find_up_rotation(up)
    np.testing.assert_array_equal(rotation @ AXES[up], (0, 0, 1))
    assert np.linalg.det(rotation) == 1.0
    if up[1] != "x":  # what is to the right in the picture stays there
        np.testing.assert_array_equal(rotation @ (1, 0, 0), (1, 0, 0))


def test_extra_rotations_are_right_handed_and_the_first_is_applied_first():
    # By hand: a quarter turn about x takes +y to +z; a quarter turn about z then leaves +z alone.
    np.testing.assert_allclose(find_extra_rotation((90.0, 90.0), (0, 2)) @ (0, 1, 0), (0, 0, 1), atol=1e-15)
    # In the other order: about z first takes +y to -x, which the turn about x leaves alone.
    np.testing.assert_allclose(find_extra_rotation((90.0, 90.0), (2, 0)) @ (0, 1, 0), (-1, 0, 0), atol=1e-15)


def test_longest_side_is_the_extent_and_the_box_is_centred():
    placed, _ = place(random_cloud(), Source(path="", up="-y", extent=1.5, center=(2.0, 2.5, 1.5)), Domain())
    low, high = np.min(placed.means, axis=0), np.max(placed.means, axis=0)
    assert (high - low).max() == pytest.approx(1.5, rel=1e-5)
    np.testing.assert_allclose(0.5 * (low + high), (2.0, 2.5, 1.5), atol=1e-5)
    default, _ = place(random_cloud(), Source(path=""), Domain(size=3.0))
    np.testing.assert_allclose(0.5 * (np.min(default.means, 0) + np.max(default.means, 0)), 1.5, atol=1e-5)


def test_covariances_transform_as_a_similarity_demands():
    cloud = random_cloud()
    placed, placement = place(
        cloud, Source(path="", up="+x", rotation_degrees=(30.0,), rotation_axes=(1,)), Domain()
    )

    def covariances(c):
        return covariance_matrices(quats_scales_to_covariances(c.quats, c.scales))

    R, s = placement.rotation, placement.scale
    np.testing.assert_allclose(covariances(placed), s**2 * R @ covariances(cloud) @ R.T, atol=2e-6 * s**2)
    np.testing.assert_array_equal(placed.sh, cloud.sh)


def test_to_source_undoes_to_world():
    cloud = random_cloud()
    placed, placement = place(
        cloud, Source(path="", up="-y", rotation_degrees=(20.0, 50.0), rotation_axes=(2, 0)), Domain()
    )
    points = np.random.default_rng(1).normal(size=(5, 7, 3))
    np.testing.assert_allclose(placement.to_source(placement.to_world(points)), points, atol=1e-12)
    back = placement.cloud_to_source(placed)
    np.testing.assert_allclose(back.means, cloud.means, atol=1e-5)
    np.testing.assert_allclose(back.scales, cloud.scales, rtol=1e-5)
    sign = np.sign(np.sum(np.asarray(back.quats) * cloud.quats, axis=1, keepdims=True))
    np.testing.assert_allclose(sign * back.quats, cloud.quats, atol=1e-6)


def test_crop_acts_after_the_extra_rotations_and_before_up():
    cloud = cloud_of([[0, 0, 0], [0, 1, 0], [0, 2, 0], [0.5, 0, 0], [0, 0, 1]])
    # A quarter turn about x brings +y to +z: only the centres at z = 0 and 1 lie in the box.
    source = Source(
        path="",
        up="-z",
        rotation_degrees=(90.0,),
        rotation_axes=(0,),
        crop=(-0.1, 0.1, -0.1, 0.1, -0.1, 1.5),
        extent=1.0,
    )
    placed, placement = place(cloud, source, Domain())
    np.testing.assert_allclose(placement.to_source(placed.means), [[0, 0, 0], [0, 1, 0]], atol=1e-6)
    assert placed.means[0, 2] > placed.means[1, 2]  # -z up: what was high is low


def test_floaters_are_counted_in_a_warning_and_crop_silences_it(recwarn):
    rng = np.random.default_rng(0)
    means = np.concatenate([rng.uniform(-1, 1, (1000, 3)), [[40.0, 0, 0], [0, 0, -30.0], [25, 25, 0]]])
    with pytest.warns(UserWarning, match=r"3 of 1003 Gaussians float"):
        place(cloud_of(means), Source(path=""), Domain())
    placed, _ = place(cloud_of(means), Source(path="", crop=(-2, 2, -2, 2, -2, 2)), Domain())
    assert placed.count == 1000
    assert not recwarn.list


def test_an_ordinary_object_gives_no_warning(robot_path, recwarn):
    place(read_ply(robot_path), Source(path="", up="-y"), Domain())
    assert not recwarn.list


@pytest.mark.parametrize(
    ("means", "source", "domain", "message"),
    [
        ([[0, 0, 0], [1, 1, 1]], dict(crop=(5, 6, 5, 6, 5, 6)), {}, "crop` leaves no"),
        ([[1, 2, 3]] * 4, {}, {}, "no extent"),
        (np.zeros((0, 3)), {}, {}, "no Gaussians"),
        ([[0, 0, 0], [1, 1, np.nan]], {}, {}, "not finite"),
        ([[0, 0, 0], [1, 1, 1]], dict(extent=3.9), {}, "does not fit"),
        ([[0, 0, 0], [1, 1, 1]], dict(center=(0.2, 2.0, 2.0)), {}, "does not fit"),
    ],
)
def test_what_cannot_be_placed_is_refused(means, source, domain, message):
    with pytest.raises(UserError, match=message):
        place(cloud_of(means), Source(path="", **source), Domain(**domain))
