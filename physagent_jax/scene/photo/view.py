"""A photo's own camera in a scene, and the photo as what stands behind the object there."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import cv2
import numpy as np

from physagent_jax.render.camera import Camera
from physagent_jax.scene.config import CameraConfig, Source
from physagent_jax.scene.config.photo import Photo
from physagent_jax.scene.photo.lift import Lifted, lift_photo
from physagent_jax.scene.placement import Placement


@dataclasses.dataclass(frozen=True)
class PhotoView:
    """The view in which the object at rest is where the photo has it.

    Attributes:
        lifted: What the photo gave.
        placement: From the frame of what was lifted to the world.
        elevation_degrees: Height of the camera above the horizon.
    """

    lifted: Lifted
    placement: Placement
    elevation_degrees: float

    def is_of(self, camera: CameraConfig) -> bool:
        """Return whether a scene's camera looks as the photo's does, and stays where it is."""
        same = camera.azimuth_degrees % 360 == 0 and camera.elevation_degrees == self.elevation_degrees
        return same and not camera.follow

    def make_camera(self, size: tuple[int, int]) -> Camera:
        """The photo's camera, its picture the largest of the photo's shape that fits into ``size`` [px]."""
        height = min(size[1], size[0] / self.lifted.aspect)
        # Encoders of video want even sides.
        height, width = (max(2 * round(0.5 * side), 16) for side in (height, height * self.lifted.aspect))
        view = np.eye(4)
        view[:3, :3] = self.lifted.turn @ self.placement.rotation.T
        view[:3, 3] = -view[:3, :3] @ self.placement.to_world(np.zeros(3))
        focal = self.lifted.focal * height
        K = np.array(
            [[focal * width / height / self.lifted.aspect, 0, width / 2], [0, focal, height / 2], [0, 0, 1]]
        )
        return Camera(view, K, width, height)

    def draw_plate(self, camera: Camera) -> np.ndarray:
        """The photo without its object in the size of a camera's picture, RGB in [0, 1], shape (h, w, 3), float32."""
        plate = self.lifted.plate.astype(np.float32) / 255
        smaller = camera.height < len(plate)
        how = cv2.INTER_AREA if smaller else cv2.INTER_CUBIC
        return np.clip(cv2.resize(plate, (camera.width, camera.height), interpolation=how), 0, 1)


def find_view(source: Source, placement: Placement, base_dir: str | Path) -> PhotoView:
    """The view of a photo's camera.

    Args:
        source: The photo.
        placement: The placement of what was lifted from it.
        base_dir: Folder that relative paths start from.

    Raises:
        UserError: The photo cannot be read.
    """
    photo = source.photo or Photo()
    lifted = lift_photo(Path(source.path), photo, Path(base_dir))
    return PhotoView(lifted, placement, photo.elevation_degrees)
