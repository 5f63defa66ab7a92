"""The colours of an object in a photo, those of its unseen sides, and the picture behind it."""

from __future__ import annotations

import cv2
import numpy as np
from scipy import ndimage

from physagent_jax.scene.photo.solid import Solid, Surface

RIM = 2.0  # [steps] from the outline, up to where colours are mixed with the background's
BACK_BLUR = 0.04  # of the mask's longer side: the back shows the front's colours, out of focus,
TURNED = 0.5  # of the depth behind the middle, from where on all of it is
PLATE = 400  # [px] longer side at which the hole behind the object is filled
FRINGE, SOFT = 0.012, 0.04  # of that: margin of the hole, and blur of what is made up


def find_colours(surface: Surface, solid: Solid, rgb: np.ndarray, radius: float) -> np.ndarray:
    """The photo's colours in front, those within the outline at the sides, and out of focus behind.

    Args:
        surface: Points on the solid.
        solid: The solid.
        rgb: The photo on the solid's grid, in [0, 1], shape (h, w, 3).
        radius: Standard deviation of the Gaussians that are to show it [steps].

    Returns:
        Colours in [0, 1], shape (n, 3).
    """
    mask = solid.mask
    inner = ndimage.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1] > RIM  # type: ignore[index]
    if not inner.any():
        inner = mask
    at = ndimage.distance_transform_edt(~inner, return_distances=False, return_indices=True)
    clean = rgb[tuple(np.asarray(at))]
    clean = np.clip(2 * clean - _blur(clean, radius), 0, 1)  # Gaussians of that size blur the picture again
    sigma = BACK_BLUR * max(np.ptp(np.argwhere(mask), axis=0))
    cover = np.repeat(mask[..., None].astype(float), 3, axis=2)
    blurred = _blur(clean * cover, sigma) / np.maximum(_blur(cover, sigma), 1e-3)
    column, row = (
        np.clip(np.rint(surface.places[:, axis]).astype(int), 0, mask.shape[1 - axis] - 1) for axis in (0, 1)
    )
    behind = surface.places[:, 2] - solid.middle[row, column]
    share = np.clip(behind / (TURNED * max(behind.max(), 1e-9)), 0, 1)[:, None]
    return share * blurred[row, column] + (1 - share) * clean[row, column]


def _blur(rgb: np.ndarray, sigma: float) -> np.ndarray:
    return ndimage.gaussian_filter(rgb, (sigma, sigma, 0))


def fill_hole(rgb: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The photo without the object: the hole is filled from its edge (Telea 2004), on a reduced picture."""
    scale = min(1.0, PLATE / max(mask.shape))
    size = [max(round(side * scale), 2) for side in mask.shape[1::-1]]
    margin = max(round(FRINGE * max(size)), 1)
    hole = (shrink(mask.astype(np.float32), size) > 0).astype(np.uint8)
    hole = np.asarray(cv2.dilate(hole, np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)))
    filled = cv2.inpaint(shrink(rgb, size), hole, 3, cv2.INPAINT_TELEA)
    depth = ndimage.distance_transform_edt(hole)
    deep = np.clip(np.asarray(depth) / (SOFT * max(size)), 0, 1)[..., None]
    soft = cv2.GaussianBlur(
        filled, (0, 0), SOFT * max(size)
    )  # streaks that meet in the middle are no picture
    filled = (deep * soft + (1 - deep) * filled).astype(np.float32)
    large = cv2.resize(filled, mask.shape[::-1], interpolation=cv2.INTER_CUBIC)
    share = cv2.resize(hole.astype(np.float32), mask.shape[::-1], interpolation=cv2.INTER_LINEAR)[..., None]
    return np.rint(share * large + (1 - share) * rgb).astype(np.uint8)


def shrink(values: np.ndarray, size: list[int]) -> np.ndarray:
    """An array (h, w, ...) at another width and height, averaged over areas."""
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA))
