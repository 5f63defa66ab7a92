from __future__ import annotations

import os
import subprocess
import sys

import av
import imageio.v3 as iio
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.output.video import read_video, write_frames, write_video


def colour_bars(frames: int, height: int, width: int) -> np.ndarray:
    """Flat bars (chroma is halved in yuv420p, so edges blur) whose brightness differs per frame."""
    bars = np.array([[230, 40, 30], [40, 180, 60], [30, 60, 220], [255, 255, 255], [128, 128, 128]], np.uint8)
    picture = np.repeat(bars, -(-width // len(bars)), axis=0)[:width]
    dimming = np.linspace(1.0, 0.5, frames)[:, None, None, None]
    return (np.broadcast_to(picture, (height, width, 3)) * dimming).astype(np.uint8)


def test_round_trip_keeps_count_size_and_colours(tmp_path):
    frames = colour_bars(12, 64, 80)
    path = write_video(tmp_path / "clip.mp4", frames, 25)
    back = read_video(path)
    assert back.shape == frames.shape
    inside = np.concatenate([back[:, :, 16 * bar + 5 : 16 * bar + 11] for bar in range(5)], axis=2)
    asked = np.concatenate([frames[:, :, 16 * bar + 5 : 16 * bar + 11] for bar in range(5)], axis=2)
    assert np.abs(inside.astype(int) - asked).max() <= 8
    assert np.abs(inside.astype(int) - asked).mean() < 2.5


def test_file_is_what_browsers_play(tmp_path):
    path = write_video(tmp_path / "clip.mp4", colour_bars(5, 32, 48), 1 / 0.04)
    with av.open(str(path)) as file:
        stream = file.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert float(stream.average_rate) == 25
        assert float(stream.duration * stream.time_base) == pytest.approx(5 * 0.04)
    content = path.read_bytes()
    assert content.index(b"moov") < content.index(b"mdat"), "the index must stand in front"


def test_odd_sizes_are_padded_with_their_edge(tmp_path):
    back = read_video(write_video(tmp_path / "odd.mp4", colour_bars(3, 33, 47), 10))
    assert back.shape == (3, 34, 48, 3)
    assert np.abs(back[:, 33, 5].astype(int) - back[:, 32, 5]).max() <= 4


@pytest.mark.parametrize(
    "frames", [np.zeros((2, 8, 8, 3)), np.zeros((8, 8, 3), np.uint8), np.zeros((0, 8, 8, 3), np.uint8)]
)
def test_refuses_what_is_not_a_clip(tmp_path, frames):
    with pytest.raises(ValueError, match="uint8 of shape"):
        write_video(tmp_path / "clip.mp4", frames, 25)


def test_unwritable_place_is_a_user_error_and_leaves_nothing(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(UserError, match="cannot write"):
        write_video(tmp_path / "file" / "clip.mp4", colour_bars(2, 16, 16), 25)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    path = write_video(tmp_path / "clip.mp4", colour_bars(4, 16, 16), 25)
    before = path.read_bytes()
    monkeypatch.setattr("physagent_jax.output.video._convert_to_yuv", lambda picture: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write_video(path, colour_bars(4, 16, 16), 25)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["clip.mp4"]


def test_reading_rubbish_is_a_user_error(tmp_path):
    (tmp_path / "clip.mp4").write_bytes(b"not a video")
    for name in ("clip.mp4", "absent.mp4"):
        with pytest.raises(UserError, match="cannot read the video"):
            read_video(tmp_path / name)


def test_frames_are_exact_and_leave_other_files_alone(tmp_path):
    """A picture called like a later frame may be somebody's own."""
    frames = colour_bars(4, 9, 11)
    (tmp_path / "frames").mkdir()
    other = tmp_path / "frames" / "frame_0003.png"
    other.write_bytes(b"precious")
    paths = write_frames(tmp_path / "frames", frames[:3])
    assert sorted((tmp_path / "frames").iterdir()) == [*paths, other]
    assert other.read_bytes() == b"precious"
    assert [path.name for path in paths] == ["frame_0000.png", "frame_0001.png", "frame_0002.png"]
    for path, picture in zip(paths, frames, strict=False):
        np.testing.assert_array_equal(iio.imread(path), picture)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no way to choose cores here")
def test_the_bytes_do_not_depend_on_the_cores_that_are_free(tmp_path):
    """The encoder's own threads would be as many as there are cores, and each count gives another file."""
    frames = np.random.default_rng(0).integers(0, 256, (12, 96, 128, 3), dtype=np.uint8)
    cores = os.sched_getaffinity(0)
    files = []
    try:
        for chosen in (cores, {min(cores)}, cores):
            os.sched_setaffinity(0, chosen)
            files.append(write_video(tmp_path / "clip.mp4", frames, 25).read_bytes())
    finally:
        os.sched_setaffinity(0, cores)
    assert files[0] == files[1] == files[2]


def test_the_bytes_do_not_depend_on_what_memory_held_before(tmp_path):
    """x264's macroblock tree read memory that nobody had written (with AVX-512); glibc fills it with what we say."""
    program = (
        "import sys; import numpy as np; from physagent_jax.output.video import write_video\n"
        "y, x = np.mgrid[:160, :160]\n"
        "discs = [(x - 48 - 5 * i) ** 2 + (y - 80) ** 2 < 40**2 for i in range(12)]\n"
        "grey = np.where(discs, 200, 40).astype(np.uint8)\n"
        "write_video(sys.argv[1], np.stack([grey] * 3, -1), 25)"
    )
    files = []
    for fill in (1, 170, 255):
        path = tmp_path / f"{fill}.mp4"
        environment = {**os.environ, "MALLOC_PERTURB_": str(fill)}
        subprocess.run([sys.executable, "-c", program, str(path)], check=True, env=environment)
        files.append(path.read_bytes())
    assert files[0] == files[1] == files[2]
