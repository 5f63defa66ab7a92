"""CLIP similarity as the objective, climbed by its gradient through the towers, the renderer and the simulator.

No loss is written by hand and no motion is measured: `jax.grad` goes from the cosine of pictures and sentence back to
the numbers of the force field. What CLIP says is all that counts, and it knows no order of the frames.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Protocol

import jax
import numpy as np

from baselines.evaluation import Evaluator
from baselines.methods.sds_steps import make_adam
from baselines.parametrisation import Parametrisation
from baselines.scores.method import GuidedMethod
from baselines.scores.sds import pick_frames
from physagent_jax.core.errors import UserError
from physagent_jax.metrics.clip_similarity import load_clip


class DifferentiableEncoder(Protocol):
    """As much of `metrics.clip_encoder.ClipEncoder` as is needed."""

    def embed(self, sentence: str) -> jax.Array:
        """The unit vector of a sentence, shape (n,)."""
        ...

    def cosines(self, rgb: jax.Array, embedded: jax.Array) -> jax.Array:
        """Cosine of each picture with it, shape (T,)."""
        ...


@dataclasses.dataclass(frozen=True)
class ClipGuided(GuidedMethod):
    """Adam on CLIPsim. Options are those of `GuidedMethod`, and these.

    Attributes:
        clip: Folder of a CLIP model, or an encoder.
        iterations: At most; the budget may hold fewer.
        shown: Frames that CLIP is shown, spread evenly over the clip; fewer where the clip is shorter.
        learning_rate: At first, in |M| v; it falls to a tenth.
    """

    clip: str | DifferentiableEncoder = ""
    iterations: int = 50
    shown: int = 16
    learning_rate: float = 0.1

    def __post_init__(self):
        if self.iterations < 1 or self.shown < 2:  # the first frame has no derivative
            raise UserError(
                "`iterations` must be at least 1, and `shown` 2", got=(self.iterations, self.shown)
            )
        if not 0 < self.learning_rate <= 10:
            raise UserError("`learning_rate` must be above 0 and at most 10", got=self.learning_rate)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "clip_guided"

    def search(self, evaluator: Evaluator) -> None:
        """One gradient an iteration; where a step cannot be simulated, half of it is taken."""
        encoder, start = self.open(), self.choose_start(evaluator)
        sentence = encoder.embed(evaluator.task.spec.sentence)
        count = evaluator.task.frame_count
        frames = pick_frames(count, min(self.shown, count)).tolist()
        unknowns = Parametrisation(start, count)
        move = make_adam(self.learning_rate, self.iterations, unknowns.size)

        def miss(rgb: jax.Array) -> jax.Array:
            return -encoder.cosines(rgb, sentence).mean()

        u = safe = unknowns.encode(start)
        for iteration in range(self.iterations):
            field = unknowns.decode(u)
            value, gradient = evaluator.differentiate_pictures(field, miss, frames, f"step {iteration}")
            evaluator.model_calls += 1
            if math.isinf(value):
                u = unknowns.project(0.5 * (u + safe))
                continue
            safe = u
            u = unknowns.project(u + move(np.asarray(unknowns.pull_back(field, gradient))))

    def open(self) -> DifferentiableEncoder:
        """The CLIP model.

        Raises:
            UserError: It is not given, or cannot be read.
        """
        if not isinstance(self.clip, str):
            return self.clip
        if not self.clip:
            raise UserError(f"method `{self.name}` needs a CLIP model", do="Give its folder with `clip`")
        return _load(self.clip)


@cache
def _load(folder: str) -> DifferentiableEncoder:
    """The model, read once for all tasks."""
    return load_clip(folder)
