"""Camera and pictures."""

from __future__ import annotations

from pydantic import Field

from physagent_jax.core.strict import Strict, Vector
from physagent_jax.scene.config.common import Positive


class CameraConfig(Strict):
    """The reference camera: looks at ``target`` from a sphere around it.

    Attributes:
        target: [m]; None = the domain's centre.
        azimuth_degrees: About +z from -y (0 = in front, looking along +y; 90 = from +x looking along -x).
        elevation_degrees: Above the horizon.
        distance: [m].
        fov_degrees: Vertical field of view.
    """

    target: Vector | None = None
    azimuth_degrees: float = 0.0
    elevation_degrees: float = Field(default=10.0, gt=-89, lt=89)
    distance: Positive = 4.0
    fov_degrees: float = Field(default=40.0, gt=1, lt=150)


class Rendering(Strict):
    """Pictures.

    Attributes:
        width, height: [px].
        background: RGB in [0, 1].
    """

    width: int = Field(default=320, ge=16, le=4096)
    height: int = Field(default=320, ge=16, le=4096)
    background: Vector = (1.0, 1.0, 1.0)
