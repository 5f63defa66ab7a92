"""The seams of perception: models with the calls of SAM 2, CoTracker and Depth Anything, and the choice by name."""

import dataclasses

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.motion import compare, measure_true_motion
from physagent_jax.perception.backends import make_backends
from physagent_jax.perception.backends.colour import ColorSegmenter
from physagent_jax.perception.backends.flow import FlowTracker
from physagent_jax.perception.measure import perceive
from physagent_jax.perception.prompt import find_prompt
from physagent_jax.perception.protocols import SegmentPrompt
from tests.perception import scenes
from tests.perception.model_fakes import FakeSam2, Sam2Segmenter, model_backends

DT = 0.04
OFFSET = np.array((0.4, 0.3, -0.15))
FRAMES = 10


def forth(x, s):
    return x + s * OFFSET


def back(x, s):
    return x - s * OFFSET


@pytest.fixture(scope="module")
def clip():
    return scenes.film(scenes.blob(), forth, frames=FRAMES)


def test_models_measure_a_motion_from_colour_pictures_alone(clip):
    backends = model_backends(clip, forth, back)
    seen = perceive(clip.rgb, None, clip.camera, frame_dt=DT, backends=backends)
    errors = compare(seen.report, measure_true_motion(clip.particles))
    assert errors["centroid_error_max"] < 0.03 and errors["size_ratio"] == pytest.approx(1, abs=0.02)
    assert seen.report.object_size == pytest.approx(np.ptp(clip.particles[0], axis=0).max(), rel=0.03)
    assert backends.tracker.model.encodings == 1
    (prompt,) = backends.segmenter.prompts  # made from the pictures, as nobody gave one
    assert prompt.frame == 0 and prompt.box.shape == (4,) and prompt.points.shape == (1, 2)
    assert not any("renderer" in note for note in seen.report.quality.notes)
    assert any(note.startswith("Nobody marked the object") for note in seen.report.quality.notes)


def test_one_encoding_serves_all_links_of_the_chain():
    def turn(x, s):
        return scenes.rotated((0, 0, 1), 60)(x, s)

    def unturn(x, s):
        return scenes.rotated((0, 0, 1), -60)(x, s)

    clip = scenes.film(scenes.blob(), turn, frames=FRAMES)
    backends = model_backends(clip, turn, unturn)
    report = perceive(clip.rgb, None, clip.camera, frame_dt=DT, backends=backends).report
    assert report.rotation_degrees[-1] == pytest.approx(60, abs=10)
    assert backends.tracker.model.encodings == 1


def test_a_depth_without_scale_tells_the_same_motion_in_body_lengths(clip):
    metric, relative = (
        perceive(
            clip.rgb, None, clip.camera, frame_dt=DT, backends=model_backends(clip, forth, back, unit=unit)
        ).report
        for unit in (None, 7.0)
    )
    np.testing.assert_allclose(relative.centroid, metric.centroid, atol=2e-3)
    assert relative.object_size == pytest.approx(metric.object_size / 7, rel=1e-3)
    assert any("no known scale" in note for note in relative.quality.notes)
    assert not any("no known scale" in note for note in metric.quality.notes)


def test_depth_that_is_unsure_of_itself_is_not_used(clip):
    backends = model_backends(
        clip, forth, back, blurred=118
    )  # the upper edge of the object, seen too far away
    methods = {"estimate": _estimate_without_uncertainty}
    sure = type("Sure", (type(backends.depth),), methods)(clip, blurred=118)
    plain = dataclasses.replace(backends, depth=sure)
    truth = measure_true_motion(clip.particles)
    kept, fooled = (
        compare(perceive(clip.rgb, None, clip.camera, frame_dt=DT, backends=each).report, truth)
        for each in (backends, plain)
    )
    assert kept["centroid_error_max"] < 0.5 * fooled["centroid_error_max"]


def _estimate_without_uncertainty(self, frames, camera, measured):
    return dataclasses.replace(super(type(self), self).estimate(frames, camera, measured), uncertainty=None)


