"""BO-Leap: a surrogate picks where to begin, a population smooths that, gradients go down (Antonova et al., CoRL 2022).

Nobody keeps a library of it; its parts are scikit-learn's Gaussian process, `cmaes` and this folder's L-BFGS. Each type
has its own surrogate, and all types compete for the next start.
"""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np

from baselines.evaluation import GRADIENT_COST, Evaluator
from baselines.local import OracleMethod
from baselines.methods.cma import WORST, import_cmaes
from baselines.methods.lbfgs import LBFGS
from baselines.parametrisation import Parametrisation
from baselines.starts import SOLVED, Types, choose_templates
from physagent_jax.core.errors import MissingPackageError, UserError
from physagent_jax.forces.schema import ForceField

CANDIDATES = 256
"""Force fields of each type that a surrogate is asked about."""

Known = tuple[list[np.ndarray], list[float]]


@dataclasses.dataclass(frozen=True)
class BOLeap(OracleMethod):
    """Leaps until the budget is spent. Options are those of `OracleMethod`, and these.

    Attributes:
        types: Who says what the actions are.
        confidence: Standard deviations by which the lower bound lies below the mean.
        population: Population of the generation from which the gradients begin.
        spread: Its standard deviation, in |M| v.
        patience: Steps without gain after which a descent ends.
    """

    types: Types = "enumerated"
    confidence: float = 2.0
    population: int = 10
    spread: float = 0.3
    patience: int = 3

    def __post_init__(self):
        super().__post_init__()
        if self.population < 4 or self.patience < 1:
            raise UserError(
                "`population` must be at least 4 and `patience` at least 1",
                got=(self.population, self.patience),
            )

    @property
    def name(self) -> str:
        """As in the registry."""
        return "bo_leap"

    def search(self, evaluator: Evaluator) -> None:
        """First each type once, as far as half of the budget goes; then leap after leap."""
        kinds = choose_templates(evaluator, self.types, self.actions)
        order = evaluator.rng.permutation(len(kinds))[: max(1, int(evaluator.remaining / 2))]
        templates = [self.draw(evaluator, kinds[index]) for index in order]
        known: list[Known] = [([], []) for _ in templates]
        for template, points in zip(templates, known):
            if self._try(evaluator, self.make_unknowns(evaluator, template), template, points) <= SOLVED:
                return
        while True:
            index, start = self._choose(evaluator, templates, known)
            if self._leap(evaluator, start, known[index]) <= SOLVED:
                return

    def _leap(self, evaluator: Evaluator, start: ForceField, points: Known) -> float:
        """One generation about ``start``, then gradients from its mean; the best loss."""
        unknowns = self.make_unknowns(evaluator, start)
        if unknowns.size == 0:
            return self._try(evaluator, unknowns, start, points)
        best, field = np.inf, start
        if evaluator.remaining > self.population + 2 * GRADIENT_COST:
            generation = import_cmaes().CMA(
                mean=unknowns.encode(start),
                sigma=self.spread,
                population_size=self.population,
                seed=int(evaluator.rng.integers(2**31)),
            )
            told = []
            for _ in range(self.population):
                u = generation.ask()
                loss = self._try(evaluator, unknowns, unknowns.decode(u), points)
                told.append((u, min(loss, WORST)))
                best = min(best, loss)
                if best <= SOLVED:
                    return best
            generation.tell(told)
            field = unknowns.decode(generation.mean)
        stagnant, least = 0, np.inf
        begun = len(evaluator.evaluations)
        for loss in LBFGS(windows=self.windows).descend(evaluator, field, evaluator.remaining):
            stagnant = 0 if loss < 0.999 * least else stagnant + 1
            least = min(least, loss)
            if least <= SOLVED or stagnant >= self.patience:
                break
        for each in evaluator.evaluations[begun:]:
            self._learn(unknowns, each.force_field, each.objective, points)
        return min(best, least)

    def _try(
        self, evaluator: Evaluator, unknowns: Parametrisation, field: ForceField, points: Known
    ) -> float:
        loss = evaluator.score(field, "surrogate").loss
        self._learn(unknowns, field, loss, points)
        return loss

    def _learn(self, unknowns: Parametrisation, field: ForceField, loss: float | None, points: Known) -> None:
        """Losses span decades, so that their logarithm is modelled; what failed is as bad as the worst."""
        if loss is None:
            return
        worst = max(points[1], default=0.0)
        points[0].append(unknowns.encode(field))
        points[1].append(float(np.log(loss + 1e-9)) if np.isfinite(loss) else worst)

    def _choose(
        self, evaluator: Evaluator, templates: list[ForceField], known: list[Known]
    ) -> tuple[int, ForceField]:
        """The type and the force field with the lowest confidence bound."""
        everything = np.concatenate([values for _, values in known])
        scale = max(float(everything.std()), 1e-3)
        best = (np.inf, 0, templates[0])
        for index, (template, (points, values)) in enumerate(zip(templates, known)):
            unknowns = self.make_unknowns(evaluator, template)
            if unknowns.size == 0:  # there is one such force field, and it has been tried
                continue
            fields = [self.draw(evaluator, template) for _ in range(CANDIDATES)]
            mean, deviation = predict(
                np.array(points),
                (np.array(values) - everything.mean()) / scale,
                np.array([unknowns.encode(field) for field in fields]),
            )
            bound = mean - self.confidence * deviation
            least = int(np.argmin(bound))
            if bound[least] < best[0]:
                best = (float(bound[least]), index, fields[least])
        return best[1], best[2]


def predict(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation of a Gaussian process through what is known; prior mean 0, prior deviation 1.

    Args:
        x: Known points, shape (n, p).
        y: Their values, shape (n,).
        at: Where to predict, shape (m, p).

    Raises:
        MissingPackageError: scikit-learn is not installed.
    """
    try:
        from sklearn.exceptions import ConvergenceWarning  # pyright: ignore[reportMissingImports]
        from sklearn.gaussian_process import GaussianProcessRegressor  # pyright: ignore[reportMissingImports]
        from sklearn.gaussian_process.kernels import Matern, WhiteKernel  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise MissingPackageError("this method needs the package `scikit-learn`", "baselines") from None
    kernel = Matern(1.0, (0.2, 5.0), nu=2.5) + WhiteKernel(1e-3, (1e-5, 1e-1))
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", ConvergenceWarning
        )  # of lengths at the ends of their range: as good as any
        model = GaussianProcessRegressor(kernel, normalize_y=False, random_state=0).fit(x, y)
        mean, deviation = (np.asarray(each) for each in model.predict(at, return_std=True))
    return mean, deviation
