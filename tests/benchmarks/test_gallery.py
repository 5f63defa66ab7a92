"""The gallery: its list, the size of its pictures, its page."""

import io
import urllib.request

import numpy as np
from PIL import Image

from benchmarks.gallery import CLIPS, KITS, MOST_BYTES, WIDTH, Clip, encode, find_object, main, write_page


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


def test_a_missing_object_is_fetched_once_with_its_texture(tmp_path, monkeypatch):
    asked = []

    def answer(url, timeout):
        asked.append(url)
        return io.BytesIO(url.encode())

    monkeypatch.setattr(urllib.request, "urlopen", answer)
    for _ in range(2):
        path, _up = find_object(Clip("coin", "platformer/coin.glb", "spin the coin"), tmp_path, tmp_path)
    assert len(asked) == 2 and all("Starter-Kit-3D-Platformer/3fa8a04b" in url for url in asked)
    assert path.read_bytes().endswith(b"/models/coin.glb")
    assert (path.parent / "Textures/colormap.png").is_file()


def test_an_object_that_cannot_be_had_ends_it(tmp_path, monkeypatch, capsys):
    def answer(url, timeout):
        raise OSError("no network")

    monkeypatch.setattr(urllib.request, "urlopen", answer)
    places = [f"--{name}={tmp_path / name}" for name in ("docs", "runs", "objects")]
    assert main(["--only", "coin", *places]) == 2
    assert "no network" in capsys.readouterr().err
    assert not (tmp_path / "docs/gallery.md").exists()


def test_every_kit_of_a_clip_is_known():
    assert {clip.file.split("/")[0] for clip in CLIPS if clip.file} == set(KITS)
