"""CMA-ES on |M| v, one search per type (Hansen 2016; package `cmaes`)."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from baselines.evaluation import Evaluator
from baselines.local import LocalMethod
from baselines.parametrisation import Parametrisation
from baselines.starts import SOLVED, Descent, Types
from physagent_jax.core.errors import MissingPackageError
from physagent_jax.forces.calibration import MAGNITUDE_MAX
from physagent_jax.forces.schema import ForceField

WORST = 1e12
"""Loss of what cannot be simulated: ranks last."""


@dataclasses.dataclass(frozen=True)
class CMA(LocalMethod):
    """Options are those of `LocalMethod`, whose types are all enumerated here by default, and these.

    Attributes:
        spread: Standard deviation at first, in |M| v.
    """

    types: Types = "enumerated"
    spread: float = 0.5

    @property
    def name(self) -> str:
        """As in the registry."""
        return "cma"

    @property
    def stochastic(self) -> bool:
        """Always."""
        return True

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents of a step: a generation's."""
        return 4.0 + 3.0 * math.log(max(self.count_unknowns(start), 1))

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """One simulation a step, until the search has converged."""
        del budget
        unknowns = Parametrisation(start, evaluator.task.frame_count, self.windows)
        mean = unknowns.encode(start)
        if len(mean) == 0:
            yield evaluator.score(start).loss
            return
        low = np.tile([-MAGNITUDE_MAX] * 3 + [0.0] * (unknowns.stride - 3), len(unknowns.entries))
        high = np.tile([MAGNITUDE_MAX] * 3 + [1.0] * (unknowns.stride - 3), len(unknowns.entries))
        library = import_cmaes()
        search = library.CMA(
            mean=np.clip(mean, low + 1e-6, high - 1e-6),
            sigma=self.spread,
            bounds=np.stack([low, high], axis=1),
            seed=int(evaluator.rng.integers(2**31)),
        )
        best = np.inf
        while not search.should_stop():
            told = []
            for _ in range(search.population_size):
                u = search.ask()
                loss = evaluator.score(unknowns.decode(u)).loss
                told.append((u, min(loss, WORST)))
                best = min(best, loss)
                yield best
                if best <= SOLVED:
                    return
            search.tell(told)


def import_cmaes():
    """The package.

    Raises:
        MissingPackageError: It is not installed.
    """
    try:
        import cmaes  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise MissingPackageError("this method needs the package `cmaes`", "baselines") from None
    return cmaes
