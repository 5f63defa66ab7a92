"""GMFlow in Flax NNX: a convolutional encoder, a transformer that compares both pictures, and matching by likeness.

Attributes are called as in the published checkpoints, so that a parameter's path is its name in the file
(`checkpoint`). Pictures have their channels last. Flow is found both ways at once, as the features are the same.
"""

from __future__ import annotations

import dataclasses
import functools

import jax
import jax.numpy as jnp
from flax import nnx  # pyright: ignore[reportMissingImports]

from physagent_jax.perception.gmflow import matching

WIDTHS = (64, 96, 128)
"""Channels of the encoder's levels."""

_MEAN, _DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
"""Mean and standard deviation of the colours of the pictures that published networks are shown first."""


@dataclasses.dataclass(frozen=True)
class Scale:
    """The search at one resolution.

    Attributes:
        splits: Windows of the transformer along a side.
        search: Half side of the square of candidates [cells]; None = the whole picture.
        spread: Half side of the square over which flow spreads [cells]; None = the whole picture.
    """

    splits: int
    search: int | None = None
    spread: int | None = None


SCALES = (Scale(2), Scale(8, search=4, spread=1))
"""From coarse to fine, as published: one cell is 8 px, then 4 px."""


@dataclasses.dataclass(frozen=True)
class GmflowConfig:
    """Sizes of the network; all follow from a checkpoint (`checkpoint.read_config`).

    Attributes:
        scales: 1, or 2 = with a refinement at twice the resolution.
        channels: Channels of a feature.
        layers: Blocks of the transformer.
        expansion: Hidden units of a block's perceptron per unit.
        factor: Pixels along a cell of the finest scale.
    """

    scales: int = 2
    channels: int = 128
    layers: int = 6
    expansion: int = 4
    factor: int = 4

    @property
    def multiple(self) -> int:
        """Sides of pictures must be multiples of this [px]: whole windows at each scale."""
        return max(SCALES[k].splits * self.factor * 2 ** (self.scales - 1 - k) for k in range(self.scales))


def _normalise(features: jax.Array) -> jax.Array:
    """Instance norm: each channel of each picture by itself."""
    mean = features.mean((1, 2), keepdims=True)
    apart = features - mean
    return apart * jax.lax.rsqrt((apart**2).mean((1, 2), keepdims=True) + 1e-5)


class Residual(nnx.Module):
    """Two convolutions beside a short cut."""

    def __init__(self, taken: int, given: int, stride: int, rngs: nnx.Rngs):
        make = functools.partial(nnx.Conv, kernel_size=(3, 3), padding=1, use_bias=False, rngs=rngs)
        self.conv1 = make(taken, given, strides=stride)
        self.conv2 = make(given, given)
        if stride > 1 or taken != given:
            self.downsample = nnx.List([nnx.Conv(taken, given, (1, 1), stride, padding=0, rngs=rngs)])

    def __call__(self, features: jax.Array) -> jax.Array:
        """Features of ``given`` channels."""
        new = jax.nn.relu(_normalise(self.conv1(features)))
        new = jax.nn.relu(_normalise(self.conv2(new)))
        if hasattr(self, "downsample"):
            features = _normalise(self.downsample[0](features))
        return jax.nn.relu(features + new)


class Encoder(nnx.Module):
    """Pictures to features, one grid for each scale."""

    def __init__(self, config: GmflowConfig, rngs: nnx.Rngs):
        self.conv1 = nnx.Conv(3, WIDTHS[0], (7, 7), 2, padding=3, use_bias=False, rngs=rngs)
        strides = (1, 2, 2 if config.scales == 1 else 1)
        self.layer1, self.layer2, self.layer3 = (
            nnx.List([Residual(taken, given, stride, rngs), Residual(given, given, 1, rngs)])
            for taken, given, stride in zip((WIDTHS[0], *WIDTHS), WIDTHS, strides)
        )
        self.conv2 = nnx.Conv(WIDTHS[-1], config.channels, (1, 1), rngs=rngs)
        if config.scales > 1:  # the same weights at each scale
            size = (config.channels, config.channels, (3, 3))
            self.trident_conv = nnx.Conv(*size, padding=1, use_bias=False, rngs=rngs)

    def __call__(self, pictures: jax.Array) -> list[jax.Array]:
        """Features from coarse to fine, shape (batch, height / cell, width / cell, channels)."""
        features = jax.nn.relu(_normalise(self.conv1(pictures)))
        for block in (*self.layer1, *self.layer2, *self.layer3):
            features = block(features)
        features = self.conv2(features)
        if not hasattr(self, "trident_conv"):
            return [features]
        kernel = self.trident_conv.kernel[...]
        order = ("NHWC", "HWIO", "NHWC")
        convolve = functools.partial(
            jax.lax.conv_general_dilated, features, kernel, padding=((1, 1), (1, 1)), dimension_numbers=order
        )
        return [convolve((stride, stride)) for stride in (2, 1)]


