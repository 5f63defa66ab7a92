"""One scale for a clip's depth, from what stands still, and a ground's: exact cases."""

import numpy as np
import pytest

from physagent_jax.perception.backends.depth_anything import scale_inverse
from physagent_jax.perception.backends.still import (
    anchor_depth,
    anchor_inverse,
    find_still,
    fit_ground,
    fit_line,
)
from physagent_jax.render.camera import look_at

HEIGHT, WIDTH = 90, 120
CAMERA = look_at((0.5, -4, 2), (0.5, 0, 0.5), (0, 0, 1), fov_degrees=45, width=WIDTH, height=HEIGHT)
GROUND = 0.2  # [m]


def make_scene(count=3):
    """A textured ground up to a wall, and a box that walks over it towards the camera: pictures and z-depth [m]."""
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    rays = np.stack([x, y, np.ones_like(x)], -1) @ np.linalg.inv(CAMERA.K).T @ CAMERA.viewmat[:3, :3]
    with np.errstate(divide="ignore"):
        ground = (GROUND - CAMERA.center[2]) / rays[..., 2]
    z = np.where((ground > 0) & (ground < 9), ground, 9.0)[None].repeat(count, 0)
    rgb = rng.integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)[None].repeat(count, 0)
    for t in range(count):
        box = np.s_[t, 35:75, 20 + 20 * t : 50 + 20 * t]
        rgb[box] = rng.integers(0, 255, (40, 30, 3), dtype=np.uint8)
        z[box] = 3.0 - 0.3 * t
    return rgb, z


def test_depth_of_all_frames_is_put_on_the_scale_of_the_first():
    rgb, z = make_scene()
    wrong = z * np.array([1.0, 1.3, 0.6])[:, None, None]
    anchored, notes = anchor_depth(wrong, rgb)
    np.testing.assert_allclose(anchored, z, rtol=1e-5)
    assert notes == ()


def test_inverse_depth_gets_scale_and_shift_of_the_first_frame():
    rgb, z = make_scene()
    scale, shift = np.array([2.0, 0.7, 3.0])[:, None, None], np.array([0.1, 0.4, -0.2])[:, None, None]
    anchored, notes = anchor_inverse(scale / z + shift, rgb)
    np.testing.assert_allclose(anchored, 2 / z + 0.1, rtol=1e-4)
    assert notes == ()


def test_before_a_flat_background_the_shift_is_not_guessed():
    rgb, _ = make_scene(2)
    w = np.full(rgb.shape[:3], 0.5)
    w[1] *= 1.2
    anchored, _ = anchor_inverse(w, rgb)
    np.testing.assert_allclose(anchored, 0.5, rtol=1e-5)


def test_a_frame_that_is_all_new_keeps_its_scale_and_says_so():
    rgb, z = make_scene(2)
    rgb[1] = 255 - rgb[1]
    anchored, notes = anchor_depth(z * np.array([1.0, 2.0])[:, None, None], rgb)
    np.testing.assert_allclose(anchored[1], 2 * z[1], rtol=1e-6)
    assert len(notes) == 1 and notes[0].startswith("In 1 frames too little stood still")


def test_what_moves_is_not_still():
    rgb, _ = make_scene(2)
    still = find_still(rgb)
    assert still[0].all() and not still[1, 35:75, 20:70].any() and still[1, :, 80:].all()


def test_a_line_is_found_among_other_points():
    rng = np.random.default_rng(1)
    x = rng.uniform(1, 2, 900)
    y = 3 * x - 0.5
    y[:350] = rng.uniform(-5, 5, 350)
    assert fit_line(x, y) == pytest.approx((3, -0.5), rel=1e-6)


def test_a_ground_of_known_height_gives_metres_to_inverse_depth():
    _, z = make_scene(1)
    w = 0.8 / z + 0.3
    assert fit_ground(w[0], CAMERA, GROUND) == pytest.approx((1.25, -0.375), rel=1e-3)
    seen = scale_inverse(w, CAMERA, GROUND, "a model", ())
    assert seen.scale_known
    np.testing.assert_allclose(seen.z, z, rtol=2e-3)
    assert "ground at 0.2 m" in seen.notes[0]


def test_a_ground_that_is_not_there_gives_nothing():
    w = np.random.default_rng(0).uniform(0.1, 1, (1, HEIGHT, WIDTH))
    assert fit_ground(w[0], CAMERA, GROUND) is None
    seen = scale_inverse(w, CAMERA, GROUND, "a model", ())
    assert not seen.scale_known and any("was not found" in note for note in seen.notes)
    above = look_at((0, -4, 2), (0, 0, 8), (0, 0, 1), fov_degrees=20, width=WIDTH, height=HEIGHT)
    assert fit_ground(w[0], above, 0.0) is None
