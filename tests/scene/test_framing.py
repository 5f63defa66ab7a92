"""The share of the picture that an object fills, for perception and for people."""

import numpy as np
import pytest

from physagent_jax.render.stage import Stage
from physagent_jax.scene import config as c
from physagent_jax.scene.camera import LEAST_SHARE, MOST_HEIGHT, frame_camera, make_reference_camera
from physagent_jax.scene.presentation import find_stage, place_cameras

WIDE = c.Rendering(width=1280, height=720)
CENTRE = np.array([2.0, 2.0, 1.0])
CORNERS = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T
BOX = CORNERS * [0.6, 0.4, 1.0] + [2, 2, 1.0]


def to_screen(points, camera):
    """Picture coordinates as shares of width and height, shape (m, 2)."""
    view = np.asarray(camera.viewmat)
    local = points @ view[:3, :3].T + view[:3, 3]
    assert (local[:, 2] > 0).all()
    return (local @ np.asarray(camera.K).T)[:, :2] / local[:, 2:] / [camera.width, camera.height]


def inside(points, camera):
    seen = to_screen(points, camera)
    return bool((seen > 0).all() and (seen < 1).all())


def height(points, camera):
    return np.ptp(to_screen(points, camera)[:, 1])


def framed(points, start=BOX, view=None, rendering=WIDE):
    camera = frame_camera(points, view or c.CameraConfig(azimuth_degrees=20), rendering, start=start)
    return make_reference_camera(camera, rendering, c.Domain())


def test_an_object_that_stays_does_not_fill_the_picture():
    assert height(BOX, framed(BOX)) == pytest.approx(MOST_HEIGHT, abs=0.01)
    assert inside(BOX, framed(BOX))


@pytest.mark.parametrize("shift", [(-1.6, 0, 0), (0, 0, 1.2), (0, 2, 0), (0.3, 0, 0.1)])
def test_a_usual_motion_stays_inside_and_the_object_is_of_a_good_size(shift):
    points = np.concatenate([BOX, BOX + shift])
    camera = framed(points)
    assert inside(points, camera)
    assert LEAST_SHARE - 0.01 <= height(BOX, camera) <= MOST_HEIGHT + 0.01


@pytest.mark.parametrize("shift", [(-20, 0, 0), (0, 0, 30.0), (9, 0, 9)])
def test_of_a_very_long_way_the_start_is_shown(shift):
    points = np.concatenate([BOX, BOX + shift])
    camera = framed(points)
    assert inside(BOX, camera)
    assert height(BOX, camera) == pytest.approx(LEAST_SHARE, abs=0.02)  # at the rim a view is wider
    ends = to_screen(np.array([[2, 2, 1.0], np.add([2, 2, 1.0], np.multiply(shift, 0.03))]), camera)
    free = np.array([0.5, 0.5]) - ends[0]  # the room is left on the side that it goes to
    assert free @ (ends[1] - ends[0]) > 0


def test_a_flat_wide_object_is_not_cut_off_to_be_high_enough():
    flat = CORNERS * [1.0, 1.0, 0.01] + [2, 2, 1.0]
    assert inside(flat, framed(flat, flat, c.CameraConfig(elevation_degrees=1.0)))


# --- the video for people ---------------------------------------------------------------------------------------------


def scene(**camera):
    return c.SceneConfig(
        source=c.Source(path="x.ply"), camera=c.CameraConfig(**camera), timing=c.Timing(frame_count=26)
    )


def moving(velocity, frames=26):
    inner = np.random.default_rng(0).uniform(-0.5, 0.5, (400, 3)) * [0.6, 0.4, 1.0] + [2, 2, 1.0]
    points = np.concatenate([BOX, inner])
    return points + np.arange(frames)[:, None, None] * 0.04 * np.asarray(velocity, float)


@pytest.mark.parametrize("velocity", [(0, 0, 0), (-1.5, 0, 0), (0.5, 1.0, 0.8)])
def test_peoples_camera_stands_still_and_shows_all_of_the_motion(velocity):
    x = moving(velocity)
    cameras = place_cameras(scene(), x, WIDE)
    assert len(cameras) == len(x) and all(camera is cameras[0] for camera in cameras)
    assert all(inside(points, camera) for points, camera in zip(x, cameras))
    assert LEAST_SHARE - 0.01 <= height(x[0], cameras[0]) <= MOST_HEIGHT + 0.01


@pytest.mark.parametrize(
    ("velocity", "follow"), [((-1.5, 0, 0), True), ((-40, 0, 0), None), ((0, 0, 30), None)]
)
def test_a_camera_follows_if_asked_to_or_if_the_object_would_be_too_small(velocity, follow):
    x = moving(velocity)
    cameras = place_cameras(scene(follow=follow), x, WIDE)
    assert all(inside(points, camera) for points, camera in zip(x, cameras))
    assert LEAST_SHARE - 0.01 <= height(x[0], cameras[0]) <= MOST_HEIGHT + 0.01
    eyes = np.array([camera.center for camera in cameras])
    way = eyes[-1] - eyes[0]
    assert way @ np.asarray(velocity) > 0.5 * np.linalg.norm(velocity) ** 2 * 25 * 0.04
    for camera in cameras:  # it moves without turning
        np.testing.assert_allclose(camera.viewmat[:3, :3], cameras[0].viewmat[:3, :3], atol=1e-9)


def test_a_camera_that_follows_does_not_jerk():
    x = moving((0, 0, 0))
    x[13:] += [1.0, 0, 0]  # a jump
    eyes = np.array([camera.center for camera in place_cameras(scene(follow=True), x, WIDE)])
    assert np.linalg.norm(np.diff(eyes, axis=0), axis=1).max() < 0.1


