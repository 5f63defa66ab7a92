"""Perception against exactly known motions, drawn by an independent renderer."""

import functools

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.motion import compare, measure_true_motion
from physagent_jax.perception.measure import perceive
from tests.perception import scenes
from tests.perception.scenes import bent, blob, film, plant, rotated, stretched, translated

DT = 0.04


def two_periods(s):
    return np.sin(4 * np.pi * s)


MOTIONS = {
    "still": (blob, translated((0, 0, 0))),
    "move": (blob, translated((0.35, 0.5, -0.2))),
    "in_plane": (blob, rotated((0, 1, 0), 90)),
    "out_of_plane": (blob, rotated((0, 0, 1), 60)),
    "tip": (blob, rotated((1, 0, 0), -60)),
    "stretch": (blob, stretched((1.6, 0.8, 0.8))),
    "squash": (blob, stretched((1.3, 1.3, 0.5))),
    "sway": (blob, translated((0.4, 0, 0), two_periods)),
    "plant_sway": (plant, bent(40, two_periods)),
    "plant_bend": (plant, bent(50)),
    "stop": (blob, translated((0.3, 0, 0), lambda s: min(max(2 * s - 0.4, 0), 1))),
    "leave": (blob, translated((-2.0, 0, 0))),
}


@functools.cache
def seen(name: str):
    shape, motion = MOTIONS[name]
    clip = film(shape(), motion)
    result = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT, windows=((3, 9),))
    truth = measure_true_motion(clip.particles)
    return result, truth, compare(result.report, truth)


@pytest.mark.parametrize(
    "name", ["move", "in_plane", "stretch", "squash", "sway", "plant_bend", "plant_sway", "stop"]
)
def test_centroid_within_3_percent_of_a_body_length(name):
    _, _, errors = seen(name)
    # A bent plant is not affine: its centroid is right in sign and to a fifth of its displacement of 0.17.
    assert errors["centroid_error_max"] < (0.04 if name == "plant_bend" else 0.03)
    assert errors["size_ratio"] == pytest.approx(1, abs=0.02)


@pytest.mark.parametrize(
    ("name", "tolerance"), [("move", 2), ("in_plane", 2), ("out_of_plane", 10), ("tip", 10)]
)
def test_rotation(name, tolerance):
    result, _, errors = seen(name)
    assert errors["rotation_error_max"] < tolerance
    axis = {"in_plane": (0, 1, 0), "out_of_plane": (0, 0, 1), "tip": (-1, 0, 0)}.get(name)
    if axis:
        assert np.dot(result.report.windows[0].rotation_axis, axis) > 0.99


@pytest.mark.parametrize("name", ["out_of_plane", "tip"])
def test_turning_on_the_spot_is_no_translation(name):
    _, _, errors = seen(name)
    assert (
        errors["centroid_error_max"] < 0.03
    )  # the hidden half's depth is a guess that the turn mends: 0.014 measured


@pytest.mark.parametrize(("name", "factors"), [("stretch", (1.6, 0.8, 0.8)), ("squash", (1.3, 1.3, 0.5))])
def test_stretch_within_8_percent(name, factors):
    window = seen(name)[0].report.windows[0]
    assert window.stretch_view_axis_observable
    assert np.diag(window.stretch) == pytest.approx(factors, rel=0.08)
    assert window.volume_ratio == pytest.approx(np.prod(factors), rel=0.08)


@pytest.mark.parametrize(
    ("name", "factors"), [("stretch", (1.6, 0.8)), ("squash", (1.3, 0.5)), ("move", (1, 1))]
)
def test_the_outline_tells_stretch_across_the_view_too(name, factors):
    extents = seen(name)[0].report.extents
    assert [e.direction for e in extents] == [(1, 0, 0), (0, 0, 1)]
    for extent, factor in zip(extents, factors):
        assert abs(extent.ratio[-1] - factor) < extent.half_width[-1] < 0.15


def test_a_turn_makes_the_outline_a_worse_measure_of_stretch():
    report = seen("in_plane")[0].report
    for extent in report.extents:
        assert extent.half_width[0] < 0.05 and extent.half_width[-1] > 0.5
    assert report.uncertainty.stretch < 0.15, "the affine fit knows better, and is not doubted for it"
    leaves = seen("leave")[0].report.extents[0]
    assert leaves.ratio[-1] is None and leaves.half_width[-1] is None


def test_ends_that_are_pressed_together_show_in_the_outline():
    """The middle of the visible side stays as it is, as of a loaf between two plates: few points move."""

    def pressed(x, s):
        return np.concatenate([np.clip(x[:, :1], -0.5 + 0.2 * s, 0.5 - 0.2 * s), x[:, 1:]], 1)

    clip = film(blob(), pressed, frames=8)
    report = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT).report
    across = report.extents[0]
    assert across.ratio[-1] == pytest.approx(0.6, abs=0.05)
    assert report.stretch[-1][0][0] > 0.7, "the points followed miss it"
    assert (
        report.stretch[-1][0][0] - report.uncertainty.stretch
        < across.ratio[-1] + across.half_width[-1] + 1e-4
    )


