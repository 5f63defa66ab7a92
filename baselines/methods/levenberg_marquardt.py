"""Levenberg-Marquardt on the target's residuals: few unknowns, so that a Jacobian costs as many simulations.

Damping by Marquardt's scaling and Nielsen's update (Madsen, Nielsen & Tingleff 2004, "Methods for non-linear least
squares problems", 3.2). Steps are projected to what the skill library allows, and their gain is judged after that.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from baselines.evaluation import Evaluator
from baselines.parametrisation import Parametrisation
from baselines.starts import SOLVED, Descent, LocalMethod
from physagent_jax.forces.schema import ForceField


@dataclasses.dataclass(frozen=True)
class LevenbergMarquardt(LocalMethod):
    """Options are those of `LocalMethod`, and these.

    Attributes:
        damping: Of the first step, in shares of J^T J's diagonal.
        shortest: Step at which it has converged, in |M| v.
    """

    damping: float = 1e-2
    shortest: float = 2e-3

    @property
    def name(self) -> str:
        """As in the registry."""
        return "levenberg_marquardt"

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents of a step."""
        return 1.0 + self.count_unknowns(start)

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """One trial a step; those that gain are followed by a Jacobian."""
        del budget
        unknowns = Parametrisation(start, evaluator.task.frame_count, self.windows)
        if unknowns.size == 0:
            yield evaluator.score(start, "start").loss
            return
        u, damping, growth = unknowns.encode(start), self.damping, 2.0
        score, jacobian = evaluator.jacobian(start, unknowns, "start")
        if score.failed:
            return
        yield score.loss
        while score.loss > SOLVED:
            normal, slope = jacobian.T @ jacobian, jacobian.T @ score.residuals
            scale = np.maximum(np.diag(normal), 1e-9 * max(normal.max(), 1e-30))
            step = unknowns.project(u - np.linalg.solve(normal + damping * np.diag(scale), slope)) - u
            if np.linalg.norm(step) < self.shortest:
                return
            field = unknowns.decode(u + step)
            trial = evaluator.score(field, "trial")
            expected = -(slope @ step + 0.5 * step @ normal @ step)
            gain = (score.loss - trial.loss) / expected if expected > 0 else -1.0
            if gain > 1e-3:
                u, growth = unknowns.encode(field), 2.0
                damping *= max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3)
                score = trial
                yield score.loss
                if score.loss > SOLVED:
                    score, jacobian = evaluator.jacobian(field, unknowns)
            else:
                damping, growth = damping * growth, 2.0 * growth
                yield score.loss
