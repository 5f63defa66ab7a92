"""Colours of surfaces: textures, vertex and face colours and factors, evaluated at points of faces."""

from __future__ import annotations

import dataclasses
import io
import warnings
from typing import Any, Literal

import numpy as np

from physagent_jax.core.errors import UserError

Wrap = Literal["repeat", "mirror", "clamp"]

_MOST_PIXELS = 2**26  # 8192 squared; as RGBA bytes a quarter of a gigabyte


@dataclasses.dataclass(frozen=True)
class Texture:
    """A picture on a surface.

    Attributes:
        pixels: RGBA in sRGB with straight alpha, first row on top, uint8, shape (h, w, 4).
        uv: Texture coordinates of the vertices, V downwards from the first row, shape (n, 2). What is not finite is
            read as 0, with a warning.
        wrap: Continuation of the picture beyond 0 and 1 along U and V.
    """

    pixels: np.ndarray
    uv: np.ndarray
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")

    def __post_init__(self):
        if bad := int((~np.isfinite(self.uv)).any(axis=1).sum()):
            warnings.warn(
                f"{bad:,} texture coordinates of the mesh are not finite: they are read as 0", stacklevel=2
            )

    def sample(self, uv: np.ndarray) -> np.ndarray:
        """RGBA of the texels in [0, 1] at ``uv``, shape (k, 4)."""
        index = [_find_texels(uv[:, axis], self.wrap[axis], self.pixels.shape[1 - axis]) for axis in range(2)]
        return self.pixels[index[1], index[0]] / 255


@dataclasses.dataclass(frozen=True)
class Look:
    """The declared colours of a surface; all that are given are multiplied in linear light.

    Attributes:
        factor: RGBA of the whole surface, shape (4,).
        vertex_colours: RGBA of the vertices, shape (n, 4).
        face_colours: RGBA of the faces, shape (m, 4).
        texture: Picture on the surface.
        linear: Whether factor, vertex and face colours are linear light, as in glTF, rather than sRGB.
        cutoff: Alpha below which a point is not there; None = alpha means nothing.
        blended: Whether alpha is the share of light that the surface stops where it is there; False = all.
    """

    factor: np.ndarray | None = None
    vertex_colours: np.ndarray | None = None
    face_colours: np.ndarray | None = None
    texture: Texture | None = None
    linear: bool = False
    cutoff: float | None = None
    blended: bool = False

    def evaluate(self, corners: np.ndarray, faces: np.ndarray, bary: np.ndarray) -> np.ndarray:
        """RGBA in sRGB at points of faces, shape (k, 4).

        Args:
            corners: Vertices of each point's face, int, shape (k, 3).
            faces: Face of each point, int, shape (k,).
            bary: Barycentric coordinates of each point, shape (k, 3).
        """
        colour = np.ones((len(faces), 4))
        given = []
        if self.factor is not None:
            given.append(np.broadcast_to(self.factor, colour.shape))
        if self.vertex_colours is not None:
            given.append(_interpolate(self.vertex_colours, corners, bary))
        if self.face_colours is not None:
            given.append(self.face_colours[faces])
        for each in given:
            colour = colour * (each if self.linear else _with_rgb(each, decode_srgb(each[:, :3])))
        if self.texture is not None:
            texels = self.texture.sample(_interpolate(self.texture.uv, corners, bary))
            colour = colour * _with_rgb(texels, decode_srgb(texels[:, :3]))
        return np.clip(_with_rgb(colour, encode_srgb(np.clip(colour[:, :3], 0, 1))), 0, 1)


def decode_srgb(value: np.ndarray) -> np.ndarray:
    """Linear light of sRGB values in [0, 1] (IEC 61966-2-1)."""
    value = np.asarray(value, np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((np.maximum(value, 0) + 0.055) / 1.055) ** 2.4)


def encode_srgb(value: np.ndarray) -> np.ndarray:
    """sRGB values of linear light in [0, 1] (IEC 61966-2-1)."""
    value = np.asarray(value, np.float64)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * np.maximum(value, 0) ** (1 / 2.4) - 0.055)


def read_pixels(data: bytes | Any) -> np.ndarray:
    """Decode a picture as RGBA, uint8, shape (h, w, 4).

    Args:
        data: Bytes of a file, or a picture that PIL has opened.

    Raises:
        UserError: The data is no picture, or has too many pixels.
    """
    from PIL import Image

    try:
        image: Any = Image.open(io.BytesIO(data)) if isinstance(data, bytes) else data
        size = image.width * image.height
        if size > _MOST_PIXELS:
            raise UserError("a texture is too large", got=f"{size:,} pixels, at most {_MOST_PIXELS:,}")
        if image.mode.startswith("I;16"):  # PIL clips sixteen bits rather than scaling them
            grey = (np.asarray(image).astype(np.uint32) >> 8).astype(np.uint8)
            image = Image.fromarray(grey)
        return np.asarray(image.convert("RGBA"))
    except UserError:
        raise
    except Exception as error:  # PIL's decoders raise whatever they meet
        raise UserError("a texture cannot be decoded", got=f"{type(error).__name__}: {error}") from None


def as_rgba(colours: np.ndarray) -> np.ndarray:
    """RGBA in [0, 1], shape (n, 4), of colours with or without alpha, shape (n, 3) or (n, 4).

    Integers span the range of their type. Floating-point values above 1 are taken to span 0 to 255. Values that are not
    finite become black, with a warning.
    """
    colours = np.asarray(colours)
    if colours.dtype.kind in "ui":
        values = colours / np.iinfo(colours.dtype).max
    else:
        values = colours.astype(np.float64)
        if bad := int((~np.isfinite(values)).any(axis=1).sum()):
            warnings.warn(f"{bad:,} colours of the mesh are not finite: they are drawn black", stacklevel=2)
        values = np.nan_to_num(values, nan=0.0, posinf=1.0, neginf=0.0)
        if values.size and values.max() > 1:
            values = values / 255
    values = np.clip(values, 0, 1)
    return values if values.shape[1] == 4 else np.concatenate([values, np.ones((len(values), 1))], axis=1)


def _interpolate(values: np.ndarray, corners: np.ndarray, bary: np.ndarray) -> np.ndarray:
    return (bary[:, :, None] * values[corners]).sum(axis=1)


def _with_rgb(rgba: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    return np.concatenate([rgb, rgba[:, 3:]], axis=1)


def _find_texels(coordinate: np.ndarray, wrap: Wrap, count: int) -> np.ndarray:
    """Indices of texels along one axis."""
    coordinate = np.nan_to_num(coordinate, nan=0.0, posinf=0.0, neginf=0.0)
    if wrap == "clamp":
        within = np.clip(coordinate, 0, 1)
    elif wrap == "mirror":
        within = 1 - np.abs(coordinate % 2 - 1)
    else:
        within = coordinate % 1
    return np.minimum((within * count).astype(int), count - 1)
