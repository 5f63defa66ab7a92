"""Shared parts of score distillation: a prior looks at the pictures, its pixel gradient goes back.

None reads the target. None has an objective either, for the loss of score distillation says nothing about how well a
clip fits: the latest force field is the answer, as in the published methods.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from baselines.evaluation import Evaluator
from baselines.protocol import Method
from baselines.scores import PRIORS, open_prior
from baselines.scores.protocol import ScorePrior
from baselines.simulation import Pictures
from baselines.starts import Numbers, Types, choose_numbers, choose_templates, draw_numbers
from baselines.truncation import WHOLE, Truncation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import ForceField


@dataclasses.dataclass(frozen=True)
class GuidedMethod(Method):
    """A descent that a model leads by what it says of the pictures, from one start.

    Attributes:
        types: Who says what the actions of the start are.
        numbers: Who says where they begin.
    """

    types: Types = "task"
    numbers: Numbers = "task"

    def choose_start(self, evaluator: Evaluator) -> ForceField:
        """Choose the start of the descent.

        Raises:
            UserError: There is no action to be improved.
        """
        templates = choose_templates(evaluator, self.types)[:1]
        draw = partial(draw_numbers, evaluator.rng)
        (start,) = choose_numbers(evaluator, templates, self.types, self.numbers, draw)
        if not (start.actions or start.constraints):
            raise UserError("the start has no action that a gradient could change", do="Take types='agent'")
        return start


@dataclasses.dataclass(frozen=True)
class SdsMethod(GuidedMethod):
    """Score distillation with a prior. Options are those of `GuidedMethod`, and these.

    Attributes:
        prior: A name of `scores.PRIORS`, or a prior.
        weights: With a name, the folder or hub id of its weights.
        prior_options: With a name, options of its `load`.
    """

    prior: str | ScorePrior = PRIORS[0]
    weights: str = ""
    prior_options: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    def __post_init__(self):
        if self.types == "enumerated":
            raise UserError(
                "a prior cannot tell which of several searches is the best", got="types=enumerated"
            )

    @property
    def stochastic(self) -> bool:
        """Noise is drawn."""
        return True

    def open(self, evaluator: Evaluator) -> Glance:
        """The prior at work for a task.

        Raises:
            UserError: There is no such prior, or its weights are not there.
        """
        if not isinstance(self.prior, str):
            return Glance(evaluator, self.prior)
        if not self.weights:
            raise UserError(f"method `{self.name}` needs the weights of its prior", do="Give `weights`")
        return Glance(evaluator, open_prior(self.prior, self.weights, **self.prior_options))


class Glance:
    """A prior that looks at an evaluator's pictures.

    Attributes:
        prior: Who looks.
    """

    def __init__(self, evaluator: Evaluator, prior: ScorePrior):
        self.prior = prior
        self._evaluator, self._looks, self._still = evaluator, 0, None

    def play(self, force_field: ForceField, note: str) -> Pictures | None:
        """Pictures; None where the simulation fails. The later, the better: there is no other order."""
        pictures = self._evaluator.play(force_field, note)
        if pictures is None:
            return None
        self._evaluator.rate(-float(len(self._evaluator.evaluations)))
        if self._still is None:
            self._still = pictures.rgb[:1]
        return pictures

    def look(self, pictures: Pictures, frames: slice = slice(None)) -> np.ndarray:
        """The gradient by all pixels of a clip of which the prior is shown ``frames``; noise differs by look."""
        calls, key = self.prior.cost.calls, self._evaluator.seed * 100_003 + self._looks
        self._looks += 1
        video = pictures.rgb.astype(np.float32) / 255
        still = (
            None if self._still is None else np.repeat(self._still.astype(np.float32) / 255, len(video), 0)
        )
        pixels = np.zeros_like(video)
        pixels[frames] = self.prior.gradient(
            video[frames],
            self._evaluator.task.spec.sentence,
            key,
            still=None if still is None else still[frames],
        )
        self._evaluator.model_calls += self.prior.cost.calls - calls
        return pixels

    def pull_back(
        self,
        force_field: ForceField,
        pixels: np.ndarray,
        truncation: Truncation = WHOLE,
        others: tuple[ForceField, ...] = (),
    ) -> tuple[ForceFieldParameters, np.ndarray]:
        """As `Evaluator.pull_back`."""
        return self._evaluator.pull_back(force_field, pixels, truncation, others)
