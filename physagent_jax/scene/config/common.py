"""Types that the parts of a scene share."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from physagent_jax.core.strict import Strict

FOREVER = 1e9  # [s]; the end of a window that never closes
SignedAxis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]


class Windowed(Strict):
    """Active for start <= time < end [s]."""

    start: NonNegative = 0.0
    end: float = FOREVER

    @model_validator(mode="after")
    def _ordered(self):
        if self.end <= self.start:
            raise ValueError(f"`end` must exceed `start` (got start={self.start}, end={self.end})")
        return self
