"""Closed forms of the renderer: pinhole formula, Gaussian integrals, symmetry, frames."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.gaussians import bind, deform, matrix_to_quat, quat_to_matrix, read_ply, splats_to_cloud
from physagent_jax.render import Camera, look_at, project, render
from tests.render.scenes import camera, one_splat, random_splats

SIZE = 65  # odd, so that a pixel centre lies on the optical axis


def front_camera(distance=2.0):
    """At -y, looking along +y, z up."""
    return look_at([0, -distance, 0], [0, 0, 0], [0, 0, 1], fov_degrees=40, width=SIZE, height=SIZE)


def test_one_gaussian_on_the_axis():
    """Peak alpha is the opacity; colour and depth are the Gaussian's; the background shows through."""
    image = render(one_splat([0, 0, 0]), front_camera(), background=(0, 0, 1))
    middle = SIZE // 2
    np.testing.assert_allclose(image.alpha[middle, middle], 0.8, atol=1e-5)
    expected = 0.8 * np.array([0.9, 0.4, 0.1]) + 0.2 * np.array([0, 0, 1])
    np.testing.assert_allclose(image.rgb[middle, middle], expected, atol=1e-5)
    np.testing.assert_allclose(image.depth[middle, middle], 2, atol=1e-5)
    assert image.alpha[0, 0] == 0 and image.depth[0, 0] == 0
    np.testing.assert_array_equal(image.rgb[0, 0], [0, 0, 1])
    assert np.asarray(image.alpha)[np.asarray(image.alpha) > 0].min() >= 1 / 255 - 1e-6


