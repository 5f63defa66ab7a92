"""Depth Anything 3 in another Python: the exchange of files, with stand-ins for its package, and what goes wrong."""

import os
import sys

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends import DEPTH_ESTIMATORS
from physagent_jax.render.camera import look_at

HEIGHT, WIDTH = 30, 40
CAMERA = look_at((0, -3, 1), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=WIDTH, height=HEIGHT)

# A stand-in for the package: its calls and names are the real ones (revision 2c21ea84 of its repository); its depth is
# the brightness of the picture at half size, times a factor of the frame's own.
STAND_IN = """
import json, os, pathlib
import numpy as np

class Prediction:
    def __init__(self, depth, is_metric):
        self.depth, self.is_metric = depth, is_metric

class DepthAnything3:
    calls = 0
    @classmethod
    def from_pretrained(cls, place):
        self = cls()
        self.config = json.loads(pathlib.Path(place, "config.json").read_text())
        self.model_name = self.config["model_name"]
        assert os.environ["HF_HUB_OFFLINE"] == "1" and "PYTHONHOME" not in os.environ
        return self
    def to(self, device):
        assert device == "cpu"
        return self
    def inference(self, image):
        (picture,) = image
        assert picture.dtype == np.uint8 and picture.ndim == 3
        factor = self.config["factors"][self.calls]
        self.calls += 1
        return Prediction(picture[None, ::2, ::2, 0] / np.float32(64) * np.float32(factor), self.config["is_metric"])
"""


@pytest.fixture
def make_python(tmp_path):
    """A program that runs this Python with a package that stands in for `depth_anything_3`."""

    def make(stand_in=STAND_IN, script=None):
        package = tmp_path / "packages" / "depth_anything_3"
        package.mkdir(parents=True, exist_ok=True)
        (package / "__init__.py").write_text("")
        (package / "api.py").write_text(stand_in)
        (tmp_path / "packages" / "torch.py").write_text(
            ""
        )  # the script asks it for a GPU only with device "auto"
        program = tmp_path / "python"
        line = f'PYTHONPATH="{tmp_path}/packages" exec "{sys.executable}" "$@"'
        program.write_text(f"#!/bin/sh\n{script or line}\n")
        program.chmod(0o755)
        return str(program)

    return make


def make_weights(tmp_path, model_name="da3-small", is_metric=0, factors=(1.0, 2.0, 0.5)):
    folder = tmp_path / "weights"
    folder.mkdir(exist_ok=True)
    told = f'{{"model_name": "{model_name}", "is_metric": {is_metric}, "factors": {list(factors)}}}'
    (folder / "config.json").write_text(told)
    return str(folder)


def make_frames():
    frames = np.full((3, HEIGHT, WIDTH, 3), 128, np.uint8)
    frames[:, :, WIDTH // 2 :] = 192
    return frames


def estimate(python, weights, **options):
    chosen = {"python": python, "weights": weights, "device": "cpu", **options}
    return DEPTH_ESTIMATORS.make(("depth_anything_3", chosen)).estimate(make_frames(), CAMERA, None)


def test_depth_comes_back_at_the_pictures_size_on_the_scale_of_the_first_frame(make_python, tmp_path):
    seen = estimate(make_python(), make_weights(tmp_path))
    assert seen.z.shape == (3, HEIGHT, WIDTH) and seen.z.dtype == np.float32 and not seen.scale_known
    np.testing.assert_allclose(seen.z[:, :, :18], 2.0, rtol=1e-5)  # whatever factor the frame had
    np.testing.assert_allclose(seen.z[:, :, 22:], 3.0, rtol=1e-5)
    assert "depth_anything_3:weights, in a unit of its own" in seen.notes[0]


def test_the_metric_model_is_scaled_by_the_focal_length_at_its_own_size(make_python, tmp_path):
    seen = estimate(make_python(), make_weights(tmp_path, "da3metric-large"))
    focal = CAMERA.K[0, 0] / 2  # [px] at half size
    np.testing.assert_allclose(seen.z[:, :, :18], 2.0 * focal / 300, rtol=1e-5)
    assert seen.scale_known and "focal length" in seen.notes[0]


def test_a_model_that_is_metric_by_itself_is_believed(make_python, tmp_path):
    seen = estimate(make_python(), make_weights(tmp_path, "da3nested-giant-large", is_metric=1))
    np.testing.assert_allclose(seen.z[:, :, :18], 2.0, rtol=1e-5)
    assert seen.scale_known


def test_a_crash_is_told_with_its_last_lines(make_python, tmp_path):
    weights = make_weights(tmp_path)
    python = make_python("raise ImportError('numpy.core.multiarray failed to import')")
    with pytest.raises(UserError, match="exit code 1.*multiarray failed to import.*`python`"):
        estimate(python, weights)
    with pytest.raises(UserError, match="exit code 3 .got it says nothing"):
        estimate(make_python(script="exit 3"), weights)


def test_a_process_that_does_not_end_is_ended(make_python, tmp_path):
    with pytest.raises(UserError, match="longer than 0.3 s.*`timeout`"):
        estimate(make_python(script="exec sleep 60"), make_weights(tmp_path), timeout=0.3)


@pytest.mark.parametrize(
    ("answer", "fragment"),
    [
        ("", "no answer of `depth_anything_3`"),
        ("np.savez(out, depth=np.zeros((2, 4, 4), np.float32), metric=False)", "one depth per frame"),
        ("np.savez(out, metric=False)", "one depth per frame"),
        ("np.savez(out, depth=np.array([None] * 3), metric=False)", "the answer of `depth_anything_3`"),
    ],
)
def test_another_answer_is_refused(answer, fragment, make_python, tmp_path):
    (tmp_path / "other.py").write_text(f"import sys\nimport numpy as np\nout = sys.argv[3]\n{answer}\n")
    script = f'exec "{sys.executable}" "{tmp_path}/other.py" "$@"'
    with pytest.raises(UserError, match=fragment):
        estimate(make_python(script=script), make_weights(tmp_path))


def test_what_is_missing_is_said_before_a_run_begins(tmp_path, make_python):
    with pytest.raises(UserError, match="needs a Python that has its package.*`python`"):
        DEPTH_ESTIMATORS.make(("depth_anything_3", {"weights": make_weights(tmp_path)}))
    with pytest.raises(UserError, match="is no program.*nowhere"):
        estimate(os.fspath(tmp_path / "nowhere"), make_weights(tmp_path))
    with pytest.raises(UserError, match="`timeout` must be above 0"):
        estimate(make_python(), make_weights(tmp_path), timeout=0)