@pytest.mark.parametrize("kind", ["points", "box", "both", "mask", "later"])
def test_a_segmenter_is_told_by_points_a_box_or_a_mask(clip, kind):
    truth = np.isfinite(clip.depth)
    frame = 4 if kind == "later" else 0
    y, x = np.nonzero(truth[frame])
    inside = find_prompt(clip.rgb[frame:], clip.depth[frame:]).points
    points = np.concatenate([inside, [[3.5, 3.5]]])
    box = np.array([x.min(), y.min(), x.max() + 1, y.max() + 1], float)
    prompt = {
        "points": SegmentPrompt(points=points, labels=np.array([True, False])),
        "box": SegmentPrompt(box=box),
        "both": SegmentPrompt(points=inside, box=box),
        "mask": SegmentPrompt(mask=truth[frame]),
        "later": SegmentPrompt(frame=frame, points=inside),
    }[kind]
    backends = dataclasses.replace(make_backends(), segmenter=Sam2Segmenter(FakeSam2(truth)))
    seen = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT, backends=backends, prompt=prompt)
    np.testing.assert_array_equal(seen.masks, truth)
    assert backends.segmenter.prompts == [prompt]
    assert backends.segmenter.predictor.directions == ([False, True] if kind == "later" else [False])


def test_a_prompt_says_one_thing():
    for wrong in ({}, {"mask": np.ones((4, 4), bool), "box": np.zeros(4)}):
        with pytest.raises(UserError, match="a prompt is points"):
            SegmentPrompt(**wrong)
    with pytest.raises(UserError, match="one per point"):
        SegmentPrompt(box=np.zeros(4), labels=np.array([True]))


def test_segmentation_by_colour_refuses_a_prompt(clip):
    with pytest.raises(UserError, match="takes no prompt"):
        ColorSegmenter().segment(clip.rgb, SegmentPrompt(box=np.zeros(4)))


def test_without_a_depth_channel_the_sensor_has_nothing_to_say(clip):
    with pytest.raises(UserError, match="no depth channel"):
        perceive(clip.rgb, None, clip.camera, frame_dt=DT)


def test_an_empty_picture_needs_no_prompt(clip):
    rgb = np.full_like(clip.rgb, 200)
    nothing = np.full_like(clip.depth, np.nan)
    backends = model_backends(dataclasses.replace(clip, rgb=rgb, depth=nothing), forth, back)
    report = perceive(rgb, None, clip.camera, frame_dt=DT, backends=backends).report
    assert "No object is visible" in report.text and backends.segmenter.prompts == []


def test_points_are_followed_from_the_frames_of_their_queries(clip):
    masks = np.isfinite(clip.depth)
    tracker = FlowTracker()
    first, later = (np.insert(find_points(clip, t), 0, t, axis=1) for t in (0, 4))
    both = tracker.encode(clip.rgb, masks).track(np.concatenate([first, later]), until=8)
    alone = tracker.encode(clip.rgb[4:8], masks[4:8]).track(later - (4, 0, 0))
    assert not both.visible[:4, len(first) :].any() and not both.visible[8:].any()
    np.testing.assert_array_equal(both.xy[4:8, len(first) :], alone.xy)
    np.testing.assert_array_equal(both.confidence > 0, both.visible)


def find_points(clip, frame):
    ((x, y),) = find_prompt(clip.rgb[frame:], clip.depth[frame:]).points
    return np.stack(np.meshgrid(x + np.arange(-20.0, 21, 10), y + np.arange(-20.0, 21, 10)), -1).reshape(
        -1, 2
    )


def test_backends_are_chosen_by_name():
    assert make_backends().names == {
        "segmenter": "RgbdSegmenter",
        "depth": "DepthSensor",
        "tracker": "FlowTracker",
    }
    with pytest.raises(UserError, match="perception.tracker"):
        make_backends(tracker="flwo")
