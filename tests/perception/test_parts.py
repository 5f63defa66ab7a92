"""The stages of perception, one by one."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.core.rotations import unwrap
from physagent_jax.perception import fit, follow, lift, timing
from physagent_jax.perception.backends.colour import ColorSegmenter
from physagent_jax.perception.backends.depth_sensor import DepthSensor
from physagent_jax.perception.backends.flow import FlowTracker
from physagent_jax.perception.ends import PartPrompt
from physagent_jax.perception.overlay import draw_overlay
from physagent_jax.perception.protocols import Tracks
from physagent_jax.perception.words import ViewerWords, name_world_axis
from physagent_jax.render.camera import look_at
from tests.perception import scenes


def test_the_schema_needs_neither_opencv_nor_jax():
    code = (
        "import sys, physagent_jax.perception.schema; "
        "sys.exit(bool({'cv2', 'jax', 'scipy', 'numpy'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("background", [(255, 255, 255), (40, 60, 80), "busy"])
def test_segmentation_overlaps_the_truth(background):
    clip = scenes.film(
        scenes.blob(),
        scenes.rotated((0, 1, 0), 40),
        frames=3,
        background=(128, 128, 128) if background == "busy" else background,
    )
    rgb, truth = clip.rgb.copy(), np.isfinite(clip.depth)
    if background == "busy":
        noise = np.random.default_rng(0).normal(0, 8, rgb.shape)
        rgb = np.where(truth[..., None], rgb, np.clip(rgb + noise, 0, 255)).astype(np.uint8)
    masks = ColorSegmenter().segment(rgb, None).masks
    assert (masks & truth).sum() / (masks | truth).sum() > (0.93 if background == "busy" else 0.97)


def test_a_floor_before_a_wall_is_no_object_and_what_the_picture_cuts_is_one():
    """The border of a room has two colours, and its median is one of them."""
    picture = np.full((2, 90, 120, 3), 200, np.uint8)
    picture[:, 50:] = 120, 90, 60
    picture[:, 40:70, 50:70] = 20, 20, 160
    room = ColorSegmenter().segment(picture, None)
    assert not room.masks.any() and "too busy" in room.notes[0]
    cut = np.full((2, 90, 120, 3), 200, np.uint8)
    cut[:, 40:, 40:80] = 20, 20, 160
    assert ColorSegmenter().segment(cut, None).masks[:, 45:85, 45:75].all()


def test_segmentation_of_nothing():
    assert not ColorSegmenter().segment(np.full((2, 40, 50, 3), 77, np.uint8), None).masks.any()


def test_unprojection_inverts_projection():
    view = scenes.camera((1.0, -2.0, 0.7))
    points = np.random.default_rng(0).normal(0, 0.3, (50, 3))
    seen = points @ view.viewmat[:3, :3].T + view.viewmat[:3, 3]
    pixels = (seen @ view.K.T)[:, :2] / seen[:, 2:]
    assert lift.unproject(pixels, seen[:, 2], view) == pytest.approx(points, abs=1e-12)


def test_pixel_centres_lie_at_one_half():
    depth = np.arange(20, dtype=np.float32).reshape(4, 5)
    assert lift.sample(depth, np.array([[2.5, 1.5], [3.0, 2.0]])) == pytest.approx([7.0, 10.0])
    assert np.isnan(lift.sample(depth, np.array([[4.9, 1.0], [-3.0, 1.0]]))).all()


def test_depth_that_bleeds_at_the_edge_is_not_trusted():
    mask = np.zeros((60, 60), bool)
    mask[15:45, 15:45] = True
    depth = np.where(mask, 2.0, np.nan).astype(np.float32)
    depth[15, 15:45] = 2.6
    depth[30, 30] = 5.0
    trusted, noise = lift.keep_trusted_depth(depth, mask)
    assert np.nanmax(trusted) == pytest.approx(2.0) and noise == 0
    assert np.isfinite(trusted).sum() > 0.7 * mask.sum()


def test_a_thin_object_keeps_its_depth():
    mask = np.zeros((60, 60), bool)
    mask[10:50, 30:32] = True
    trusted, _ = lift.keep_trusted_depth(np.full((60, 60), 2.0, np.float32), mask)
    assert np.isfinite(trusted).sum() == mask.sum()


def test_the_rim_of_a_round_body_tells_its_middle():
    clip = scenes.film(scenes.blob(axes=(0.4, 0.4, 0.4)), scenes.translated((0, 0, 0)), frames=1)
    depth, mask = clip.depth[0], np.isfinite(clip.depth[0])
    center = lift.find_center(lift.keep_trusted_depth(depth, mask)[0], mask, clip.camera)
    front = lift.find_middle(lift.unproject_surface(depth, clip.camera))
    assert np.linalg.norm(center) < 0.1 < np.linalg.norm(front)


def test_affine_fit_survives_outliers():
    rng = np.random.default_rng(1)
    a = rng.normal(size=(200, 3)) * (0.5, 0.2, 0.4)
    R = Rotation.from_rotvec((0.2, -0.5, 0.9)).as_matrix()
    A = R @ np.diag((1.5, 0.7, 0.9))
    b = a @ A.T + (1, 2, 3)
    b[:15] += rng.normal(size=(15, 3))
    found = fit.fit_affine(a, b)
    assert found.matrix == pytest.approx(A, abs=0.03)
    assert found.rotation == pytest.approx(R, abs=0.02)
    assert found(np.zeros(3)) == pytest.approx((1, 2, 3), abs=0.01)


def test_an_end_that_moves_by_itself_is_motion_and_no_outlier():
    """A quarter that is squashed to half: the strain is that of least squares, with a few lost points or without."""
    rng = np.random.default_rng(3)
    a = rng.uniform(-0.5, 0.5, (400, 3)) * (0.5, 0.3, 1.0)
    b = a.copy()
    top = a[:, 2] > 0.2
    b[top, 2] = 0.2 + 0.3 * (a[top, 2] - 0.2)
    exact = np.polyfit(a[:, 2], b[:, 2], 1)[0]
    assert exact < 0.87
    assert fit.fit_affine(a, b).matrix[2, 2] == pytest.approx(exact, abs=0.015)
    b[::25] += rng.normal(0, 0.4, (16, 3))
    assert fit.fit_affine(a, b).matrix[2, 2] == pytest.approx(exact, abs=0.02)


def test_a_flat_side_keeps_its_unseen_thickness():
    a = np.random.default_rng(2).uniform(-1, 1, (100, 3)) * (1, 0, 1)
    R = Rotation.from_rotvec((0, 0, 0.6)).as_matrix()
    found = fit.fit_affine(a, a * (1.4, 1, 0.7) @ R.T)
    assert found.matrix == pytest.approx(R @ np.diag((1.4, 1, 0.7)), abs=0.01)
    assert (
        fit.estimate_hidden_spread(a, np.array((0, 1.0, 0)))
        < 1e-3
        < fit.estimate_hidden_spread(a, np.array((1.0, 0, 0)))
    )


def test_angles_grow_beyond_half_a_turn():
    axis = np.array((0.6, 0.0, 0.8))
    angles = np.radians(np.linspace(0, 500, 26))
    rotations = [Rotation.from_rotvec(a * axis).as_matrix() for a in angles]
    rotations[3] = None
    vectors = unwrap(rotations)
    assert vectors[3] is None
    assert [v @ axis for v in vectors if v is not None] == pytest.approx(
        np.delete(angles, 3).tolist(), abs=1e-6
    )
    back = unwrap([Rotation.from_rotvec(a * axis).as_matrix() for a in (*angles, *angles[::-1])])
    assert np.linalg.norm(back[-1]) == pytest.approx(0, abs=1e-6)


def test_tracks_do_not_drift_under_rotation():
    clip = scenes.film(scenes.blob(), scenes.rotated((0, -3, 0.5), 90))  # about the viewing axis
    masks = np.isfinite(clip.depth)
    y, x = np.mgrid[100:160:8, 90:170:8]
    queries = np.stack([x.ravel() + 0.5, y.ravel() + 0.5], 1)
    found = FlowTracker().encode(clip.rgb, masks).track(np.insert(queries, 0, 0, axis=1))
    tracks, visible = found.xy, found.visible
    middle = np.array((128.0, 128.0))
    expected = middle + (queries - middle) @ np.array([[0, -1], [1, 0]])
    error = np.linalg.norm(tracks[-1] - expected, axis=1)[visible[-1]]
    assert visible[-1].mean() > 0.9 and np.median(error) < 0.15 and np.quantile(error, 0.9) < 0.3


@pytest.mark.parametrize("periods", [1, 2, 5])
def test_oscillation_of_a_sine(periods):
    t = np.linspace(0, 1, 60)
    path = 0.2 * np.sin(2 * np.pi * periods * t)[:, None] * (0.6, 0, 0.8) + 0.1 * t[:, None] * (0, 1, 0)
    path[7] = np.nan
    found = timing.find_oscillation(path, 0.1, 0.01)
    assert found.reversals == 2 * periods
    assert found.frequency_hz == pytest.approx(periods / 5.9, rel=0.03)
    assert found.amplitude == pytest.approx(0.2, rel=0.05)
    assert found.direction == pytest.approx((0.6, 0, 0.8), abs=0.1)


@pytest.mark.parametrize(
    "path", [lambda t: t, lambda t: t**2, lambda t: t * (1 - t), lambda t: 0.004 * np.sin(40 * t)]
)
def test_no_oscillation(path):
    t = np.linspace(0, 1, 50)
    assert timing.find_oscillation(path(t)[:, None] * (1.0, 0, 0), 0.1, 0.01) is None


def test_onset_and_settling_of_a_ramp():
    ramp = np.clip(np.arange(40) - 10, 0, 15) * 0.05
    assert timing.find_onset(ramp, 0.01) == 11
    assert timing.find_settling(np.abs(ramp - ramp[-1]), 0.01) == 25
    assert timing.find_onset(np.zeros(9), 0.01) is None
    assert timing.find_settling(np.abs(np.arange(40) - 39) * 0.05, 0.01) is None
    assert timing.find_onset(np.array([0, 0, 0.2, 0, 0]), 0.01) is None, "a single frame's jump is noise"


@pytest.mark.parametrize(
    ("eye", "up"), [((0, -3, 0.5), (0, 0, 1)), ((2, 2, 1), (0, 0, 1)), ((0.3, -0.4, -3), (0, -1, 0))]
)
def test_viewers_words(eye, up):
    view = look_at(eye, (0, 0, 0), up, fov_degrees=40, width=64, height=64)
    words = ViewerWords(view, up)
    assert words.where(view.right).startswith("to the right")
    assert words.where(-view.right).startswith("to the left")
    assert words.where(up).startswith("up (world")
    assert words.where(np.asarray(eye, float)).startswith(("towards the camera", "("))
    assert words.turn(view.forward).startswith("clockwise for the viewer")
    top = np.cross(words.right, up)  # where the top goes in a turn about `right`
    assert top @ view.forward < 0 and words.turn(words.right).startswith("tipping its top towards")
    assert words.turn(up).startswith("counter-clockwise seen from above")


def test_world_axes():
    assert name_world_axis((-0.5, 0.01, 0)) == "world -x"
    assert name_world_axis((0.5, 0.5, 0)) == "world (0.50, 0.50, 0.00)"


def test_depth_sensor_marks_missing_surface():
    measured = np.array([[[0.0, 1.0], [np.nan, 2.0]]])
    depth = DepthSensor().estimate(np.zeros((1, 2, 2, 3), np.uint8), scenes.camera(), measured).z
    assert np.isnan(depth[0, 0, 0]) and depth[0, 1, 1] == 2


def test_overlay_draws_without_touching_its_input():
    rgb = np.full((3, 40, 40, 3), 200, np.uint8)
    masks = np.zeros((3, 40, 40), bool)
    masks[:, 10:30, 10:30] = True
    tracks = np.full((3, 2, 2), 20.0) + np.arange(3)[:, None, None]
    drawn = draw_overlay(rgb, masks, tracks, np.ones((3, 2), bool))
    assert drawn.shape == rgb.shape and drawn.dtype == np.uint8
    assert (rgb == 200).all() and (drawn[2, 12:28, 12:28] != 200).any()
    assert draw_overlay(rgb, masks, np.zeros((3, 0, 2)), np.zeros((3, 0), bool)).shape == rgb.shape
    some = draw_overlay(rgb, masks, tracks, np.ones((3, 2), bool), frames=[2, 0])
    np.testing.assert_array_equal(some, drawn[[2, 0]])


def test_seeds_without_depth_do_not_stop_the_measurement():
    """An object that breaks up leaves seeds at rims without depth; the rest is still followed."""
    camera = look_at((0, -3, 0), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=64, height=64)
    seeds = np.stack(np.meshgrid(np.arange(20.5, 44, 4), np.arange(20.5, 44, 4)), -1).reshape(-1, 2)
    depths = np.full((2, 64, 64), 3.0)
    depths[0, 20:22] = np.nan  # under the first row of seeds, in the frame where they are planted
    everywhere = np.ones((2, len(seeds)), bool)
    still = Tracks(np.broadcast_to(seeds, (2, *seeds.shape)), everywhere, everywhere.astype(float))
    path = follow.Path([None, None], np.full(2, -1), np.zeros(2), np.zeros((2, 0, 2)), np.zeros((2, 0), bool))
    clip = SimpleNamespace(track=lambda queries, until: still)
    reached = follow.link(
        path,
        slice(0, 2),
        fit.Affine.identity(),
        0,
        seeds,
        clip,
        depths,
        camera,
    )
    assert reached == 1
    np.testing.assert_allclose(path.poses[1].matrix, np.eye(3), atol=1e-6)


@pytest.mark.parametrize("changed", [False, True])
def test_a_part_is_back_where_the_picture_shows_it_as_at_first(changed):
    """Its tracks drift by a pixel per frame; the last picture is the first one, or another."""
    camera = look_at((0, -3, 0), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=64, height=64)
    rng, depths = np.random.default_rng(0), np.full((6, 64, 64), np.nan)
    depths[:, 12:52, 12:52] = 3.0
    frames = rng.integers(0, 255, (6, 64, 64, 3), np.uint8)
    frames[5] = frames[5] if changed else frames[0]

    def track(queries, until):
        shifts = np.arange(6.0)[:, None, None] * (1.0, 0.0)
        seen = np.ones((6, len(queries)), bool)
        return Tracks(queries[None, :, 1:] + shifts, seen, seen.astype(float))

    surface = lift.unproject_surface(depths[0], camera)
    right = surface[:, 0] > 0.25
    prompt = PartPrompt(0, surface[right][::7], surface[~right][::7])
    path = follow.follow(frames, depths, camera, SimpleNamespace(track=track), (prompt,))
    ways = [None if p is None else np.linalg.norm(p.offset) for p in (each[-1] for each in path.ends.poses)]
    assert ways[1] > 0.01
    assert (ways[5] == 0.0) is not changed
