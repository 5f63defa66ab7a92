"""Pictures that show nothing, a pixel, or nothing but the object: "not observable", never an error, never a number."""

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from physagent_jax.core.errors import UserError
from physagent_jax.perception import extents, fit, follow, lift, timing, uncertainty
from physagent_jax.perception.backends import make_backends
from physagent_jax.perception.backends.colour import ColorSegmenter, find_border_colour, remove_specks
from physagent_jax.perception.backends.depth_sensor import DepthSensor
from physagent_jax.perception.backends.flow import FlowTracker
from physagent_jax.perception.backends.ground_contact import GroundContact
from physagent_jax.perception.backends.rgbd import RgbdSegmenter
from physagent_jax.perception.background import find_background
from physagent_jax.perception.ends import Ends
from physagent_jax.perception.measure import perceive
from physagent_jax.perception.overlay import draw_overlay
from physagent_jax.perception.pieces import count_pieces
from physagent_jax.perception.prompt import find_prompt
from physagent_jax.perception.protocols import (
    Cues,
    Depth,
    DepthEstimator,
    Masks,
    Segmenter,
    SegmentPrompt,
    Setting,
    Tracker,
    Tracks,
)
from physagent_jax.perception.schema import MotionReport
from physagent_jax.render.camera import look_at

DT = 0.04
SIZES = [(1, 1), (1, 16), (16, 1), (2, 2), (5, 7), (24, 20)]
PICTURE = (24, 20)


def view(height: int, width: int):
    return look_at((0, -3, 0.5), (0, 0, 0), (0, 0, 1), fov_degrees=36, width=width, height=height)


