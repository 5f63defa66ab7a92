"""A run's photo before it is lifted: what models find in it is kept in files, so that a scene can be replayed."""

from __future__ import annotations

import hashlib
from pathlib import Path

import cv2
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import replace_file
from physagent_jax.kernels.folders import make_private_folder
from physagent_jax.perception.backends import DEPTH_ESTIMATORS, SEGMENTERS
from physagent_jax.perception.protocols import SegmentPrompt
from physagent_jax.render.camera import Camera
from physagent_jax.run.spec import Implementation, PhotoChoice, RunSpec
from physagent_jax.scene.config import Photo
from physagent_jax.scene.config.photo import ELEVATION
from physagent_jax.scene.load import is_photo, refuse_photo
from physagent_jax.scene.photo.lens import find_focal
from physagent_jax.scene.photo.picture import Picture, read_picture

MIDDLE = 0.1  # of the sides, left free around the box by which a segmenter is told where the object is


def make_photo(spec: RunSpec, path: Path, sha256: str, base_dir: Path) -> Photo | None:
    """The photo of a run as a scene has it, None if its object is none; the models that the spec names are asked here.

    Args:
        spec: The run.
        path: The object's file.
        sha256: Hash of its file.
        base_dir: Folder that relative paths start from.

    Raises:
        UserError: It is no picture and should be one, or a model cannot be asked.
    """
    if not is_photo(path):
        return None if spec.object.photo is None else refuse_photo(path)
    if spec.object.up not in (None, "+z"):
        raise UserError("`object.up` means nothing for an image", got=spec.object.up, do="Leave it out")
    choice = spec.object.photo or PhotoChoice()
    stated = (choice.elevation_degrees, spec.camera.elevation_degrees, ELEVATION)
    photo = Photo(
        box=choice.box,
        mask_path=None if choice.mask_path is None else str((base_dir / choice.mask_path).resolve()),
        fov_degrees=choice.fov_degrees,
        elevation_degrees=next(each for each in stated if each is not None),
    )
    segmenter, depth = choice.segmenter, choice.depth
    if segmenter is None and depth is None:
        return photo
    picture, found = read_picture(path), {}
    if segmenter is not None:
        key = (sha256, segmenter.model_dump_json(), str(choice.box))
        found["mask_path"] = _keep(key, lambda: _segment(segmenter, picture, photo))
        found["box"] = None
    if depth is not None:
        key = (sha256, depth.model_dump_json(), str(choice.fov_degrees))
        found["depth_path"] = _keep(key, lambda: _estimate(depth, picture, photo))
    return photo.model_copy(update=found)


def _keep(key: tuple[str, ...], make) -> str:
    """The file that holds an array, made if it is not there."""
    name = hashlib.sha256("\n".join(key).encode()).hexdigest()[:24]
    path = make_private_folder("photos") / f"{name}.npy"
    if not path.is_file():
        with replace_file(path) as temporary, open(temporary, "wb") as file:
            np.save(file, make())
    return str(path)


def _segment(choice: Implementation, picture: Picture, photo: Photo) -> np.ndarray:
    """A segmenter's mask at the size of the file, bool; told of the box, or of the middle, if it can be told."""
    model = SEGMENTERS.make((choice.name, choice.options))
    height, width = picture.rgb.shape[:2]
    box = np.array([MIDDLE * width, MIDDLE * height, (1 - MIDDLE) * width, (1 - MIDDLE) * height])
    if photo.box is not None:
        if not model.takes_prompt:
            raise UserError(f"the segmenter {choice.name!r} cannot be told a box", do="Leave the box out")
        box = np.array(photo.box) * np.tile(np.divide([width, height], picture.size), 2)
    prompt = SegmentPrompt(box=box) if photo.box is not None or model.needs_prompt else None
    if prompt is not None:
        prompt.check_fit((1, height, width))
    mask = model.segment(picture.rgb[None], prompt).masks[0]
    return cv2.resize(mask.astype(np.uint8), picture.size, interpolation=cv2.INTER_NEAREST).astype(bool)


def _estimate(choice: Implementation, picture: Picture, photo: Photo) -> np.ndarray:
    """An estimator's depth of each pixel, float32."""
    height, width = picture.rgb.shape[:2]
    focal = find_focal(picture, photo) * max(width, height)
    K = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    camera = Camera(np.eye(4), K, width, height)
    model = DEPTH_ESTIMATORS.make((choice.name, choice.options))
    return np.asarray(model.estimate(picture.rgb[None], camera, None).z[0], np.float32)
