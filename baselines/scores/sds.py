"""Score distillation: the gradient of a noised latent's misfit, for each way in which a denoiser predicts.

With x_t = alpha x_0 + sigma e and a denoiser's guess of the noise, the gradient by x_0 is w (e_hat - e), the
derivative of the denoiser left out (Poole et al. 2023, DreamFusion, eq. 3). This is plain arithmetic on arrays of any
library: numpy, JAX or torch.
"""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np

from baselines.scores.protocol import Key
from physagent_jax.core.errors import UserError

PUBLISHED_GUIDANCE = 101.0
"""DreamPhysics, Physics3D and OmniPhysGS add 100 times the difference to the conditional guess: 101 from the other."""


class Form(enum.StrEnum):
    """The prediction form of a denoiser.

    EPSILON: The noise e.
    V: alpha e - sigma x_0 (Salimans & Ho 2022).
    FLOW: The velocity e - x_0 of the straight path x_s = (1 - s) x_0 + s e (Liu et al. 2023).
    """

    EPSILON = "epsilon"
    V = "v_prediction"
    FLOW = "flow"


class Weighting(enum.StrEnum):
    """Weight w of a noise level.

    VARIANCE: sigma^2, which is 1 - alpha_bar: what the published methods take.
    UNIFORM: 1.
    """

    VARIANCE = "variance"
    UNIFORM = "uniform"


@dataclasses.dataclass(frozen=True)
class Level:
    """A noise level.

    Attributes:
        time: What the denoiser is told of it.
        alpha: Share of the clean latent.
        sigma: Share of the noise.
    """

    time: float
    alpha: float
    sigma: float


@dataclasses.dataclass(frozen=True)
class SdsSettings:
    """The settings of the gradient's estimate.

    Attributes:
        guidance: s of classifier-free guidance, out = unconditional + s (conditional - unconditional); 1 = none.
        time_range: Noise levels are drawn evenly from this part of the model's [0, 1].
        draws: Pairs of level and noise per gradient, averaged: a draw costs less than a simulation's gradient.
        antithetic: Whether every second draw is the one before with its noise reversed.
        weighting: Weight of a level.
        motion: Whether the same gradient of a still clip is subtracted, at the same level and noise: what concerns
            appearance cancels, motion stays (the MDS of DreamPhysics, Huang et al. 2024, by its description: it was
            never released). Costs as many calls again.
    """

    guidance: float = 7.5
    time_range: tuple[float, float] = (0.02, 0.98)
    draws: int = 1
    antithetic: bool = False
    weighting: Weighting = Weighting.VARIANCE
    motion: bool = False

    def __post_init__(self):
        low, high = self.time_range
        if not 0 <= low < high <= 1:
            raise UserError("`time_range` must be two increasing numbers in [0, 1]", got=self.time_range)
        if self.draws < 1 or (self.antithetic and self.draws % 2):
            raise UserError("`draws` must be at least 1, and even where they are antithetic", got=self.draws)


@dataclasses.dataclass(frozen=True)
class Draw:
    """The random draws of one evaluation.

    Attributes:
        time: Position of the noise level in [0, 1].
        noise: Standard normal, float32, in the latent's shape.
    """

    time: float
    noise: np.ndarray


def draw(settings: SdsSettings, key: Key, shape: Sequence[int]) -> tuple[Draw, ...]:
    """Noise and levels of a key; the same for all videos whose latents have this shape."""
    entropy = [key] if isinstance(key, int) else np.ravel(jax.random.key_data(key)).tolist()
    rng, draws = np.random.default_rng(entropy), []
    while len(draws) < settings.draws:
        drawn = Draw(rng.uniform(*settings.time_range), rng.standard_normal(tuple(shape), np.float32))
        draws += [drawn, Draw(drawn.time, -drawn.noise)] if settings.antithetic else [drawn]
    return tuple(draws)


def add_noise(clean: Any, noise: Any, level: Level) -> Any:
    """x_t = alpha x_0 + sigma e."""
    return level.alpha * clean + level.sigma * noise


def make_target(form: Form, clean: Any, noise: Any, level: Level) -> Any:
    """The answer of a perfect denoiser that knows the noise."""
    if form is Form.EPSILON:
        return noise
    if form is Form.V:
        return level.alpha * noise - level.sigma * clean
    return noise - clean


def compute_misfit(form: Form, output: Any, clean: Any, noise: Any, level: Level) -> Any:
    """e_hat - e, or for a flow v_hat - (e - x_0), which is (e_hat - e) / (1 - s).

    From v, e_hat = alpha v_hat + sigma x_t.
    """
    if form is Form.V:
        return level.alpha * output + level.sigma * add_noise(clean, noise, level) - noise
    return output - make_target(form, clean, noise, level)


def compute_latent_gradient(
    form: Form,
    predict: Callable[[Any, Level, bool], Any],
    clean: Any,
    drawn: Sequence[tuple[Level, Any]],
    settings: SdsSettings,
    still: Any = None,
) -> Any:
    """The distillation gradient by a clean latent, averaged over the draws.

    It is the derivative of 0.5 |x_0 - stop_gradient(x_0 - g)|^2.

    Args:
        form: What ``predict`` answers.
        predict: Maps (x_t, level, whether with the prompt) to the denoiser's answer.
        clean: x_0.
        drawn: Level and noise of each draw, as arrays of ``clean``'s library.
        settings: How to estimate.
        still: x_0 of the still clip; needed if ``settings.motion``.
    """

    def find_misfit(x0: Any, noise: Any, level: Level) -> Any:
        noisy = add_noise(x0, noise, level)
        output = predict(noisy, level, True)
        if settings.guidance != 1:
            bare = predict(noisy, level, False)
            output = bare + settings.guidance * (output - bare)
        return compute_misfit(form, output, x0, noise, level)

    total: Any = 0.0
    for level, noise in drawn:
        misfit = find_misfit(clean, noise, level)
        if settings.motion:
            misfit = misfit - find_misfit(still, noise, level)
        weight = level.sigma**2 if settings.weighting is Weighting.VARIANCE else 1.0
        total = total + weight / len(drawn) * misfit
    return total


def repeat_first(video: np.ndarray) -> np.ndarray:
    """The clip in which nothing moves, shape (T, H, W, 3)."""
    return np.broadcast_to(video[:1], video.shape)


def pick_frames(count: int, wanted: int) -> np.ndarray:
    """The frames of ``count`` that a model of ``wanted`` frames gets: spread evenly, shape (wanted,)."""
    return np.linspace(0, count - 1, wanted).round().astype(int)


def check_video(video: np.ndarray) -> np.ndarray:
    """The clip as float32, shape (T, H, W, 3).

    Raises:
        UserError: It is not one, or has colours outside [0, 1].
    """
    video = np.asarray(video)
    if video.ndim != 4 or video.shape[-1] != 3 or not np.issubdtype(video.dtype, np.floating):
        raise UserError(
            "a clip must be floats in [0, 1], shape (T, H, W, 3)", got=f"{video.dtype} {video.shape}"
        )
    if not (video.min() >= -1e-5 and video.max() <= 1 + 1e-5):
        raise UserError("colours of a clip must lie in [0, 1]", got=f"{video.min():.3g} to {video.max():.3g}")
    return video.astype(np.float32)
