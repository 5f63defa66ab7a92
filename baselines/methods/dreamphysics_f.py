"""DreamPhysics' score distillation with the force field in the place of the material, and a variant without its limits.

DreamPhysics (Huang et al. 2024) moves Young's modulus by the SDS gradient of a video model. The PhysAgent paper's
"DreamPhysics-f" moves forces instead and says no more than that. The schedule here is that of the public code: 50
iterations, one draw each, every s-th frame from an offset that goes round ("frame boosting"), the last substep before
each picture differentiated, and steps of a size that the gradient's does not change. That code scales a field of moduli
by its least and greatest entry; one vector has no such spread, so its largest component is what is scaled.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Literal

import jax.numpy as jnp
import numpy as np
import optax

from baselines.evaluation import Evaluator
from baselines.parametrisation import Parametrisation
from baselines.scores.method import SdsMethod
from baselines.truncation import WHOLE, Truncation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import MAGNITUDE_MAX

PUBLISHED_STEP = 0.5 / 2.6
"""Half a decade at most of the 2.6 decades in which the public code seeks the modulus, per iteration."""


@dataclasses.dataclass(frozen=True)
class DreamPhysicsF(SdsMethod):
    """Options are those of `SdsMethod`, and these.

    Attributes:
        schedule: "published" as above; "adam" differentiates the whole clip and steps by Adam with a falling rate.
        iterations: At most; the budget may hold fewer.
        shown: "published": frames that the prior is shown at least, where the clip has as many.
        learning_rate: "adam": at first, in |M| v.
    """

    schedule: Literal["published", "adam"] = "published"
    iterations: int = 50
    shown: int = 16
    learning_rate: float = 0.1

    def __post_init__(self):
        super().__post_init__()
        if self.schedule not in ("published", "adam"):
            raise UserError("`schedule` must be 'published' or 'adam'", got=self.schedule)
        if self.iterations < 1 or self.shown < 1:
            raise UserError("`iterations` and `shown` must be at least 1", got=(self.iterations, self.shown))
        if not 0 < self.learning_rate <= 10:
            raise UserError("`learning_rate` must be above 0 and at most 10", got=self.learning_rate)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "dreamphysics_f"

    def search(self, evaluator: Evaluator) -> None:
        """One gradient an iteration; where a step cannot be simulated, half of it is taken."""
        glance, start = self.open(evaluator), self.choose_start(evaluator)
        unknowns = Parametrisation(start, evaluator.task.frame_count)
        published = self.schedule == "published"
        stride = max(1, evaluator.task.frame_count // self.shown) if published else 1
        truncation = Truncation(substeps=1) if published else WHOLE
        move = step_by_largest if published else make_adam(self.learning_rate, self.iterations, unknowns.size)
        u = safe = unknowns.encode(start)
        for iteration in range(self.iterations):
            field = unknowns.decode(u)
            pictures = glance.play(field, f"{self.schedule} {iteration + 1}")
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


def step_by_largest(slope: np.ndarray) -> np.ndarray:
    """Downhill, the largest component by `PUBLISHED_STEP` of the range; nothing where there is no slope."""
    largest = np.abs(slope).max()
    return -PUBLISHED_STEP * 2 * MAGNITUDE_MAX * slope / largest if largest > 0 else np.zeros_like(slope)


def make_adam(learning_rate: float, count: int, size: int) -> Callable[[np.ndarray], np.ndarray]:
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
