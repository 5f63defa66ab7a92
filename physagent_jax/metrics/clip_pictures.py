"""Pictures as a CLIP model is shown them: resized, cropped and normalised, all of it differentiable.

The resizing is Pillow's bicubic one: Keys' kernel with a = -1/2, widened where it shrinks, columns first and then rows,
cut to [0, 1] after each. Pillow also rounds to whole colours after each. That has no derivative: pictures of 8 bits are
rounded likewise, others are not.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import jax
import jax.numpy as jnp
from pydantic import BaseModel, ConfigDict, PositiveInt, ValidationError, ValidationInfo, field_validator

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error, read_json
from physagent_jax.core.strict import Positive

_FILES = ("preprocessor_config.json", "processor_config.json")  # the second is of newer versions


class Preparation(BaseModel):
    """The steps of `preprocessor_config.json`; the defaults are those of OpenAI's models.

    Attributes:
        size: Length of the shorter side after resizing [px], or height and width.
        crop_size: Height and width of the middle that is cut out [px].
        image_mean, image_std: Mean and standard deviation of each colour over the pictures that the model has seen.
        resample, do_resize, do_center_crop, do_rescale, do_normalize: Only as all CLIP models have them.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")
    size: PositiveInt | tuple[PositiveInt, PositiveInt] = 224
    crop_size: tuple[PositiveInt, PositiveInt] = (224, 224)
    image_mean: tuple[float, float, float] = (0.48145466, 0.4578275, 0.40821073)
    image_std: tuple[Positive, Positive, Positive] = (0.26862954, 0.26130258, 0.27577711)
    resample: Literal[3] = 3  # Pillow's number of its bicubic kernel
    do_resize: Literal[True] = True
    do_center_crop: Literal[True] = True
    do_rescale: Literal[True] = True
    do_normalize: Literal[True] = True

    @field_validator("size", "crop_size", mode="before")
    @classmethod
    def _read_size(cls, value: Any, info: ValidationInfo) -> Any:
        """The size of what the file has: a number, or the shorter side or both sides by name."""
        if isinstance(value, dict):
            value = value.get("shortest_edge") or (value.get("height"), value.get("width"))
        return (value, value) if info.field_name == "crop_size" and isinstance(value, int) else value

    @staticmethod
    def read(folder: Path, image_size: int) -> Preparation:
        """The preparation that a folder asks for; OpenAI's, at the model's size, where it does not say.

        Raises:
            UserError: It asks for steps that there are not.
        """
        path = next((folder / name for name in _FILES if (folder / name).is_file()), None)
        said = {} if path is None else read_json(path)
        said = said.get("image_processor", said) if isinstance(said, dict) else said
        if not isinstance(said, dict):
            raise UserError(f"{path} is no preparation of pictures", got=type(said).__name__)
        try:
            made = Preparation.model_validate(dict(size=image_size, crop_size=image_size) | said)
        except ValidationError as error:
            raise format_validation_error(error, str(path), do="Take a CLIP model's own file") from None
        least = made.size if isinstance(made.size, int) else min(made.size)
        if made.crop_size != (image_size, image_size) or least < image_size:
            raise UserError(
                f"{path} does not make pictures of the model's size, {image_size}",
                got=f"{made.crop_size} of {made.size}",
            )
        return made


def prepare(rgb: jax.Array, how: Preparation) -> jax.Array:
    """Pictures for `ClipModel.encode_pictures`, shape (T, *crop_size, 3).

    Args:
        rgb: uint8, or colours in [0, 1], shape (T, height, width, 3).
        how: The model's own preparation.
    """
    most = 255.0 if (whole := rgb.dtype == jnp.uint8) else 1.0
    rgb = rgb.astype(jnp.float32) if whole else rgb
    height, width = find_size(rgb.shape[1], rgb.shape[2], how.size)
    for axis, length in ((2, width), (1, height)):  # Pillow's order
        shape = tuple(length if at == axis else side for at, side in enumerate(rgb.shape))
        rgb = jnp.clip(jax.image.resize(rgb, shape, "cubic", antialias=True), 0.0, most)
        rgb = jnp.floor(rgb + 0.5) if whole else rgb
    rgb = crop(rgb, *how.crop_size) / most
    return (rgb - jnp.asarray(how.image_mean, rgb.dtype)) / jnp.asarray(how.image_std, rgb.dtype)


def find_size(height: int, width: int, size: int | tuple[int, int]) -> tuple[int, int]:
    """Height and width after resizing: the longer side is cut to whole pixels, as the reference does."""
    if not isinstance(size, int):
        return size
    shorter = min(height, width)
    return int(size * height / shorter), int(size * width / shorter)


def crop(rgb: jax.Array, height: int, width: int) -> jax.Array:
    """The middle of pictures."""
    top, left = (rgb.shape[1] - height) // 2, (rgb.shape[2] - width) // 2
    return rgb[:, top : top + height, left : left + width]
