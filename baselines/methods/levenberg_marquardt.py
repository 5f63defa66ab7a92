"""Levenberg-Marquardt on the target's residuals: few unknowns, so that a Jacobian costs as many simulations.

Damping is Levenberg's, with Nielsen's update (Madsen, Nielsen & Tingleff 2004, "Methods for non-linear least
squares problems", 3.2). Directions in which the skill library's range ends take no part in a step (active set); what
is left of it is projected to the range, and its gain is judged after that. While steps gain what they promise, the
Jacobian is updated by Broyden's formula (there, 3.5), which costs no simulation; else it is made anew.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Generator

import numpy as np

from baselines.evaluation import Evaluator
from baselines.local import LocalMethod
from baselines.parametrisation import Parametrisation
from baselines.starts import SOLVED, Descent
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField

TRUSTED = 0.5
"""Gain of a step, in shares of what was promised, from which the Jacobian is updated only."""

COARSE = 0.03
"""[|M| v] of a step at which what is sought first has settled well enough for the rest to be sought too."""


@dataclasses.dataclass(frozen=True)
class LevenbergMarquardt(LocalMethod):
    """Options are those of `LocalMethod`, and these.

    Attributes:
        damping: Damping of the first step, in shares of the greatest element of J^T J's diagonal; the same for
            all unknowns,
            which are of one size, so that those that hardly matter stay where they are.
        shortest: Step at which it has converged, in |M| v.
    """

    damping: float = 1e-2
    shortest: float = 2e-3

    def __post_init__(self):
        super().__post_init__()
        if not self.damping > 0:
            raise UserError("`damping` must be positive: steps are shortened by it", got=self.damping)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "levenberg_marquardt"

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents of the first step."""
        return 1.0 + (1.0 if self._told else 3.0) * (len(start.actions) + len(start.constraints))

    @property
    def _told(self) -> bool:
        """Return whether directions are worked out already."""
        return self.types == "responses"

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """One trial a step.

        What is dear is sought once the rest has settled: windows, and directions where responses have told them, which
        are three times as many unknowns as strengths alone.
        """
        del budget
        stages = [dict(directions=False)] if self._told else []
        stages += [dict(), dict(windows=True)] if self.windows else [dict()]
        field = start
        for options in stages:
            shortest = self.shortest if options is stages[-1] else COARSE
            unknowns = Parametrisation(field, evaluator.task.frame_count, **options)
            if unknowns.size == 0:
                yield evaluator.score(start, "start").loss
                return
            field = yield from self._settle(evaluator, unknowns, field, shortest)

    def _settle(
        self, evaluator: Evaluator, unknowns: Parametrisation, start: ForceField, shortest: float
    ) -> Generator[float, None, ForceField]:
        """Steps until they are ``shortest`` by a Jacobian that was made there; where it ends."""
        u, damping, growth, best = unknowns.encode(start), self.damping, 2.0, start
        longest, fresh = np.inf, True
        score, jacobian = evaluator.jacobian(start, unknowns, "start")
        if score.failed:
            return best
        yield score.loss
        while score.loss > SOLVED:
            normal, slope = restrict(jacobian, score.residuals, unknowns, u)
            step = _step(unknowns, u, normal, slope, damping)
            while np.linalg.norm(step) > longest:
                damping *= growth
                step = _step(unknowns, u, normal, slope, damping)
            if np.linalg.norm(step) < shortest and fresh:
                break
            trial, gain = None, -1.0
            if np.linalg.norm(step) >= shortest:
                field = unknowns.decode(u + step)
                trial = evaluator.score(field, "trial")
                expected = -(slope @ step + 0.5 * step @ normal @ step)
                gain = (score.loss - trial.loss) / expected if expected > 0 else -1.0
            if trial is not None and gain > 1e-3:
                step, growth, best, longest = unknowns.encode(field) - u, 2.0, field, np.inf
                u = u + step
                damping *= max(1.0 / 3.0, 1.0 - float(2.0 * gain - 1.0) ** 3)
                jacobian = update(jacobian, step, trial.residuals - score.residuals)
                score, fresh = trial, False
                yield score.loss
                if score.loss > SOLVED and gain < TRUSTED:
                    (score, jacobian), fresh = evaluator.jacobian(field, unknowns), True
                continue
            if trial is not None:  # by the damping alone it comes back slowly from what tore
                longest = 0.5 * float(np.linalg.norm(step))
            if fresh:
                damping, growth = damping * growth, 2.0 * growth
            else:
                (score, jacobian), fresh = evaluator.jacobian(best, unknowns), True
            yield score.loss
        return best


def restrict(
    jacobian: np.ndarray, residuals: np.ndarray, unknowns: Parametrisation, u: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """J^T J and J^T r without the directions in which descent would leave the library's range."""
    blocked = unknowns.list_blocked(u, -jacobian.T @ residuals)
    free = jacobian - (jacobian @ blocked.T) @ blocked
    return free.T @ free, free.T @ residuals


def update(jacobian: np.ndarray, step: np.ndarray, change: np.ndarray) -> np.ndarray:
    """The Jacobian nearest to ``jacobian`` that gives the ``change`` of the residuals over ``step`` (Broyden 1965)."""
    return jacobian + np.outer(change - jacobian @ step, step) / (step @ step)


def _step(unknowns: Parametrisation, u: np.ndarray, normal, slope, damping: float) -> np.ndarray:
    ridge = (np.diag(normal).max() + 1e-12) * np.eye(len(u))
    return unknowns.project(u - np.linalg.solve(normal + damping * ridge, slope)) - u
