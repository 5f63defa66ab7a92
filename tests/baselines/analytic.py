"""Simulators with a closed form in the place of the real one: methods meet them through the same evaluator."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np

from baselines.evaluation import Evaluator
from baselines.protocol import Budget
from physagent_jax.forces.parameters import ActionParameters, ForceFieldParameters
from physagent_jax.forces.schema import ForceField
from tests.baselines.tiny import act

FRAMES = 11


def pushes(parameters: ForceFieldParameters) -> np.ndarray:
    """M v of all actions, shape (3 actions,)."""
    return np.concatenate(
        [np.asarray(a.magnitude) * np.asarray(a.vector, float) for a in parameters.actions] or [np.zeros(0)]
    )


@dataclasses.dataclass
class Linear:
    """r = A (M v) - b for the wanted kinds of actions; of others, r is far larger whatever their numbers."""

    A: np.ndarray
    b: np.ndarray
    kinds: tuple[str, ...] | None = None
    calls: int = 0

    def simulate(self, force_field: ForceField):
        self.calls += 1
        return force_field

    def compute_residuals(self, rollout: ForceField) -> np.ndarray:
        return self.replay(rollout, ForceFieldParameters.of(rollout, FRAMES))

    def replay(self, rollout: ForceField, parameters: ForceFieldParameters) -> np.ndarray:
        u = pushes(parameters)
        if not self._is_wanted(rollout):
            return np.full(len(self.b), 30.0) + 0.01 * np.resize([*u, 0.0], len(self.b))
        return self.A @ u - self.b

    def differentiate(self, rollout: ForceField, parameters: ForceFieldParameters):
        r = self.replay(rollout, parameters)
        slope = self.A.T @ r if self._is_wanted(rollout) else np.zeros(3 * len(parameters.actions))
        entries = [
            ActionParameters(np.asarray(a.magnitude) * s, np.asarray(np.asarray(a.vector) @ s), np.zeros(2))
            for a, s in zip(parameters.actions, slope.reshape(-1, 3))
        ]
        return r, ForceFieldParameters(tuple(entries))

    def _is_wanted(self, force_field: ForceField) -> bool:
        kinds = tuple(action.action_type for action in force_field.actions)
        return kinds == self.kinds or (self.kinds is None and 3 * len(kinds) == self.A.shape[1])


def make_evaluator(
    simulation, start: ForceField | None = None, budget: float = 100.0, seed: int = 0, expert=None
) -> Evaluator:
    spec = SimpleNamespace(name="analytic", expert=expert)
    start = start or act("translation", (0.0, 0.6, 0.8), 1.0)
    task = SimpleNamespace(spec=spec, start=start, frame_count=FRAMES)
    return Evaluator(task, Budget(budget), seed, simulation=simulation)  # type: ignore[arg-type]
