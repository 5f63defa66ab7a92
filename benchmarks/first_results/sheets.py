"""Contact sheets: each video as a strip of frames with the sentence and the verdict above it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import chain, repeat
from pathlib import Path

import cv2
import numpy as np

from benchmarks.first_results.viewing import hash_video
from benchmarks.harness import Row
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_bytes
from physagent_jax.output.video import read_video

FRAMES, PER_SHEET = 7, 6
STILLS = 16  # frames of a picture to be looked at
WIDTH = 240  # of a frame [px]
MOST_BYTES = 400_000
_STILL, _ABREAST = 400, 4  # width of a still [px], and stills side by side
_GAP = 2  # between frames [px]
_LINE, _QUALITIES = 26, (88, 80, 70, 60, 50, 40)


def write_sheets(folder: Path, rows: Sequence[Row], runs: Path, group: str = "sentences") -> list[Path]:
    """Write ``first-results-1.jpg`` and so on.

    Args:
        folder: Folder of the sheets.
        rows: All rows of a set, in order.
        runs: Folder of the runs' folders.
        group: Name of the set.

    Returns:
        The files.

    Raises:
        UserError: A video is missing, or is not the one that the row is of.
    """
    folder.mkdir(parents=True, exist_ok=True)
    strips = [_read_strip(row, runs / row["case"]) for row in rows]
    files = []
    for first in range(0, len(strips), PER_SHEET):
        files.append(folder / name_sheet(first, group))
        write_bytes(files[-1], encode_jpeg(np.concatenate(strips[first : first + PER_SHEET])))
    return files


def name_sheet(index: int, group: str = "sentences") -> str:
    """The file with the strip of row ``index`` of a set."""
    return f"first-results-{'' if group == 'sentences' else f'{group}-'}{index // PER_SHEET + 1}.jpg"


def write_stills(folder: Path, rows: Sequence[Row], runs: Path) -> list[Path]:
    """Write a picture per row for a person who looks: more frames, larger, as PNG.

    Args:
        folder: Folder of the pictures.
        rows: The rows; those without a video have no picture.
        runs: Folder of the runs' folders.

    Returns:
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for row in rows:
        if row["video"] is None:
            continue
        chosen = partial(choose_frames, most=STILLS)
        frames = read_video(_find_video(row, runs / row["case"]), chosen)
        times = [f"{index * row['frame_dt']:.2f} s" for index in chosen(row["frames"])]
        lines = [
            draw_strip(frames[at : at + _ABREAST], times[at : at + _ABREAST], caption, _STILL, _ABREAST)
            for at, caption in zip(range(0, len(frames), _ABREAST), chain([_caption(row)], repeat("")))
        ]
        files.append(folder / f"{row['case']}.png")
        write_bytes(files[-1], cv2.imencode(".png", np.concatenate(lines)[..., ::-1])[1].tobytes())
    return files


def draw_strip(
    frames: np.ndarray, labels: Sequence[str], caption: str, width: int = WIDTH, abreast: int = FRAMES
) -> np.ndarray:
    """A caption over frames side by side, uint8, shape (height, ``abreast`` ``width``, 3).

    Args:
        frames: At most ``abreast`` pictures, uint8, shape (k, H, W, 3).
        labels: One per picture, written into it.
        caption: The line above, plain ASCII.
        width: Width of a frame [px].
        abreast: Places for frames.
    """
    strip = np.full((_LINE, abreast * width, 3), 255, np.uint8)
    _write(strip, caption, (6, 18), 0.5)
    if not len(frames):
        return strip
    height = round(width * frames.shape[1] / frames.shape[2])
    pictures = np.full((height, abreast * width, 3), 255, np.uint8)
    for place, (frame, label) in enumerate(zip(frames, labels, strict=True)):
        small = cv2.resize(frame, (width - _GAP, height), interpolation=cv2.INTER_AREA)
        _write(small, label, (5, height - 6), 0.4)
        pictures[:, place * width : (place + 1) * width - _GAP] = small
    return np.concatenate([strip, pictures])


def encode_jpeg(picture: np.ndarray) -> bytes:
    """As JPEG of at most `MOST_BYTES`, as good as that allows.

    Raises:
        UserError: It does not fit at any quality.
    """
    for quality in _QUALITIES:
        data = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
        if len(data) <= MOST_BYTES:
            return data
    raise UserError("the contact sheet is too large", got=f"{len(data)} bytes", do="Put fewer rows on it")


def choose_frames(count: int, most: int = FRAMES) -> list[int]:
    """Frames of so many, evenly spaced, the first and the last among them."""
    return sorted(set(np.linspace(0, count - 1, min(most, count)).round().astype(int).tolist()))


def _read_strip(row: Row, folder: Path) -> np.ndarray:
    if row["video"] is None:
        return draw_strip(np.empty((0, 1, 1, 3), np.uint8), (), _caption(row))
    frames = read_video(_find_video(row, folder), choose_frames)
    labels = [f"{index * row['frame_dt']:.2f} s" for index in choose_frames(row["frames"])]
    return draw_strip(frames, labels, f"{_caption(row)}, from the truth {row['true_verdict']}")


def _caption(row: Row) -> str:
    return f'{row["case"]}, {row["preset"]}: "{row["sentence"]}" - {row["verdict"]}'


def _find_video(row: Row, folder: Path) -> Path:
    """The video that a row is of.

    Raises:
        UserError: It is missing, or is another one.
    """
    video = folder / "video.mp4"
    if not video.is_file() or hash_video(video) != row["video"]:
        raise UserError(
            "a contact sheet needs the videos that the rows are of",
            got=f"{row['case']}: {'another video' if video.is_file() else 'no video'}",
            do="Run the sentences where their videos are to be kept",
        )
    return video


def _write(picture: np.ndarray, text: str, at: tuple[int, int], size: float) -> None:
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, (0, 0, 0), 1, cv2.LINE_AA)