@pytest.mark.parametrize("name", ["sway", "plant_sway"])
def test_sway(name):
    result, truth, _ = seen(name)
    oscillation = result.report.oscillation
    assert oscillation.reversals == 4
    assert oscillation.frequency_hz == pytest.approx(2 / (23 * DT), rel=0.1)
    assert abs(oscillation.direction[0]) > 0.95
    assert oscillation.direction[0] * truth.centroid[3][0] > 0, "the first swing's direction"
    amplitude = np.ptp(np.array(truth.centroid)[:, 0]) / 2
    assert oscillation.amplitude == pytest.approx(amplitude, rel=0.15)


def test_bending_to_the_left_is_told_so():
    report = seen("plant_bend")[0].report
    assert report.windows[0].displacement[0] < -0.1
    assert "to the left (world -x)" in report.text
    assert "counter-clockwise for the viewer" in report.text


def test_still():
    report = seen("still")[0].report
    assert report.onset_frame is None and report.oscillation is None and report.settle_frame == 0
    assert np.abs(report.centroid).max() < 0.01 and max(report.rotation_degrees) < 0.5
    assert "Nothing moves visibly" in report.text


def test_onset_and_settling():
    report = seen("stop")[0].report
    assert report.onset_frame in (5, 6)  # the motion starts at frame 4.6 and ends at 16.1
    assert report.settle_frame in (15, 16, 17)
    assert f"comes to rest by frame {report.settle_frame}" in report.text


def test_leaving_the_picture_is_said_not_guessed():
    result, truth, errors = seen("leave")
    report = result.report
    assert 3 <= report.quality.leaves_frame <= 8
    assert (
        report.centroid[-1] is None
        and report.volume_ratio[-1] is None
        and report.rotation_degrees[-1] is None
    )
    assert errors["centroid_error_max"] < 0.03, "what is still observed must be right"
    whole = report.windows[0]
    assert whole.displacement is None and "not in the picture" in whole.unobservable["displacement"]
    assert whole.peak_displacement[0] < -0.4
    assert "not observable" in report.text and report.oscillation is None


def test_windows_are_the_clip_its_quarters_and_those_asked_for():
    report = seen("move")[0].report
    assert [(w.first, w.last) for w in report.windows] == [
        (0, 23),
        (0, 6),
        (6, 12),
        (12, 17),
        (17, 23),
        (3, 9),
    ]
    quarters = np.sum([w.displacement for w in report.windows[1:5]], axis=0)
    assert quarters == pytest.approx(report.windows[0].displacement, abs=1e-4)
    assert report.window(3, 9).displacement == pytest.approx(np.array((0.35, 0.5, -0.2)) * 6 / 23, abs=0.01)
    assert report == type(report).model_validate_json(report.model_dump_json())


def test_text_speaks_the_viewers_words():
    text = seen("move")[0].report.text
    assert text.startswith("At frame 23, the centroid translates 0.65 body lengths (0.5")
    assert "away from the camera" in text and "right" in text and "RGB-D" in text


def test_tracks_for_drawing():
    result = seen("out_of_plane")[0]
    frames, points, _ = result.tracks.shape
    assert result.visible.shape == (frames, points) and result.masks.shape == (
        frames,
        scenes.SIZE,
        scenes.SIZE,
    )
    assert result.visible.any(axis=1).all(), "points are re-seeded as others turn away"


def test_empty_first_frame():
    view = scenes.camera()
    rgb = np.full((6, view.height, view.width, 3), 255, np.uint8)
    report = perceive(rgb, np.zeros(rgb.shape[:3], np.float32), view, frame_dt=DT).report
    assert report.centroid == (None,) * 6 and report.onset_frame is None and len(report.windows) == 5
    assert "not in the picture" in report.windows[0].unobservable["displacement"]
    assert "No object is visible" in report.text


def test_single_frame():
    clip = film(blob(), translated((0, 0, 0)), frames=1)
    report = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT).report
    assert report.frame_count == 1 and report.centroid == ((0.0, 0.0, 0.0),)
    assert "one frame" in report.windows[0].unobservable["displacement"]


def test_object_that_vanishes_and_returns():
    clip = film(blob(), translated((0.3, 0, 0)), frames=12)
    clip.rgb[5:7], clip.depth[5:7] = 255, np.nan
    report = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT).report
    assert report.centroid[5] is None and report.rotation_degrees[-1] is None
    assert report.windows[0].displacement == pytest.approx((0.3, 0, 0), abs=0.03)


