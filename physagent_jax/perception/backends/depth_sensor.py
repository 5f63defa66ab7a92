"""Depth as a camera measures it."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.perception.lift import keep_possible_depth
from physagent_jax.perception.protocols import Depth, DepthEstimator
from physagent_jax.render.camera import Camera

_NOTE = "Depth comes from the renderer's depth channel, as from an RGB-D camera; only the visible side is measured."


class DepthSensor(DepthEstimator):
    """The depth channel of an RGB-D camera.

    The channel comes from the renderer, as a depth camera's would from its sensor. It is a picture: it
    shows the visible surface only and knows nothing of particles.
    """

    @property
    def takes_measured(self) -> bool:
        """It is the measured channel."""
        return True

    def estimate(self, frames: np.ndarray, camera: Camera, measured: np.ndarray | None) -> Depth:
        """The channel itself, with "no surface" as nan."""
        if measured is None:
            raise UserError("the depth sensor has no depth channel", do="Choose a model that estimates depth")
        return Depth(keep_possible_depth(measured), notes=(_NOTE,))
