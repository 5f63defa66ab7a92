"""The miss of a target: residuals, their sum of squares, and the same with the worst counting most."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.metrics.task_judge import ROOM

GOOD = 0.5 * ROOM**2
"""Loss at which no residual is beyond `ROOM`, which is a success."""


@dataclasses.dataclass(frozen=True)
class Score:
    """The miss of a force field from the target.

    Attributes:
        loss: |r|^2 / 2; infinite where the simulation failed.
        residuals: r in tolerances, shape (m,); empty where it failed.
    """

    loss: float
    residuals: np.ndarray

    @staticmethod
    def of(residuals: np.ndarray, power: int = 1) -> Score:
        """Of the residuals, `sharpen`ed; a failure if they are not finite."""
        residuals = np.asarray(residuals, np.float64)
        if not np.isfinite(residuals).all():
            return FAILED
        residuals = sharpen(residuals, power)
        return Score(0.5 * float(residuals @ residuals), residuals)

    def find_objective(self, power: int) -> float:
        """The loss of the residuals as they are, if these are `sharpen`ed by ``power``: to be compared with others'.

        What the judge is content with is not worse for the sum of what it does not ask for.
        """
        if power == 1 or self.failed:
            return self.loss
        plain = np.abs(self.residuals / ROOM) ** (1.0 / power) * ROOM
        content = plain.size and plain.max() <= ROOM
        return min(0.5 * float(plain @ plain), GOOD if content else np.inf)

    @property
    def failed(self) -> bool:
        """Return whether there is nothing to go by."""
        return not np.isfinite(self.loss)


FAILED = Score(float("inf"), np.zeros(0))


def sharpen(residuals, power: int):
    """Residuals of which the larger count for more; those of `ROOM`, with which the judge is just content, stay.

    The judge is a greatest miss, least squares are a sum: with a power of 1 two small misses are as bad as one that is
    judged. The greater the power, the more the worst clause counts, to the cost of those that are met anyhow.
    """
    return residuals if power == 1 else residuals * (abs(residuals) / ROOM) ** (power - 1)
