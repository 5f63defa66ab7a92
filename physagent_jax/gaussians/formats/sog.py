"""Reading PlayCanvas SOG, versions 1 and 2: Gaussians as pixels of lossless images, bundled in a zip or in a folder.

Layout (PlayCanvas, "The SOG format"): ``meta.json`` names the images. Pixel i of each, row by row, belongs to Gaussian
i. ``means_l`` and ``means_u`` are the low and high bytes of sign(x) log(1 + |x|) between bounds. ``quats`` has three
components and a fourth byte of 252 + the place in wxyz that is left out. ``scales`` and ``sh0`` index codebooks
(version 2) or lie between bounds (version 1). ``shN_labels`` points into a palette of higher harmonics,
``shN_centroids``, which has 64 entries in a row of pixels.
"""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import Protocol

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import (
    JSON_BYTES,
    MIB,
    check_regular,
    decode_json,
    parse_model,
    read_bytes,
    shorten,
)
from physagent_jax.gaussians.formats.base import SplatData
from physagent_jax.gaussians.formats.lossless_image import decode_image
from physagent_jax.gaussians.formats.packing import MOST_RATIO, check_unpacked_size, expand_smallest_three
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES
from physagent_jax.gaussians.formats.sog_meta import Harmonics, SogMeta, explain_damage, interpolate

META = "meta.json"
_ZIP = b"PK\x03\x04"
_EACH = 18  # bytes of a Gaussian's pixels: two of positions, one each of rotation, scale, colour
_PALETTE_COLUMNS = 64
_FIRST_TAG = 252
_MOST_ENTRIES = 1000
_ZIP_ERRORS = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    OSError,
    ValueError,
)


class _Store(Protocol):
    """The place of a bundle's files.

    Attributes:
        shown: The bundle, for messages.
    """

    shown: str

    def read(self, name: str) -> bytes:
        """The content of a file of the bundle."""
        ...


class _Sog:
    """PlayCanvas SOG."""

    name = "SOG (PlayCanvas)"
    suffixes = (".sog",)

    def matches(self, head: bytes) -> bool:
        """Return whether the file is a zip of images or names the images of Gaussians."""
        if head.startswith(_ZIP):
            return META.encode() in head or b".webp" in head
        return head.lstrip().startswith(b"{") and all(
            word in head for word in (b'"means"', b'"quats"', b'"sh0"')
        )

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Read a bundle, or the folder of a ``meta.json``; ``encoding`` changes nothing.

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
                f"{shorten(path)} is a damaged SOG bundle",
                got=shorten(error),
                do="Copy or export the file again",
            ) from None


SOG = _Sog()


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
                f"{self.shown} is no complete SOG bundle",
                got=f"no entry {shorten(name, 60)}",
                do="Export it again",
            )
        info = self._names[name]
        most = MOST_RATIO * info.compress_size + MIB
        with self._archive.open(info) as file:
            data = file.read(most + 1)
        if len(data) > most:
            raise UserError(
                f"{self.shown} holds an entry that unpacks to far more than it should",
                got=name,
                do="Export it again",
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
                f"{self.shown} names a file outside its folder",
                got=shorten(name, 60),
                do="Export the scene again",
            )
        return read_bytes(self._folder / name, most=512 * MIB, what="the SOG image")


# --- values --------------------------------------------------------------------------------------------


def _decode(store: _Store, meta_bytes: bytes) -> SplatData:
    meta = parse_model(decode_json(meta_bytes, store.shown), SogMeta, store.shown)
    count = meta.gaussian_count
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
    sh = meta.sh0.decode(colour[:, :3], store.shown)[:, None, :]
    if meta.shN is not None and meta.shN.bands != 0:
        sh = np.concatenate([sh, _read_rest(meta.shN, store, pixels)], axis=1)
    with np.errstate(over="ignore"):  # bounds far too large: such Gaussians are dropped
        level = (pixels(low, "means_l")[:, :3] + 256.0 * pixels(high, "means_u")[:, :3]) / 65535.0
        logs = interpolate(meta.means.mins, meta.means.maxs, level)
        return SplatData(
            means=np.sign(logs) * np.expm1(np.abs(logs)),
            quats=_read_quats(pixels(quats, "quats")),
            scales=np.exp(meta.scales.decode(pixels(scales, "scales")[:, :3], store.shown)),
            opacities=_read_opacities(meta, colour[:, 3]),
            sh=sh,
            encoding=f"SOG version {meta.version}: 16-bit log positions, SH of degree {round(sh.shape[1] ** 0.5) - 1}",
        )


def _read_opacities(meta: SogMeta, bytes_: np.ndarray) -> np.ndarray:
    """Opacities, shape (n,): plain in version 2, logits between the fourth bounds in version 1."""
    bounds = meta.sh0
    if (
        meta.version == 1
        and bounds.mins is not None
        and len(bounds.mins) == 4
        and len(bounds.maxs or ()) == 4
    ):
        low, high = bounds.mins[3], (bounds.maxs or [])[3]
        return 1.0 / (1.0 + np.exp(-(low + (high - low) * bytes_ / 255.0)))
    return bytes_ / 255.0


def _read_quats(pixels: np.ndarray) -> np.ndarray:
    """Unit quaternions wxyz, shape (n, 4); zero where the fourth byte names no component."""
    known = pixels[:, 3] >= _FIRST_TAG
    three = (pixels[:, :3] / 255.0 * 2.0 - 1.0) * np.sqrt(0.5)
    quats = expand_smallest_three(three, np.where(known, pixels[:, 3] - np.uint8(_FIRST_TAG), 0))
    return np.where(known[:, None], quats, 0.0)


def _read_rest(part: Harmonics, store: _Store, pixels) -> np.ndarray:
    """Higher coefficients, shape (n, k, 3)."""
    labels = pixels(store.read(part.files[1]), "shN_labels")
    entries = labels[:, 0].astype(np.int64) + 256 * labels[:, 1].astype(np.int64)
    data = store.read(part.files[0])
    name = f"shN_centroids of {store.shown}"
    image = decode_image(data, name, least=_PALETTE_COLUMNS * 3, most=2**20, flat=False)
    count = image.shape[1] // _PALETTE_COLUMNS
    bands = {3: 1, 8: 2, 15: 3}.get(count)
    if image.shape[1] != _PALETTE_COLUMNS * count or bands is None or part.bands not in (None, bands):
        raise explain_damage(store.shown, f"a palette {image.shape[1]} pixels wide for {part.bands} bands")
    palette = image[..., :3].reshape(-1, count, 3)
    size = min(len(palette), part.count or len(palette))
    if int(entries.max(initial=0)) >= size:
        raise explain_damage(store.shown, f"entry {entries.max()} of a palette of {size}")
    return part.decode(palette, store.shown)[entries]
