"""Writing clouds as SPZ of version 3, which viewers read and which is a tenth of the PLY."""

from __future__ import annotations

import gzip
import os
import warnings
from typing import BinaryIO

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.formats.spz import COLOUR_SCALE, SCALE_LEAST, SCALE_STEPS
from physagent_jax.gaussians.formats.spz_container import HEADER, MAGIC

VERSION = 3
_POSITION_BITS = 23  # of a magnitude; the 24th is the sign
_MOST_FRACTIONAL_BITS = 20  # readers shift a 32-bit one by them


def write_spz(
    path: str | os.PathLike[str] | BinaryIO, cloud: GaussianCloud, *, origin: np.ndarray | None = None
) -> None:
    """Write a cloud whose up axis is +y, as SPZ prescribes.

    Largest errors of what is read again: positions 2^-23 of the largest coordinate (or 2^-21 units); scales 3.2 %,
    within [4.5e-5, 380] units; opacities 0.002; rotations 0.0021 (a component of the quaternion); colours 0.004,
    within [-0.44, 1.44]; higher harmonics 0.004, within [-1, 0.992].

    Args:
        path: The file to write, whose folder must exist, or a stream.
        cloud: The Gaussians.
        origin: Point that the positions are relative to, shape (3,); 24 bits cannot hold it, so that they stay so.

    Raises:
        UserError: A coordinate is too large for the format's 24 bits.
    """
    means, quats, scales, opacities, sh = (
        np.asarray(values, np.float64)
        for values in (cloud.means, cloud.quats, cloud.scales, cloud.opacities, cloud.sh)
    )
    _warn_of_limits(scales, origin)
    bits = _choose_fractional_bits(means)
    header = HEADER.pack(MAGIC, VERSION, len(means), round(sh.shape[1] ** 0.5) - 1, bits, 0, 0)
    log_scales = np.log(np.maximum(scales, np.finfo(np.float32).tiny))
    rest = sh[:, 1:, :].reshape(len(sh), -1)  # coefficient by coefficient, red, green and blue of each
    body = b"".join(
        (
            _encode_positions(means, bits),
            _to_bytes(opacities * 255.0),
            _to_bytes((sh[:, 0, :] * COLOUR_SCALE + 0.5) * 255.0),
            _to_bytes((log_scales - SCALE_LEAST) * SCALE_STEPS),
            _encode_quats(quats),
            _to_bytes(rest * 128.0 + 128.0),
        )
    )
    # Without a date, so that the same cloud gives the same file.
    packed = gzip.compress(header + body, compresslevel=6, mtime=0)
    if isinstance(path, str | os.PathLike):
        with open(path, "wb") as file:
            file.write(packed)
    else:
        path.write(packed)


def _warn_of_limits(scales: np.ndarray, origin: np.ndarray | None) -> None:
    """Warn of what the format cannot hold."""
    if origin is not None and np.any(origin):
        warnings.warn(f"positions in SPZ files are relative to {np.asarray(origin).tolist()}", stacklevel=3)
    least, most = np.exp(SCALE_LEAST), np.exp(SCALE_LEAST + 255 / SCALE_STEPS)
    largest = scales.max(axis=1, initial=0.0)
    if (beyond := np.sum((largest < least) | (largest > most))) > 0:
        warnings.warn(
            f"{beyond:,} Gaussians are smaller than {least:.2g} or larger than {most:.3g} units, which SPZ cannot "
            "hold; save as PLY to keep their sizes",
            stacklevel=3,
        )


def _choose_fractional_bits(means: np.ndarray) -> int:
    """The most fractional bits that leave room for the largest coordinate."""
    largest = np.abs(means).max(initial=0.0)
    bits = min(
        int(_POSITION_BITS - np.ceil(np.log2(max(largest, 2.0**-20) * (1 + 2.0**-20)))), _MOST_FRACTIONAL_BITS
    )
    if bits < 0:
        raise UserError(
            "the object is too far away or too large for SPZ",
            got=f"a coordinate of {largest:.3g} units, at most {2**_POSITION_BITS:,} fit",
            do="Save as PLY",
        )
    return bits


def _to_bytes(values: np.ndarray) -> bytes:
    return np.clip(np.round(values), 0, 255).astype(np.uint8).tobytes()


def _encode_positions(means: np.ndarray, bits: int) -> bytes:
    fixed = np.round(means * 2.0**bits).astype("<i4")
    return np.ascontiguousarray(fixed.view(np.uint8).reshape(*fixed.shape, 4)[..., :3]).tobytes()


def _encode_quats(quats: np.ndarray) -> bytes:
    """The place of the largest component of xyzw in 2 bits, then sign and 9 bits of each of the others."""
    xyzw = quats[:, [1, 2, 3, 0]]
    xyzw = xyzw / np.linalg.norm(xyzw, axis=1, keepdims=True)
    largest = np.abs(xyzw).argmax(axis=1)
    rows = np.arange(len(xyzw))
    xyzw = xyzw * np.where(xyzw[rows, largest] < 0, -1.0, 1.0)[:, None]  # q and -q are one rotation
    others = np.stack([np.delete(np.arange(4), i) for i in range(4)])[largest]
    three = np.take_along_axis(xyzw, others, axis=1)
    size = np.clip(np.round(np.abs(three) * np.sqrt(2.0) * 511), 0, 511).astype(np.uint32)
    parts = size | (three < 0).astype(np.uint32) << 9
    words = largest.astype(np.uint32) << 30 | parts[:, 0] << 20 | parts[:, 1] << 10 | parts[:, 2]
    return words.astype("<u4").tobytes()
