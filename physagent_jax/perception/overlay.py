"""Mask outline and track tails drawn over the pictures, for people."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

import cv2
import numpy as np

_SHIFT = 4
"""Sub-pixel bits of OpenCV's drawing calls."""
_FAR = 1e6
"""Points that are farther off are drawn there: OpenCV takes integers of 32 bits [px]."""


def draw_overlay(
    rgb: np.ndarray,
    masks: np.ndarray,
    tracks: np.ndarray,
    visible: np.ndarray,
    *,
    frames: Sequence[int] | None = None,
    tail: int = 8,
    most: int = 70,
) -> np.ndarray:
    """Draw what perception followed.

    Args:
        rgb: Pictures, uint8, shape (T, H, W, 3).
        masks: The object, bool, shape (T, H, W).
        tracks: Points, pixel centres at +0.5 [px], shape (T, N, 2).
        visible: Where to draw them, bool, shape (T, N).
        frames: Indices of the pictures to draw on; None = all.
        tail: Length of the tails [frames].
        most: Tracks drawn per frame, at most; they are thinned evenly.

    Returns:
        New pictures, uint8, shape (len(frames), H, W, 3).
    """
    colours = _choose_colours(tracks, visible)
    chosen = range(len(rgb)) if frames is None else frames
    return np.stack([_draw_frame(rgb, masks, tracks, visible, colours, t, tail, most) for t in chosen])


def _draw_frame(rgb, masks, tracks, visible, colours, t: int, tail: int, most: int) -> np.ndarray:
    outside = ~masks[t][..., None]
    picture = np.where(outside, rgb[t] * 0.85 + 0.15 * 128, rgb[t]).astype(
        np.uint8, order="C"
    )  # as OpenCV needs it
    outline, _ = cv2.findContours(masks[t].astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(picture, outline, -1, (20, 20, 30), 3, cv2.LINE_AA)
    cv2.drawContours(picture, outline, -1, (255, 255, 255), 1, cv2.LINE_AA)
    shown = np.flatnonzero(visible[t])
    shown = shown[:: max(1, -(-len(shown) // most))]
    tails = picture.copy()
    for age in range(min(tail, t), 0, -1):
        at = t - age
        for i in shown[visible[at, shown] & visible[at + 1, shown]]:
            cv2.line(
                tails,
                _to_pixel(tracks[at, i]),
                _to_pixel(tracks[at + 1, i]),
                colours[i],
                1,
                cv2.LINE_AA,
                _SHIFT,
            )
    picture = cv2.addWeighted(tails, 0.85, picture, 0.15, 0)
    for i in shown:
        cv2.circle(
            picture, _to_pixel(tracks[t, i]), int(2.2 * 2**_SHIFT), (20, 20, 30), -1, cv2.LINE_AA, _SHIFT
        )
        cv2.circle(
            picture, _to_pixel(tracks[t, i]), int(1.5 * 2**_SHIFT), colours[i], -1, cv2.LINE_AA, _SHIFT
        )
    return picture


def _to_pixel(xy: np.ndarray) -> tuple[int, int]:
    x, y = np.round((np.clip(xy, -_FAR, _FAR) - 0.5) * 2**_SHIFT).astype(int)
    return int(x), int(y)


def _choose_colours(tracks: np.ndarray, visible: np.ndarray) -> list[tuple[int, int, int]]:
    """One colour per track, by the height at which it first appears, so that neighbours look alike."""
    if tracks.shape[1] == 0:
        return []
    start = tracks[visible.argmax(0), np.arange(tracks.shape[1])]
    rank = start[:, 1].argsort().argsort() / max(len(start) - 1, 1)
    return [
        (int(255 * r), int(255 * g), int(255 * b))
        for r, g, b in (colorsys.hsv_to_rgb(0.55 + 0.4 * k, 0.75, 1.0) for k in rank)
    ]
