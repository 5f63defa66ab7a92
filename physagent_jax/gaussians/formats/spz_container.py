"""The containers of SPZ files: one gzip stream (versions 1 to 3), or a zstd stream for each attribute (version 4)."""

from __future__ import annotations

import dataclasses
import io
import struct
import zlib

import zstandard

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_counts, shorten
from physagent_jax.gaussians.formats.packing import check_unpacked_size

MAGIC = b"NGSP"
GZIP = b"\x1f\x8b"
HEADER = struct.Struct("<4sIIBBBB")
MOST_DEGREE = 4
_ZSTD_HEADER = struct.Struct("<4sIIBBBBI12x")
_HAS_EXTENSIONS = 0x2
_MOST_EXTENSION_BYTES = 2**16


@dataclasses.dataclass(frozen=True)
class SpzHeader:
    """An SPZ file's header.

    Attributes:
        version: 1 to 4.
        count: Gaussians.
        degree: Degree of the spherical harmonics, 0 to 4.
        fractional_bits: Fractional bits of the positions.
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


def unpack_spz(data: bytes, shown: str) -> tuple[SpzHeader, dict[str, bytes], bytes]:
    """Unpacks an SPZ file; never more than its header announces, and never more than a capture of its size has.

    Args:
        data: The file.
        shown: Its name, for messages.

    Returns:
        The header, the bytes of each attribute and those of the extensions.

    Raises:
        UserError: The file is damaged or of an unknown version, or the package for version 4 is missing.
    """
    return (_unpack_gzip if data.startswith(GZIP) else _unpack_zstd)(data, shown)


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
    if not inflate.eof:  # only there its checksum is compared
        raise _explain_damage(shown, "a gzip stream that does not end where it should")
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
    # Not `decompress`: it takes as much memory as the frame says, whatever the limit.
    unpacker = zstandard.ZstdDecompressor(max_window_size=2**27)
    try:
        with unpacker.stream_reader(io.BytesIO(data)) as reader:
            unpacked = reader.read(size)
    except (zstandard.ZstdError, MemoryError) as error:
        raise _explain_damage(shown, shorten(error)) from None
    if len(unpacked) != size:
        raise _explain_damage(shown, f"{len(unpacked):,} bytes where {size:,} should be")
    return unpacked


def _explain_damage(shown: str, found: str) -> UserError:
    return UserError(f"{shown} is a damaged SPZ file", got=found, do="Copy or export the file again")
