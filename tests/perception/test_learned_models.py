"""SAM 2 and Depth Anything V2 as `transformers` has them, with tiny random weights: what goes in and what comes out."""

import json

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends import DEPTH_ESTIMATORS, SEGMENTERS
from physagent_jax.perception.backends.sam2 import convert_prompt
from physagent_jax.perception.protocols import SegmentPrompt
from physagent_jax.render.camera import look_at
from tests.perception import tiny_models

HEIGHT, WIDTH = 48, 60
CAMERA = look_at((0, -3, 1), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)


def make_frames(count):
    """Noise: equal frames but for a square that walks to the right."""
    frames = np.random.default_rng(0).integers(0, 255, (1, HEIGHT, WIDTH, 3), dtype=np.uint8).repeat(count, 0)
    for t, frame in enumerate(frames):
        frame[10:20, 5 + 6 * t : 15 + 6 * t] = 250
    return frames


@pytest.fixture(scope="module")
def sam2(tmp_path_factory):
    tiny_models.import_torch("torchvision", "transformers")
    folder = tmp_path_factory.mktemp("sam2-tiny")
    tiny_models.make_sam2(folder)
    return folder


@pytest.fixture(scope="module")
def segmenter(sam2):
    return SEGMENTERS.make(("sam2", {"weights": str(sam2), "device": "cpu"}))


@pytest.fixture(scope="module")
def depths(tmp_path_factory):
    tiny_models.import_torch("transformers")
    folders = {kind: tmp_path_factory.mktemp(f"depth-{kind}") for kind in ("metric", "relative")}
    for kind, folder in folders.items():
        tiny_models.make_depth_anything(folder, kind)
    return {kind: str(folder) for kind, folder in folders.items()}


def test_a_prompt_is_told_in_indices_of_pixels():
    prompt = SegmentPrompt(
        points=np.array([[10.5, 20.5], [0.5, 0.5]]),
        labels=np.array([True, False]),
        box=np.array([5, 6, 30, 40]),
    )
    assert convert_prompt(prompt) == {
        "input_points": [[[[10.0, 20.0], [0.0, 0.0]]]],
        "input_labels": [[[1, 0]]],
        "input_boxes": [[[4.5, 5.5, 29.5, 39.5]]],
    }
    assert convert_prompt(SegmentPrompt(points=np.array([[1.5, 2.5]])))["input_labels"] == [[[1]]]


def test_sam2_follows_a_mask_both_ways(segmenter):
    frames, mask = make_frames(4), np.zeros((HEIGHT, WIDTH), bool)
    mask[8:32, 10:40] = True
    found = segmenter.segment(frames, SegmentPrompt(frame=2, mask=mask)).masks
    assert found.shape == frames.shape[:3] and found.dtype == bool
    overlap = (found[2] & mask).sum() / (found[2] | mask).sum()
    assert overlap > 0.9  # the mask of the prompt's own frame is the prompt, through the model's coarser grid
    assert found[[0, 1, 3]].any(axis=(1, 2)).all()  # each other frame was reached, from both sides
    assert segmenter.name.startswith("sam2:sam2-tiny") and segmenter.needs_prompt


def test_sam2_answers_differ_by_what_it_is_told(segmenter):
    frames = make_frames(2)
    box = SegmentPrompt(box=np.array([5.0, 5.0, 30.0, 30.0]))
    both = SegmentPrompt(points=np.array([[50.5, 40.5]]), box=box.box)
    first, again, other = (segmenter.segment(frames, each).masks for each in (box, box, both))
    np.testing.assert_array_equal(first, again)  # nothing of a clip is left over
    assert (first != other).any()


def test_sam2_without_a_prompt_is_refused(segmenter):
    with pytest.raises(UserError, match="must be told where"):
        segmenter.segment(make_frames(1), None)


def test_metric_depth_is_in_metres_and_one_scale_per_clip(depths):
    estimator = DEPTH_ESTIMATORS.make(("depth_anything", {"weights": depths["metric"], "device": "cpu"}))
    frames = make_frames(3)
    raw = np.stack([estimator._look(frame) for frame in frames])
    seen = estimator.estimate(frames, CAMERA, None)
    assert seen.z.shape == frames.shape[:3] and seen.scale_known and 0 < seen.z.min() < seen.z.max() < 20
    np.testing.assert_allclose(seen.z[0], raw[0])
    still = (frames[2] == frames[0]).all(-1)
    still[:25, :40] = False
    assert np.median(seen.z[2][still] / seen.z[0][still]) == pytest.approx(1, abs=1e-4)
    assert "focal length" in seen.notes[0] and estimator.name in seen.notes[0]


def test_relative_depth_is_a_reciprocal_without_scale(depths):
    estimator = DEPTH_ESTIMATORS.make(("depth_anything", {"weights": depths["relative"], "device": "cpu"}))
    frames = make_frames(2)
    raw, seen = estimator._look(frames[0]), estimator.estimate(frames, CAMERA, None)
    assert not seen.scale_known and np.nanmin(seen.z) == pytest.approx(1)
    known = np.isfinite(seen.z[0])
    np.testing.assert_allclose(seen.z[0][known] * raw[known], raw.max(), rtol=1e-4)
    assert "without scale and shift" in seen.notes[0]


def test_another_model_does_not_pass_for_it(depths, sam2, tmp_path):
    with pytest.raises(UserError, match="not of `depth_anything`.*sam2_video"):
        DEPTH_ESTIMATORS.make(("depth_anything", {"weights": str(sam2)}))
    with pytest.raises(UserError, match="not of `sam2`.*depth_anything"):
        SEGMENTERS.make(("sam2", {"weights": depths["metric"]}))


def test_weights_that_are_not_whole_are_refused(depths, tmp_path):
    from safetensors.numpy import load_file, save_file

    for file in ("config.json", "preprocessor_config.json"):
        (tmp_path / file).write_bytes((tmp_path.__class__(depths["metric"]) / file).read_bytes())
    tensors = load_file(f"{depths['metric']}/model.safetensors")
    gone = sorted(tensors)[0]
    save_file(
        {name: array for name, array in tensors.items() if name != gone}, tmp_path / "model.safetensors"
    )
    with pytest.raises(UserError, match=f"lack some of `depth_anything`.*{gone}"):
        DEPTH_ESTIMATORS.make(("depth_anything", {"weights": str(tmp_path)}))


def test_weights_that_are_not_there_are_told_before_anything_heavy_is_imported(tmp_path, monkeypatch):
    monkeypatch.setenv("HF_HUB_CACHE", str(tmp_path))
    with pytest.raises(UserError, match="facebook/sam2.1-hiera-small, looked for in .*hf download"):
        SEGMENTERS.make("sam2")
    with pytest.raises(UserError, match="no model for `depth_anything` in this folder.*config.json"):
        DEPTH_ESTIMATORS.make(("depth_anything", {"weights": str(tmp_path)}))
    with pytest.raises(UserError, match="must be a folder or owner/name"):
        SEGMENTERS.make(("sam2", {"weights": 3}))
    with pytest.raises(UserError, match="`ground_height` must be a number"):
        DEPTH_ESTIMATORS.make(("depth_anything", {"ground_height": "low"}))


def test_a_broken_config_is_one_line(depths, tmp_path):
    (tmp_path / "config.json").write_text(json.dumps({"model_type": "no_such_model"}))
    with pytest.raises(UserError, match="cannot be loaded"):
        DEPTH_ESTIMATORS.make(("depth_anything", {"weights": str(tmp_path)}))
