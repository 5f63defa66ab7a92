"""The gallery: its list, the size of its pictures, its page."""

import io

import numpy as np
import pytest
from PIL import Image

from benchmarks.gallery import CLIPS, MOST_BYTES, WIDTH, Clip, encode, find_object, main, write_page
from physagent_jax.core.errors import UserError


def test_twelve_of_sixteen_clips_are_on_other_peoples_objects():
    assert len({clip.name for clip in CLIPS}) == len(CLIPS) == 16
    assert len({clip.file for clip in CLIPS} - {""}) == 12


def test_pictures_move_and_stay_small():
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 255, (40, 90, 160, 3), np.uint8)
    smooth = np.repeat(np.repeat(noise[:, ::10, ::10], 20, axis=1), 20, axis=2)
    content = encode(smooth, 0.04)
    assert len(content) <= MOST_BYTES
    picture = Image.open(io.BytesIO(content))
    assert picture.format == "WEBP" and picture.n_frames == 40 and picture.width == WIDTH


def test_the_page_shows_every_picture(tmp_path):
    clips = [(clip, "SUCCESS") for clip in CLIPS[:3]]
    write_page(tmp_path / "gallery.md", tmp_path / "images", clips)
    text = (tmp_path / "gallery.md").read_text()
    for clip, _ in clips:
        assert f"(images/gallery-{clip.name}.webp)" in text and clip.prompt in text


def test_a_missing_object_is_said_with_the_command_that_fetches_it(tmp_path, capsys):
    with pytest.raises(UserError, match="first_results.objects"):
        find_object(Clip("duck", "Duck.glb", "drop the duck"), tmp_path, tmp_path)
    assert main(["--only", "duck", "--docs", str(tmp_path), "--runs", str(tmp_path / "runs")]) == 2
    assert "duck" in capsys.readouterr().err
