"""Reading Niantic's SPZ, versions 1 to 4.

Layout (nianticlabs/spz, README): a header tells the number of Gaussians, the degree of the spherical harmonics and the
fractional bits of the positions. Each attribute follows for all Gaussians at once: positions (24-bit fixed point,
float16 in version 1), opacities, colours, scales, rotations and higher harmonics in bytes. Versions 1 to 3 are one gzip
stream. Version 4 is a plain header, a table of sizes and one zstd stream for each attribute.
"""

from __future__ import annotations

import dataclasses
import struct
import zlib
from pathlib import Path

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import read_bytes, shorten
from physagent_jax.gaussians.formats.base import SignedAxis, SplatData
from physagent_jax.gaussians.formats.packing import expand_smallest_three
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES
from physagent_jax.gaussians.formats.spz_container import GZIP, MAGIC, SpzHeader, unpack_spz

COLOUR_SCALE = 0.15  # of the constant coefficients: bytes reach a little beyond black and white
SCALE_STEPS = 16.0  # of the scales' logarithms, from SCALE_LEAST on
SCALE_LEAST = -10.0
_KEPT_DEGREE = 3  # what the renderer draws
_COORDINATES = 0xADBE0003  # the extension SPZ_ADOBE_coordinate_system
_UP_NOTE = (
    "SPZ prescribes +y as up, which some converters of PLY files do not keep to; "
    "if the object lies or stands on its head, give --up"
)
# Axes of x, y and z by the extension's number, as its documentation lists them from 1 on: L/R, U/D, F/B.
_SYSTEMS = "LDB RDB LUB RUB LDF RDF LUF RUF LFD RFD LFU RFU LBD RBD LBU RBU".split()


class _Spz:
    """Niantic's SPZ."""

    name = "SPZ (Niantic)"
    suffixes = (".spz",)

    def matches(self, head: bytes) -> bool:
        """Return whether the file begins with SPZ's magic number, plain or packed by gzip."""
        if not head.startswith(GZIP):
            return head.startswith(MAGIC)
        try:
            return zlib.decompressobj(wbits=31).decompress(head, len(MAGIC)) == MAGIC
        except zlib.error:
            return False

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Read a file; its values have one meaning, so that ``encoding`` changes nothing.

        Raises:
            UserError: It is damaged or of an unknown version, or the package for version 4 is missing.
        """
        shown = shorten(path)
        data, up_is_stated = decode_spz(read_bytes(path, most=MOST_BYTES), shown)
        return (
            data if up_is_stated else dataclasses.replace(data, notes=(*data.notes, f"{shown}: {_UP_NOTE}"))
        )


SPZ = _Spz()


def decode_spz(data: bytes, shown: str) -> tuple[SplatData, bool]:
    """Decode an SPZ file.

    Args:
        data: The file.
        shown: Its name, for messages.

    Returns:
        The Gaussians, and whether the file itself states its up axis.

    Raises:
        UserError: As `Format.read`.
    """
    header, streams, extensions = unpack_spz(data, shown)
    kept, notes = min(header.degree, _KEPT_DEGREE), ()
    if kept < header.degree:
        notes = (f"{shown}: spherical harmonics of degree {header.degree} are cut to degree {kept}",)
    sh = ((_rows(streams["colours"], 3) / 255.0 - 0.5) / COLOUR_SCALE)[:, None, :]
    if kept:
        rest = _rows(streams["rest"], header.sizes["rest"])[:, : 3 * ((kept + 1) ** 2 - 1)]
        sh = np.concatenate([sh, (rest.reshape(header.count, -1, 3) - 128.0) / 128.0], axis=1)
    up, up_is_stated = _find_up(extensions, shown)
    decoded = SplatData(
        means=_decode_positions(streams["positions"], header),
        quats=_decode_quats(streams["rotations"], header),
        scales=np.exp(_rows(streams["scales"], 3) / SCALE_STEPS + SCALE_LEAST),
        opacities=_rows(streams["opacities"], 1)[:, 0] / 255.0,
        sh=sh,
        encoding=f"SPZ version {header.version}: 8-bit log scales, opacities and colours, SH of degree {kept}",
        up=up,
        notes=notes,
    )
    return decoded, up_is_stated


def _rows(data: bytes, width: int) -> np.ndarray:
    return np.frombuffer(data, np.uint8).reshape(-1, width)


def _decode_positions(data: bytes, header: SpzHeader) -> np.ndarray:
    """Centres, shape (n, 3)."""
    if header.version == 1:
        with np.errstate(invalid="ignore"):  # signalling NaNs: such Gaussians are dropped
            return np.frombuffer(data, "<f2").reshape(-1, 3).astype(np.float64)
    low, middle, high = (_rows(data, 3)[:, i].astype(np.int32) for i in range(3))
    signed = ((low | middle << 8 | high << 16) ^ 2**23) - 2**23  # the 24th bit is the sign
    return signed.reshape(-1, 3) * 2.0**-header.fractional_bits


def _decode_quats(data: bytes, header: SpzHeader) -> np.ndarray:
    """Unit quaternions wxyz, shape (n, 4); the file has xyzw."""
    if header.version < 3:
        xyz = _rows(data, 3) / 127.5 - 1.0
        w = np.sqrt(np.maximum(1.0 - np.square(xyz).sum(axis=1, keepdims=True), 0.0))
        return np.concatenate([w, xyz], axis=1)
    words = np.frombuffer(data, "<u4")
    three = np.stack([_decode_signed(words >> shift) for shift in (20, 10, 0)], axis=-1)
    return expand_smallest_three(three, words >> 30)[:, [3, 0, 1, 2]]


def _decode_signed(words: np.ndarray) -> np.ndarray:
    """Components of quaternions: nine bits of the magnitude over 1/sqrt(2), and the sign."""
    size = (words & 511) * (np.sqrt(0.5) / 511)
    return np.where(words & 512, -size, size)


def _find_up(extensions: bytes, shown: str) -> tuple[SignedAxis, bool]:
    """The up axis, and whether the file states it; by default SPZ's axes point right, up and back.

    Raises:
        UserError: The file states left-handed axes.
    """
    at = 0
    while len(extensions) - at >= 12:
        kind, size, value = struct.unpack_from("<III", extensions, at)
        if kind == _COORDINATES and size == 4 and 1 <= value <= len(_SYSTEMS):
            system = _SYSTEMS[value - 1]
            if not _is_right_handed(system):
                raise UserError(
                    f"{shown} has left-handed axes, which are not read",
                    got=f"{system} in its extension SPZ_ADOBE_coordinate_system",
                    do="Export it without that extension",
                )
            place = next(i for i, letter in enumerate(system) if letter in "UD")
            axes: tuple[tuple[SignedAxis, SignedAxis], ...] = (("+x", "-x"), ("+y", "-y"), ("+z", "-z"))
            return axes[place][system[place] == "D"], True
        at += 8 + size
    return "+y", False


def _is_right_handed(system: str) -> bool:
    """Return whether axes given as letters obey x cross y = z."""
    directions = {
        "R": (1, 0, 0),
        "L": (-1, 0, 0),
        "U": (0, 1, 0),
        "D": (0, -1, 0),
        "B": (0, 0, 1),
        "F": (0, 0, -1),
    }
    return np.linalg.det(np.array([directions[letter] for letter in system], float)) > 0
