"""The video for people beside the pictures of perception."""

import numpy as np
import pytest

import physagent_jax as pa
from physagent_jax.gaussians.binding import deform
from physagent_jax.output.video import read_video
from physagent_jax.simulation.presentation import draw_presentation
from tests.run.specs import made, small

SIZE = (160, 90)


@pytest.fixture(scope="module")
def dropped(robot_path):
    with pytest.warns(UserWarning, match="particles per grid cell"):
        robot = pa.load_object(robot_path, max_particles=600)
    return pa.simulate_scene(pa.build_scene(robot, "drop the robot", frame_count=8, width=64, height=64))


def draw(recording, **changes):
    scene = recording.scene
    config = scene.config.model_copy(update=changes)
    x, F = recording.x[:, scene.back], recording.F[:, scene.back]
    return np.stack(list(draw_presentation(config, scene.body, x, F, SIZE)))


def test_pictures_for_people_have_their_own_size_and_a_ground(dropped):
    pictures = draw(dropped)
    assert pictures.shape == (8, 90, 160, 3) and pictures.dtype == np.uint8
    assert dropped.rgb.shape == (8, 64, 64, 3)
    white = (dropped.rgb == 255).all(axis=3).mean()
    assert white > 0.5, "perception's channel stays plain"
    assert not (pictures == 255).all(axis=3).any()
    low, sky = pictures[0, -5:].astype(float).mean((0, 1)), pictures[0, :5].astype(float).mean((0, 1))
    assert sky[2] > sky[0] + 3 and low[0] > low[2] + 3, "blue above, warm below"


def test_without_a_ground_the_backdrop_is_plain(dropped):
    free = tuple(b for b in dropped.scene.config.boundaries if b.kind == "domain_box")
    pictures = draw(dropped, boundaries=free).astype(float)
    edge = pictures[0, :, [0, -1]]
    assert np.abs(np.diff(edge, axis=1)).max() < 4


def test_the_program_that_deforms_is_the_simulations(dropped):
    compiled = deform._cache_size()
    draw(dropped)
    assert deform._cache_size() == compiled > 0


def test_a_run_leaves_a_video_for_people_and_a_plain_one_per_round(tmp_path, robot_path):
    spec = small(robot_path, "drop the robot", frames=5, rounds=1, save=dict(video_size=SIZE))
    store = made(spec, tmp_path / "run")
    assert read_video(store.path / "video.mp4").shape == (5, 90, 160, 3)
    assert read_video(store.path / "iterations/0/perception.mp4").shape == (5, 96, 96, 3)
    assert (store.path / "iterations/0/video.mp4").samefile(store.path / "video.mp4")
    assert {"video.mp4", "perception.mp4", "iterations/0/video.mp4"} <= set(store.manifest.files)
    shown = pa.open_run(store.path)
    assert shown.frames().shape == (5, 90, 160, 3)


def test_a_run_without_a_video_for_people_shows_the_plain_one(tmp_path, robot_path):
    store = made(small(robot_path, frames=4, rounds=1), tmp_path / "run")
    assert not list(store.path.glob("**/video.mp4"))
    assert pa.open_run(store.path).frames().shape == (4, 96, 96, 3)
