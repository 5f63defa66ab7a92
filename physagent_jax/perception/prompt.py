"""The place of the object in the first frame, for a segmenter that needs a prompt."""

from __future__ import annotations

import cv2
import numpy as np

from physagent_jax.perception.backends.colour import ColorSegmenter
from physagent_jax.perception.backends.rgbd import RgbdSegmenter
from physagent_jax.perception.protocols import SegmentPrompt


def find_prompt(rgb: np.ndarray, z: np.ndarray | None) -> SegmentPrompt | None:
    """The box around what stands out in frame 0, and the point deepest inside it.

    A point alone may mean a part of the object, a box alone may hold more than the object.

    Args:
        rgb: Pictures, uint8, shape (T, H, W, 3).
        z: z-depth, nan where there is no surface, shape (T, H, W); None = not known yet, and colour
            alone tells.

    Returns:
        The prompt; None if nothing stands out.
    """
    mask = RgbdSegmenter().segment(rgb[:1], None, depth=None if z is None else z[:1]).masks[0]
    if not mask.any():  # before a busy background GrabCut guesses: good enough to point at the object
        mask = ColorSegmenter().segment(rgb[:1], None).masks[0]
    if not mask.any():
        return None
    x, y, w, h = cv2.boundingRect(mask.astype(np.uint8))
    inside = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 3)[1:-1, 1:-1]
    row, column = np.unravel_index(int(inside.argmax()), inside.shape)
    return SegmentPrompt(
        points=np.array([[column + 0.5, row + 0.5]]), box=np.array([x, y, x + w, y + h], float)
    )