def test_object_of_the_backgrounds_colour_is_found_by_depth():
    shape = blob()
    shape.colours[:] = 255
    clip = film(shape, translated((0.3, 0, 0.1)), frames=8)
    report = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT).report
    assert any("taken from depth" in note for note in report.quality.notes)
    assert any("little texture" in note for note in report.quality.notes)
    assert report.windows[0].displacement == pytest.approx((0.3, 0, 0.1), abs=0.04)


def test_scattering_grains_have_no_common_rotation():
    rng = np.random.default_rng(0)
    grains, throw = rng.uniform(-0.3, 0.3, (20_000, 3)), rng.normal(0, 0.25, (20_000, 3))
    shape = scenes.Shape(grains, scenes.texture(grains, 3), grains)
    clip = film(shape, lambda x, s: x + s * throw, frames=10)
    report = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT).report
    assert report.rotation_degrees[-1] is None or report.rotation_degrees[-1] < 10
    assert (
        np.linalg.norm(report.windows[0].displacement) < 0.15
    )  # the shell that flies towards the camera is seen


def test_same_pictures_same_report():
    clip = film(plant(), bent(30), frames=6)
    first, second = (perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT) for _ in range(2))
    assert first.report == second.report and np.array_equal(first.tracks, second.tracks)


def test_bad_input_is_refused():
    clip = film(blob(count=2000), translated((0, 0, 0)), frames=2)
    with pytest.raises(UserError, match="outside of the clip"):
        perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT, windows=((0, 9),))
    with pytest.raises(UserError, match="shape"):
        perceive(clip.rgb, clip.depth[:1], clip.camera, frame_dt=DT)
    with pytest.raises(UserError, match="differ in size"):
        perceive(clip.rgb[:, :-2], clip.depth[:, :-2], clip.camera, frame_dt=DT)


def test_rotation_and_stretch_per_frame_end_where_the_whole_clip_does():
    for name in ("in_plane", "squash"):
        report = seen(name)[0].report
        whole = report.windows[0]
        assert np.linalg.norm(report.rotation[-1]) == pytest.approx(whole.rotation_degrees, abs=1e-3)
        assert np.asarray(report.stretch[-1]) == pytest.approx(np.asarray(whole.stretch), abs=1e-4)
        assert np.allclose(report.rotation[0], 0) and np.allclose(report.stretch[0], np.eye(3))
    half = report.stretch[12]  # the motion is even: 12 of 23 frames
    assert np.diag(half) == pytest.approx(1 + (np.array((1.3, 1.3, 0.5)) - 1) * 12 / 23, rel=0.08)


def test_the_box_moves_with_the_object():
    report = seen("move")[0].report
    edges = [np.subtract(b.high, b.low) for b in (report.box[0], report.box[-1])]
    assert max(edges[0]) == pytest.approx(1, abs=0.01) and edges[1] == pytest.approx(edges[0], abs=0.05)
    assert np.subtract(report.box[-1].low, report.box[0].low) == pytest.approx((0.35, 0.5, -0.2), abs=0.05)
    assert seen("leave")[0].report.box[-1] is None


def test_the_head_of_a_bent_plant_moves_and_its_foot_stays():
    result, truth, _ = seen("plant_bend")
    ends = {part.direction: part for part in result.report.parts}
    assert len(ends) == 6
    head, foot = ends[(0.0, 0.0, 1.0)], ends[(0.0, 0.0, -1.0)]
    shape, motion = plant(), bent(50)
    top = shape.surface[shape.surface[:, 2] > 0.2]
    true = (motion(top, 1.0) - top).mean(0) / truth.object_size
    assert head.centroid[-1] == pytest.approx(true, abs=0.06)
    assert np.linalg.norm(foot.centroid[-1]) < 0.5 * np.linalg.norm(head.centroid[-1])
    assert -1 * head.rotation[-1][1] > 20, "it tips to -x, against the right-hand rule about y"


def test_one_body_is_one_piece_and_two_are_two():
    assert set(seen("move")[0].report.pieces) == {1}
    whole = blob()
    side = np.sign(whole.surface[:, :1])

    def parted(x, s):
        return x + s * 0.4 * (np.sign(x[:, :1]) if len(x) != len(side) else side) * (1, 0, 0)

    clip = film(whole, parted, frames=8)
    pieces = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT).report.pieces
    assert pieces[0] == 1 and pieces[-1] == 2


@pytest.mark.parametrize("name", ["still", "move", "in_plane", "out_of_plane", "tip", "sway"])
def test_the_stated_uncertainty_holds_the_error(name):
    result, _, errors = seen(name)
    report = result.report
    assert errors["centroid_error_max"] < report.uncertainty.displacement < 0.2
    assert errors["rotation_error_max"] < report.uncertainty.rotation < 15
