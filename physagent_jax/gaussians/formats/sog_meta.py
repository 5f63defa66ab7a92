"""The schema of a SOG bundle's ``meta.json``, versions 1 and 2, and the values that its bytes stand for."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from physagent_jax.core.errors import UserError

_MOST_ENTRIES = 65536  # of a codebook or a palette: two bytes point into it

_Codebook = Annotated[list[float], Field(min_length=1, max_length=_MOST_ENTRIES)]
_Bounds = Annotated[list[float], Field(min_length=3, max_length=4)]
_Pair = Annotated[list[str], Field(min_length=2, max_length=2)]


class _Lenient(BaseModel):
    """A schema that passes over keys that it does not know: writers add their own."""

    model_config = ConfigDict(extra="ignore", allow_inf_nan=False)


class Positions(_Lenient):
    """Positions.

    Attributes:
        files: Images of the low and of the high bytes.
        mins, maxs: Bounds of sign(x) log(1 + |x|).
        shape: The number of Gaussians and 3 (version 1).
    """

    files: _Pair
    mins: _Bounds
    maxs: _Bounds
    shape: list[int] = []


class Attribute(_Lenient):
    """Another attribute.

    Attributes:
        files: Its image.
        mins, maxs: Bounds of the values (version 1).
        codebook: The values (version 2).
    """

    files: Annotated[list[str], Field(min_length=1, max_length=1)]
    mins: _Bounds | None = None
    maxs: _Bounds | None = None
    codebook: _Codebook | None = None

    def decode(self, levels: np.ndarray, shown: str) -> np.ndarray:
        """Values that bytes stand for: entries of the codebook, or places between the bounds.

        Args:
            levels: Bytes, shape (n, 3).
            shown: The bundle, for messages.
        """
        if self.codebook is not None:
            return look_up(self.codebook, levels, shown)
        if self.mins is None or self.maxs is None:
            raise explain_damage(shown, "neither a codebook nor bounds")
        return interpolate(self.mins, self.maxs, levels / 255.0)


class Harmonics(_Lenient):
    """Higher spherical harmonics.

    Attributes:
        files: Images of the palette and of the Gaussians' entries.
        count: Entries of the palette (version 2).
        bands: Degree of the harmonics (version 2).
        codebook: Values (version 2).
        mins, maxs: Bounds of the values (version 1).
    """

    files: _Pair
    count: Annotated[int, Field(ge=1, le=_MOST_ENTRIES)] | None = None
    bands: Annotated[int, Field(ge=0, le=3)] | None = None
    codebook: _Codebook | None = None
    mins: float | None = None
    maxs: float | None = None

    def decode(self, levels: np.ndarray, shown: str) -> np.ndarray:
        """Values that bytes stand for; arguments as of `Attribute.decode`."""
        if self.codebook is not None:
            return look_up(self.codebook, levels, shown)
        if self.mins is None or self.maxs is None:
            raise explain_damage(shown, "neither a codebook nor bounds of `shN`")
        return self.mins + (self.maxs - self.mins) * levels / 255.0


class SogMeta(_Lenient):
    """``meta.json``.

    Attributes:
        version: 1 or 2; files of version 1 do not say it.
        count: Gaussians (version 2).
        means, scales, quats, sh0, shN: Attributes of the Gaussians.
    """

    version: Literal[1, 2] = 1
    count: Annotated[int, Field(ge=1, le=2**32)] | None = None
    means: Positions
    scales: Attribute
    quats: Attribute
    sh0: Attribute
    shN: Harmonics | None = None

    @property
    def gaussian_count(self) -> int:
        """Number of Gaussians, 0 if the file does not say it."""
        return self.count if self.count is not None else (*self.means.shape, 0)[0]


def interpolate(low: list[float], high: list[float], parts: np.ndarray) -> np.ndarray:
    """Values between bounds of the three axes.

    Args:
        low: Lower bounds; of four, the last is another attribute's.
        high: Upper bounds.
        parts: Fractions, shape (n, 3).
    """
    return np.asarray(low[:3]) + (np.asarray(high[:3]) - np.asarray(low[:3])) * parts


def look_up(codebook: list[float], levels: np.ndarray, shown: str) -> np.ndarray:
    """Entries of a codebook.

    Raises:
        UserError: It has too few.
    """
    if int(levels.max(initial=0)) >= len(codebook):
        raise explain_damage(shown, f"entry {levels.max()} of a codebook of {len(codebook)}")
    return np.asarray(codebook, np.float64)[levels]


def explain_damage(shown: str, found: str) -> UserError:
    """The error of a bundle that cannot be decoded."""
    return UserError(f"{shown} is a damaged SOG bundle", got=found, do="Copy or export the scene again")
