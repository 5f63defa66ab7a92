"""What perception needs from a vision model, as protocols: pictures in, arrays out.

Those in `backends` need no weights.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from physagent_jax.render.camera import Camera


class Segmenter(Protocol):
    """Finds the object in each frame."""

    def __call__(self, frames: np.ndarray) -> np.ndarray:
        """Masks of the object.

        Args:
            frames: Pictures, uint8, shape (T, H, W, 3).

        Returns:
            True on the object, bool, shape (T, H, W).
        """
        ...


class DepthEstimator(Protocol):
    """Says how far away the surface behind each pixel is."""

    def __call__(self, frames: np.ndarray, camera: Camera) -> np.ndarray:
        """z-depth.

        Args:
            frames: Pictures, uint8, shape (T, H, W, 3).
            camera: Where they were taken from.

        Returns:
            z-depth [m], not ray length; nan or 0 where there is no surface; float32, shape (T, H, W).
        """
        ...


class Tracker(Protocol):
    """Follows points through the frames."""

    def __call__(
        self, frames: np.ndarray, queries: np.ndarray, masks: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Tracks of points that are given in the first of ``frames``.

        Args:
            frames: Pictures, uint8, shape (T, H, W, 3).
            queries: Points (x, y) in frame 0, pixel centres at +0.5 [px], shape (N, 2).
            masks: The object, bool, shape (T, H, W).

        Returns:
            tracks: Positions [px], shape (T, N, 2); meaningless where not visible.
            visible: Whether the point was found in the frame, bool, shape (T, N).
        """
        ...
