"""Adam on |M| v, through the simulator (Kingma & Ba 2015, from optax).

Dimensionless unknowns, a rate that falls to a tenth by a cosine, clipped gradients, the best that was seen, and short
memories: a budget has 10 to 40 iterations, and the field's (0.9, 0.99) looks back as far as that and swings. On random
linear problems of 3 and 6 unknowns with paths as long as the tasks' and conditions of 1 to 13, nine in ten searches of
12 to 40 iterations come within a tolerance with (0.5, 0.8), three in ten with (0.9, 0.99) at the best rate for it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
import optax

from baselines.evaluation import GRADIENT_COST, Evaluator, Score
from baselines.local import LocalMethod
from baselines.parametrisation import Parametrisation
from baselines.starts import SOLVED, Descent
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField

Slope = Callable[[np.ndarray], tuple[Score, np.ndarray]]
"""The loss and its gradient at unknowns."""

TRAVEL = 12.0
"""[|M| v] of a search, were all its steps as long as the first."""

RATES = (0.1, 0.3)
"""[|M| v] from which the first rate is taken: with 0.5 a search from near begins by leaving."""

MEMORIES = (0.5, 0.8)
"""Decay rates of the means of the gradient and of its square."""


@dataclasses.dataclass(frozen=True)
class Adam(LocalMethod):
    """Options are those of `LocalMethod`, and these.

    Attributes:
        learning_rate: At first, in |M| v; None = `TRAVEL` over the iterations, within `RATES`.
        most: Iterations at most; fewer where the budget has fewer.
    """

    learning_rate: float | None = None
    most: int = 200

    def __post_init__(self):
        super().__post_init__()
        if self.learning_rate is not None and not 0 < self.learning_rate <= 10:
            raise UserError("`learning_rate` must be above 0 and at most 10", got=self.learning_rate)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "adam"

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents of two iterations: the gain of a step is seen by the next."""
        del start
        return 2.0 * self.iteration_cost

    @property
    def iteration_cost(self) -> float:
        """Forward-equivalents; a step is too long for the schedule of the one before, as a rule."""
        return 1.0 + GRADIENT_COST

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """One gradient a step."""
        unknowns = Parametrisation(start, evaluator.task.frame_count, self.windows)
        if unknowns.size == 0:
            return iter([evaluator.score(start, "start").loss])
        count = int(np.clip(budget / self.iteration_cost, 10, self.most))

        def slope(u: np.ndarray) -> tuple[Score, np.ndarray]:
            return self.find_slope(evaluator, unknowns, u)

        rate = self.learning_rate or float(np.clip(TRAVEL / count, *RATES))
        return descend_adam(slope, unknowns, unknowns.encode(start), rate, count)

    def find_slope(
        self, evaluator: Evaluator, unknowns: Parametrisation, u: np.ndarray
    ) -> tuple[Score, np.ndarray]:
        """The loss and its gradient."""
        field = unknowns.decode(u)
        score, gradient = evaluator.gradient(field, "gradient")
        return score, unknowns.pull_back(field, gradient)


def descend_adam(
    slope: Slope, unknowns: Parametrisation, u: np.ndarray, learning_rate: float, count: int
) -> Descent:
    """Projected Adam; gradients are those of the loss over the first loss, clipped to norm 1."""
    schedule = optax.cosine_decay_schedule(learning_rate, count, alpha=0.1)
    optimiser = optax.chain(optax.clip_by_global_norm(1.0), optax.adam(schedule, *MEMORIES))
    moments = optimiser.init(jnp.asarray(u))
    best, best_u, unit = np.inf, u, None
    for _ in range(count):
        score, gradient = slope(u)
        if score.failed:
            if unit is None:
                return  # nowhere to go back to
            u = unknowns.project(best_u + 0.25 * (u - best_u))
            yield best
            continue
        unit = unit or max(score.loss, 1e-12)
        if score.loss < best:
            best, best_u = score.loss, u
        yield best
        if best <= SOLVED:
            return
        updates, moments = optimiser.update(jnp.asarray(gradient / unit), moments)
        u = unknowns.project(u + np.asarray(updates, float))
