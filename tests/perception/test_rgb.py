"""Perception from pictures alone: no depth reaches it, what it cannot see it does not say, what it says it covers."""

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends import make_backends, parse_choice
from physagent_jax.perception.measure import perceive
from physagent_jax.perception.reasons import BY_SIZE, TURNED
from physagent_jax.perception.uncertainty import NINETY
from physagent_jax.run.spec import PerceptionChoice, RunSpec
from tests.perception import scenes

DT, FRAMES, SIDE = 0.04, 5, 128
FOOT = -0.5
"""Height of the ground under `scenes.plant` [m]."""


def film(motion, shape=scenes.plant):
    return scenes.film(shape(), motion, scenes.camera((0.0, -3.0, 0.9), SIDE), frames=FRAMES)


def see(clip, depth=None, **facts):
    backends = make_backends(**parse_choice("rgb"))
    return perceive(clip.rgb, depth, clip.camera, frame_dt=DT, backends=backends, **facts)


@pytest.fixture(scope="module")
def pushed():
    return film(scenes.translated((0.4, 0, 0)))


@pytest.fixture(scope="module")
def pushed_seen(pushed):
    return see(pushed, ground=FOOT, length=2.0)


def test_a_depth_channel_changes_nothing(pushed, pushed_seen):
    garbage = np.random.default_rng(0).uniform(0, 9, pushed.rgb.shape[:3]).astype(np.float32)
    for depth in (pushed.depth, garbage):
        seen = see(pushed, depth, ground=FOOT, length=2.0)
        assert seen.report.model_dump_json() == pushed_seen.report.model_dump_json()


def test_a_motion_across_the_sight_is_measured_within_what_is_stated(pushed, pushed_seen):
    report = pushed_seen.report
    true = np.ptp(pushed.particles[0], axis=0).max()
    assert report.object_size == pytest.approx(
        true, rel=0.15
    )  # by the ground, not by the length that is told
    shift = np.asarray(report.centroid[-1]) * report.object_size
    assert np.linalg.norm(shift[[0, 2]] - (0.4, 0)) < report.uncertainty.displacement * report.object_size
    assert report.rotation_degrees[-1] < report.uncertainty.rotation
    assert np.abs(np.diag(report.stretch[-1]) - 1)[[0, 2]].max() < report.uncertainty.stretch
    assert any("not measured" in note for note in report.quality.notes)
    assert not report.windows[0].stretch_view_axis_observable


def test_the_depth_of_pixels_is_within_what_is_stated(pushed, pushed_seen):
    depth = pushed_seen.depth
    known = np.isfinite(depth.z) & np.isfinite(pushed.depth)
    off = np.abs(depth.z - pushed.depth)[known]
    assert known.sum() > 1000 and np.mean(off <= NINETY * depth.uncertainty[known]) > 0.95


def test_ground_or_length_tell_the_scale_and_nothing_else_does(pushed):
    by_length, unknown = see(pushed, length=1.0).report, see(pushed).report
    assert by_length.object_size == pytest.approx(1, abs=0.1)
    assert any("no known scale" in note for note in unknown.quality.notes)
    np.testing.assert_allclose(by_length.centroid, unknown.centroid, atol=1e-6)


def test_an_approach_is_observed_on_the_ground_and_not_in_the_air():
    clip = film(scenes.translated((0, 0.5, 0)))
    grounded, floating = see(clip, ground=FOOT).report, see(clip).report
    whole = grounded.windows[0]
    assert whole.displacement_view_axis_observable
    size = grounded.object_size
    assert whole.displacement[1] * size == pytest.approx(0.5, abs=grounded.uncertainty.along * size + 0.02)
    whole = floating.windows[0]
    assert not whole.displacement_view_axis_observable and BY_SIZE in whole.unobservable.values()
    assert "translates 0.1" in floating.text  # upwards in the picture, as the camera looks down
    assert BY_SIZE in floating.text
    along = 0.5 * clip.camera.forward[1] / np.ptp(clip.particles[0], axis=0).max()
    assert floating.uncertainty.along > along


def test_a_turn_out_of_the_picture_plane_is_not_observable_and_one_in_it_is():
    turned = see(film(scenes.rotated((0, 0, 1), 40), scenes.blob)).report
    assert turned.rotation[-1] is None and turned.stretch[-1] is None and turned.centroid[-1] is not None
    assert turned.windows[0].unobservable["rotation_degrees"] == TURNED and TURNED in turned.text
    rolled = see(film(scenes.rotated((0, 1, 0), 40), scenes.blob)).report
    assert rolled.rotation_degrees[-1] == pytest.approx(40, abs=3)


def test_nothing_is_said_of_an_object_before_a_busy_background(pushed):
    noise = np.random.default_rng(0).integers(0, 255, pushed.rgb.shape[1:], np.uint8)
    rgb = np.where(np.isfinite(pushed.depth)[..., None], pushed.rgb, noise)
    report = perceive(
        rgb, None, pushed.camera, frame_dt=DT, backends=make_backends(**parse_choice("rgb"))
    ).report
    assert set(report.centroid) == {None} and "too busy" in " ".join(report.quality.notes)


def test_a_choice_is_a_preset_and_what_differs_from_it():
    spec = RunSpec(object={"path": "a.ply"}, prompt="push it", perception="rgb, segmenter=rgbd")
    names = {role: getattr(spec.perception, role).name for role in ("segmenter", "depth", "tracker")}
    assert names == {"segmenter": "rgbd", "depth": "ground_contact", "tracker": "flow"}
    assert PerceptionChoice.model_validate("rgbd") == PerceptionChoice()
    for text in ("rgb+", "rgb,eyes=flow", "rgb,depth=guess"):
        with pytest.raises(ValueError, match="is not known"):
            PerceptionChoice.model_validate(text)
    with pytest.raises(UserError, match="Known: rgbd, rgb"):
        parse_choice("lidar")