class Attention(nnx.Module):
    """Attention within windows, and with ``mlp`` a perceptron over what was known and what was told."""

    def __init__(self, config: GmflowConfig, mlp: bool, rngs: nnx.Rngs):
        width = config.channels
        linear = functools.partial(nnx.Linear, use_bias=False, rngs=rngs)
        norm = functools.partial(nnx.LayerNorm, width, epsilon=1e-5, use_fast_variance=False, rngs=rngs)
        self.q_proj, self.k_proj, self.v_proj = (linear(width, width) for _ in range(3))
        self.merge, self.norm1 = linear(width, width), norm()
        if mlp:
            hidden = 2 * width * config.expansion
            self.mlp = nnx.Dict({"0": linear(2 * width, hidden), "2": linear(hidden, width)})
            self.norm2 = norm()

    def __call__(self, asking: jax.Array, asked: jax.Array, splits: int, shifted: bool) -> jax.Array:
        """Features of ``asking``, with what those of ``asked`` told them."""
        heard = matching.attend_in_windows(
            self.q_proj(asking), self.k_proj(asked), self.v_proj(asked), splits, shifted
        )
        told = self.norm1(self.merge(heard))
        if hasattr(self, "mlp"):
            hidden = jax.nn.gelu(self.mlp["0"](jnp.concatenate([asking, told], -1)), approximate=False)
            told = self.norm2(self.mlp["2"](hidden))
        return asking + told


class Block(nnx.Module):
    """Each picture asks itself, and then the other."""

    def __init__(self, config: GmflowConfig, rngs: nnx.Rngs):
        self.self_attn = Attention(config, False, rngs)
        self.cross_attn_ffn = Attention(config, True, rngs)

    def __call__(self, features: jax.Array, others: jax.Array, splits: int, shifted: bool) -> jax.Array:
        """Features after both."""
        features = self.self_attn(features, features, splits, shifted)
        return self.cross_attn_ffn(features, others, splits, shifted)


class Transformer(nnx.Module):
    """Blocks one after the other; each second one with shifted windows."""

    def __init__(self, config: GmflowConfig, rngs: nnx.Rngs):
        self.layers = nnx.List([Block(config, rngs) for _ in range(config.layers)])

    def __call__(self, first: jax.Array, second: jax.Array, splits: int) -> tuple[jax.Array, jax.Array]:
        """Features of both pictures that know of each other."""
        both = jnp.concatenate([first, second])
        for k, block in enumerate(self.layers):
            swapped = jnp.concatenate(jnp.split(both, 2)[::-1])
            both = block(both, swapped, splits, k % 2 == 1)
        first, second = jnp.split(both, 2)
        return first, second


class Spreading(nnx.Module):
    """Flow goes from where it is sure to where features are alike."""

    def __init__(self, config: GmflowConfig, rngs: nnx.Rngs):
        self.q_proj = nnx.Linear(config.channels, config.channels, rngs=rngs)
        self.k_proj = nnx.Linear(config.channels, config.channels, rngs=rngs)

    def __call__(self, features: jax.Array, flow: jax.Array, radius: int | None) -> jax.Array:
        """Flow, shape (batch, height, width, 2)."""
        queries = self.q_proj(features)
        if radius is not None:
            return matching.spread_nearby(queries, self.k_proj(features), flow, radius)
        keys = self.k_proj(queries)  # of the queries: the weights were trained so
        flat = [each.reshape(len(flow), -1, each.shape[-1]) for each in (queries, keys, flow)]
        return matching.attend(*flat).reshape(flow.shape)


class Gmflow(nnx.Module):
    """Optical flow between two pictures, both ways."""

    def __init__(self, config: GmflowConfig, rngs: nnx.Rngs):
        self.config = config
        self.backbone = Encoder(config, rngs)
        self.transformer = Transformer(config, rngs)
        self.feature_flow_attn = Spreading(config, rngs)
        given = 9 * config.factor**2
        first = nnx.Conv(2 + config.channels, 256, (3, 3), padding=1, rngs=rngs)
        self.upsampler = nnx.Dict({"0": first, "2": nnx.Conv(256, given, (1, 1), rngs=rngs)})

    def __call__(self, first: jax.Array, second: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Flow from ``first`` to ``second`` and back [px], shape (batch, height, width, 2) each.

        Args:
            first: Colours in [0, 1], shape (batch, height, width, 3), sides multiples of `config.multiple`.
            second: The other picture.
        """
        pictures = (jnp.concatenate([first, second]) - jnp.asarray(_MEAN)) / jnp.asarray(_DEVIATION)
        flow = here = None
        for features, scale in zip(self.backbone(pictures), SCALES):
            here, there = jnp.split(features, 2)
            if flow is not None:
                here, there = jnp.concatenate([here, there]), jnp.concatenate([there, here])
                flow = matching.double(flow)
                there = matching.warp(there, flow)
            _, height, width, channels = here.shape
            window = (height // scale.splits, width // scale.splits)
            places = jnp.tile(matching.encode_places(*window, channels), (scale.splits, scale.splits, 1))
            here, there = self.transformer(here + places, there + places, scale.splits)
            if flow is None:
                flow = matching.match_globally(here, there)
                here = jnp.concatenate([here, there])
            else:
                assert scale.search is not None
                flow = flow + matching.match_nearby(here, there, scale.search)
            flow = self.feature_flow_attn(here, flow, scale.spread)
        assert flow is not None and here is not None
        hidden = jax.nn.relu(self.upsampler["0"](jnp.concatenate([flow, here], -1)))
        fine = matching.blend_up(flow, self.upsampler["2"](hidden), self.config.factor)
        there_and_back = jnp.split(fine, 2)
        return there_and_back[0], there_and_back[1]
