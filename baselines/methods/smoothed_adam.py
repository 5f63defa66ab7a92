"""Adam on a smoothed loss: gradients at scattered points, exact and by differences, weighted by their variances.

Where contact makes the loss rough an exact gradient has little to do with the way down (Suh et al. 2022, "Do
differentiable simulators give better policy gradients?"). The exact gradients of antithetic samples and the estimate
from their values, which costs nothing more, are combined coordinate by coordinate by the inverse of their variances.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from baselines.evaluation import FAILED, GRADIENT_COST, Evaluator, Score
from baselines.methods.adam import Adam
from baselines.parametrisation import Parametrisation
from physagent_jax.core.errors import UserError


@dataclasses.dataclass(frozen=True)
class SmoothedAdam(Adam):
    """Options are those of `Adam`, and these.

    Attributes:
        samples: Samples of a gradient, an even number.
        width: Standard deviation of their scatter, in |M| v.
    """

    samples: int = 4
    width: float = 0.05

    def __post_init__(self):
        super().__post_init__()
        if self.samples < 2 or self.samples % 2:
            raise UserError("`samples` must be an even number of at least 2", got=self.samples)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "smoothed_adam"

    @property
    def stochastic(self) -> bool:
        """Always."""
        return True

    @property
    def iteration_cost(self) -> float:
        """Forward-equivalents; the samples lie near enough to share one schedule."""
        return 1.0 + self.samples * GRADIENT_COST

    def find_slope(
        self, evaluator: Evaluator, unknowns: Parametrisation, u: np.ndarray
    ) -> tuple[Score, np.ndarray]:
        """The mean loss of the samples, and the gradient of the smoothed loss."""
        half = evaluator.rng.normal(size=(self.samples // 2, unknowns.size))
        noise = np.concatenate([half, -half])
        losses, slopes = [], []
        for each in noise:
            score, gradient = super().find_slope(evaluator, unknowns, u + self.width * each)
            if score.failed:
                return FAILED, np.zeros(unknowns.size)
            losses.append(score.loss)
            slopes.append(gradient)
        return Score(float(np.mean(losses)), np.zeros(0)), combine(
            np.array(slopes), np.array(losses), noise, self.width
        )


def combine(slopes: np.ndarray, losses: np.ndarray, noise: np.ndarray, width: float) -> np.ndarray:
    """Exact gradients and differences of antithetic samples, weighted by inverse variances of their means.

    Args:
        slopes: Exact gradients at the samples, shape (k, p).
        losses: There, shape (k,); sample i + k/2 lies opposite sample i.
        noise: Standard normal, shape (k, p).
        width: Their scale.
    """
    half = len(losses) // 2
    exact = 0.5 * (slopes[:half] + slopes[half:])
    differences = (losses[:half] - losses[half:])[:, None] / (2.0 * width) * noise[:half]
    if half < 2:
        return exact.mean(0)  # a variance needs two
    spread = [np.var(each, axis=0, ddof=1) / half + 1e-30 for each in (exact, differences)]
    weight = spread[1] / (spread[0] + spread[1])
    return weight * exact.mean(0) + (1.0 - weight) * differences.mean(0)