def test_footprint_is_the_projected_gaussian_plus_blur():
    """A profile of variance (f sigma / z)^2 + 0.3 px^2, cut off at 1/255, the same in both directions."""
    image = render(one_splat([0, 0, 0], sigma=0.05, opacity=0.95), front_camera())
    alpha = np.asarray(image.alpha, np.float64)
    offset = np.arange(SIZE) - SIZE // 2
    focal = 0.5 * SIZE / np.tan(np.radians(20))
    variance = (focal * 0.05 / 2) ** 2 + 0.3
    profile = 0.95 * np.exp(-(offset**2) / (2 * variance))
    profile = np.where(profile >= 1 / 255, profile, 0)
    np.testing.assert_allclose(alpha[SIZE // 2], profile, atol=1e-5)
    np.testing.assert_allclose(alpha, alpha.T, atol=1e-6)


@pytest.mark.parametrize("point", [(0.3, 0.4, -0.2), (-0.25, -0.5, 0.3)])
def test_position_follows_the_pinhole_formula(point):
    """x right, z up in the world means u right, v down on the image; depth is z, not ray length."""
    cam = front_camera()
    focal = 0.5 * SIZE / np.tan(np.radians(20))
    depth = 2 + point[1]
    projected = project(one_splat(point), cam)
    expected = [SIZE / 2 + focal * point[0] / depth, SIZE / 2 - focal * point[2] / depth]
    np.testing.assert_allclose(projected.means2d[0], expected, rtol=1e-5)
    image = render(one_splat(point, sigma=0.02), cam)
    v, u = np.unravel_index(np.argmax(image.alpha), (SIZE, SIZE))
    np.testing.assert_allclose([u + 0.5, v + 0.5], expected, atol=0.51)
    np.testing.assert_allclose(image.depth[v, u], depth, atol=1e-4)


def test_nearer_gaussian_covers_the_farther_whatever_their_order():
    red = one_splat([0, -0.5, 0], opacity=0.6, color=(1, 0, 0))
    green = one_splat([0, 0.5, 0], opacity=0.6, color=(0, 1, 0))
    for pair in ((red, green), (green, red)):
        image = render(
            jax.tree.map(lambda a, b: jnp.concatenate([a, b]), *pair), front_camera(), background=(0, 0, 1)
        )
        pixel = image.rgb[SIZE // 2, SIZE // 2]
        np.testing.assert_allclose(pixel, [0.6, 0.4 * 0.6, 0.16], atol=1e-5)
        depth = (0.6 * 1.5 + 0.24 * 2.5) / 0.84
        np.testing.assert_allclose(image.depth[SIZE // 2, SIZE // 2], depth, atol=1e-5)


def test_covariance_is_the_pinhole_jacobian_of_the_gaussian(x64):
    """Sample covariance of a tiny Gaussian's points projected exactly, off axis."""
    point, sigma = np.array([0.3, 0.2, -0.25]), 1e-4
    cam = camera()
    samples = point + sigma * np.random.default_rng(0).normal(size=(200_000, 3))
    p = samples @ cam.viewmat[:3, :3].T + cam.viewmat[:3, 3]
    uv = p[:, :2] / p[:, 2:] * np.diag(cam.K)[:2] + cam.K[:2, 2]
    splat = jax.tree.map(lambda a: jnp.asarray(a, jnp.float64), one_splat(point, sigma=sigma))
    splat = dataclasses.replace(splat, means=jnp.asarray([point]))
    a, b, c = np.asarray(project(splat, cam).conics[0])
    covariance = np.linalg.inv([[a, b], [b, c]]) - 0.3 * np.eye(2)
    np.testing.assert_allclose(covariance, np.cov(uv.T), rtol=0.02, atol=0.01 * covariance.max())


def test_rotated_scene_seen_by_a_rotated_camera_is_the_same_image():
    """Also with view-dependent colour, because the view direction is rotated back, not the coefficients."""
    splats, cam = random_splats(100, degree=3, scale=0.1, dtype=np.float32), camera()
    R, t = Rotation.from_euler("xyz", [50, -20, 70], degrees=True).as_matrix(), np.array([0.5, -1, 2])
    full = np.asarray(splats.covariances)[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    turned = dataclasses.replace(
        splats,
        means=jnp.asarray(np.asarray(splats.means) @ R.T + t, jnp.float32),
        covariances=jnp.asarray((R @ full @ R.T)[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]], jnp.float32),
        rotations=jnp.asarray(R @ np.asarray(splats.rotations), jnp.float32),
    )
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = R, t
    moved = Camera(cam.viewmat @ np.linalg.inv(motion), cam.K, cam.width, cam.height)
    before, after = render(splats, cam), render(turned, moved)
    np.testing.assert_allclose(before.rgb, after.rgb, atol=2e-3)
    np.testing.assert_allclose(before.depth, after.depth, atol=2e-3)


def test_pre_rotation_turns_the_captured_colours_with_the_object(robot_path):
    """The robot turned upright by the scene, SH left in the captured frame, looks as it was captured."""
    cloud = read_ply(robot_path)
    identity = jnp.broadcast_to(jnp.eye(3), (cloud.count, 3, 3))
    captured = deform(cloud, bind(cloud.means, cloud.means), cloud.means, identity, np.eye(3))
    up = np.diag(np.float32([1, -1, -1]))  # y-down to y-up: half a turn about x
    turned = dataclasses.replace(
        cloud,
        means=cloud.means @ up,
        quats=jnp.asarray(matrix_to_quat(up @ np.asarray(quat_to_matrix(cloud.quats)))),
    )
    upright = deform(turned, bind(turned.means, turned.means), turned.means, identity, up)
    below = look_at([1, -1, -2], [0, -0.6, 0], [0, -1, 0], fov_degrees=35, width=64, height=64)
    above = look_at([1, 1, 2], [0, 0.6, 0], [0, 1, 0], fov_degrees=35, width=64, height=64)
    a, b = render(captured, below).rgb, render(upright, above).rgb
    assert np.asarray(a).std() > 0.1
    np.testing.assert_allclose(a, b, atol=2e-3)


def test_exported_cloud_renders_as_the_deformed_splats():
    """Decomposed covariances and rotated SH are what the renderer drew."""
    splats, cam = random_splats(100, degree=3, scale=0.1, dtype=np.float32), camera()
    cloud = splats_to_cloud(splats)
    identity = jnp.broadcast_to(jnp.eye(3), (100, 3, 3))
    again = deform(cloud, bind(cloud.means, cloud.means), cloud.means, identity, np.eye(3))
    np.testing.assert_allclose(render(again, cam).rgb, render(splats, cam).rgb, atol=2e-3)