def make_masks(height: int, width: int) -> dict[str, np.ndarray]:
    """Masks with hardly an outline, by what they are."""
    y, x = np.mgrid[:height, :width]
    inside = (y > 0) & (x > 0) & (y < height - 1) & (x < width - 1)
    return {
        "empty": np.zeros((height, width), bool),
        "full": np.ones((height, width), bool),
        "a pixel": (y == height // 2) & (x == width // 2),
        "a corner": (y == 0) & (x == 0),
        "a row": y == height // 2,
        "a column": x == width // 2,
        "the first row": y == 0,
        "half the picture": y <= height // 2,
        "all but the border": inside,
        "every other pixel": (y % 2 == 0) & (x % 2 == 0),
        "a diagonal": y == x,
        "a block": (abs(y - height // 2) < height / 4) & (abs(x - width // 2) < width / 4),
        "eight pixels": (abs(y - height // 2 + 0.5) < 1) & (abs(x - width // 2 + 0.5) < 2),
    }


def make_depths(frames: int, height: int, width: int) -> dict[str, np.ndarray]:
    """Depth channels that tell little, by what they are; shape (frames, height, width)."""
    shape, rng = (frames, height, width), np.random.default_rng(0)
    y, x = np.mgrid[:height, :width]
    bulge = 1 - ((y - height / 2) ** 2 + (x - width / 2) ** 2) / (height * width / 4)
    ball = np.broadcast_to(3 - 0.3 * np.sqrt(np.maximum(bulge, 0)), shape).copy()
    known = np.full(shape, 3.0)
    alone = np.full(shape, np.nan)
    alone[:, height // 2, width // 2] = 3.0
    first, later, leap, half = known.copy(), known.copy(), ball.copy(), ball.copy()
    first[0], later[1:] = np.nan, np.nan
    leap[1:] *= 1e5
    half[:, : height // 2] *= 1e5
    return {
        "constant": known,
        "a ball": ball,
        "noise": rng.uniform(1, 5, shape),
        "none": np.full(shape, np.nan),
        "zero": np.zeros(shape),
        "sparse": np.where(rng.uniform(size=shape) < 0.7, np.nan, 3.0),
        "a pixel": alone,
        "none at first": first,
        "none later": later,
        "far later": leap,
        "half far": half,
        "a far plane": np.full(shape, 1e10),
        "huge": np.full(shape, 1e300),
        "tiny": np.full(shape, 1e-30),
        "infinite": np.full(shape, np.inf),
        "behind": np.full(shape, -3.0),
    }


@dataclasses.dataclass(frozen=True)
class Given(Segmenter):
    """Masks that are known beforehand."""

    masks: np.ndarray

    def segment(self, frames, prompt, depth=None):
        return Masks(self.masks)


def check_report(report: MotionReport, masks: np.ndarray) -> None:
    """The report is JSON of finite numbers, says why something is missing, and has no place without an object."""
    text = report.model_dump_json()
    assert MotionReport.model_validate_json(text) == report
    json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in the report"))
    assert not {"nan", "inf", "None"} & set(report.text.replace(",", " ").replace("(", " ").split())
    for window in report.windows:
        for field in ("displacement", "rotation_degrees", "stretch", "volume_ratio"):
            assert (getattr(window, field) is None) == (field in window.unobservable), field
    for t, mask in enumerate(masks):
        if not mask.any():
            assert report.centroid[t] is report.rotation[t] is report.stretch[t] is report.box[t] is None


def see(rgb, measured, **roles) -> MotionReport:
    """The report of a clip through the default backends, but for those given."""
    backends = dataclasses.replace(make_backends(), **roles)
    seen = perceive(rgb, measured, view(*rgb.shape[1:3]), frame_dt=DT, backends=backends)
    check_report(seen.report, seen.masks)
    draw_overlay(rgb, seen.masks, seen.tracks, seen.visible)
    return seen.report


def colour_pictures(frames: int, height: int, width: int) -> np.ndarray:
    picture = np.random.default_rng(1).integers(0, 255, (height, width, 3), np.uint8)
    return np.broadcast_to(picture, (frames, height, width, 3)).copy()


@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[1]}x{size[0]}")
@pytest.mark.parametrize("frames", [1, 4])
def test_masks_that_show_nothing_are_measured_as_not_observable(size, frames):
    for mask in make_masks(*size).values():
        for name, depth in make_depths(frames, *size).items():
            masks = np.broadcast_to(mask, (frames, *size)).copy()
            report = see(colour_pictures(frames, *size), depth, segmenter=Given(masks))
            if (
                mask.sum() < 8
                or mask.all()
                or name in ("none", "zero", "none at first", "infinite", "behind")
            ):
                assert report.object_size == 0 and set(report.centroid) == {None}
                assert "not observable" in report.text and report.onset_frame is None


@pytest.mark.parametrize("later", ["empty", "full", "a pixel", "a row", "half the picture", "a diagonal"])
def test_what_cannot_be_observed_later_is_not_observable_from_there_on(later):
    masks = make_masks(*PICTURE)
    for depth in make_depths(6, *PICTURE).values():
        for pattern in ([0], [0, 2, 4], [1, 2, 3, 4, 5]):
            shown = np.stack([masks["a block"] if t in pattern else masks[later] for t in range(6)])
            see(colour_pictures(6, *PICTURE), depth, segmenter=Given(shown))


@pytest.mark.parametrize("segmenter", [RgbdSegmenter(), ColorSegmenter()], ids=["rgbd", "colour"])
@pytest.mark.parametrize("colour", [0, 77, 255, "noise", "ramp"])
def test_pictures_without_an_object(segmenter, colour):
    for size in SIZES:
        pictures = {
            "noise": colour_pictures(2, *size),
            "ramp": np.broadcast_to(np.linspace(0, 255, size[1])[:, None], (2, *size, 3)).astype(np.uint8),
        }
        rgb = pictures[colour] if isinstance(colour, str) else np.full((2, *size, 3), colour, np.uint8)
        for depth in make_depths(2, *size).values():
            see(rgb, depth, segmenter=segmenter)


def test_an_object_that_fills_the_picture_is_told():
    full = Given(np.ones((3, *PICTURE), bool))
    report = see(colour_pictures(3, *PICTURE), np.full((3, *PICTURE), 3.0), segmenter=full)
    assert report.quality.mask_fraction == 1 and report.quality.leaves_frame == 0
    assert (
        report.text == "In the initial frame, the object fills the picture, so its motion is not observable."
    )
    assert set(report.windows[0].unobservable.values()) == {"the object fills the picture in frame 0"}


def test_frames_without_depth_are_told():
    masks = make_masks(*PICTURE)
    clip = np.broadcast_to(masks["a block"], (6, *PICTURE)).copy()
    depth = make_depths(6, *PICTURE)["none later"]
    report = see(colour_pictures(6, *PICTURE), depth, segmenter=Given(clip))
    assert report.centroid[0] is not None and set(report.centroid[1:]) == {None}
    assert set(report.windows[0].unobservable.values()) == {"the object's depth is not known"}
    assert "Nothing is known in 5 frames (first: 1), because the object's depth is not known." in report.text
    assert "Whether the motion is periodic is not observable." in report.text


@dataclasses.dataclass(frozen=True)
class WildTracker(Tracker):
    """Answers that no tracker should give, by what they are."""

    kind: str

    def encode(self, frames, masks):
        return _WildClip(self.kind, len(frames))


@dataclasses.dataclass(frozen=True)
class _WildClip:
    kind: str
    frames: int

    def track(self, queries, until=None):
        xy = np.repeat(queries[None, :, 1:], self.frames, axis=0).astype(float)
        visible, sure = np.ones(xy.shape[:2], bool), np.ones(xy.shape[:2])
        match self.kind:
            case "nothing":
                visible[:] = False
            case "nan":
                xy[:] = np.nan
            case "inf":
                xy[1:] = np.inf
            case "far off":
                xy[1:] += 1e12
            case "one place":
                xy[1:] = xy[:1, :1]
            case "one line":
                xy[1:, :, 1] = xy[:1, :1, 1]
            case "mirrored":
                xy[1:, :, 0] = 2 * xy[1:, :, 0].mean(1, keepdims=True) - xy[1:, :, 0]
            case "noise":
                xy[1:] += np.random.default_rng(0).normal(0, 10, xy[1:].shape)
            case _:
                sure[:] = float(self.kind)
        return Tracks(xy, visible, sure)


@pytest.mark.parametrize(
    "kind",
    [
        "nothing",
        "nan",
        "inf",
        "far off",
        "one place",
        "one line",
        "mirrored",
        "noise",
        "0",
        "1e-300",
        "-1",
        "1e300",
    ],
)
def test_tracks_that_cannot_be_right(kind):
    masks = make_masks(*PICTURE)
    clip = np.broadcast_to(masks["all but the border"], (4, *PICTURE)).copy()
    for depth in make_depths(4, *PICTURE).values():
        report = see(colour_pictures(4, *PICTURE), depth, segmenter=Given(clip), tracker=WildTracker(kind))
        if kind in ("nothing", "nan", "inf", "far off", "0"):
            assert set(report.rotation[1:]) == {None}, "nothing was followed"


@dataclasses.dataclass(frozen=True)
class GivenDepth(DepthEstimator):
    """Depth that is known beforehand, as uncertain as told."""

    z: np.ndarray
    uncertainty: np.ndarray | None = None

    def estimate(self, frames, camera, measured):
        return Depth(self.z, scale_known=False, uncertainty=self.uncertainty)


def test_depth_of_a_model_that_knows_nothing():
    block = np.broadcast_to(make_masks(*PICTURE)["a block"], (4, *PICTURE)).copy()
    rgb = colour_pictures(4, *PICTURE)
    for z in make_depths(4, *PICTURE).values():
        for spread in (0.0, 1e9, np.nan, np.inf):
            depth = GivenDepth(z, np.full(z.shape, spread))
            report = see(rgb, None, depth=depth, segmenter=Given(block))
            assert spread == 0 or set(report.centroid) == {None}, "depth this uncertain is not used"


def test_answers_of_another_shape_are_refused():
    rgb, depth = colour_pictures(2, *PICTURE), np.full((2, *PICTURE), 3.0)
    with pytest.raises(UserError, match="segmenter must give one value per pixel"):
        see(rgb, depth, segmenter=Given(np.ones((1, *PICTURE), bool)))
    with pytest.raises(UserError, match="depth estimator must give one value per pixel"):
        see(rgb, None, depth=GivenDepth(depth[:, :-1]))


@dataclasses.dataclass(frozen=True)
class Prompted(Segmenter):
    """The object around the prompt, if the prompt lies on one."""

    needs_prompt = True
    truth: np.ndarray

    def segment(self, frames, prompt):
        masks = np.zeros(frames.shape[:3], bool)
        for x, y in [] if prompt.points is None else np.asarray(prompt.points, int):
            if self.truth[min(y, self.truth.shape[0] - 1), min(x, self.truth.shape[1] - 1)]:
                masks[:] = self.truth
        return Masks(masks)


def test_a_prompt_beside_the_object_leaves_nothing_to_observe():
    block = make_masks(*PICTURE)["a block"]
    rgb, depth = colour_pictures(2, *PICTURE), np.full((2, *PICTURE), 3.0)
    backends = dataclasses.replace(make_backends(), segmenter=Prompted(block))

    def report(prompt):
        seen = perceive(rgb, depth, view(*PICTURE), frame_dt=DT, backends=backends, prompt=prompt)
        check_report(seen.report, seen.masks)
        return seen.report

    assert report(SegmentPrompt(points=np.array([[10.0, 12.0]]))).object_size > 0
    for prompt in (
        SegmentPrompt(points=np.array([[0.0, 0.0]])),
        SegmentPrompt(points=np.array([[20.0, 24.0]])),
        SegmentPrompt(box=np.array([0.0, 0.0, 2.0, 2.0])),
        None,  # nothing stands out in such pictures
    ):
        assert set(report(prompt).centroid) == {None}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (dict(frame=2, box=[1, 1, 5, 5]), "frame is not in the clip"),
        (dict(points=np.zeros((0, 2))), "shape"),
        (dict(points=np.zeros(2)), "shape"),
        (dict(points=[[np.nan, 3.0]]), "must lie in the picture of 20 x 24"),
        (dict(points=[[3.0, 24.5]]), "must lie in the picture of 20 x 24"),
        (dict(points=[[3.0, 4.0]], labels=[False]), "no point of the prompt is on the object"),
        (dict(box=[5, 5, 5, 9]), "x0 < x1"),
        (dict(box=[np.nan, 5, 8, 9]), "x0 < x1"),
        (dict(box=[20, 5, 30, 9]), "reach into the picture"),
        (dict(box=[1, 2, 3]), "x0 y0 x1 y1"),
        (dict(mask=np.zeros(PICTURE, bool)), "shows no object"),
        (dict(mask=np.ones((3, 3), bool)), "shape"),
    ],
    ids=lambda value: value if isinstance(value, str) else None,
)
def test_a_prompt_that_shows_no_object_is_refused(values, words):
    arrays = {key: value if key == "frame" else np.asarray(value) for key, value in values.items()}
    backends = dataclasses.replace(make_backends(), segmenter=Prompted(np.ones(PICTURE, bool)))
    with pytest.raises(UserError, match=words):
        perceive(
            colour_pictures(2, *PICTURE),
            np.full((2, *PICTURE), 3.0),
            view(*PICTURE),
            frame_dt=DT,
            backends=backends,
            prompt=SegmentPrompt(**arrays),
        )


def is_number_or_nan(*values) -> bool:
    return all(np.issubdtype(np.asarray(v).dtype, np.floating) and not np.isinf(v).any() for v in values)


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (5, 7), (24, 20)], ids=lambda size: f"{size[1]}x{size[0]}")
def test_every_stage_alone(size):
    """Each function on every mask with every depth: numbers of the stated shape, nan where there is nothing to tell."""
    rgb = colour_pictures(2, *size)
    for mask in make_masks(*size).values():
        for raw in make_depths(2, *size).values():
            check_stages(rgb, mask, raw, view(*size))


def check_stages(rgb: np.ndarray, mask: np.ndarray, raw: np.ndarray, camera) -> None:
    masks = np.stack([mask, mask])
    z = lift.keep_possible_depth(raw)
    assert is_number_or_nan(z) and np.array_equal(
        DepthSensor().estimate(rgb, camera, raw).z, z, equal_nan=True
    )
    z = lift.fill_dropped(lift.keep_comparable_depth(z, mask), masks)
    trusted, noise = lift.keep_trusted_depth(z[0], mask)
    known = bool(np.isfinite(trusted).any())
    assert is_number_or_nan(trusted) and noise >= 0
    box = lift.measure_box(z[0], mask, trusted, camera)
    center, rim = lift.find_center(trusted, mask, camera), lift.measure_rim_depth(trusted, mask)
    assert box.shape == (2, 3) and center.shape == (3,) and is_number_or_nan(box, rim)
    assert math.isfinite(rim) == known, "a rim without any depth"
    assert known or np.isnan(box).all() and np.isnan(center).all()
    outline, surface = lift.unproject_mask(trusted, mask, camera), lift.unproject_surface(trusted, camera)
    assert len(outline) == (mask.sum() if known else 0) and len(surface) == np.isfinite(trusted).sum()
    assert np.isfinite(lift.find_middle(surface)).all() == known
    seeds, strength = follow.place_seeds(rgb[0], trusted)
    assert len(seeds) == len(strength) and np.isfinite(lift.measure_facing(trusted, seeds, camera)).all()
    lengths = extents.measure_lengths([outline, outline], np.eye(3))
    assert np.isfinite(lengths).all() == known
    extents.describe_extents(lengths, np.eye(3), [np.zeros(3), None], 0.01, camera.forward)
    if known:
        Ends.split(surface, 2)
    clip = FlowTracker().encode(rgb, masks)
    path = follow.follow(rgb, np.stack([trusted, trusted]), camera, clip)
    assert known or path.poses == [None, None]
    cues = Cues(masks, clip, Setting(np.array([0.0, 0.0, 1.0]), ground=-1.0))
    guessed = GroundContact().estimate(rgb, camera, None, cues)
    assert guessed.z.shape == masks.shape and is_number_or_nan(guessed.z)
    for queries in (np.zeros((0, 3)), np.array([[0, 0.5, 0.5]]), np.array([[1, -9.0, 99.0]])):
        assert clip.track(queries).xy.shape == (2, len(queries), 2)
    assert (count_pieces(masks)[0] is None) == (not mask.any())
    assert remove_specks(mask).sum() <= mask.sum() and np.isfinite(find_border_colour(rgb)[0]).all()
    background = find_background(1 / z)
    assert np.isfinite(background.inverse).all() and math.isfinite(background.tolerance)
    prompt = find_prompt(rgb, z)
    if prompt is not None:
        prompt.check_fit(rgb.shape[:3])


def test_stages_without_any_series():
    nothing = np.full((4, 3), np.nan)
    assert (
        timing.find_onset(nothing[:, 0], 0.01) is None and timing.find_settling(nothing[:, 0], 0.01) is None
    )
    assert timing.find_oscillation(nothing, DT, 0.01) is None
    assert timing.find_onset(np.zeros(1), 0.01) is None and timing.find_settling(np.zeros(1), 0.01) is None
    hard = uncertainty.Difficulty(pixel=0.1, noise=0.0, residual=0.0, turn=0.0, links=-1, travel=0.0)
    told = uncertainty.estimate_uncertainty(hard, [None, None], None, DT)
    assert told.rotation is told.stretch is told.axis is told.frequency is None
    tracks = np.full((2, 3, 2), 1e30)
    drawn = draw_overlay(
        np.zeros((2, 4, 4, 3), np.uint8), np.zeros((2, 4, 4), bool), tracks, np.ones((2, 3), bool)
    )
    assert drawn.shape == (2, 4, 4, 3)


def test_points_that_coincide_tell_no_turn_and_no_stretch():
    a, b = np.ones((50, 3)), np.full((50, 3), 4.0)
    found = fit.fit_affine(a, b)
    assert found.rotation == pytest.approx(np.eye(3)) and found.matrix == pytest.approx(np.eye(3))
    assert found(a) == pytest.approx(b)


def test_a_far_speck_of_depth_costs_no_memory():
    """Depth in kilometres at a few pixels of the object: the raster of its outline stays as large as the picture."""
    size = (160, 160)
    mask = make_masks(*size)["all but the border"]
    depth = np.where(mask, 3.0, np.nan)
    depth[20:26, 20:26] = 1e8
    center = lift.find_center(depth, mask, view(*size))
    assert np.isfinite(center).all()


masks_of = hnp.arrays(bool, st.tuples(st.integers(1, 4), st.integers(1, 9), st.integers(1, 9)))
distances = st.one_of(
    st.sampled_from([0.0, np.nan, np.inf, 3.0]), st.floats(-1.0, 10.0, width=32), st.floats(width=32)
)


@given(masks=masks_of, data=st.data())
@settings(max_examples=60, deadline=None)
def test_whatever_is_seen_gives_a_report(masks, data):
    depth = data.draw(hnp.arrays(np.float32, masks.shape, elements=distances, fill=distances))
    rgb = data.draw(hnp.arrays(np.uint8, (*masks.shape, 3), fill=st.integers(0, 255)))
    kind = data.draw(st.sampled_from(["flow", "nothing", "noise", "mirrored", "one line"]))
    tracker = FlowTracker() if kind == "flow" else WildTracker(kind)
    see(rgb, depth, segmenter=Given(masks), tracker=tracker)
    see(rgb, depth)


@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_whatever_a_tracker_says_gives_a_report(data):
    """Points anywhere, on an object that is large enough to be followed."""
    count, size = 3, (18, 18)
    block = np.broadcast_to(make_masks(*size)["all but the border"], (count, *size)).copy()
    spread = data.draw(st.sampled_from([0.1, 1.0, 5.0, 1e3, 1e8]))
    seed = data.draw(st.integers(0, 2**32 - 1))
    lost = data.draw(st.floats(0, 1))

    class Random(Tracker):
        def encode(self, frames, masks):
            return self

        def track(self, queries, until=None):
            rng = np.random.default_rng(seed)
            xy = np.repeat(queries[None, :, 1:], count, axis=0) + rng.normal(
                0, spread, (count, len(queries), 2)
            )
            return Tracks(xy, rng.uniform(size=xy.shape[:2]) >= lost, rng.uniform(size=xy.shape[:2]))

    depth = np.random.default_rng(seed).uniform(2.5, 3.5, (count, *size))
    see(colour_pictures(count, *size), depth, segmenter=Given(block), tracker=Random())
