"""Score distillation that moves a force field, step by step: through each picture's last substep, or the whole clip.

It stands where the PhysAgent paper has "DreamPhysics-f", of which it says no more than that forces are moved.
DreamPhysics (Huang et al. 2024) moves Young's modulus by the SDS gradient of a video model. From its public code
`SdsLastSubstep` has 50 iterations, one draw each, every s-th frame from an offset that goes round ("frame boosting"),
and steps of a size that the gradient's does not change. It is not that code: there one tape chains the 16 last
substeps, and a field of moduli is scaled by its least and greatest entry. Here each picture's substep stands alone, and
one vector has no such spread, so its largest component is what is scaled.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
import optax

from baselines.evaluation import Evaluator
from baselines.parametrisation import Parametrisation
from baselines.scores.method import SdsMethod
from baselines.truncation import WHOLE, Truncation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import MAGNITUDE_MAX

Move = Callable[[np.ndarray], np.ndarray]
"""A step of the numbers, of their slope."""

PUBLISHED_STEP = 0.5 / 2.6
"""Half a decade at most of the 2.6 decades in which the public code seeks the modulus, per iteration."""


@dataclasses.dataclass(frozen=True)
class _SdsSteps(SdsMethod):
    """Steps along one gradient an iteration. Options are those of `SdsMethod`, and these.

    Attributes:
        iterations: At most; the budget may hold fewer.
    """

    iterations: int = 50

    def __post_init__(self):
        super().__post_init__()
        if self.iterations < 1:
            raise UserError("`iterations` must be at least 1", got=self.iterations)

    def descend(
        self, evaluator: Evaluator, stride: int, truncation: Truncation, make_move: Callable[[int], Move]
    ) -> None:
        """Step by step; where a step cannot be simulated, half of it is taken."""
        glance, start = self.open(evaluator), self.choose_start(evaluator)
        unknowns = Parametrisation(start, evaluator.task.frame_count)
        move = make_move(unknowns.size)
        u = safe = unknowns.encode(start)
        for iteration in range(self.iterations):
            field = unknowns.decode(u)
            pictures = glance.play(field, f"{self.name} {iteration + 1}")
            if pictures is None:
                u = unknowns.project(0.5 * (u + safe))
                continue
            safe = u
            pixels = glance.look(pictures, slice(iteration % stride, None, stride))
            gradient, _ = glance.pull_back(field, pixels, truncation)
            slope = unknowns.pull_back(field, gradient)
            if not np.isfinite(slope).all():
                raise UserError("the gradient of score distillation is not finite", got=field)
            u = unknowns.project(u + move(slope))
        glance.play(unknowns.decode(u), "result")


@dataclasses.dataclass(frozen=True)
class SdsLastSubstep(_SdsSteps):
    """The public code's steps, through the last substep before each picture.

    Attributes:
        shown: Frames that the prior is shown at least, where the clip has as many.
    """

    shown: int = 16

    def __post_init__(self):
        super().__post_init__()
        if self.shown < 1:
            raise UserError("`shown` must be at least 1", got=self.shown)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "sds_last_substep"

    def search(self, evaluator: Evaluator) -> None:
        """Some of the frames in turn, steps of a fixed length."""
        stride = max(1, evaluator.task.frame_count // self.shown)
        self.descend(evaluator, stride, Truncation(substeps=1), lambda size: step_by_largest)


@dataclasses.dataclass(frozen=True)
class SdsWholeClip(_SdsSteps):
    """Adam through the whole clip, with a falling rate.

    Attributes:
        learning_rate: Learning rate at first, in |M| v.
    """

    learning_rate: float = 0.1

    def __post_init__(self):
        super().__post_init__()
        if not 0 < self.learning_rate <= 10:
            raise UserError("`learning_rate` must be above 0 and at most 10", got=self.learning_rate)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "sds_whole_clip"

    def search(self, evaluator: Evaluator) -> None:
        """All frames at once."""
        self.descend(evaluator, 1, WHOLE, lambda size: make_adam(self.learning_rate, self.iterations, size))


def step_by_largest(slope: np.ndarray) -> np.ndarray:
    """Downhill, the largest component by `PUBLISHED_STEP` of the range; nothing where there is no slope."""
    largest = np.abs(slope).max()
    return -PUBLISHED_STEP * 2 * MAGNITUDE_MAX * slope / largest if largest > 0 else np.zeros_like(slope)


def make_adam(learning_rate: float, count: int, size: int) -> Move:
    """Steps of Adam, the rate falling to a tenth by a cosine; they do not depend on the loss's scale."""
    optimiser = optax.adam(
        optax.cosine_decay_schedule(learning_rate, count, alpha=0.1), b1=0.9, b2=0.99, eps=1e-12
    )
    moments, unit = optimiser.init(jnp.zeros(size)), 0.0

    def move(slope: np.ndarray) -> np.ndarray:
        nonlocal moments, unit
        unit = unit or float(np.abs(slope).max())  # so that squares stay far from what single precision holds
        if not unit:
            return np.zeros(size)
        updates, moments = optimiser.update(jnp.asarray(slope / unit), moments)
        return np.asarray(updates, float)

    return move
