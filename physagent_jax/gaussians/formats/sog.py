"""Reading PlayCanvas SOG, versions 1 and 2: Gaussians as pixels of lossless images, bundled in a zip or in a folder.

Layout (PlayCanvas, "The SOG format"): ``meta.json`` names the images, and pixel i of each belongs to Gaussian i, row
by row. ``means_l`` and ``means_u`` are the low and high bytes of sign(x) log(1 + |x|) between bounds; ``quats`` has
three components and, as 252 + place in wxyz, which one is left out; ``scales`` and ``sh0`` index codebooks (version 2)
or lie between bounds (version 1); the higher harmonics are palette entries (``shN_centroids``, 64 in a row of pixels)
that ``shN_labels`` points to.
"""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal, Protocol

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import JSON_BYTES, MIB, check_regular, decode_json, parse_model, read_bytes, shorten
from physagent_jax.gaussians.formats.base import SplatData
from physagent_jax.gaussians.formats.lossless_image import decode_image
from physagent_jax.gaussians.formats.packing import MOST_RATIO, check_unpacked_size, expand_smallest_three
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES

META = "meta.json"
_ZIP = b"PK\x03\x04"
_EACH = 18  # bytes of a Gaussian's pixels: two of positions, one each of rotation, scale, colour
_PALETTE_COLUMNS = 64
_FIRST_TAG = 252
_MOST_ENTRIES = 1000
_ZIP_ERRORS = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError, ValueError)

