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
from physagent_jax.scene.photo.foreground import find_foreground
from physagent_jax.scene.photo.picture import ASSUMED_FOCAL, MOST_BYTES, Picture, read_picture
from physagent_jax.scene.photo.solid import STEEP, Solid, Surface, find_surface, inflate
from physagent_jax.scene.surfels import make_surfels

FRONT = 30_000  # points that the camera sees at most
RADIUS = 0.55  # standard deviation over the spacing of points
RIM = 2.0  # [steps] from the outline, up to where colours are mixed with the background's
BACK_BLUR = 0.04  # of the mask's longer side: the back shows the front's colours, out of focus,
TURNED = 0.5  # of the depth behind the middle, from where on all of it is
MOST_RELIEF = 1.0  # of the mask's longer side, by which a depth that is given may reach to and fro
PLATE = 400  # [px] longer side at which the hole behind the object is filled
FRINGE, SOFT = 0.012, 0.04  # of that: margin of the hole, and blur of what is made up


@dataclasses.dataclass(frozen=True)
class Lifted:
    """What a photo gives.

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
    focal = find_focal(picture, photo) * max(mask.shape)
    step = max(float(np.sqrt(mask.sum() / FRONT)), 1.0)
    size = [max(round(side / step), 2) for side in mask.shape[1::-1]]
    steps = np.array([mask.shape[1] / size[0], mask.shape[0] / size[1]])  # [px] along columns and rows
    small = _shrink(mask.astype(np.float32), size) > 0.5
    square = inflate(small)
    middle, depth = np.zeros_like(square), None
    if photo.depth_path is not None:
        depth = _shrink(_read_depth(base_dir / photo.depth_path, mask), size)
        relief = focal / steps[0] * (depth / np.median(depth[small]) - 1)
        most = MOST_RELIEF * max(np.ptp(np.argwhere(small), axis=0))
        middle = np.where(small, np.clip(relief, -most, most) + np.sqrt(square), 0.0)
    surface = find_surface(Solid(small, square, middle))
    turn = _find_turn(0.0 if depth is not None else photo.elevation_degrees)
    points, sizes = _unproject(surface, steps, mask.shape, focal, turn)
    if depth is not None:
        turn = _find_turn(photo.elevation_degrees)
        points = points @ _find_turn(0.0).T @ turn
    points = _stand(points, surface)
    normals = surface.normals @ turn
    cloud = _make_discs(
        points,
        normals / np.linalg.norm(normals, axis=1, keepdims=True),
        RADIUS * surface.spacing * sizes,
        np.where(surface.front, 1 / np.maximum(np.abs(surface.normals[:, 2]), STEEP), 1.0),
        turn[2],
        _find_colours(surface, _shrink(picture.rgb.astype(np.float32) / 255, size), small, middle),
    )
    height, width = mask.shape
    notes = _explain(picture, photo, mask)
    return Lifted(cloud, turn, focal / height, width / height, _fill_hole(picture.rgb, mask), mask, notes)


def _make_discs(
    points: np.ndarray,
    normals: np.ndarray,
    radius: np.ndarray,
    stretch: np.ndarray,
    forward: np.ndarray,
    rgb: np.ndarray,
) -> GaussianCloud:
    """Discs in the surface, drawn out along the slope so that one pixel of the photo is one pixel of them.

    Args:
        points: Centres, shape (n, 3).
        normals: Unit normals, shape (n, 3).
        radius: Standard deviations across the slope, shape (n,).
        stretch: Factors of those along it, shape (n,).
        forward: The camera's direction, along which the slope runs, shape (3,).
        rgb: Colours in [0, 1], shape (n, 3).
    """
    across = np.cross(normals, forward)
    level = np.linalg.norm(across, axis=1) < 1e-6
    across[level] = np.cross(normals[level], [1.0, 0.3, 0.2])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    frames = np.stack([np.cross(across, normals), across, normals], axis=2)
    quats = Rotation.from_matrix(frames).as_quat(scalar_first=True)
    cloud = make_surfels(points, normals, radius, rgb)
    scales = np.asarray(cloud.scales) * np.stack(
        [stretch, np.ones_like(stretch), np.ones_like(stretch)], axis=1
    )
    return dataclasses.replace(
        cloud, quats=to_device(quats, np.float32), scales=to_device(scales, np.float32)
    )


def find_focal(picture: Picture, photo: Photo) -> float:
    """The focal length over the longer side: as it was given, else as EXIF data tell it, else assumed."""
    if photo.fov_degrees is not None:
        return 0.5 / np.tan(0.5 * np.radians(photo.fov_degrees))
    return picture.focal or ASSUMED_FOCAL


def _shrink(values: np.ndarray, size: list[int]) -> np.ndarray:
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA))


def _read_depth(path: Path, mask: np.ndarray) -> np.ndarray:
    """The depth at each pixel, holes in it filled from the nearest pixel of the object."""
    depth = read_npy(path, most=MOST_BYTES, what="the image's depth")
    if depth.ndim != 2 or depth.dtype.kind != "f":
        raise UserError(f"{shorten(path)} is no depth of each pixel", got=f"{depth.dtype}, {depth.shape}")
    fitted = np.asarray(
        cv2.resize(depth.astype(np.float32), mask.shape[::-1], interpolation=cv2.INTER_NEAREST)
    )
    known = mask & np.isfinite(fitted) & (fitted > 0)
    if not known.any():
        raise UserError(
            "the image's depth says nothing of the object", do="Choose another estimator, or none"
        )
    at = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    return fitted[tuple(np.asarray(at))]


def _find_turn(elevation: float) -> np.ndarray:
    """From (right, away, up) to (right, down, forward) of a camera that looks down by ``elevation`` [degrees]."""
    sin, cos = np.sin(np.radians(elevation)), np.cos(np.radians(elevation))
    return np.array([[1, 0, 0], [0, -sin, -cos], [0, cos, -sin]])


def _unproject(
    surface: Surface, steps: np.ndarray, shape: tuple[int, int], focal: float, turn: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Points in the frame of this module, shape (n, 3), and the length of a step there, shape (n,).

    The middle of the solid stands upright, at the distance of the focal length on the optical axis; depth runs along
    the rays, so that each point stays on its pixel.
    """
    height, width = shape
    pixels = (surface.places[:, :2] + 0.5) * steps
    rays = np.column_stack([(pixels - [width / 2, height / 2]) / focal, np.ones(len(pixels))]) @ turn
    upright = turn[2, 1] / np.maximum(rays[:, 1], 0.05)
    scale = upright * (1 + surface.places[:, 2] * steps[0] / focal)
    return rays * (focal * scale)[:, None], np.abs(scale) * steps.mean()


