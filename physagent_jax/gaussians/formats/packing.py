"""Steps that several compressed formats share: quaternions of three components, colours, bounds on unpacked sizes."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.reading import MIB, check_counts

SH_C0 = 0.28209479177387814
"""The constant spherical harmonic: colour = 0.5 + SH_C0 * coefficient."""

MOST_RATIO = 256
"""Bytes that one stored byte may unpack to; captures reach 2 to 10, and a file made to fill the memory 1,000."""

_OTHERS = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


def check_unpacked_size(place: str, count: int, each: int, stored: int) -> None:
    """Refuse a compressed file that would unpack to far more than captures do, before anything is unpacked.

    Args:
        place: The file, for messages.
        count: Gaussians that the header announces.
        each: Unpacked size of one of them [bytes].
        stored: Size of the file [bytes].

    Raises:
        UserError: ``count`` is negative, or the file is too small for them.
    """
    check_counts(f"{place}, unpacked,", "Gaussians", count, each, MOST_RATIO * stored + MIB)


def expand_smallest_three(three: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Unit quaternions of which the largest component was left out and is positive.

    Args:
        three: The other components in their order, shape (n, 3).
        largest: Place of the one left out, 0 to 3, integers of shape (n,).

    Returns:
        Shape (n, 4), in the file's order of components.
    """
    quats = np.empty((len(three), 4))
    np.put_along_axis(quats, _OTHERS[largest], three, axis=1)
    rest = np.sqrt(np.maximum(1.0 - np.square(three).sum(axis=1), 0.0))
    np.put_along_axis(quats, largest[:, None].astype(np.intp), rest[:, None], axis=1)
    return quats


def colours_to_sh(colours: np.ndarray) -> np.ndarray:
    """Constant coefficients of colours in [0, 1], of the same shape."""
    return (colours - 0.5) / SH_C0


def unpack_rest(channel_major: np.ndarray) -> np.ndarray:
    """Higher coefficients in the order of PLY files (all of red, then green, blue) as (n, k, 3)."""
    return channel_major.reshape(len(channel_major), 3, -1).transpose(0, 2, 1)
