"""The object's part of a photo, and the camera that took it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from physagent_jax.core.strict import Strict
from physagent_jax.scene.config.common import Path

Pixel = Annotated[float, Field(ge=0, le=65_536)]
ELEVATION = 10.0
"""Height above the horizon of a camera of which nobody says it [degrees]."""
FieldOfView = Annotated[float, Field(gt=1, lt=150)]  # [degrees]
Elevation = Annotated[float, Field(gt=-89, lt=89)]  # [degrees]


class Cutout(Strict):
    """The part of the picture that is the object; nothing given = what GrabCut finds in the middle.

    Attributes:
        box: Corners (x0, y0, x1, y1) of a box that holds the object [px].
        mask_path: Picture of the same size or shape that is bright on the object, or ``.npy`` of one bool per pixel.
        fov_degrees: Field of view along the longer side; None = the file's EXIF data, else an assumed one.
    """

    box: tuple[Pixel, Pixel, Pixel, Pixel] | None = None
    mask_path: Path | None = None
    fov_degrees: FieldOfView | None = None

    @model_validator(mode="after")
    def _check_box(self):
        if self.box is not None and self.mask_path is not None:
            raise ValueError("`box` and `mask_path` both say where the object is: give one of them")
        if self.box is not None and not (self.box[0] < self.box[2] and self.box[1] < self.box[3]):
            raise ValueError(f"`box` is x0 y0 x1 y1 with x0 < x1 and y0 < y1 (got {self.box})")
        return self


class Photo(Cutout):
    """The lifting of a photo to Gaussians (`scene.photo`).

    Attributes:
        depth_path: ``.npy`` of the z-depth of each pixel, in any unit, shape (height, width); None = the outline is
            inflated.
        elevation_degrees: Height of the camera above the horizon.
    """

    depth_path: Path | None = None
    elevation_degrees: Elevation = ELEVATION
