"""Photos, damaged or of unusual kinds, and the masks and depths beside them: lifted, or refused."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image

from physagent_jax.scene.config import Photo
from physagent_jax.scene.photo.lift import lift_photo
from tests.fuzz import seeds
from tests.fuzz.contract import Breach, Case, Fault
from tests.fuzz.drawing import Draw, damaged

WIDTH, HEIGHT, NAME = 64, 48, "photo.png"
KINDS = ("PNG", "JPEG", "BMP", "TIFF", "WEBP", "GIF")
MODES = ("RGB", "RGBA", "L", "LA", "P", "1", "CMYK", "I", "I;16", "F", "LAB", "HSV")


def make(draw: Draw) -> Case:
    """One photo, with what may stand beside it."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    ball = (x - 32) ** 2 + (y - 24) ** 2 < 15**2
    what, content = draw.one([_damage, _damage, _draw_kind, _draw_size])(draw, ball)
    photo, files = {}, {NAME: content}
    beside = draw.one(["none", "none", "box", "mask", "depth"])
    if beside == "box":
        low, high = sorted(draw.one([0.0, 1.0, 30.0, 63.9, 64.0, 6e4]) for _ in range(2))
        photo = {"box": (low, low, high, high)} if low < high else {}
    elif beside != "none":
        good = ball if beside == "mask" else np.float32(2 + 0.01 * x)
        how, files["beside.npy"] = draw.one([_damage_array, _draw_array])(draw, good)
        photo, what = {f"{beside}_path": "beside.npy"}, f"{what}; {beside} {how}"
    if draw.chance(0.3):
        photo["elevation_degrees"] = draw.one([-88.0, -20.0, 0.0, 60.0, 88.9])
    if draw.chance(0.3):
        photo["fov_degrees"] = draw.one([1.1, 20.0, 149.0])
    return Case(f"{what}; {photo}", lambda folder: _lift(folder, Photo(**photo)), files, seconds=60.0)


def _lift(folder: Path, photo: Photo):
    lifted = lift_photo(Path(NAME), photo, folder)
    cloud = lifted.cloud
    if not all(
        np.isfinite(np.asarray(each)).all() for each in (cloud.means, cloud.scales, cloud.quats, cloud.sh)
    ):
        raise Breach(Fault.SILENT, "Gaussians that are not finite")
    return lifted.mask


def _encode(picture: Image.Image, kind: str) -> bytes:
    buffer = io.BytesIO()
    picture.save(buffer, kind)
    return buffer.getvalue()


def _draw_ball(ball: np.ndarray) -> Image.Image:
    return Image.fromarray(np.where(ball[..., None], np.uint8([200, 60, 30]), np.uint8([120, 160, 210])))


def _damage(draw: Draw, ball: np.ndarray) -> tuple[str, bytes]:
    kind = draw.one(KINDS)
    how, content = damaged(draw, _encode(_draw_ball(ball), kind), [seeds.npy(ball)])
    return f"{kind}, {how}", content


def _draw_kind(draw: Draw, ball: np.ndarray) -> tuple[str, bytes]:
    kind, mode = draw.one(KINDS), draw.one(MODES)
    try:
        return f"{kind} {mode}", _encode(_draw_ball(ball).convert(mode), kind)
    except (OSError, ValueError):  # that kind has no such pictures
        return f"{kind} RGB", _encode(_draw_ball(ball), kind)


def _draw_size(draw: Draw, ball: np.ndarray) -> tuple[str, bytes]:
    size = draw.one([(1, 1), (1, 400), (400, 1), (2, 2), (3, 900), (33, 33), (700, 90)])
    return f"{size} px", _encode(_draw_ball(ball).resize(size), "PNG")


def _damage_array(draw: Draw, good: np.ndarray) -> tuple[str, bytes]:
    return damaged(draw, seeds.npy(good), [seeds.npy(np.ones(3))])


def _draw_array(draw: Draw, good: np.ndarray) -> tuple[str, bytes]:
    options = {
        "as it should be": good,
        "of nan": np.full(good.shape, np.nan),
        "of zeros": np.zeros(good.shape),
        "of ones": np.ones(good.shape, bool),
        "of infinities": np.full(good.shape, np.inf),
        "of huge numbers": np.where(good > 2.3, 1e300, 1e-300),
        "of negative numbers": -np.ones(good.shape),
        "of one row": good[0],
        "of colours": np.stack([good] * 3, axis=2),
        "of text": np.full(good.shape, "x"),
        "of another size": good[:20],
    }
    name = draw.one(sorted(options))
    return name, seeds.npy(options[name])