def _stand(points: np.ndarray, surface: Surface) -> np.ndarray:
    """The points with a level foot: what lies behind the front's lowest point, and lower, is hidden by it."""
    lowest = points[surface.front, 2].min()
    points = points.copy()
    points[:, 2] = np.maximum(points[:, 2], lowest)
    return points


def _find_colours(surface: Surface, rgb: np.ndarray, mask: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Colours in [0, 1], shape (n, 3): the photo's in front, those within the outline at the sides, blurred behind."""
    inner = ndimage.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1] > RIM  # type: ignore[index]
    if not inner.any():
        inner = mask
    at = ndimage.distance_transform_edt(~inner, return_distances=False, return_indices=True)
    clean = rgb[tuple(np.asarray(at))]
    clean = np.clip(2 * clean - _blur(clean, RADIUS), 0, 1)  # Gaussians of that size blur the picture again
    sigma = BACK_BLUR * max(np.ptp(np.argwhere(mask), axis=0))
    cover = np.repeat(mask[..., None].astype(float), 3, axis=2)
    blurred = _blur(clean * cover, sigma) / np.maximum(_blur(cover, sigma), 1e-3)
    column, row = (
        np.clip(np.rint(surface.places[:, axis]).astype(int), 0, mask.shape[1 - axis] - 1) for axis in (0, 1)
    )
    behind = surface.places[:, 2] - middle[row, column]
    share = np.clip(behind / (TURNED * max(behind.max(), 1e-9)), 0, 1)[:, None]
    return share * blurred[row, column] + (1 - share) * clean[row, column]


def _blur(rgb: np.ndarray, sigma: float) -> np.ndarray:
    return ndimage.gaussian_filter(rgb, (sigma, sigma, 0))


def _fill_hole(rgb: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The photo without the object: the hole is filled from its edge (Telea 2004), on a reduced picture."""
    scale = min(1.0, PLATE / max(mask.shape))
    size = [max(round(side * scale), 2) for side in mask.shape[1::-1]]
    margin = max(round(FRINGE * max(size)), 1)
    hole = (_shrink(mask.astype(np.float32), size) > 0).astype(np.uint8)
    hole = np.asarray(cv2.dilate(hole, np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)))
    filled = cv2.inpaint(_shrink(rgb, size), hole, 3, cv2.INPAINT_TELEA)
    depth = ndimage.distance_transform_edt(hole)
    deep = np.clip(np.asarray(depth) / (SOFT * max(size)), 0, 1)[..., None]
    soft = cv2.GaussianBlur(
        filled, (0, 0), SOFT * max(size)
    )  # streaks that meet in the middle are no picture
    filled = (deep * soft + (1 - deep) * filled).astype(np.float32)
    large = cv2.resize(filled, mask.shape[::-1], interpolation=cv2.INTER_CUBIC)
    share = cv2.resize(hole.astype(np.float32), mask.shape[::-1], interpolation=cv2.INTER_LINEAR)[..., None]
    return np.rint(share * large + (1 - share) * rgb).astype(np.uint8)


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
