"""The number of separate pieces of the object in the pictures."""

from __future__ import annotations

import cv2
import numpy as np

LEAST_SHARE = 0.02
"""Share of the object's area in frame 0 that a piece must have to count."""
GAP = 3
"""Gaps narrower than this are the mask's raggedness [px]."""


def count_pieces(masks: np.ndarray) -> list[int | None]:
    """Pieces of the mask that a gap parts from the others, per frame; None where the object is not seen.

    What flies in front of the rest is not told from it: a piece counts once the background shows between.

    Args:
        masks: The object, bool, shape (T, H, W).
    """
    least = LEAST_SHARE * masks[0].sum()
    return [_count(mask, least) if mask.any() else None for mask in masks]


def _count(mask: np.ndarray, least: float) -> int:
    x, y, width, height = cv2.boundingRect(mask.astype(np.uint8))
    closed = cv2.morphologyEx(
        np.pad(mask[y : y + height, x : x + width], GAP).astype(np.uint8),
        cv2.MORPH_CLOSE,
        np.ones((GAP, GAP), np.uint8),
    )
    stats = cv2.connectedComponentsWithStats(closed, connectivity=8)[2]
    return max(int((stats[1:, cv2.CC_STAT_AREA] >= least).sum()), 1)
