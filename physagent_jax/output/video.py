"""Videos that every browser plays, and numbered pictures."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterable
from fractions import Fraction
from pathlib import Path, PurePosixPath

import av
import imageio.v3 as iio
import numpy as np
from av.container import OutputContainer
from av.error import FFmpegError
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import replace_file, write_bytes

# Visually lossless for H.264: "veryfast" at a constant rate factor of 16 errs as little as "medium" at 18 (42.8 and
# 42.7 dB over a clip of 1280 x 720) in 40 % of the time, in files larger by a third. "yuv420p" and the index in front
# ("faststart") are what browsers and phones need. One thread: with several, the bytes depend on the machine and the
# moment. No macroblock tree: x264 (core 165) reads memory there that it never wrote, where it has AVX-512, so that the
# same frames gave one of several files.
QUALITY = {"crf": "16", "preset": "veryfast", "threads": "1", "mbtree": "0"}


ENCODER = "libx264"


def find_encoder() -> str | None:
    """The H.264 encoder with its library's description; None if this build of PyAV has none."""
    try:
        return f"{ENCODER}, {av.Codec(ENCODER, 'w').long_name}"
    except (FFmpegError, ValueError):
        return None


def write_video(path: str | Path, frames: Iterable[np.ndarray], fps: float) -> Path:
    """Write frames as an H.264 mp4 (yuv420p, BT.709, limited range).

    Odd sizes are padded by repeating the last row or column, because 4:2:0 colour needs even ones.

    Args:
        path: Where to, ending in ``.mp4``.
        frames: At least one picture, uint8, shape (H, W, 3): an array of them, or one after another as they are made.
        fps: Frames per second [1/s].

    Returns:
        ``path``.

    Raises:
        UserError: The file cannot be written.
        ValueError: The frames are not uint8 RGB of one size, or ``fps`` is not positive.
    """
    if not fps > 0:
        raise ValueError(f"`fps` must be positive (got {fps})")
    path = Path(path)
    pictures = iter(frames)
    first = next(pictures, np.empty((0, 0, 0)))
    size = _check_frames(np.asarray(first)[None]).shape[1:]
    with (
        replace_file(path) as temporary,
        av.open(str(temporary), "w", options={"movflags": "+faststart"}) as file,
    ):
        stream = _add_h264_stream(file, size[1] + size[1] % 2, size[0] + size[0] % 2, fps)
        for picture in itertools.chain([first], pictures):
            if _check_frames(np.asarray(picture)[None]).shape[1:] != size:
                raise ValueError(f"`frames` must be of one size (got {size} and {np.shape(picture)})")
            padded = np.pad(picture, ((0, size[0] % 2), (0, size[1] % 2), (0, 0)), mode="edge")
            file.mux(stream.encode(_convert_to_yuv(padded)))
        file.mux(stream.encode(None))
    return path


def read_video(path: str | Path, choose: Callable[[int], Collection[int]] = range) -> np.ndarray:
    """Frames of a video, uint8, shape (T, H, W, 3).

    Args:
        path: The file.
        choose: Which frames of so many, ascending; all by default.

    Raises:
        UserError: The file is missing or is not a video.
    """
    try:
        with av.open(str(path)) as file:
            wanted = set(choose(file.streams.video[0].frames))
            decoded = [
                frame.to_ndarray(format="rgb24")
                for index, frame in enumerate(file.decode(video=0))
                if index in wanted
            ]
    except (OSError, FFmpegError, IndexError, UnicodeError) as error:  # names of codecs may be damaged too
        raise UserError(
            f"cannot read the video {path}", got=error, do="Check that it is a finished mp4"
        ) from None
    if not decoded:
        raise UserError(f"the video {path} holds no frames", do="Render it again")
    return np.stack(decoded)


def write_frames(folder: str | Path, frames: np.ndarray) -> list[Path]:
    """Write ``frame_0000.png`` and so on.

    Args:
        folder: Where to; made if absent.
        frames: Pictures, uint8, shape (T, H, W, 3).

    Returns:
        The files' paths in order.

    Raises:
        UserError: The folder cannot be written to.
        ValueError: The frames are not uint8 RGB.
    """
    folder = Path(folder)
    paths = [folder / name for name in make_frame_names("", len(_check_frames(frames)))]
    for path, picture in zip(paths, frames, strict=True):
        write_picture(path, picture)
    return paths


def make_frame_names(folder: str, count: int) -> list[str]:
    """Names of the pictures of ``count`` frames in ``folder``."""
    return [str(PurePosixPath(folder, f"frame_{index:04d}.png")) for index in range(count)]


def write_picture(path: str | Path, picture: np.ndarray) -> None:
    """Write a PNG, uint8, shape (H, W, 3), atomically."""
    write_bytes(path, encode_png(picture))


def encode_png(picture: np.ndarray) -> bytes:
    """A picture, uint8, shape (H, W, 3), as PNG."""
    return iio.imwrite("<bytes>", picture, extension=".png")


def _check_frames(frames: np.ndarray) -> np.ndarray:
    frames = np.asarray(frames)
    if frames.ndim != 4 or frames.shape[-1] != 3 or frames.dtype != np.uint8 or frames.size == 0:
        raise ValueError(
            f"`frames` must be uint8 of shape (T, H, W, 3) with T >= 1 (got {frames.dtype} {frames.shape})"
        )
    return frames


def _add_h264_stream(file: OutputContainer, width: int, height: int, fps: float):
    stream = file.add_stream(ENCODER, rate=Fraction(fps).limit_denominator(1001), options=QUALITY)
    stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
    # Untagged files are shown with BT.601 or BT.709 by taste of the player: colours would shift.
    context = stream.codec_context
    context.color_primaries, context.color_trc = ColorPrimaries.BT709, ColorTrc.BT709
    context.colorspace, context.color_range = Colorspace.ITU709, ColorRange.MPEG
    return stream


def _convert_to_yuv(picture: np.ndarray) -> av.VideoFrame:
    return av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(
        format="yuv420p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
    )
