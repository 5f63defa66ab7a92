"""Reading antimatter15's `.splat`: 32 bytes for each Gaussian, without a header.

Layout (the reader and converter of antimatter15/splat): position as three float32, scale as three float32 (standard
deviations, not their logarithms), colour and opacity as four bytes, and the rotation as four bytes
``128 + 128 q`` of the unit quaternion wxyz. Nothing names the format, so that it is known by values that make sense.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import read_bytes, shorten
from physagent_jax.gaussians.formats.base import SplatData
from physagent_jax.gaussians.formats.packing import colours_to_sh
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES

ROW = np.dtype([("position", "<f4", 3), ("scale", "<f4", 3), ("colour", "u1", 4), ("rotation", "u1", 4)])
_FARTHEST = 1e6  # larger positions and scales are taken for bytes of something else
_NORM_ERROR = 0.05  # of a unit quaternion whose components are rounded down to 1/128
_SENSIBLE = 0.98  # share of the rows: a capture has a few that make no sense


class _Antimatter15:
    """antimatter15's `.splat`. It comes last: it goes by values alone."""

    name = ".splat (antimatter15)"
    suffixes = (".splat",)

    def matches(self, head: bytes) -> bool:
        """Return whether the bytes, in rows of 32, are Gaussians whose values make sense."""
        rows = np.frombuffer(head, ROW, len(head) // ROW.itemsize)
        return len(rows) > 0 and bool(np.mean(_find_sensible(rows)) >= _SENSIBLE)

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Read a file; its values have one meaning, so that ``encoding`` changes nothing.

        Raises:
            UserError: It holds no whole number of rows, or most of them make no sense.
        """
        shown, data = shorten(path), read_bytes(path, most=MOST_BYTES)
        if len(data) == 0 or len(data) % ROW.itemsize:
            raise UserError(
                f"{shown} is truncated or no .splat file",
                got=f"{len(data):,} bytes, not a multiple of {ROW.itemsize}",
                do="Copy or export the file again",
            )
        rows = np.frombuffer(data, ROW)
        if np.mean(_find_sensible(rows)) < _SENSIBLE:
            raise UserError(
                f"{shown} is damaged or no .splat file",
                got=f"{np.mean(_find_sensible(rows)):.0%} of the rows are Gaussians that make sense",
                do="Copy or export the file again",
            )
        with np.errstate(invalid="ignore"):  # signalling NaNs: such Gaussians are dropped
            means, scales = rows["position"].astype(np.float64), rows["scale"].astype(np.float64)
        return SplatData(
            means=means,
            quats=(rows["rotation"].astype(np.float64) - 128.0) / 128.0,
            scales=scales,
            opacities=rows["colour"][:, 3] / 255.0,
            sh=colours_to_sh(rows["colour"][:, None, :3] / 255.0),
            encoding="float32 positions, plain scales, 8-bit colours and rotations, SH of degree 0",
        )


ANTIMATTER15 = _Antimatter15()


def _find_sensible(rows: np.ndarray) -> np.ndarray:
    """Rows that can be Gaussians, shape (n,)."""
    with np.errstate(invalid="ignore"):
        near = (np.abs(rows["position"]) <= _FARTHEST).all(axis=1)  # False for NaN
        sized = ((rows["scale"] >= 0) & (rows["scale"] <= _FARTHEST)).all(axis=1)
    norms = np.linalg.norm((rows["rotation"].astype(np.float64) - 128.0) / 128.0, axis=1)
    return near & sized & (np.abs(norms - 1.0) <= _NORM_ERROR)
