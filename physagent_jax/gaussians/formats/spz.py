"""Reading Niantic's SPZ, versions 1 to 4.

Layout (nianticlabs/spz, README): a header with the number of Gaussians, the degree of the spherical harmonics and the
fractional bits of the positions; then, each for all Gaussians at once, positions (24-bit fixed point; float16 in
version 1), opacities, colours, scales, rotations and higher harmonics in bytes. Versions 1 to 3 are one gzip stream,
version 4 is a plain header, a table of sizes and one zstd stream for each attribute.
"""

from __future__ import annotations

import dataclasses
import io
import struct
import zlib
from pathlib import Path

import numpy as np

from physagent_jax.core.errors import MissingPackageError, UserError
from physagent_jax.core.reading import check_counts, read_bytes, shorten
from physagent_jax.gaussians.formats.base import SignedAxis, SplatData
from physagent_jax.gaussians.formats.packing import check_unpacked_size, expand_smallest_three
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES

MAGIC = b"NGSP"
GZIP = b"\x1f\x8b"
COLOUR_SCALE = 0.15  # of the constant coefficients: bytes reach a little beyond black and white
SCALE_STEPS = 16.0  # of the scales' logarithms, from SCALE_LEAST on
SCALE_LEAST = -10.0
MOST_DEGREE = 4
_KEPT_DEGREE = 3  # what the renderer draws
HEADER = struct.Struct("<4sIIBBBB")
_ZSTD_HEADER = struct.Struct("<4sIIBBBBI12x")
_HAS_EXTENSIONS = 0x2
_COORDINATES = 0xADBE0003  # the extension SPZ_ADOBE_coordinate_system
_MOST_EXTENSION_BYTES = 2**16
# Axes of x, y and z by the extension's number, as its documentation lists them from 1 on: L/R, U/D, F/B.
_SYSTEMS = "LDB RDB LUB RUB LDF RDF LUF RUF LFD RFD LFU RFU LBD RBD LBU RBU".split()


@dataclasses.dataclass(frozen=True)
class SpzHeader:
    """An SPZ file's header.

    Attributes:
        version: 1 to 4.
        count: Gaussians.
        degree: Degree of the spherical harmonics, 0 to 4.
        fractional_bits: Of the positions.
        flags: Bits; 0x1 = trained with antialiasing, 0x2 = extensions follow.
    """

    version: int
    count: int
    degree: int
    fractional_bits: int
    flags: int

    @property
    def sizes(self) -> dict[str, int]:
        """Bytes of each attribute for one Gaussian, in the order of the file; those of 0 bytes are left out."""
        sizes = {
            "positions": 6 if self.version == 1 else 9,
            "opacities": 1,
            "colours": 3,
            "scales": 3,
            "rotations": 3 if self.version < 3 else 4,
            "rest": 3 * ((self.degree + 1) ** 2 - 1),
        }
        return {name: size for name, size in sizes.items() if size}


