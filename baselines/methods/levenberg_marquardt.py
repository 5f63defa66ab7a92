"""Levenberg-Marquardt on the target's residuals: few unknowns, so that a Jacobian costs as many simulations.

Damping is Levenberg's, with Nielsen's update (Madsen, Nielsen & Tingleff 2004, "Methods for non-linear least
squares problems", 3.2). Steps are projected to what the skill library allows, and their gain is judged after that.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Generator

import numpy as np

from baselines.evaluation import Evaluator
from baselines.parametrisation import Parametrisation
from baselines.starts import SOLVED, Descent, LocalMethod
from physagent_jax.forces.schema import ForceField

COARSE = 0.03
"""[|M| v] of a step at which numbers have settled well enough for windows to be sought."""


@dataclasses.dataclass(frozen=True)
class LevenbergMarquardt(LocalMethod):
    """Options are those of `LocalMethod`, and these.

    Attributes:
        damping: Of the first step, in shares of the greatest element of J^T J's diagonal; the same for all unknowns,
            which are of one size, so that those that hardly matter stay where they are.
        shortest: Step at which it has converged, in |M| v.
    """

    damping: float = 1e-2
    shortest: float = 2e-3

    @property
    def name(self) -> str:
        """As in the registry."""
        return "levenberg_marquardt"

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents of a step, with the windows as they are."""
        return 1.0 + 3.0 * (len(start.actions) + len(start.constraints))

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """One trial a step; windows, which double the unknowns nearly, are sought once the rest has settled."""
        del budget
        stages = ((False, COARSE), (True, self.shortest)) if self.windows else ((False, self.shortest),)
        field = start
        for windows, shortest in stages:
            unknowns = Parametrisation(field, evaluator.task.frame_count, windows)
            if unknowns.size == 0:
                yield evaluator.score(start, "start").loss
                return
            field = yield from self._settle(evaluator, unknowns, field, shortest)

    def _settle(
        self, evaluator: Evaluator, unknowns: Parametrisation, start: ForceField, shortest: float
    ) -> Generator[float, None, ForceField]:
        """Steps until they are ``shortest``, those that gain followed by a Jacobian; where it ends."""
        u, damping, growth, best = unknowns.encode(start), self.damping, 2.0, start
        score, jacobian = evaluator.jacobian(start, unknowns, "start")
        if score.failed:
            return best
        yield score.loss
        while score.loss > SOLVED:
            normal, slope = jacobian.T @ jacobian, jacobian.T @ score.residuals
            ridge = (damping * np.diag(normal).max() + 1e-12) * np.eye(len(u))
            step = unknowns.project(u - np.linalg.solve(normal + ridge, slope)) - u
            if np.linalg.norm(step) < shortest:
                break
            field = unknowns.decode(u + step)
            trial = evaluator.score(field, "trial")
            expected = -(slope @ step + 0.5 * step @ normal @ step)
            gain = (score.loss - trial.loss) / expected if expected > 0 else -1.0
            if gain > 1e-3:
                u, growth, best = unknowns.encode(field), 2.0, field
                damping *= max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3)
                score = trial
                yield score.loss
                if score.loss > SOLVED:
                    score, jacobian = evaluator.jacobian(field, unknowns)
            else:
                damping, growth = damping * growth, 2.0 * growth
                yield score.loss
        return best
