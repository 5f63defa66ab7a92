"""Contact sheets: clips as rows of frames, so that labels and verdicts can be checked by eye."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

import cv2
import imageio.v3 as imageio
import numpy as np

from benchmarks.harness import Row
from benchmarks.verdicts.backgrounds import compose
from benchmarks.verdicts.clip import Clip
from benchmarks.verdicts.recording import record

FRAMES, PER_SHEET = 8, 8
_LINE = 26  # [px] of text above a row


def write_sheets(
    folder: Path, clips: Sequence[tuple[Clip, Row | None]], recordings: Path, data: Path | None
) -> None:
    """Write clips with what is said of them.

    Args:
        folder: Folder of the sheets.
        clips: Each with the row of its verdict, if there is one.
        recordings: Folder of clips.
        data: Folder of captured objects and a photo.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for first in range(0, len(clips), PER_SHEET):
        rows = [_row(clip, row, recordings, data) for clip, row in clips[first : first + PER_SHEET]]
        imageio.imwrite(folder / f"sheet-{first // PER_SHEET:02d}.png", np.concatenate(rows))


def _row(clip: Clip, row: Row | None, recordings: Path, data: Path | None) -> np.ndarray:
    held = record(clip.thing, clip.motion, recordings, data)
    rgb, _ = compose(held, clip.background, data)
    shown = np.linspace(0, len(rgb) - 1, FRAMES).round().astype(int)
    strip = np.concatenate([rgb[index][::2, ::2] for index in shown], axis=1)
    label = "right" if clip.wrong is None else f"wrong ({clip.wrong})"
    text = f'{clip.name}: "{clip.sentence}" -- {clip.motion.words} -- {label}'
    if row is not None:
        text += f" -- verdict {row['verdict']}"
    head = np.full((_LINE, strip.shape[1], 3), 255, np.uint8)
    for number, line in enumerate(textwrap.wrap(text, 190)[:2]):
        cv2.putText(
            head, line, (4, 11 + 13 * number), cv2.FONT_HERSHEY_SIMPLEX, 0.38, (0, 0, 0), 1, cv2.LINE_AA
        )
    return np.concatenate([head, strip])
