"""The base of every JSON schema, immutable and strict, and the ranges that every number from outside keeps.

The general rule: a number is at most `LARGEST` in magnitude, and one that may be divided by (`Positive`) at least
its inverse. The simulation computes in float32, which ends at 3e38 and 1e-38: squares of such numbers, and
inverses of the squares, are still numbers there. Real quantities in SI units lie far inside, from a virus (1e-8 m)
to the bulk modulus of a nearly incompressible diamond (2e14 Pa). What physics bounds more tightly has its own
range where it is declared. Schemas of what was measured (`Vector`, plain floats) are only required to be finite.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

Vector = tuple[float, float, float]

LARGEST = 1e15
Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(ge=1 / LARGEST, le=LARGEST)]
NonNegative = Annotated[float, Field(ge=0, le=LARGEST)]
Seed = Annotated[int, Field(ge=0, lt=2**32)]
"""Seed of a random generator: NumPy's and JAX's both take it."""
Numbers = tuple[Number, Number, Number]
Count = Annotated[int, Field(ge=0, lt=2**63)]


class Strict(BaseModel):
    """Immutable, refuses unknown keys and numbers that are not finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def read_numbers(value: Any, count: int) -> tuple | None:
    """``value`` as that many finite numbers, or None."""
    if not isinstance(value, (list, tuple)) or len(value) != count:
        return None
    try:
        numbers = tuple(float(v) for v in value)
    except (TypeError, ValueError, OverflowError):
        return None
    return numbers if all(math.isfinite(v) and abs(v) < 1e12 for v in numbers) else None


_ROUND_OFF = 1e-15  # of the length of a vector that was normalised


def normalise_direction(value: Vector) -> Vector:
    """Normalise a direction; a zero vector is refused, and one that is normalised stays as it is, to the last bit."""
    norm = math.sqrt(sum(c * c for c in value))
    if norm < 1e-9:
        raise ValueError(f"a direction must not be the zero vector (got {list(value)})")
    if abs(norm - 1.0) < _ROUND_OFF:
        return value
    return (value[0] / norm, value[1] / norm, value[2] / norm)


Direction = Annotated[Numbers, AfterValidator(normalise_direction)]
"""Normalised on input, zero refused."""
