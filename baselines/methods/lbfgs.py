"""L-BFGS (Nocedal & Wright 2006, algorithm 7.4) with a line search that is fit for simulations.

Its probes are plain simulations, less than a quarter of a gradient's cost; the gradient is taken where a probe is
accepted. Libraries' searches ask for a gradient at every probe, and cannot be stopped in between.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from baselines.evaluation import GRADIENT_COST, Evaluator
from baselines.local import LocalMethod
from baselines.parametrisation import Parametrisation
from baselines.starts import SOLVED, Descent
from physagent_jax.forces.schema import ForceField


@dataclasses.dataclass(frozen=True)
class LBFGS(LocalMethod):
    """Options are those of `LocalMethod`, and these.

    Attributes:
        memory: Pairs that are kept.
        first: Length of the first step, in |M| v.
        shortest: Step at which it has converged.
        probes: Probes of a line search, at most.
    """

    memory: int = 10
    first: float = 0.3
    shortest: float = 2e-3
    probes: int = 8

    @property
    def name(self) -> str:
        """As in the registry."""
        return "lbfgs"

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents of a gradient, a probe and the gradient there."""
        del start
        return 2.0 * (1.0 + GRADIENT_COST)

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """One line search a step."""
        del budget
        unknowns = Parametrisation(start, evaluator.task.frame_count, self.windows)
        if unknowns.size == 0:
            yield evaluator.score(start, "start").loss
            return
        pairs: list[tuple[np.ndarray, np.ndarray]] = []
        u = unknowns.encode(start)
        score, slope = evaluator.gradient(start, "gradient")
        gradient = unknowns.pull_back(start, slope)
        if score.failed:
            return
        yield score.loss
        while score.loss > SOLVED:
            direction = find_direction(gradient, pairs)
            if direction @ gradient >= 0:  # a memory of other curvature
                pairs.clear()
                direction = -gradient
            length = 1.0 if pairs else self.first / max(np.linalg.norm(direction), 1e-30)
            for _ in range(self.probes):
                field = unknowns.decode(u + length * direction)
                step = unknowns.encode(field) - u
                if np.linalg.norm(step) < self.shortest:
                    return
                trial = evaluator.score(field, "line search")
                if trial.loss <= score.loss + 1e-4 * min(0.0, float(gradient @ step)):
                    break
                length *= fit_parabola(score.loss, float(gradient @ step), trial.loss)
                yield score.loss
            else:
                if not pairs:
                    return
                pairs.clear()
                continue
            score, slope = evaluator.gradient(field, "gradient")
            if score.failed:
                return
            known, gradient = gradient, unknowns.pull_back(field, slope)
            u, change = u + step, gradient - known
            if change @ step > 1e-10 * np.linalg.norm(change) * np.linalg.norm(step):
                pairs = [*pairs, (step, change)][-self.memory :]
            yield score.loss


def find_direction(gradient: np.ndarray, pairs: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """The quasi-Newton direction, by the two loops over pairs of (step, change of the gradient)."""
    q, factors = gradient.copy(), []
    for s, y in reversed(pairs):
        a = (s @ q) / (s @ y)
        q -= a * y
        factors.append(a)
    if pairs:
        s, y = pairs[-1]
        q *= (s @ y) / (y @ y)
    for (s, y), a in zip(pairs, reversed(factors)):
        q += (a - (y @ q) / (s @ y)) * s
    return -q


def fit_parabola(value: float, slope: float, trial: float) -> float:
    """The minimum of the parabola through a value with its slope and a trial value at 1, within [0.1, 0.5]."""
    if not np.isfinite(trial) or slope >= 0:
        return 0.25
    return float(np.clip(-slope / (2.0 * (trial - value - slope)), 0.1, 0.5))
