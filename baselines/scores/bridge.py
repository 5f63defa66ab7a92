"""From a prior's pixel gradient to the gradient of what a clip is rendered from, wherever the prior itself runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from baselines.scores.protocol import Key, ScorePrior


def distil(
    render: Callable[[Any], jax.Array],
    theta: Any,
    prior: ScorePrior,
    prompt: str,
    key: Key,
    *,
    still: np.ndarray | None = None,
) -> tuple[np.ndarray, Any]:
    """The clip, and the distillation gradient by its parameters.

    No callback is traced: `jax.vjp` keeps the way back while the prior looks at the clip.

    Args:
        render: Maps parameters to a clip in [0, 1], shape (T, H, W, 3).
        theta: The parameters, a pytree.
        prior: Who judges.
        prompt: What should be seen.
        key: Random key of the prior's draws.
        still: As in `ScorePrior.gradient`.
    """
    video, pull = jax.vjp(render, theta)
    seen = np.asarray(video)
    pixels = prior.gradient(seen, prompt, key, still=still)
    (gradient,) = pull(jnp.asarray(pixels, video.dtype))
    return seen, gradient
