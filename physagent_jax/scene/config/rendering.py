"""Camera and pictures."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from physagent_jax.core.strict import Strict
from physagent_jax.scene.config.common import Degrees, Length, Point

_Channel = Annotated[float, Field(ge=0, le=1)]


class CameraConfig(Strict):
    """The reference camera: looks at ``target`` from a sphere around it.

    Attributes:
        target: [m]; None = the domain's centre.
        azimuth_degrees: About +z from -y (0 = in front, looking along +y; 90 = from +x looking along -x).
        elevation_degrees: Above the horizon.
        distance: [m].
        fov_degrees: Vertical field of view.
        follow: Whether the camera of the video for people goes along with the object; None = only if the object would
            else be too small in it (`scene.presentation`). Perception's always stands still.
        turn: Whether that camera may stand aside, so that what moves along the line of sight is seen to move.
    """

    target: Point | None = None
    azimuth_degrees: Degrees = 0.0
    elevation_degrees: float = Field(default=10.0, gt=-89, lt=89)
    distance: Length = 4.0
    fov_degrees: float = Field(default=40.0, gt=1, lt=150)
    follow: bool | None = None
    turn: bool = True


class Rendering(Strict):
    """Pictures.

    Attributes:
        width, height: [px].
        background: RGB in [0, 1].
    """

    width: int = Field(default=320, ge=16, le=4096)
    height: int = Field(default=320, ge=16, le=4096)
    background: tuple[_Channel, _Channel, _Channel] = (1.0, 1.0, 1.0)
