"""The toy prior's denoiser: a small diffusion transformer over clips of 16 x 32 x 32 (Peebles & Xie 2023, DiT)."""

from __future__ import annotations

import dataclasses
import math

import jax
import jax.numpy as jnp
from flax import nnx  # pyright: ignore[reportMissingImports]

PATCH = (4, 4, 4)  # frames, rows, columns of a token
SMALLEST_SHARE = 0.05  # of noise: where less is left, the velocity's error counts as if there were this much
MEAN, SPREAD = 0.8, 0.5  # of the clips' values in [-1, 1], roughly: most of a picture is white


@dataclasses.dataclass(frozen=True)
class ModelConfig:
    """Sizes.

    Attributes:
        frames, size: Frames and size of a clip; size [px].
        words: Length of the condition.
        width: Channels of a token.
        depth: Blocks.
        heads: Heads of each attention.
    """

    frames: int = 16
    size: int = 32
    words: int = 12
    width: int = 80
    depth: int = 3
    heads: int = 4

    @property
    def grid(self) -> tuple[int, int, int]:
        """Tokens along time, rows and columns."""
        return self.frames // PATCH[0], self.size // PATCH[1], self.size // PATCH[2]


class Block(nnx.Module):
    """Attention and a perceptron; the condition scales, shifts and gates both."""

    def __init__(self, width: int, heads: int, *, rngs: nnx.Rngs):
        zeros = nnx.initializers.zeros_init()
        self.before_attention = nnx.LayerNorm(width, use_bias=False, use_scale=False, rngs=rngs)
        self.attention = nnx.MultiHeadAttention(heads, width, decode=False, rngs=rngs)
        self.before_mix = nnx.LayerNorm(width, use_bias=False, use_scale=False, rngs=rngs)
        self.widen = nnx.Linear(width, 4 * width, rngs=rngs)
        self.narrow = nnx.Linear(4 * width, width, rngs=rngs)
        self.modulate = nnx.Linear(width, 6 * width, kernel_init=zeros, rngs=rngs)

    def __call__(self, tokens: jax.Array, condition: jax.Array) -> jax.Array:
        """Tokens (b, n, width) under a condition (b, width)."""
        parts = jnp.split(self.modulate(nnx.silu(condition))[:, None], 6, axis=-1)
        shift, scale, gate, shift_mix, scale_mix, gate_mix = parts
        tokens += gate * self.attention(self.before_attention(tokens) * (1 + scale) + shift)
        hidden = nnx.gelu(self.widen(self.before_mix(tokens) * (1 + scale_mix) + shift_mix))
        return tokens + gate_mix * self.narrow(hidden)


class ToyVideoModel(nnx.Module):
    """Guesses the clean clip from x_s = (1 - s) x_0 + s e, and answers with the velocity (x_s - x_0) / s.

    A token has fewer channels than its pixels: it could not tell the noise, but it can tell the clip. What a picture
    shows in spite of the noise goes past the tokens: the guess is a mixture of the input and what the network makes of
    it, with the shares that are best for values of `MEAN` and `SPREAD` (Karras et al. 2022, EDM, table 1).
    """

    def __init__(self, config: ModelConfig, *, rngs: nnx.Rngs):
        pixels, zeros = 3 * math.prod(PATCH), nnx.initializers.zeros_init()
        self.config = config
        self.embed = nnx.Linear(pixels, config.width, rngs=rngs)
        self.place = nnx.Param(0.02 * rngs.params.normal((math.prod(config.grid), config.width)))
        self.embed_share = nnx.Linear(16, config.width, rngs=rngs)
        self.embed_words = nnx.Linear(config.words, config.width, rngs=rngs)
        self.blocks = nnx.List([Block(config.width, config.heads, rngs=rngs) for _ in range(config.depth)])
        self.norm = nnx.LayerNorm(config.width, rngs=rngs)
        self.unembed = nnx.Linear(config.width, pixels, kernel_init=zeros, rngs=rngs)

    def __call__(self, noisy: jax.Array, share: jax.Array, words: jax.Array) -> jax.Array:
        """The velocity e - x_0.

        Args:
            noisy: x_s, shape (b, frames, size, size, 3).
            share: s, shape (b,).
            words: Condition, shape (b, words); zeros = none.
        """
        spread = jnp.maximum(share, SMALLEST_SHARE)[:, None, None, None, None]
        return (noisy - self.guess_clean(noisy, share, words)) / spread

    def guess_clean(self, noisy: jax.Array, share: jax.Array, words: jax.Array) -> jax.Array:
        """x_0; arguments as in `__call__`."""
        s = share[:, None, None, None, None]
        input_size = jnp.sqrt(measure_input(s))
        centred = noisy - (1 - s) * MEAN
        made = self._transform(centred / input_size, share, words)
        return MEAN + SPREAD**2 * (1 - s) / input_size**2 * centred + SPREAD * s / input_size * made

    def _transform(self, clip: jax.Array, share: jax.Array, words: jax.Array) -> jax.Array:
        waves = 2.0 ** jnp.arange(8) * share[:, None]
        waves = jnp.concatenate([jnp.sin(waves), jnp.cos(waves)], axis=1)
        condition = self.embed_share(waves) + self.embed_words(words)
        tokens = self.embed(_split(clip, self.config.grid)) + self.place[...]
        for block in self.blocks:
            tokens = block(tokens, condition)
        return _join(self.unembed(self.norm(tokens)), self.config.grid)


def measure_input(share: jax.Array) -> jax.Array:
    """Variance of x_s about its mean, for clips of `SPREAD`."""
    return share**2 + (1 - share) ** 2 * SPREAD**2


def _split(clip: jax.Array, grid: tuple[int, int, int]) -> jax.Array:
    """Patches of a clip, shape (b, tokens, values)."""
    (t, h, w), (p, q, r) = grid, PATCH
    cut = clip.reshape(len(clip), t, p, h, q, w, r, 3).transpose(0, 1, 3, 5, 2, 4, 6, 7)
    return cut.reshape(len(clip), t * h * w, -1)


def _join(patches: jax.Array, grid: tuple[int, int, int]) -> jax.Array:
    """Undo `_split`."""
    (t, h, w), (p, q, r) = grid, PATCH
    cut = patches.reshape(len(patches), t, h, w, p, q, r, 3).transpose(0, 1, 4, 2, 5, 3, 6, 7)
    return cut.reshape(len(patches), t * p, h * q, w * r, 3)
