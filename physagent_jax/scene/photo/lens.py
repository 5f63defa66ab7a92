"""The camera of a photo, and the way from its pixels to places in the frame of what is lifted."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.scene.config.photo import Photo
from physagent_jax.scene.photo.picture import ASSUMED_FOCAL, Picture

STEEPEST = 45.0  # [degrees] between the line of sight and the solid's middle plane, where that need not lean


@dataclasses.dataclass(frozen=True)
class Lens:
    """A pinhole camera at zero, and a grid over its picture.

    Attributes:
        focal: Focal length [px].
        shape: Height and width of the picture [px].
        steps: Steps of the grid along columns and rows [px], shape (2,).
        elevation: Height of the camera above the horizon [degrees].
        lean: Angle by which the plane that holds depth 0 leans back from upright [degrees].
    """

    focal: float
    shape: tuple[int, int]
    steps: np.ndarray
    elevation: float
    lean: float

    @property
    def turn(self) -> np.ndarray:
        """From (right, away, up) to the camera's (right, down, forward), shape (3, 3)."""
        sin, cos = np.sin(np.radians(self.elevation)), np.cos(np.radians(self.elevation))
        return np.array([[1, 0, 0], [0, -sin, -cos], [0, cos, -sin]])

    def unproject(self, places: np.ndarray) -> np.ndarray:
        """Places in the frame of `scene.photo.lift` for (column, row, depth) [steps], shape (n, 3).

        Depth 0 is a plane through the optical axis at the distance of the focal length; depth runs along the rays, so
        that each place stays on its pixel.
        """
        height, width = self.shape
        pixels = (places[:, :2] + 0.5) * self.steps - [width / 2, height / 2]
        rays = np.column_stack([pixels / self.focal, np.ones(len(pixels))]) @ self.turn
        lean = np.radians(self.lean)
        normal = np.array([0, np.cos(lean), -np.sin(lean)])
        plane = (self.turn[2] @ normal) / np.maximum(rays @ normal, 0.05)
        return rays * (plane * (self.focal + places[:, 2] * self.steps[0]))[:, None]

    def find_derivatives(self, places: np.ndarray) -> np.ndarray:
        """The derivatives of `unproject`, shape (n, 3, 3), the last axis over (column, row, depth)."""
        steps = 0.5 * np.eye(3)
        return np.stack(
            [self.unproject(places + each) - self.unproject(places - each) for each in steps], axis=2
        )


def find_focal(picture: Picture, photo: Photo) -> float:
    """The focal length over the longer side: as it was given, else as EXIF data tell it, else assumed."""
    if photo.fov_degrees is not None:
        return 0.5 / np.tan(0.5 * np.radians(photo.fov_degrees))
    return picture.focal or ASSUMED_FOCAL
