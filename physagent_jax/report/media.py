"""Videos and pictures inside the page, as data URIs."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import io
from pathlib import Path

import imageio.v3 as iio
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.output.video import read_video
from physagent_jax.report.formats import format_fixed
from physagent_jax.report.markup import Markup, div, join, tag

# Firefox plays no data URI above 32 MB, and base64 makes four bytes of three.
MAX_EMBEDDED_BYTES = 22 * 2**20
STRIP_FRAMES, STRIP_HEIGHT = 8, 140


def encode_data_uri(content: bytes, mime: str) -> str:
    """Bytes as a URI that needs no file."""
    return f"data:{mime};base64,{base64.b64encode(content).decode('ascii')}"


def embed_image(path: Path, alt: str) -> Markup:
    """A picture file inside the page."""
    return tag("img", src=encode_data_uri(path.read_bytes(), "image/png"), alt=alt)


@dataclasses.dataclass(frozen=True)
class Clip:
    """A video to be shown, read once.

    Attributes:
        path: The file.
        content: Its bytes.
        frame_count: How many it has.
        frames: At most `STRIP_FRAMES` evenly through it, uint8, shape (k, H, W, 3); None if they cannot be decoded.
    """

    path: Path
    content: bytes
    frame_count: int
    frames: np.ndarray | None

    @property
    def digest(self) -> str:
        """Tell equal videos, which are embedded once."""
        return hashlib.sha256(self.content).hexdigest()


def load_clip(path: Path | None) -> Clip | None:
    """Read a video; None if there is none."""
    if path is None:
        return None
    count = 0

    def choose(frame_count: int) -> list[int]:
        nonlocal count
        count = frame_count
        return _space_frames(frame_count)

    try:
        frames = read_video(path, choose)
    except UserError:
        frames = None
    return Clip(path, path.read_bytes(), count, frames)


def embed_player(
    clip: Clip,
    *,
    group: str,
    frame_dt: float | None,
    folder: Path,
    id_: str | None = None,
    same_as: str | None = None,
) -> Markup:
    """A video element.

    Args:
        clip: What to play.
        group: Which plots' cursors follow it.
        frame_dt: Seconds per frame [s].
        folder: The page's folder, against which a video too large to embed is linked.
        id_: Identifier of the element, if another is to share its video.
        same_as: Id of the player that holds the same bytes already; the script then shares them.
    """
    if clip.frames is None:
        return div("missing", f"{clip.path.name} cannot be played: it is not a finished video.")
    if same_as is not None:
        source = None
    elif len(clip.content) > MAX_EMBEDDED_BYTES:
        source = clip.path.relative_to(folder).as_posix()
    else:
        source = encode_data_uri(clip.content, "video/mp4")
    height, width = clip.frames.shape[1:3]
    return tag(
        "video",
        src=source,
        poster=_encode_jpeg(clip.frames[len(clip.frames) // 2]),
        width=width,
        height=height,
        controls=True,
        loop=True,
        autoplay=True,
        muted=True,
        playsinline=True,
        data_clip=group,
        data_frame_dt=frame_dt,
        data_same_as=same_as,
        id=id_,
    )


def embed_filmstrip(clip: Clip, frame_dt: float | None) -> Markup | None:
    """A row of pictures evenly through the clip, for print and for a glance."""
    if clip.frames is None:
        return None
    cells = []
    for index, frame in zip(_space_frames(clip.frame_count), clip.frames):
        time = "" if frame_dt is None else f", {format_fixed(index * frame_dt)} s"
        picture = tag("img", src=_encode_jpeg(frame, STRIP_HEIGHT), alt=f"frame {index}")
        cells.append(tag("figure", picture, tag("figcaption", f"{index}{time}")))
    return div("filmstrip", join(cells))


def _space_frames(count: int) -> list[int]:
    """Frames evenly through a clip of ``count``, the first and the last among them."""
    return sorted({round(i * (count - 1) / (STRIP_FRAMES - 1)) for i in range(STRIP_FRAMES)})


def _encode_jpeg(picture: np.ndarray, height: int | None = None) -> str:
    if height is not None and picture.shape[0] > height:
        # Whole-number steps: plain averaging is enough for a thumbnail.
        step = max(1, picture.shape[0] // height)
        rows, columns = (size // step * step for size in picture.shape[:2])
        blocks = picture[:rows, :columns].reshape(rows // step, step, columns // step, step, 3)
        # Rows first, as whole numbers: four times as fast as the mean of both axes, and equal.
        sums = blocks.sum(axis=1, dtype=np.uint32).sum(axis=2)
        picture = (sums / step**2).round().astype(np.uint8)
    buffer = io.BytesIO()
    iio.imwrite(buffer, picture, extension=".jpg", quality=85)
    return encode_data_uri(buffer.getvalue(), "image/jpeg")
