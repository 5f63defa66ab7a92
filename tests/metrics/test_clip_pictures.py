"""Pictures as a CLIP model is shown them: Pillow's resizing, the middle, and the model's own colours."""

import json

import jax.numpy as jnp
import numpy as np
import pytest
from PIL import Image

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.clip_pictures import Preparation, find_size, prepare


def show(rgb, how):
    """The reference: Pillow, the middle, mean and standard deviation."""
    height, width = find_size(*rgb.shape[1:3], how.size)
    made = []
    for picture in rgb:
        resized = np.asarray(Image.fromarray(picture).resize((width, height), Image.Resampling.BICUBIC)) / 255
        top, left = (height - how.crop_size[0]) // 2, (width - how.crop_size[1]) // 2
        made.append(resized[top : top + how.crop_size[0], left : left + how.crop_size[1]])
    return (np.stack(made) - how.image_mean) / how.image_std


@pytest.mark.parametrize("size", [(224, 224), (480, 640), (300, 225), (64, 97), (225, 1000)])
@pytest.mark.parametrize("kind", ["noise", "edges"])
def test_pictures_are_pillow_s(size, kind):
    """Noise and hard edges, larger and smaller than the model's pictures; in steps of 8 bits.

    Of rounded colours some lie on the border between two, and Pillow's weights are rounded too.
    """
    rng, how = np.random.default_rng(0), Preparation()
    rgb = rng.integers(0, 256, (2, *size, 3), np.uint8)
    if kind == "edges":
        blocks = np.where(rgb[:, ::16, ::16] > 127, 255, 0).astype(np.uint8)
        rgb = blocks.repeat(16, 1).repeat(16, 2)[:, : size[0], : size[1]]
    whole, parts = (
        np.abs(np.asarray(prepare(jnp.asarray(each), how)) - show(rgb, how)) * how.image_std * 255
        for each in (rgb, np.float32(rgb) / 255)
    )
    assert whole.shape == (2, 224, 224, 3)
    assert whole.max() < 1.01 and (whole > 0.01).mean() < 0.005
    assert parts.max() < 1.2 and parts.mean() < 0.35


def test_sizes_are_those_of_the_reference():
    assert find_size(480, 640, 224) == (224, 298) and find_size(1000, 225, 224) == (995, 224)
    assert find_size(480, 640, (224, 300)) == (224, 300)


def test_sides_and_numbers_name_sizes(tmp_path):
    path = tmp_path / "preprocessor_config.json"
    assert Preparation.read(tmp_path, 32) == Preparation(size=32, crop_size=(32, 32))
    path.write_text(json.dumps({"size": 40, "crop_size": 32, "image_mean": [0, 0, 0], "other": 1}))
    read = Preparation.read(tmp_path, 32)
    assert (read.size, read.crop_size, read.image_mean) == (40, (32, 32), (0, 0, 0))
    sides = {"height": 33, "width": 34}
    path.write_text(json.dumps({"size": sides, "crop_size": {"height": 32, "width": 32}}))
    assert Preparation.read(tmp_path, 32).size == (33, 34)
    path.rename(tmp_path / "processor_config.json").write_text(
        json.dumps(
            {"image_processor": {"size": {"shortest_edge": 36}, "crop_size": 32}, "processor_class": "x"}
        )
    )
    assert Preparation.read(tmp_path, 32).size == 36


@pytest.mark.parametrize(
    "said", ["[]", '{"size": 0}', '{"size": 20}', '{"image_std": [0, 1, 1]}', "{", '{"do_resize": false}']
)
def test_what_cannot_be_followed_is_refused(tmp_path, said):
    (tmp_path / "preprocessor_config.json").write_text(said)
    with pytest.raises(UserError, match="preprocessor_config"):
        Preparation.read(tmp_path, 32)
