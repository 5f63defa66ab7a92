"""The video for people beside the pictures of perception."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

import physagent_jax as pa
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ConstraintType, ForceField, VelocityConstraint
from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.gaussians.specks import count_neighbours, hide_specks, shorten_needles
from physagent_jax.output.video import read_video
from physagent_jax.scene.actors import find_actors
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.config import CameraConfig
from physagent_jax.scene.presentation import place_cameras, turn_aside
from physagent_jax.scene.surfels import make_surfels
from physagent_jax.simulation import ending
from physagent_jax.simulation.ending import LONGEST, simulate_ending
from physagent_jax.simulation.notes import Notes
from physagent_jax.simulation.presentation import draw_presentation
from tests.run.specs import made, small

SIZE = (160, 90)


@pytest.fixture(scope="module")
def dropped(robot_path):
    with pytest.warns(UserWarning, match="thinly filled"):
        robot = pa.load_object(robot_path, max_particles=600, cells=48)
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
    film = read_video(store.path / "video.mp4")
    assert film.shape[1:] == (90, 160, 3) and len(film) > 5, "it still falls after the planned frames"
    assert read_video(store.path / "iterations/0/perception.mp4").shape == (5, 96, 96, 3)
    assert (store.path / "iterations/0/video.mp4").samefile(store.path / "video.mp4")
    assert {"video.mp4", "perception.mp4", "iterations/0/video.mp4"} <= set(store.manifest.files)
    shown = pa.open_run(store.path)
    assert shown.frames().shape == film.shape


def test_a_run_without_a_video_for_people_shows_the_plain_one(tmp_path, robot_path):
    store = made(small(robot_path, frames=4, rounds=1), tmp_path / "run")
    assert not list(store.path.glob("**/video.mp4"))
    assert pa.open_run(store.path).frames().shape == (4, 96, 96, 3)


def test_a_clip_goes_on_until_rest_and_no_longer(dropped):
    x, F = simulate_ending(dropped)
    planned, dt = len(dropped.x), dropped.scene.config.timing.frame_dt
    assert len(x) == len(F) > planned and len(x) - planned <= int(np.ceil(LONGEST / dt))
    np.testing.assert_array_equal(x[:planned], dropped.x[:, dropped.scene.back])
    config = dropped.scene.config
    timing = config.timing.model_copy(update=dict(frame_count=planned + 3))
    longer = pa.simulate_scene(
        compile_scene(config.model_copy(update=dict(timing=timing)), dropped.scene.body)
    )
    np.testing.assert_allclose(x[: planned + 3], longer.x[:, longer.scene.back], atol=1e-5)
    still = dataclasses.replace(dropped, x=np.repeat(dropped.x[:1], planned, axis=0))
    assert len(simulate_ending(still)[0]) == planned, "what rests already gets no ending"

    last = float(config.timing.frame_count - 1)
    press = VelocityConstraint(
        constraint_type=ConstraintType("moving_plate"), vector=(1, 0, 0), active_time=(0, 3), held_until=last
    )
    held = config.model_copy(update=dict(force_field=ForceField(constraints=(press,))))
    scene = dataclasses.replace(dropped.scene, config=held)
    assert len(simulate_ending(dataclasses.replace(dropped, scene=scene))[0]) == planned, (
        "what is held stays so"
    )


@pytest.fixture
def brief_endings(monkeypatch):
    """Endings of one frame, where a test asks whether there is one."""
    monkeypatch.setattr(ending, "LONGEST", 0.01)


@pytest.mark.parametrize("group", ["actions", "constraints"])
def test_what_is_carried_to_the_end_is_seen_there(dropped, group, brief_endings):
    """Not how it falls when it is let go: nobody asked for that."""
    kind = dict(action_type="translation", constraint_type="enforce_particle_translation")
    name = group.removesuffix("s") + "_type"

    def ends_with_the_plan(**entry):
        field = ForceField.model_validate({group: [{name: kind[name], "vector": (0, 0.2, 1), **entry}]})
        config = dropped.scene.config.model_copy(update=dict(force_field=field))
        scene = dataclasses.replace(dropped.scene, config=config)
        return len(simulate_ending(dataclasses.replace(dropped, scene=scene))[0]) == len(dropped.x)

    upper = dict(kind="half_space", point=(0.5, 0.5, 0.5), normal=(0, 0, 1))
    assert ends_with_the_plan(active_time=(2, 7)) and ends_with_the_plan()
    assert not ends_with_the_plan(active_time=(2, 5))
    assert not ends_with_the_plan(vector=(1, 0, 0.1)) and not ends_with_the_plan(region=upper)


def test_what_is_swung_over_the_ground_is_seen_standing(dropped, brief_endings):
    """The pushes hold it upright; what stands on small feet would fall over after them."""

    def ends_with_the_plan(windows, anchor="none", **more):
        pushes = [
            dict(action_type="translation", vector=(1, 0, 0), magnitude=(-1) ** k, active_time=each, **more)
            for k, each in enumerate(windows)
        ]
        config = dropped.scene.config
        changes = dict(
            force_field=ForceField.model_validate(dict(actions=pushes)),
            anchor=config.anchor.model_copy(update=dict(kind=anchor)),
        )
        scene = dataclasses.replace(dropped.scene, config=config.model_copy(update=changes))
        return len(simulate_ending(dataclasses.replace(dropped, scene=scene))[0]) == len(dropped.x)

    swing = [(0, 1.5), (1.5, 4.5), (4.5, 6)]
    assert ends_with_the_plan(swing)
    assert not ends_with_the_plan(swing[:2]), "a push and its brake"
    assert not ends_with_the_plan(swing, anchor="base"), "what is held swings out"
    upper = dict(kind="half_space", point=(0.5, 0.5, 0.5), normal=(0, 0, 1))
    assert not ends_with_the_plan(swing, region=upper)


def test_a_clip_ends_before_the_object_meets_the_domains_wall(robot_path):
    """Nobody sees that wall: what flies past it in the picture must not be turned or stopped by it."""
    with pytest.warns(UserWarning, match="thinly filled"):
        robot = pa.load_object(robot_path, max_particles=600)
    scene = pa.build_scene(robot, "a wind pushes the robot to the left", frame_count=50, width=32, height=32)
    recording = pa.simulate_scene(scene)
    x, _ = simulate_ending(recording)
    planned = len(recording.x)
    wall, dx = 3 * scene.config.domain.dx, scene.config.domain.dx
    assert 0 < len(x) - planned < int(np.ceil(LONGEST / scene.config.timing.frame_dt))
    assert x[-1, :, 0].min() < wall + 10 * dx, "it is on its way to the wall"
    assert x[:, :, 0].min() > wall + dx
    speed = np.diff(x[planned - 2 :, :, 0].mean(axis=1))
    np.testing.assert_allclose(speed, speed[0], rtol=0.02)
    shape = x - x.mean(axis=1, keepdims=True)
    assert np.linalg.norm(shape[-1] - shape[planned - 1], axis=1).max() < 0.02 * scene.body.extent


def test_a_caption_and_arrows_are_drawn_only_on_request(dropped):
    plain = draw(dropped)
    scene = dropped.scene
    x, F = dropped.x[:, scene.back], dropped.F[:, scene.back]
    noted = np.stack(list(draw_presentation(scene.config, scene.body, x, F, SIZE, Notes(caption=True))))
    assert (noted[:, -1].mean((1, 2)) < 0.6 * plain[:, -1].mean((1, 2))).all()
    np.testing.assert_array_equal(noted[:, :40], plain[:, :40])


def test_a_plate_that_acts_is_drawn_where_it_is(dropped):
    press = VelocityConstraint(
        constraint_type=ConstraintType("moving_plate"), vector=(1, 0, 0), active_time=(2, 6)
    )
    scene = dropped.scene
    scaling = make_closed_form_scaling(
        extent=scene.body.extent, youngs_modulus=1e5, density=1e3, duration=scene.config.timing.duration
    )
    config = scene.config.model_copy(
        update=dict(force_field=ForceField(constraints=(press,)), scaling=scaling)
    )
    x = np.repeat(np.asarray(scene.body.particles.x)[None], 8, axis=0)
    seen = find_actors(config, scene.body, x)
    assert [len(each) for each in seen] == [0, 0, 1, 1, 1, 1, 1, 1]  # then it goes back
    faces = np.array([(each[0].center + each[0].half_size[0] * each[0].axes[0])[0] for each in seen[2:6]])
    assert abs(faces[0] - x[0, :, 0].min()) < 1e-3, "it starts at the object's side"
    assert np.ptp(np.diff(faces)) < 1e-3 and (np.diff(faces) > 0).all()
    assert seen[7][0].center[0] < seen[6][0].center[0]
    pictures = [
        list(draw_presentation(c, scene.body, x, np.tile(np.eye(3), (8, x.shape[1], 1, 1)), SIZE))
        for c in (config, scene.config)
    ]
    changed = [bool((a != b).any()) for a, b in zip(*pictures)]
    assert changed == [False] * 2 + [True] * 6


def test_a_hand_is_drawn_where_it_pushes_on_the_side_that_is_left(dropped):
    """It comes, stays as long as it pushes, and goes back; what turns about y moves its top along x."""
    turn = VelocityConstraint(
        constraint_type=ConstraintType("enforce_particle_rotation"), vector=(0, 1, 0), active_time=(3, 4)
    )
    scene = dropped.scene
    x = np.repeat(np.asarray(scene.body.particles.x)[None], 8, axis=0)

    def find(touched):
        field = ForceField(constraints=(turn.model_copy(update=dict(touched=touched)),))
        return find_actors(scene.config.model_copy(update=dict(force_field=field)), scene.body, x)

    seen = [each[0].center for each in find(True) if each]
    assert not any(find(False)) and len(seen) == 8
    there, low, high = seen[4], x[0].min(0), x[0].max(0)
    assert there[0] < x[0, :, 0].mean() and low[2] + 0.5 * (high - low)[2] < there[2] < high[2]
    assert seen[0][0] < there[0] > seen[-1][0], "it comes and goes"


def test_what_moves_along_the_line_of_sight_is_seen_from_aside():
    cube = np.random.default_rng(0).uniform(-0.5, 0.5, (200, 3))
    camera = CameraConfig(azimuth_degrees=0)
    ways = {word: np.asarray(each) for word, each in find_viewer_directions(camera).items()}
    for word, way in ways.items():
        points = cube + np.linspace(0, 2, 6)[:, None, None] * way
        turned = turn_aside(camera, points)
        if word not in ("toward", "away"):
            assert turned == camera, word
            continue
        seen = {each: float(np.dot(axis, way)) for each, axis in find_viewer_directions(turned).items()}
        assert abs(seen["right"]) > 0.6 and seen[word] > 0.7, "it is seen to move, and still comes or goes"
    slight = ways["toward"] + 0.4 * ways["left"]
    turned = turn_aside(camera, cube + np.linspace(0, 2, 6)[:, None, None] * slight)
    assert np.dot(find_viewer_directions(turned)["left"], slight) > np.dot(ways["left"], slight), (
        "left stays left"
    )


def test_an_object_that_goes_far_stays_large(dropped):
    config = dropped.scene.config
    cube = 2 + np.random.default_rng(0).uniform(-0.5, 0.5, (300, 3))
    for word, way in find_viewer_directions(config.camera).items():
        x = cube + np.linspace(0, 9, 30)[:, None, None] * np.asarray(way)
        cameras = place_cameras(config, x, config.rendering)
        for points, camera in zip(x, cameras):
            local = points @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]
            places = local[:, :2] / local[:, 2:]
            share = np.ptp(places, axis=0).max() / (camera.height / camera.K[1, 1])
            assert 0.2 < share < 0.75, (word, share)


def test_specks_are_hidden_and_needles_shortened():
    rng = np.random.default_rng(0)
    means = np.concatenate([rng.uniform(-0.5, 0.5, (20_000, 3)), [[0.1, 0.1, 0.1]]])
    rest = count_neighbours(means, 1.0)
    far = means.copy()
    far[-1] = 2, 2, 2
    cloud = make_surfels(far, np.tile([0.0, 0, 1], (len(far), 1)), 0.01, np.full((len(far), 3), 0.5))
    flat, turn = jnp.zeros((len(far), 6)), jnp.eye(3)[None]
    splats = Splats(cloud.means, flat, cloud.opacities, cloud.sh, turn)
    hidden = np.flatnonzero(np.asarray(hide_specks(splats, rest, 1.0).opacities) == 0)
    assert hidden.tolist() == [len(far) - 1]
    scales = np.asarray(cloud.scales).copy()
    scales[0] = 0.3, 0.002, 0.001
    shortened = np.asarray(shorten_needles(dataclasses.replace(cloud, scales=scales), 1.0).scales)
    np.testing.assert_allclose(shortened[0], [0.06, 0.002, 0.001], rtol=1e-6)
    np.testing.assert_array_equal(shortened[1:], scales[1:])