def test_a_camera_that_must_not_follow_does_not():
    cameras = place_cameras(scene(follow=False), moving((-40, 0, 0)), WIDE)
    assert all(camera is cameras[0] for camera in cameras) and inside(BOX, cameras[0])


SHAPES = {
    "flat": [1.0, 0.8, 0.15],
    "long": [1.0, 0.1, 0.1],
    "tall": [0.15, 0.15, 1.0],
    "cube": [1.0, 1.0, 1.0],
}
RISE = np.linspace(0, 1, 40)[:, None] ** 2 * [0, 0, 1.0]
SIDE, ARC = RISE[:, [2, 0, 1]], RISE + np.linspace(0, 1, 40)[:, None] * [1.0, 0, 0] - RISE**0.5 * 0.5


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("way", [SIDE, RISE, ARC], ids=["side", "rise", "arc"])
@pytest.mark.parametrize("far", [1.0, 2.5, 6.0])
def test_all_of_a_way_is_in_the_picture_with_a_margin(shape, way, far):
    """Of an object of any shape, its tips as well; and it is large enough to be seen."""
    size = np.array(SHAPES[shape])
    inner = np.random.default_rng(0).uniform(-0.5, 0.5, (3000, 3))
    tip = np.array([[0.55, 0, 0], [0, 0, -0.55], [0, 0, 0.55]])  # fewer than might have flown off
    rest = np.concatenate([CORNERS, inner, tip]) * size
    x = rest + [2, 2, 1.0] + far * way[:, None]
    cameras = place_cameras(scene(), x, WIDE)
    seen = np.stack([to_screen(points, camera) for points, camera in zip(x, cameras)])
    assert seen.min() > 0.02 and seen.max() < 0.98
    assert np.ptp(seen, axis=1).max(axis=1).min() > 0.25
    steps = np.diff([camera.center for camera in cameras], axis=0)
    jerk = np.linalg.norm(np.diff(steps, axis=0), axis=1).max()
    assert jerk <= np.linalg.norm(np.diff(far * way, n=2, axis=0), axis=1).max() + 1e-6, "no faster than it"


def test_what_flies_off_or_breaks_does_not_make_the_rest_small():
    x = moving((0, 0, 0))
    x[5:, -1] = [300.0, 2, 1]
    x[9:, -2] = np.nan
    camera = place_cameras(scene(), x, WIDE)[0]
    assert height(x[0, :-2], camera) == pytest.approx(MOST_HEIGHT, abs=0.03)


def test_the_ground_of_a_stage_is_the_level_plane():
    slope, wall = (
        c.HalfSpace(point=(0, 0, 9), normal=(1, 0, 1)),
        c.HalfSpace(point=(0, 0, 9), normal=(1, 0, 0)),
    )
    floor = c.HalfSpace(point=(0, 0, 0.4), normal=(0, 0, 1))
    bare = scene()
    grounded = bare.model_copy(update=dict(boundaries=(c.DomainBox(), wall, slope, floor)))
    assert find_stage(grounded, CENTRE, 1.0).ground == 0.4
    assert find_stage(bare, CENTRE, 1.0) == Stage(None, 1.0)


def test_walls_and_boxes_that_stand_still_are_on_the_stage():
    wall = c.HalfSpace(point=(3.0, 0, 0), normal=(-1, 0, 0))
    box = c.Box(point=(1, 1, 0.2), half_size=(0.1, 0.2, 0.3))
    moving_box, later = (
        box.model_copy(update=dict(velocity=(1.0, 0, 0))),
        box.model_copy(update=dict(start=0.5)),
    )
    config = scene().model_copy(update=dict(boundaries=(c.DomainBox(), wall, box, moving_box, later)))
    panel, block = find_stage(config, CENTRE, 1.0).blocks
    np.testing.assert_allclose(block.center, box.point)
    face = panel.center - panel.axes.T @ [-panel.half_size[0], 0, 0]
    np.testing.assert_allclose(
        face, [3.0, 2.0, 1.0], atol=1e-12
    )  # right beside the object, on the wall's plane
    np.testing.assert_allclose(panel.axes @ panel.axes.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("azimuth", range(-180, 180, 20))
@pytest.mark.parametrize("way", [(-0.6, -0.8, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
def test_what_meets_a_wall_is_seen_from_beside_it(azimuth, way):
    """The camera stands on the wall's free side, as seen along which it hides nothing of what comes towards it."""
    way = np.array(way)
    point = tuple((np.array([2.0, 2.0, 1.0]) + 1.6 * way).tolist())
    wall = c.HalfSpace(point=point, normal=tuple((-way).tolist()))
    config = scene(azimuth_degrees=azimuth).model_copy(update=dict(boundaries=(wall,)))
    away = np.asarray(place_cameras(config, moving(tuple(way)), WIDE)[0].viewmat)[2, :2]
    forward = away @ way[:2] / np.linalg.norm(away)
    assert -1e-9 <= forward <= np.sin(np.radians(20.5))


def test_what_goes_towards_the_camera_is_seen_from_aside():
    config = scene(azimuth_degrees=0).model_copy(update=dict(boundaries=()))
    way = np.array([-0.6, -0.8, 0.0])
    away = np.asarray(place_cameras(config, moving(tuple(way)), WIDE)[0].viewmat)[2, :2]
    across = np.degrees(np.arccos(abs(away @ way[:2]) / np.linalg.norm(away)))
    assert across == pytest.approx(40.0, abs=0.5)
