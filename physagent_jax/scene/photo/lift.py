"""A photo lifted to Gaussians: the object's front in its own colours, and all else made up.

The frame of what is lifted: x to the right, y away, z up; the camera is at zero, and a unit is a pixel at the object's
middle. So the placement of the object in a scene places the camera as well.
"""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import cv2
import numpy as np
from scipy import ndimage
from scipy.spatial.transform import Rotation

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.core.npy import read_npy
from physagent_jax.core.reading import shorten
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.config.photo import Photo
from physagent_jax.scene.photo.colours import fill_hole, find_colours, shrink
from physagent_jax.scene.photo.foreground import find_foreground
from physagent_jax.scene.photo.lens import STEEPEST, Lens, find_focal
from physagent_jax.scene.photo.picture import MOST_BYTES, Picture, read_picture
from physagent_jax.scene.photo.solid import STEEP, Solid, Surface, find_surface, inflate
from physagent_jax.scene.surfels import FLATNESS, OPAQUE, SH_DC

FRONT = 30_000  # points that the camera sees at most
RADIUS = 0.55  # standard deviation over the spacing of points
LEAST_DEPTH = 1e-9  # in any unit; less is no depth, nor is more than its inverse
MOST_RELIEF = 1.0  # of the mask's longer side, by which a depth that is given may reach to and fro


@dataclasses.dataclass(frozen=True)
class Lifted:
    """The object in a photo, lifted, and what is left of the photo.

    Attributes:
        cloud: Gaussians in the frame of this module.
        turn: From that frame to the camera's (x right, y down, z forward), shape (3, 3).
        focal: Focal length over the height of the picture.
        aspect: Width over height of the picture.
        plate: The photo with the hole behind the object filled, uint8, shape (h, w, 3).
        mask: The object, bool, shape (h, w).
        notes: What was assumed and made up, a sentence each.
    """

    cloud: GaussianCloud
    turn: np.ndarray
    focal: float
    aspect: float
    plate: np.ndarray
    mask: np.ndarray
    notes: tuple[str, ...]


def lift_photo(path: Path, photo: Photo, base_dir: Path) -> Lifted:
    """Lift the object in a photo to Gaussians.

    Args:
        path: The photo.
        photo: How to do it.
        base_dir: Folder that relative paths start from.

    Raises:
        UserError: It is no picture, or shows no object that can be lifted.
    """
    named = [base_dir / each for each in (path, photo.mask_path, photo.depth_path) if each is not None]
    stamps = tuple((stat.st_size, stat.st_mtime_ns) for stat in (_find_stat(each) for each in named))
    return _lift_cached(base_dir / path, photo.model_dump_json(), base_dir, stamps)


def _find_stat(path: Path):
    try:
        return path.stat()
    except OSError as error:
        raise UserError(f"cannot read {shorten(path)}", got=error.strerror, do="Check the path") from None


@functools.lru_cache(maxsize=2)
def _lift_cached(path: Path, photo: str, base_dir: Path, stamps: tuple) -> Lifted:
    """Lifting of a file that is known by its stamps: a run reads its object several times."""
    return _lift(read_picture(path), Photo.model_validate_json(photo), base_dir)


def _lift(picture: Picture, photo: Photo, base_dir: Path) -> Lifted:
    mask = find_foreground(picture, photo, base_dir)
    height, width = mask.shape
    focal = find_focal(picture, photo) * max(mask.shape)
    step = max(float(np.sqrt(mask.sum() / FRONT)), 1.0)
    size = [max(round(side / step), 2) for side in (width, height)]
    steps = np.array([width / size[0], height / size[1]])
    small = shrink(mask.astype(np.float32), size) > 0.5
    square = inflate(small)
    lean = max(photo.elevation_degrees - STEEPEST, 0.0)
    middle = np.zeros_like(square)
    if photo.depth_path is not None:
        depth = shrink(_read_depth(base_dir / photo.depth_path, mask), size)
        relief = focal / steps[0] * (depth / np.median(depth[small]) - 1)
        most = MOST_RELIEF * max(np.ptp(np.argwhere(small), axis=0))
        middle = np.where(small, np.clip(relief, -most, most) + np.sqrt(square), 0.0)
        lean = photo.elevation_degrees
    lens, solid = Lens(focal, mask.shape, steps, photo.elevation_degrees, lean), Solid(small, square, middle)
    surface = find_surface(solid)
    rgb = find_colours(surface, solid, shrink(picture.rgb.astype(np.float32) / 255, size), RADIUS)
    notes, plate = _explain(picture, photo, mask), fill_hole(picture.rgb, mask)
    return Lifted(
        _make_discs(surface, lens, rgb), lens.turn, focal / height, width / height, plate, mask, notes
    )


