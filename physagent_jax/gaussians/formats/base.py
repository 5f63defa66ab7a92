"""The interface of a splat file format, and the Gaussians that a reader hands on."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

HEAD_BYTES = 2**20  # a glTF file may name its extensions late in its JSON
"""Length of the beginning of a file by which formats are told apart [bytes]."""

SignedAxis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]


@dataclasses.dataclass(frozen=True)
class SplatData:
    """The Gaussians of a file: linear units, the file's own frame and precision, nothing dropped yet.

    Attributes:
        means: Centres [file units], float64, shape (n, 3).
        quats: Rotations wxyz of any norm, float64, shape (n, 4).
        scales: Standard deviations [file units], float64, shape (n, 3); 0 along the normal of a flat Gaussian.
        opacities: Opacities in [0, 1], float64, shape (n,); NaN where the file holds none that means something.
        sh: Coefficients of spherical harmonics, float64, shape (n, (degree + 1)^2, 3).
        encoding: The reading in words ("log scales, logit opacities, SH of degree 3, float32").
        up: The up axis that the format prescribes or the file states; None = neither does.
        notes: Sentences that a user should read before a run.
    """

    means: np.ndarray
    quats: np.ndarray
    scales: np.ndarray
    opacities: np.ndarray
    sh: np.ndarray
    encoding: str
    up: SignedAxis | None = None
    notes: tuple[str, ...] = ()


class Format(Protocol):
    """A splat file format."""

    @property
    def name(self) -> str:
        """The format's name as its users write it ("3DGS PLY")."""
        ...

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Usual file name endings, for messages; a format is found by content, not by name."""
        ...

    def matches(self, head: bytes) -> bool:
        """Return whether a file that begins with ``head`` (at most `HEAD_BYTES`) is of this format."""
        ...

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Read a file.

        Args:
            path: The file.
            encoding: The user's reading of ambiguous values (`--splat-encoding`); None = found from the content.

        Raises:
            UserError: The file is damaged, announces more than it holds, or is ambiguous.
        """
        ...
