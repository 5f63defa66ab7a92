"""Depth as a camera measures it."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.render.camera import Camera


@dataclasses.dataclass(frozen=True)
class DepthSensor:
    """The depth channel of an RGB-D camera as a `DepthEstimator`.

    The channel comes from the renderer, as a depth camera's would from its sensor. It is a picture: it
    shows the visible surface only and knows nothing of particles.

    Attributes:
        depth: z-depth [m], nan or 0 where there is no surface, shape (T, H, W).
    """

    depth: np.ndarray

    def __call__(self, frames: np.ndarray, camera: Camera) -> np.ndarray:
        """The channel itself, with "no surface" as nan."""
        depth = np.asarray(self.depth, np.float32)
        return np.where(np.isfinite(depth) & (depth > 0), depth, np.float32(np.nan))
