"""CLIP (Radford et al. 2021) in Flax NNX: two transformers that place pictures and sentences in one space.

Attributes are called as in the checkpoints of `transformers.CLIPModel`, so that a parameter's path is its name in the
file (`clip_checkpoint`). Pictures have their colours last.
"""

from __future__ import annotations

import functools
import math
from typing import Literal

import jax
import jax.numpy as jnp
from flax import nnx  # pyright: ignore[reportMissingImports]
from pydantic import BaseModel, ConfigDict, Field, PositiveInt, model_validator

ARGMAX_EOS = 2
"""`eos_token_id` of the first published configurations: a mistake that means the token of the largest number."""

_ACTIVATIONS = {
    "quick_gelu": lambda x: x * jax.nn.sigmoid(1.702 * x),
    "gelu": functools.partial(jax.nn.gelu, approximate=False),
}


class TowerConfig(BaseModel):
    """Sizes of a transformer, by the names of `config.json`; what else stands there is not looked at."""

    model_config = ConfigDict(frozen=True, extra="ignore")
    hidden_size: PositiveInt
    intermediate_size: PositiveInt
    num_hidden_layers: PositiveInt = 12
    num_attention_heads: PositiveInt
    hidden_act: Literal["quick_gelu", "gelu"] = "quick_gelu"
    layer_norm_eps: float = Field(default=1e-5, gt=0)

    @model_validator(mode="after")
    def _divide(self) -> TowerConfig:
        if self.hidden_size % self.num_attention_heads:
            raise ValueError("`hidden_size` must be a multiple of `num_attention_heads`")
        return self


class TextConfig(TowerConfig):
    """The tower of sentences. Defaults are those of the format, whose files leave them out."""

    hidden_size: PositiveInt = 512
    intermediate_size: PositiveInt = 2048
    num_attention_heads: PositiveInt = 8
    vocab_size: PositiveInt = 49408
    max_position_embeddings: PositiveInt = 77
    eos_token_id: int = 49407


class VisionConfig(TowerConfig):
    """The tower of pictures, which are square, `image_size` pixels wide, and cut into squares of `patch_size`."""

    hidden_size: PositiveInt = 768
    intermediate_size: PositiveInt = 3072
    num_attention_heads: PositiveInt = 12
    image_size: PositiveInt = 224
    patch_size: PositiveInt = 32
    num_channels: Literal[3] = 3


class ClipConfig(BaseModel):
    """Both towers, and the width of the space in which they meet."""

    model_config = ConfigDict(frozen=True, extra="ignore")
    text_config: TextConfig = TextConfig()
    vision_config: VisionConfig = VisionConfig()
    projection_dim: PositiveInt = 512


