"""The validation of the toy prior: find the prompt that fits a held-out clip, by its denoising error."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

LEAST_ACCURACY = 0.6
"""A toy prior that names fewer of the held-out motions is refused; chance is one in twelve."""


@dataclasses.dataclass(frozen=True)
class Validation:
    """The accuracy of the prompts that were found.

    Attributes:
        accuracy: Share of the held-out clips whose own prompt has the least error.
        known_kinds, unknown_kind: The same shares for other instances of kinds of objects that were learnt
            from, and for a
            kind that was not.
        by_motion: The same shares by prompt.
        chance: One over the number of prompts.
        clips: How many.
        draws: Noise levels and noises per clip, the same for all prompts.
    """

    accuracy: float
    known_kinds: float
    unknown_kind: float
    by_motion: dict[str, float]
    chance: float
    clips: int
    draws: int


def classify(find_errors: Callable[[np.ndarray], np.ndarray], clips: np.ndarray) -> np.ndarray:
    """Index of the prompt with the least error for each clip, shape (n,).

    Args:
        find_errors: Maps a clip to its denoising error under each prompt, shape (prompts,).
        clips: Shape (n, ...).
    """
    return np.array([int(np.argmin(find_errors(clip))) for clip in clips], int)


def summarise(
    found: np.ndarray, true: np.ndarray, unknown: np.ndarray, prompts: Sequence[str], draws: int
) -> Validation:
    """Accuracies.

    Args:
        found: Indices of the prompts with the least error, shape (n,).
        true: Indices of the right ones, shape (n,).
        unknown: Whether the clip's kind of object was not learnt from, shape (n,).
        prompts: All of them.
        draws: As in `Validation`.
    """
    right = found == true

    def share(mask: np.ndarray) -> float:
        return float(right[mask].mean()) if mask.any() else float("nan")

    return Validation(
        accuracy=share(np.ones_like(right)),
        known_kinds=share(~unknown),
        unknown_kind=share(unknown),
        by_motion={prompt: share(true == index) for index, prompt in enumerate(prompts)},
        chance=1 / len(prompts),
        clips=len(true),
        draws=draws,
    )
