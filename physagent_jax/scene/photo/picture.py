"""Photos as arrays: read upright, reduced, with the lens that their EXIF data tell."""

from __future__ import annotations

import dataclasses
import io
import math
from pathlib import Path

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import read_bytes, shorten

MOST_BYTES = 256 * 2**20
MOST_PIXELS = 100_000_000
LONGEST = 1280  # [px]; larger photos are reduced: the video is no larger
ASSUMED_FOCAL = 1.2  # focal length over the longer side where nothing tells it (COLMAP's default)
_FULL_FRAME = math.hypot(
    36, 24
)  # [mm], the diagonal that "35 mm equivalent" speaks of (EXIF 2.3, CIPA DCG-001)
_EXIF, _EQUIVALENT = 0x8769, 0xA405
_MARKS = (b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"BM", b"II*\0", b"MM\0*", b"GIF8")


@dataclasses.dataclass(frozen=True)
class Picture:
    """A photo.

    Attributes:
        rgb: Its colours, uint8, shape (h, w, 3), the longer side at most `LONGEST`.
        size: Width and height of the file's picture, upright [px].
        name: The file, for messages.
        focal: Focal length over the longer side, as EXIF data tell it; None = they do not.
    """

    rgb: np.ndarray
    size: tuple[int, int]
    name: str
    focal: float | None


def is_picture(head: bytes) -> bool:
    """Return whether a file that begins with ``head`` is a picture: PNG, JPEG, WebP, BMP, TIFF or GIF."""
    return head.startswith(_MARKS) or (head[:4] == b"RIFF" and head[8:12] == b"WEBP")


def read_picture(path: Path) -> Picture:
    """Read a photo.

    Raises:
        UserError: The file is no picture that can be read, or too large.
    """
    from PIL import Image, ImageOps

    data = read_bytes(path, most=MOST_BYTES, what="the image")
    try:
        picture = Image.open(io.BytesIO(data))
        if picture.width * picture.height > MOST_PIXELS:
            got = f"{picture.width} x {picture.height} pixels"
            raise UserError(f"the image {shorten(path)} is too large", got=got, do="Reduce it")
        focal = _find_focal(picture)
        upright = ImageOps.exif_transpose(picture).convert("RGBA")
    except (OSError, ValueError, SyntaxError, EOFError, Image.DecompressionBombError) as error:
        raise UserError(
            f"{shorten(path)} is no image that can be read",
            got=shorten(error),
            do="Give a PNG, JPEG, WebP, BMP or TIFF file",
        ) from None
    size, reduced = upright.size, upright
    if max(size) > LONGEST:
        shrunk = (max(round(side * LONGEST / max(size)), 1) for side in size)
        reduced = upright.resize((next(shrunk), next(shrunk)), Image.Resampling.LANCZOS)
    white = Image.new("RGBA", reduced.size, (255, 255, 255, 255))
    return Picture(
        np.asarray(Image.alpha_composite(white, reduced).convert("RGB")), size, shorten(path), focal
    )


def _find_focal(picture) -> float | None:
    """The focal length over the longer side, from the 35 mm equivalent in EXIF data."""
    equivalent = picture.getexif().get_ifd(_EXIF).get(_EQUIVALENT)
    try:
        focal = float(equivalent) / _FULL_FRAME * math.hypot(*picture.size) / max(picture.size)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return focal if 0.2 < focal < 50 else None