class Attention(nnx.Module):
    """Each token asks all tokens that ``mask`` lets it see."""

    def __init__(self, config: TowerConfig, rngs: nnx.Rngs):
        self.heads, width = config.num_attention_heads, config.hidden_size
        self.q_proj = nnx.Linear(width, width, rngs=rngs)
        self.k_proj = nnx.Linear(width, width, rngs=rngs)
        self.v_proj = nnx.Linear(width, width, rngs=rngs)
        self.out_proj = nnx.Linear(width, width, rngs=rngs)

    def __call__(self, tokens: jax.Array, mask: jax.Array | None) -> jax.Array:
        """Answers, shape (batch, tokens, hidden_size); ``mask`` is (batch, 1, tokens, tokens), None = all see all."""
        batch, count, width = tokens.shape
        queries, keys, values = (
            project(tokens).reshape(batch, count, self.heads, width // self.heads)
            for project in (self.q_proj, self.k_proj, self.v_proj)
        )
        likeness = jnp.einsum("bqhd,bkhd->bhqk", queries, keys) / math.sqrt(width // self.heads)
        shares = jax.nn.softmax(likeness, where=mask)  # `jax.nn.dot_product_attention` is in single precision
        seen = jnp.einsum("bhqk,bkhd->bqhd", shares, values)
        return self.out_proj(seen.reshape(batch, count, width))


class Mlp(nnx.Module):
    """Each token by itself, through a wider layer."""

    def __init__(self, config: TowerConfig, rngs: nnx.Rngs):
        self.fc1 = nnx.Linear(config.hidden_size, config.intermediate_size, rngs=rngs)
        self.fc2 = nnx.Linear(config.intermediate_size, config.hidden_size, rngs=rngs)
        self.activation = config.hidden_act

    def __call__(self, tokens: jax.Array) -> jax.Array:
        """Tokens, shape (batch, tokens, hidden_size)."""
        return self.fc2(_ACTIVATIONS[self.activation](self.fc1(tokens)))


class Layer(nnx.Module):
    """Attention, then the wider layer, each added to what it was made of."""

    def __init__(self, config: TowerConfig, rngs: nnx.Rngs):
        self.layer_norm1 = _make_norm(config, rngs)
        self.self_attn = Attention(config, rngs)
        self.layer_norm2 = _make_norm(config, rngs)
        self.mlp = Mlp(config, rngs)

    def __call__(self, tokens: jax.Array, mask: jax.Array | None) -> jax.Array:
        """Tokens, shape (batch, tokens, hidden_size)."""
        tokens = tokens + self.self_attn(self.layer_norm1(tokens), mask)
        return tokens + self.mlp(self.layer_norm2(tokens))


class Encoder(nnx.Module):
    """Layers one after the other."""

    def __init__(self, config: TowerConfig, rngs: nnx.Rngs):
        self.layers = nnx.List([Layer(config, rngs) for _ in range(config.num_hidden_layers)])

    def __call__(self, tokens: jax.Array, mask: jax.Array | None = None) -> jax.Array:
        """Tokens, shape (batch, tokens, hidden_size)."""
        for layer in self.layers:
            tokens = layer(tokens, mask)
        return tokens


class TextEmbeddings(nnx.Module):
    """A vector for each token, and one for its place."""

    def __init__(self, config: TextConfig, rngs: nnx.Rngs):
        self.token_embedding = nnx.Embed(config.vocab_size, config.hidden_size, rngs=rngs)
        self.position_embedding = nnx.Embed(config.max_position_embeddings, config.hidden_size, rngs=rngs)

    def __call__(self, ids: jax.Array) -> jax.Array:
        """Tokens of sentences, shape (batch, tokens, hidden_size)."""
        return self.token_embedding(ids) + self.position_embedding(jnp.arange(ids.shape[1]))


class VisionEmbeddings(nnx.Module):
    """A vector for each patch of a picture, one that stands for the whole before them, and one for each place."""

    def __init__(self, config: VisionConfig, rngs: nnx.Rngs):
        width, patch = config.hidden_size, (config.patch_size, config.patch_size)
        self.class_embedding = nnx.Param(rngs.params.normal((width,)))
        self.patch_embedding = nnx.Conv(
            config.num_channels, width, patch, patch, padding="VALID", use_bias=False, rngs=rngs
        )
        places = (config.image_size // config.patch_size) ** 2 + 1
        self.position_embedding = nnx.Embed(places, width, rngs=rngs)

    def __call__(self, pixels: jax.Array) -> jax.Array:
        """Tokens of pictures, shape (batch, 1 + patches, hidden_size)."""
        patches = self.patch_embedding(pixels)
        batch, _, _, width = patches.shape
        whole = jnp.broadcast_to(self.class_embedding[...], (batch, 1, width))
        tokens = jnp.concatenate([whole, patches.reshape(batch, -1, width)], axis=1)
        return tokens + self.position_embedding(jnp.arange(tokens.shape[1]))


class TextTower(nnx.Module):
    """Sentences to one vector each: that of the token of their end, which has seen all before it."""

    def __init__(self, config: TextConfig, rngs: nnx.Rngs):
        self.eos = config.eos_token_id
        self.embeddings = TextEmbeddings(config, rngs)
        self.encoder = Encoder(config, rngs)
        self.final_layer_norm = _make_norm(config, rngs)

    def __call__(self, ids: jax.Array, mask: jax.Array) -> jax.Array:
        """Vectors, shape (batch, hidden_size). A token sees itself and those before it that belong to the sentence."""
        count = ids.shape[1]
        seen = jnp.tri(count, dtype=bool) & mask[:, None, None, :].astype(bool)
        tokens = self.final_layer_norm(self.encoder(self.embeddings(ids), seen))
        ends = ids if self.eos == ARGMAX_EOS else ids == self.eos
        return tokens[jnp.arange(len(ids)), jnp.argmax(ends, axis=1)]


class VisionTower(nnx.Module):
    """Pictures to one vector each: that of the token which stands for the whole."""

    def __init__(self, config: VisionConfig, rngs: nnx.Rngs):
        self.embeddings = VisionEmbeddings(config, rngs)
        self.pre_layrnorm = _make_norm(config, rngs)  # spelt so in all files
        self.encoder = Encoder(config, rngs)
        self.post_layernorm = _make_norm(config, rngs)

    def __call__(self, pixels: jax.Array) -> jax.Array:
        """Vectors, shape (batch, hidden_size). A token sees all."""
        tokens = self.encoder(self.pre_layrnorm(self.embeddings(pixels)))
        return self.post_layernorm(tokens[:, 0])


class ClipModel(nnx.Module):
    """Both towers. The cosine of what they say of a picture and of a sentence is how well these fit each other."""

    def __init__(self, config: ClipConfig, rngs: nnx.Rngs):
        text, vision, width = config.text_config, config.vision_config, config.projection_dim
        self.text_model = TextTower(text, rngs)
        self.vision_model = VisionTower(vision, rngs)
        self.text_projection = nnx.Linear(text.hidden_size, width, use_bias=False, rngs=rngs)
        self.visual_projection = nnx.Linear(vision.hidden_size, width, use_bias=False, rngs=rngs)
        self.logit_scale = nnx.Param(jnp.asarray(math.log(1 / 0.07), jnp.float32))

    def encode_text(self, ids: jax.Array, mask: jax.Array) -> jax.Array:
        """Unit vectors of sentences, shape (batch, projection_dim).

        Args:
            ids: Numbers of tokens, shape (batch, tokens).
            mask: Whether a token belongs to the sentence, shape (batch, tokens).
        """
        return normalise(self.text_projection(self.text_model(ids, mask)))

    def encode_pictures(self, pixels: jax.Array) -> jax.Array:
        """Unit vectors of pictures, shape (batch, projection_dim).

        Args:
            pixels: As `clip_pictures.prepare` makes them, shape (batch, image_size, image_size, 3).
        """
        return normalise(self.visual_projection(self.vision_model(pixels)))

    def __call__(self, ids: jax.Array, mask: jax.Array, pixels: jax.Array) -> jax.Array:
        """Scaled cosines whose softmax says which sentence a picture has, shape (pictures, sentences)."""
        cosines = self.encode_pictures(pixels) @ self.encode_text(ids, mask).T
        return jnp.exp(self.logit_scale[...]) * cosines


def normalise(vectors: jax.Array) -> jax.Array:
    """Vectors of length 1, along the last axis."""
    return vectors / jnp.linalg.norm(vectors, axis=-1, keepdims=True)


def _make_norm(config: TowerConfig, rngs: nnx.Rngs) -> nnx.LayerNorm:
    """With the variance of the differences from the mean: that of the squares loses digits."""
    return nnx.LayerNorm(
        config.hidden_size, epsilon=config.layer_norm_eps, use_fast_variance=False, rngs=rngs
    )