class Spz:
    """Niantic's SPZ, as `formats.base.Format`."""

    name = "SPZ (Niantic)"
    suffixes = (".spz",)

    def matches(self, head: bytes) -> bool:
        """Whether the file begins with SPZ's magic number, plain or packed by gzip."""
        if not head.startswith(GZIP):
            return head.startswith(MAGIC)
        try:
            return zlib.decompressobj(wbits=31).decompress(head, len(MAGIC)) == MAGIC
        except zlib.error:
            return False

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Reads a file; its values have one meaning, so that ``encoding`` changes nothing.

        Raises:
            UserError: It is damaged or of an unknown version, or the package for version 4 is missing.
        """
        return decode_spz(read_bytes(path, most=MOST_BYTES), shorten(path))


def decode_spz(data: bytes, shown: str) -> SplatData:
    """Decodes an SPZ file; ``shown`` names it in messages.

    Raises:
        UserError: As `Spz.read`.
    """
    header, streams, extensions = (_unpack_gzip if data.startswith(GZIP) else _unpack_zstd)(data, shown)
    kept = min(header.degree, _KEPT_DEGREE)
    sh = ((_rows(streams["colours"], 3) / 255.0 - 0.5) / COLOUR_SCALE)[:, None, :]
    if kept:
        rest = _rows(streams["rest"], header.sizes["rest"])[:, : 3 * ((kept + 1) ** 2 - 1)]
        sh = np.concatenate([sh, (rest.reshape(header.count, -1, 3) - 128.0) / 128.0], axis=1)
    up, stated = _find_up(extensions, shown)
    return SplatData(
        means=_decode_positions(streams["positions"], header),
        quats=_decode_quats(streams["rotations"], header),
        scales=np.exp(_rows(streams["scales"], 3) / SCALE_STEPS + SCALE_LEAST),
        opacities=_rows(streams["opacities"], 1)[:, 0] / 255.0,
        sh=sh,
        encoding=f"SPZ version {header.version}: 8-bit log scales, opacities and colours, SH of degree {kept}",
        up=up,
        notes=tuple(_make_notes(header, stated)),
    )


def _make_notes(header: SpzHeader, up_is_stated: bool):
    if not up_is_stated:
        yield (
            "SPZ prescribes +y as up, which some converters of PLY files do not keep to: "
            "if the object lies or stands on its head, give --up"
        )
    if header.degree > _KEPT_DEGREE:
        yield f"spherical harmonics of degree {header.degree} are cut to degree {_KEPT_DEGREE}"


# --- containers ----------------------------------------------------------------------------------------


def _check_header(header: SpzHeader, shown: str, versions: tuple[int, ...], stored: int) -> None:
    if header.version not in versions:
        raise UserError(
            f"{shown} is an SPZ file of a version that is not read",
            got=f"version {header.version} in {'gzip' if 1 in versions else 'plain bytes'}",
            do="Convert it to PLY: `splat-transform in.spz out.ply`",
        )
    if header.degree > MOST_DEGREE:
        raise _explain_damage(shown, f"spherical harmonics of degree {header.degree}")
    if header.count == 0:
        raise UserError(f"{shown} holds no Gaussians", do="Export the scene again")
    check_unpacked_size(shown, header.count, sum(header.sizes.values()), stored)


def _unpack_gzip(data: bytes, shown: str) -> tuple[SpzHeader, dict[str, bytes], bytes]:
    """Header, attributes and extensions of versions 1 to 3."""
    inflate = zlib.decompressobj(wbits=31)
    try:
        head = inflate.decompress(data, HEADER.size)
        if len(head) < HEADER.size or not head.startswith(MAGIC):
            raise _explain_damage(shown, "no header of SPZ")
        _, *fields, _ = HEADER.unpack(head)
        header = SpzHeader(*fields)
        _check_header(header, shown, (1, 2, 3), len(data))
        size = header.count * sum(header.sizes.values())
        body = inflate.decompress(inflate.unconsumed_tail, size + _MOST_EXTENSION_BYTES)
    except zlib.error as error:
        raise _explain_damage(shown, str(error)) from None
    check_counts(shown, "Gaussians", header.count, sum(header.sizes.values()), len(body))
    streams, start = {}, 0
    for name, each in header.sizes.items():
        streams[name] = body[start : start + header.count * each]
        start += header.count * each
    return header, streams, body[size:] if header.flags & _HAS_EXTENSIONS else b""


def _unpack_zstd(data: bytes, shown: str) -> tuple[SpzHeader, dict[str, bytes], bytes]:
    """Header, attributes and extensions of version 4."""
    if len(data) < _ZSTD_HEADER.size or not data.startswith(MAGIC):
        raise _explain_damage(shown, "no header of SPZ")
    _, *fields, stream_count, start = _ZSTD_HEADER.unpack_from(data)
    header = SpzHeader(*fields)
    _check_header(header, shown, (4,), len(data))
    if stream_count != len(header.sizes) or start < _ZSTD_HEADER.size:
        raise _explain_damage(shown, f"{stream_count} streams, listed from byte {start} on")
    check_counts(shown, "streams", stream_count, 16, len(data) - start)
    at, streams = start + 16 * stream_count, {}
    for index, (name, each) in enumerate(header.sizes.items()):
        stored, size = struct.unpack_from("<QQ", data, start + 16 * index)
        check_counts(shown, f"bytes of {name}", stored, 1, len(data) - at)
        if size != header.count * each:
            raise _explain_damage(shown, f"{size:,} bytes of {name} for {header.count:,} Gaussians")
        streams[name] = _unpack_zstd_stream(data[at : at + stored], size, shown)
        at += stored
    return header, streams, data[_ZSTD_HEADER.size : start] if header.flags & _HAS_EXTENSIONS else b""


def _unpack_zstd_stream(data: bytes, size: int, shown: str) -> bytes:
    """The ``size`` bytes that a zstd frame holds; never more than these are unpacked."""
    decompress, errors = _find_zstd(shown)
    try:
        unpacked = decompress(data, size)
    except errors as error:
        raise _explain_damage(shown, shorten(error)) from None
    if len(unpacked) != size:
        raise _explain_damage(shown, f"{len(unpacked):,} bytes where {size:,} should be")
    return unpacked


def _find_zstd(shown: str):
    """A function (frame, most bytes) -> bytes and the exceptions that it raises."""
    try:
        import zstandard

        def unpack(data: bytes, size: int) -> bytes:
            # Not `decompress`: it takes as much memory as the frame says, whatever the limit.
            with zstandard.ZstdDecompressor(max_window_size=2**27).stream_reader(io.BytesIO(data)) as reader:
                return reader.read(size)

        return unpack, (zstandard.ZstdError, MemoryError)
    except ImportError:
        pass
    try:
        from compression import zstd  # pyright: ignore[reportMissingImports]  # Python 3.14 and later
    except ImportError:
        raise MissingPackageError(
            f"{shown} is an SPZ file of version 4, which needs the package zstandard. "
            "Install it (pip install zstandard), or convert the file: `splat-transform in.spz out.ply`"
        ) from None
    return lambda data, size: zstd.ZstdDecompressor().decompress(data, size), (zstd.ZstdError, EOFError)


def _explain_damage(shown: str, found: str) -> UserError:
    return UserError(f"{shown} is a damaged SPZ file", got=found, do="Copy or export the file again")


# --- values --------------------------------------------------------------------------------------------


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
    """Whether axes given as letters obey x cross y = z."""
    directions = {"R": (1, 0, 0), "L": (-1, 0, 0), "U": (0, 1, 0), "D": (0, -1, 0), "B": (0, 0, 1), "F": (0, 0, -1)}
    return np.linalg.det(np.array([directions[letter] for letter in system], float)) > 0