_Numbers = Annotated[list[float], Field(max_length=65536)]
_Three = Annotated[list[float], Field(min_length=3, max_length=4)]
_Files = Annotated[list[str], Field(min_length=1, max_length=2)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", allow_inf_nan=False)

    files: _Files
    mins: _Three | None = None
    maxs: _Three | None = None
    codebook: _Numbers | None = None
    shape: list[int] | None = None


class _Means(_Part):
    mins: _Three
    maxs: _Three
    files: Annotated[list[str], Field(min_length=2, max_length=2)]


class _Harmonics(BaseModel):
    model_config = ConfigDict(extra="ignore", allow_inf_nan=False)

    files: Annotated[list[str], Field(min_length=2, max_length=2)]
    count: Annotated[int, Field(ge=1, le=65536)] | None = None
    bands: Annotated[int, Field(ge=0, le=3)] | None = None
    codebook: _Numbers | None = None
    mins: float | None = None
    maxs: float | None = None


class _Meta(BaseModel):
    """``meta.json``, both versions."""

    model_config = ConfigDict(extra="ignore")

    version: Literal[1, 2] = 1
    count: Annotated[int, Field(ge=1, le=2**32)] | None = None
    means: _Means
    scales: _Part
    quats: _Part
    sh0: _Part
    shN: _Harmonics | None = None


class _Store(Protocol):
    """Where a bundle's files lie.

    Attributes:
        shown: The bundle, for messages.
        size: Bytes of the bundle, where they bound its content.
    """

    shown: str

    def read(self, name: str) -> bytes:
        """The content of a file of the bundle."""
        ...


class Sog:
    """PlayCanvas SOG, as `formats.base.Format`."""

    name = "SOG (PlayCanvas)"
    suffixes = (".sog", META)

    def matches(self, head: bytes) -> bool:
        """Whether the file is a zip of images or names the images of Gaussians."""
        if head.startswith(_ZIP):
            return META.encode() in head or b".webp" in head
        return head.lstrip().startswith(b"{") and all(word in head for word in (b'"means"', b'"quats"', b'"sh0"'))

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Reads a bundle, or the folder of a ``meta.json``; ``encoding`` changes nothing.

        Raises:
            UserError: The bundle is damaged, an image is missing, too small or lossily compressed.
        """
        check_regular(path, most=MOST_BYTES)
        with path.open("rb") as file:
            bundled = file.read(len(_ZIP)) == _ZIP
        if not bundled:
            return _decode(_Folder(path), read_bytes(path, most=JSON_BYTES))
        try:
            with zipfile.ZipFile(path) as archive:
                store = _Archive(archive, shorten(path))
                return _decode(store, store.read(META))
        except UserError:
            raise
        except _ZIP_ERRORS as error:
            raise UserError(
                f"{shorten(path)} is a damaged SOG bundle", got=shorten(error), do="Copy or export the file again"
            ) from None


class _Archive:
    """The files of a zip, by the names of its own list."""

    def __init__(self, archive: zipfile.ZipFile, shown: str):
        self.shown = shown
        self._archive = archive
        self._names = {info.filename: info for info in archive.infolist()[:_MOST_ENTRIES]}

    def read(self, name: str) -> bytes:
        """The content of the entry of that name."""
        if name not in self._names:
            raise UserError(
                f"{self.shown} is no complete SOG bundle", got=f"no entry {shorten(name, 60)}", do="Export it again"
            )
        info = self._names[name]
        most = MOST_RATIO * info.compress_size + MIB
        with self._archive.open(info) as file:
            data = file.read(most + 1)
        if len(data) > most:
            raise UserError(
                f"{self.shown} holds an entry that unpacks to far more than it should", got=name, do="Export it again"
            )
        return data


class _Folder:
    """The files beside a ``meta.json``."""

    def __init__(self, meta: Path):
        self.shown = shorten(meta)
        self._folder = meta.parent

    def read(self, name: str) -> bytes:
        """The content of the file of that name."""
        if PurePosixPath(name).name != name or name in (".", "..") or "\\" in name:
            raise UserError(
                f"{self.shown} names a file outside its folder", got=shorten(name, 60), do="Export the scene again"
            )
        return read_bytes(self._folder / name, most=512 * MIB, what="the SOG image")


# --- values --------------------------------------------------------------------------------------------


def _decode(store: _Store, meta_bytes: bytes) -> SplatData:
    meta = parse_model(decode_json(meta_bytes, store.shown), _Meta, store.shown)
    count = meta.count if meta.count is not None else (meta.means.shape or [0])[0]
    low, high, quats, scales, colours = (
        store.read(name)
        for name in (*meta.means.files, meta.quats.files[0], meta.scales.files[0], meta.sh0.files[0])
    )
    stored = sum(map(len, (low, high, quats, scales, colours)))
    check_unpacked_size(store.shown, count, _EACH, stored)
    if count == 0:
        raise UserError(f"{store.shown} holds no Gaussians", do="Export the scene again")

    def pixels(data: bytes, name: str) -> np.ndarray:
        return decode_image(data, f"{name} of {store.shown}", least=count, most=4 * count + MIB)[:count]

    colour = pixels(colours, "sh0")
    sh = _look_up(meta.sh0, colour[:, :3], store.shown)[:, None, :]
    if meta.shN is not None and meta.shN.bands != 0:
        sh = np.concatenate([sh, _read_rest(meta.shN, store, pixels)], axis=1)
    with np.errstate(over="ignore"):  # bounds far too large: such Gaussians are dropped
        level = (pixels(low, "means_l")[:, :3] + 256.0 * pixels(high, "means_u")[:, :3]) / 65535.0
        logs = _interpolate(meta.means.mins, meta.means.maxs, level)
        return SplatData(
            means=np.sign(logs) * np.expm1(np.abs(logs)),
            quats=_read_quats(pixels(quats, "quats")),
            scales=np.exp(_look_up(meta.scales, pixels(scales, "scales")[:, :3], store.shown)),
            opacities=_read_opacities(meta, colour[:, 3]),
            sh=sh,
            encoding=f"SOG version {meta.version}: 16-bit log positions, SH of degree {round(sh.shape[1] ** 0.5) - 1}",
        )


def _interpolate(low: Any, high: Any, parts: np.ndarray) -> np.ndarray:
    low, high = np.asarray(low[:3]), np.asarray(high[:3])
    return low + (high - low) * parts


def _look_up(part: _Part, bytes_: np.ndarray, shown: str) -> np.ndarray:
    """Values that bytes stand for: entries of the codebook, or places between the bounds."""
    if part.codebook is not None:
        return _index(part.codebook, bytes_, shown)
    if part.mins is None or part.maxs is None:
        raise _explain_missing(shown, "neither a codebook nor bounds")
    return _interpolate(part.mins, part.maxs, bytes_ / 255.0)


def _index(codebook: list[float], bytes_: np.ndarray, shown: str) -> np.ndarray:
    if int(bytes_.max(initial=0)) >= len(codebook):
        raise _explain_missing(shown, f"entry {bytes_.max()} of a codebook of {len(codebook)}")
    return np.asarray(codebook, np.float64)[bytes_]


def _read_opacities(meta: _Meta, bytes_: np.ndarray) -> np.ndarray:
    """Opacities, shape (n,): plain in version 2, logits between the fourth bounds in version 1."""
    bounds = meta.sh0
    if meta.version == 1 and bounds.mins is not None and len(bounds.mins) == 4 and len(bounds.maxs or ()) == 4:
        low, high = bounds.mins[3], (bounds.maxs or [])[3]
        return 1.0 / (1.0 + np.exp(-(low + (high - low) * bytes_ / 255.0)))
    return bytes_ / 255.0


def _read_quats(pixels: np.ndarray) -> np.ndarray:
    """Unit quaternions wxyz, shape (n, 4); zero where the fourth byte names no component."""
    known = pixels[:, 3] >= _FIRST_TAG
    three = (pixels[:, :3] / 255.0 * 2.0 - 1.0) * np.sqrt(0.5)
    quats = expand_smallest_three(three, np.where(known, pixels[:, 3] - np.uint8(_FIRST_TAG), 0))
    return np.where(known[:, None], quats, 0.0)


def _read_rest(part: _Harmonics, store: _Store, pixels) -> np.ndarray:
    """Higher coefficients, shape (n, k, 3)."""
    labels = pixels(store.read(part.files[1]), "shN_labels")
    entries = labels[:, 0].astype(np.int64) + 256 * labels[:, 1].astype(np.int64)
    data = store.read(part.files[0])
    name = f"shN_centroids of {store.shown}"
    image = decode_image(data, name, least=_PALETTE_COLUMNS * 3, most=2**20, flat=False)
    count = image.shape[1] // _PALETTE_COLUMNS
    bands = {3: 1, 8: 2, 15: 3}.get(count)
    if image.shape[1] != _PALETTE_COLUMNS * count or bands is None or part.bands not in (None, bands):
        raise _explain_missing(store.shown, f"a palette {image.shape[1]} pixels wide for {part.bands} bands")
    palette = image[..., :3].reshape(-1, count, 3)
    size = min(len(palette), part.count or len(palette))
    if int(entries.max(initial=0)) >= size:
        raise _explain_missing(store.shown, f"entry {entries.max()} of a palette of {size}")
    if part.codebook is not None:
        values = _index(part.codebook, palette, store.shown)
    elif part.mins is not None and part.maxs is not None:
        values = part.mins + (part.maxs - part.mins) * palette / 255.0
    else:
        raise _explain_missing(store.shown, "neither a codebook nor bounds of `shN`")
    return values[entries]


def _explain_missing(shown: str, found: str) -> UserError:
    return UserError(f"{shown} is a damaged SOG bundle", got=found, do="Copy or export the scene again")