def _make_discs(surface: Surface, lens: Lens, rgb: np.ndarray) -> GaussianCloud:
    """Discs in the surface, one pixel of the photo each where the camera sees them.

    They are laid out on the grid, drawn out along the slope there, and brought into the frame by the derivatives of
    the way there. What lies behind the front's lowest point, and lower, is raised to it: the foot is level.
    """
    normals, count = surface.normals, len(surface.normals)
    across = np.cross(normals, [0.0, 0.0, 1.0])
    across[np.linalg.norm(across, axis=1) < 1e-6] = [1.0, 0.0, 0.0]
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(across, normals)
    radius = RADIUS * surface.spacing
    stretch = np.where(surface.front, 1 / np.maximum(np.abs(normals[:, 2]), STEEP), 1.0)
    axes = np.stack([stretch[:, None] * along, across, FLATNESS * normals], axis=2) * radius[:, None, None]
    frames, scales, _ = np.linalg.svd(lens.find_derivatives(surface.places) @ axes)
    frames[:, :, 2] *= np.linalg.det(frames)[:, None]
    points = lens.unproject(surface.places)
    points[:, 2] = np.maximum(points[:, 2], points[surface.front, 2].min())
    return GaussianCloud(
        means=to_device(points, np.float32),
        quats=to_device(Rotation.from_matrix(frames).as_quat(scalar_first=True), np.float32),
        scales=to_device(scales, np.float32),
        opacities=to_device(np.full(count, OPAQUE), np.float32),
        sh=to_device(((np.clip(rgb, 0, 1) - 0.5) / SH_DC)[:, None, :], np.float32),
    )


def _read_depth(path: Path, mask: np.ndarray) -> np.ndarray:
    """The depth at each pixel, holes in it filled from the nearest pixel of the object."""
    depth = read_npy(path, most=MOST_BYTES, what="the image's depth")
    if depth.ndim != 2 or depth.dtype.kind != "f":
        raise UserError(f"{shorten(path)} is no depth of each pixel", got=f"{depth.dtype}, {depth.shape}")
    depth = np.where((depth > LEAST_DEPTH) & (depth < 1 / LEAST_DEPTH), depth, 0).astype(np.float32)
    fitted = np.asarray(cv2.resize(depth, mask.shape[::-1], interpolation=cv2.INTER_NEAREST))
    known = mask & (fitted > 0)
    if not known.any():
        raise UserError(
            "the image's depth says nothing of the object", do="Choose another estimator, or none"
        )
    at = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    return fitted[tuple(np.asarray(at))]


def _explain(picture: Picture, photo: Photo, mask: np.ndarray) -> tuple[str, ...]:
    """Sentences on what was found, assumed and made up."""
    how = "by its mask" if photo.mask_path else "within the box" if photo.box else "as what stands out"
    lens = "from its EXIF data" if picture.focal else "assumed"
    lens = lens if photo.fov_degrees is None else "as given"
    angle = 2 * np.degrees(np.arctan(0.5 / find_focal(picture, photo)))
    shape = "its depth is estimated" if photo.depth_path else "its depth is made up, from its outline"
    notes = [
        f"the object was cut out of the photo {how}: {mask.mean():.0%} of the picture",
        f"one photo shows one side of an object: {shape}; its back, with the front's colours, what is hidden, and its "
        "size (longest side 1 m) are made up, and so is the picture behind it",
        f"the photo's camera is taken to have a field of view of {angle:.0f} degrees along the longer side ({lens}) "
        f"and to look from {photo.elevation_degrees:g} degrees above the horizon (`camera.elevation_degrees`)",
    ]
    cut = [name for name, edge in _list_edges(mask) if edge.any()]
    if cut:
        notes.append(
            f"the object is cut off by the photo's edge ({', '.join(cut)}): it ends there in the scene too"
        )
    return tuple(notes)


def _list_edges(mask: np.ndarray) -> list[tuple[str, np.ndarray]]:
    return [("top", mask[0]), ("bottom", mask[-1]), ("left", mask[:, 0]), ("right", mask[:, -1])]
