"""The protocol of a score prior: the direction in which a clip's pixels should change to fit a sentence."""

from __future__ import annotations

import dataclasses
from typing import Protocol, runtime_checkable

import jax
import numpy as np

Key = jax.Array | int
"""A key of `jax.random`, or a seed: the same key means the same noise."""


@dataclasses.dataclass
class Cost:
    """The spending of a prior so far.

    Attributes:
        calls: Evaluations of the denoiser; guidance needs two per draw.
        seconds: Wall time of `ScorePrior.gradient` [s].
    """

    calls: int = 0
    seconds: float = 0.0


@runtime_checkable
class ScorePrior(Protocol):
    """A model of videos that gives score distillation its gradient (Poole et al. 2023, DreamFusion).

    Attributes:
        name: In the registry, `open_prior`.
        toy: Whether it was trained here on a few clips: nothing about video models follows from its results.
        licence: Licence of the weights.
        cost: What it has spent.
    """

    @property
    def name(self) -> str:
        """As in the class."""
        ...

    @property
    def toy(self) -> bool:
        """As in the class."""
        ...

    @property
    def licence(self) -> str:
        """As in the class."""
        ...

    @property
    def cost(self) -> Cost:
        """As in the class."""
        ...

    def gradient(
        self, video: np.ndarray, prompt: str, key: Key, *, still: np.ndarray | None = None
    ) -> np.ndarray:
        """The derivative of the distillation loss by the pixels.

        Args:
            video: Colours in [0, 1], shape (T, H, W, 3).
            prompt: What should be seen.
            key: Random key of the draws of noise and noise level.
            still: For priors that compare with a clip in which nothing moves, that clip, shape (T, H, W, 3); None =
                the first frame, repeated.

        Returns:
            d loss / d video, shape (T, H, W, 3).

        Raises:
            UserError: The video or the prompt does not fit the model, or a number is not finite.
        """
        ...
