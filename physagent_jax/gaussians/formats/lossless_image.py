"""Images whose pixels are data: sizes are checked before anything is decoded, and lossy ones are refused."""

from __future__ import annotations

import struct

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten

_PNG = b"\x89PNG\r\n\x1a\n"


def decode_image(data: bytes, shown: str, *, least: int, most: int, flat: bool = True) -> np.ndarray:
    """Decode a lossless WebP or a PNG of 8 bits.

    Args:
        data: The file.
        shown: The image, for messages.
        least: Number of pixels that it must have.
        most: Number of pixels that it may have.
        flat: Whether the pixels are given in one row.

    Returns:
        Red, green, blue and opacity (255 where there is none), uint8 of shape (pixels, 4) or (rows, columns, 4).

    Raises:
        UserError: It is of another kind, lossily compressed, damaged, or of another size.
    """
    width, height = _read_size(data, shown)
    if not least <= width * height <= most:
        raise UserError(
            f"{shown} has a size that does not fit the Gaussians",
            got=f"{width} x {height} pixels, {least:,} to {most:,} are expected",
            do="Export the scene again",
        )
    image = _decode_quietly(data, shown)
    if image is None or image.dtype != np.uint8 or image.shape[:2] != (height, width):
        raise _explain_damage(shown, "no image of 8 bits")
    if image.ndim != 3 or image.shape[2] not in (3, 4):
        raise _explain_damage(shown, "an image without colours")
    rgba = np.full((height, width, 4), 255, np.uint8)
    rgba[..., : image.shape[2]] = image
    rgba[..., :3] = image[..., 2::-1]
    return rgba.reshape(-1, 4) if flat else rgba


def _decode_quietly(data: bytes, shown: str) -> np.ndarray | None:
    """OpenCV's decoder, whose own words on damaged files would come between those of the command."""
    import cv2  # heavy

    log = cv2.utils.logging
    level = log.setLogLevel(log.LOG_LEVEL_SILENT)
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise _explain_damage(shown, shorten(error)) from None
    finally:
        log.setLogLevel(level)


def _read_size(data: bytes, shown: str) -> tuple[int, int]:
    """Width and height in pixels, from the header."""
    if data.startswith(_PNG) and len(data) >= 24:
        return struct.unpack_from(">II", data, 16)
    if data[:4] != b"RIFF" or data[8:12] != b"WEBP":
        raise UserError(f"{shown} is no image that is read", do="Export the scene with lossless WebP images")
    at, size = 12, None
    while at + 8 <= len(data):
        kind, length = struct.unpack_from("<4sI", data, at)
        if kind == b"VP8L" and at + 13 <= len(data):
            bits = int.from_bytes(data[at + 9 : at + 13], "little")
            found = (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
            if size is not None and size != found:
                raise _explain_damage(shown, "two sizes")
            return found
        if kind == b"VP8X" and at + 18 <= len(data):
            size = tuple(
                int.from_bytes(data[at + 12 + 3 * i : at + 15 + 3 * i], "little") + 1 for i in range(2)
            )
        elif kind in (b"VP8 ", b"ANMF"):
            raise UserError(
                f"{shown} is compressed with loss, so that its values are not those of the Gaussians",
                do="Export the scene with lossless WebP images",
            )
        at += 8 + length + (length & 1)
    raise _explain_damage(shown, "no picture in the WebP")


def _explain_damage(shown: str, found: str) -> UserError:
    return UserError(f"{shown} is a damaged image", got=found, do="Copy or export the scene again")
