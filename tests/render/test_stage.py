"""Ground, shadow and horizon: where the camera's geometry says, and only around what is drawn."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.render import look_at, render
from physagent_jax.render.blocks import Block, cast_at_block
from physagent_jax.render.shadow import cast_shadow
from physagent_jax.render.stage import GRID_STEP, HORIZON, Stage, compose, make_backdrop
from tests.render.scenes import one_splat

WIDTH, HEIGHT = 160, 120
EYE, TARGET = np.array([0.3, -3.0, 1.2]), np.array([0.0, 0.0, 0.3])
CAMERA = look_at(EYE, TARGET, (0, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)
STAGE = Stage(ground=0.0, size=1.0)


def to_pixels(points, camera=CAMERA):
    view = np.asarray(camera.viewmat)
    local = np.atleast_2d(points) @ view[:3, :3].T + view[:3, 3]
    return (local @ np.asarray(camera.K).T)[:, :2] / local[:, 2:]


def at(picture, point, camera=CAMERA):
    x, y = to_pixels(point, camera)[0]
    return picture[int(y), int(x)].astype(float)


def staged(splats, stage=STAGE, camera=CAMERA):
    return compose(render(splats, camera, background=(0, 0, 0)), splats, make_backdrop(stage, camera))


def ball(height, x=0.0, sigma=0.1):
    return one_splat([x, 0.0, height], sigma=sigma, opacity=0.99, color=(0.9, 0.1, 0.1))


def empty(camera=CAMERA, stage=STAGE):
    return make_backdrop(stage, camera).levels


@pytest.mark.parametrize("elevation", [-0.2, 0.0, 0.25])
def test_the_horizon_is_at_the_height_of_the_eye(elevation):
    """Whatever the camera's pitch: ground and sky part where rays are level."""
    away = np.array([0, np.cos(elevation), -np.sin(elevation)])
    camera = look_at(EYE, EYE + away, (0, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)
    row = HEIGHT / 2 - np.tan(elevation) * np.asarray(camera.K)[1, 1]
    assert 5 < row < HEIGHT - 5
    step = np.abs(np.diff(empty(camera).astype(float).sum(2).mean(1)))
    assert abs(np.argmax(step) + 1 - row) <= 1.5


def test_a_rolled_camera_has_a_rolled_horizon():
    level = look_at(EYE, EYE + [0, 1, 0], (0, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)
    camera = look_at(EYE, EYE + [0, 1, 0], (0.5, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)
    ground = make_backdrop(STAGE, camera).ground
    assert np.isfinite(make_backdrop(STAGE, level).ground[HEIGHT // 2 + 2 :]).all()
    left, right = (np.isfinite(ground[:, column, 0]).sum() for column in (0, WIDTH - 1))
    assert abs(left - right) == pytest.approx(0.5 * WIDTH, abs=4)


def test_ground_points_project_onto_their_pixels():
    points = make_backdrop(STAGE, CAMERA).ground
    for row, column in ((70, 10), (100, 80), (119, 159)):
        x, y = points[row, column]
        np.testing.assert_allclose(to_pixels([x, y, 0.0])[0], [column + 0.5, row + 0.5], atol=1e-2)


def test_the_grid_lies_on_the_ground_and_is_faint():
    camera = look_at((0.1, -1.5, 1.0), (0.1, 0, 0), (0, 0, 1), fov_degrees=40, width=640, height=480)
    picture = empty(camera)
    line = at(picture, [0.0, 0.25 * GRID_STEP, 0], camera)
    between = at(picture, [0.5 * GRID_STEP, 0.25 * GRID_STEP, 0], camera)
    assert 5 < (between - line).mean() < 40


def test_the_far_ground_pales_without_moire():
    camera = look_at((0, 0, 0.4), (0, 10, 0), (0, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)
    picture = empty(camera).astype(float)
    row = int(HEIGHT / 2 - 0.04 * np.asarray(camera.K)[1, 1]) + 4
    assert np.ptp(picture[row : row + 3].mean(2), axis=1).max() < 6
    assert np.abs(picture[row] / 255 - HORIZON).max() < 0.12


def test_a_shadow_lies_below_what_casts_it_and_moves_with_it():
    for x in (-0.4, 0.0, 0.5):
        darkness = empty().astype(float) - staged(ball(0.4, x))
        assert at(darkness, [x, 0, 0]).mean() > 5
        assert np.abs(at(darkness, [x + 0.9, 0, 0])).max() <= 1
        shadow = cast_shadow(ball(0.4, x), 0.0, 1.0)
        weights = shadow.darkness / shadow.darkness.sum()
        centre = [(weights.sum(1 - axis) * np.arange(weights.shape[axis])).sum() for axis in (0, 1)]
        np.testing.assert_allclose(shadow.low + shadow.cell * np.array(centre), [x, 0], atol=0.01)


def test_a_shadow_is_darker_and_sharper_the_nearer_the_ground():
    depth, width = [], []
    for height in (0.0, 0.05, 0.2, 0.5, 1.0):
        darkness = cast_shadow(ball(height), 0.0, 1.0).darkness
        depth.append(darkness.max())
        width.append((darkness > 0.5 * darkness.max()).sum())
    assert (np.diff(depth) < 0).all() and (np.diff(width) > 0).all()
    assert depth[0] > 0.3
    assert cast_shadow(ball(2.5), 0.0, 1.0) is None


def test_shadows_change_smoothly_with_height():
    peaks = [cast_shadow(ball(height), 0.0, 1.0).darkness.max() for height in np.linspace(0, 1.5, 61)]
    assert (np.diff(peaks) <= 0).all() and np.abs(np.diff(peaks)).max() < 0.2


def test_transparent_gaussians_cast_no_shadow():
    clear = dataclasses.replace(ball(0.1), opacities=jnp.zeros(1))
    assert cast_shadow(clear, 0.0, 1.0) is None


def test_what_is_drawn_hides_the_ground_behind_it():
    picture = staged(ball(0.5, sigma=0.2))
    assert at(picture, [0, 0, 0.5])[0] > 200 and at(picture, [0, 0, 0.5])[1] < 60


@pytest.mark.parametrize("height", [-0.6, -2.0])
def test_what_is_below_the_ground_is_hidden_and_casts_nothing(height):
    np.testing.assert_array_equal(staged(ball(height)), empty())


def test_what_touches_the_ground_is_not_cut():
    """Matter sinks into a soft contact by a little; that is no reason to lose its foot."""
    resting = ball(0.0, sigma=0.05)
    bare = staged(resting, Stage(None, 1.0))
    np.testing.assert_allclose(at(staged(resting), [0, 0, 0]), at(bare, [0, 0, 0]), atol=6)


def test_without_a_ground_there_is_neither_horizon_nor_shadow():
    stage = Stage(None, 1.0)
    plain = empty(stage=stage).astype(float)
    assert np.ptp(plain, axis=1).max() <= 1 and np.abs(np.diff(plain.mean((1, 2)))).max() < 2
    changed = np.abs(staged(ball(0.4), stage).astype(float) - plain).max(2) > 1
    rows, columns = np.nonzero(changed)
    centre = to_pixels([0, 0, 0.4])[0]
    assert np.hypot(columns + 0.5 - centre[0], rows + 0.5 - centre[1]).max() < 25


def test_from_below_the_ground_nothing_of_it_is_drawn():
    camera = look_at((0, -3, -0.5), (0, 0, 0.4), (0, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)
    np.testing.assert_array_equal(empty(camera), empty(camera, Stage(None, 1.0)))
    assert at(staged(ball(0.4), camera=camera), [0, 0, 0.4], camera)[1] < 60


def test_a_stage_is_the_same_at_any_scale():
    """Metres are only units: an object ten times as large on a stage ten times as large is the same picture."""
    large = look_at(10 * EYE, 10 * TARGET, (0, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)
    one = staged(ball(0.3, 0.2)).astype(int)
    ten = staged(
        one_splat([2.0, 0, 3.0], sigma=1.0, opacity=0.99, color=(0.9, 0.1, 0.1)), Stage(0.0, 10.0), large
    )
    assert np.abs(one - ten).max() <= 2


def test_objects_far_apart_stay_affordable():
    splats = dataclasses.replace(
        ball(0.1),
        means=jnp.asarray([[0.0, 0, 0.1], [1e6, 0, 0.1], [0.2, 0, 0.1]], jnp.float32),
        covariances=jnp.tile(ball(0.1).covariances, (3, 1)),
        opacities=jnp.full(3, 0.9),
    )
    shadow = cast_shadow(splats, 0.0, 1.0)
    assert max(shadow.darkness.shape) < 400
    assert shadow.sample(np.array([[0.1, 0.0], [np.nan, 0.0], [50.0, 0.0]], np.float32))[0] > 0.05


# --- walls ------------------------------------------------------------------------------------------------------------


def block(x, y, z=0.3, half=(0.2, 0.1, 0.3)):
    return Block(np.array([x, y, z]), np.eye(3), np.array(half))


def test_rays_meet_a_block_where_it_is():
    depth, _ = cast_at_block(block(0.1, 0.5), CAMERA)
    rows, columns = np.nonzero(np.isfinite(depth))
    corners = np.array([0.1, 0.5, 0.3]) + np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T * [
        0.2,
        0.1,
        0.3,
    ]
    seen = to_pixels(corners)
    np.testing.assert_allclose([columns.min(), rows.min()], seen.min(0), atol=1.5)
    np.testing.assert_allclose([columns.max() + 1, rows.max() + 1], seen.max(0), atol=1.5)
    x, y = to_pixels([0.1, 0.4, 0.3])[0]  # on its front
    assert depth[int(y), int(x)] == pytest.approx(
        np.asarray(CAMERA.viewmat)[2] @ [0.1, 0.4, 0.3, 1], abs=0.02
    )


def test_a_block_hides_what_is_behind_it_and_not_what_is_in_front():
    stage = Stage(0.0, 1.0, (block(0.0, 0.5, half=(0.6, 0.1, 0.5)),))
    assert np.abs(at(empty(stage=stage).astype(float) - empty(), [0.3, 0.4, 0.4])).max() > 20
    front, behind = (
        staged(one_splat([0, y, 0.4], sigma=0.15, opacity=0.99, color=(0.9, 0.1, 0.1)), stage) for y in (0, 1)
    )
    assert at(front, [0, 0, 0.4])[1] < 60
    assert at(behind, [0, 1, 0.4])[1] > 90


def test_what_of_a_block_is_below_the_ground_is_not_drawn():
    sunk = Stage(0.0, 1.0, (block(0.0, 0.5, z=-0.6, half=(0.4, 0.1, 0.3)),))
    np.testing.assert_array_equal(empty(stage=sunk), empty())
