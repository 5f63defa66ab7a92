"""A CLIP model of a folder as a differentiable function of pictures: tokens, preparation and both towers together."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from flax import nnx  # pyright: ignore[reportMissingImports]

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.clip_checkpoint import make_model, read_config, read_tensors
from physagent_jax.metrics.clip_model import ClipModel
from physagent_jax.metrics.clip_pictures import Preparation, prepare
from physagent_jax.metrics.clip_words import Words

BATCH = 16
"""Pictures at a time, at most: the towers of the largest published models take a gigabyte for them."""


class ClipEncoder:
    """A CLIP model that compares pictures with a sentence; compiled once for each size and number of pictures.

    Args:
        model: Both towers.
        preparation: The steps from a picture to what the model is shown.
        words: The model's tokens.
        name: Name of the weights.
    """

    def __init__(self, model: ClipModel, preparation: Preparation, words: Words, name: str):
        self.preparation, self.words, self.name = preparation, words, name
        self._graph, self._weights = nnx.split(model)

    @classmethod
    def load(cls, folder: str | Path) -> ClipEncoder:
        """As `clip_similarity.load_clip`."""
        folder = Path(folder)
        if not (folder / "config.json").is_file():
            raise UserError(
                "this folder holds no CLIP model",
                got=folder,
                do="Give a folder with config.json, model.safetensors and the tokenizer's files, "
                "as of openai/clip-vit-base-patch32",
            )
        config = read_config(folder / "config.json")
        preparation = Preparation.read(folder, config.vision_config.image_size)
        words = Words(folder, config.text_config.max_position_embeddings)
        if (count := words.tokenizer.get_vocab_size()) > config.text_config.vocab_size:
            raise UserError(
                f"the tokenizer has more tokens than the model, {config.text_config.vocab_size}", got=count
            )
        return cls(make_model(config, read_tensors(folder)), preparation, words, folder.resolve().name)

    def embed(self, sentence: str) -> jax.Array:
        """The unit vector of a sentence, shape (projection_dim,); longer ones than the model takes are cut."""
        return _embed(self._graph, self._weights, *self.words.encode(sentence))

    def cosines(self, rgb: Any, embedded: jax.Array) -> jax.Array:
        """Cosine of each picture with a sentence, shape (T,); differentiable by both.

        Args:
            rgb: uint8, or colours in [0, 1], shape (T, height, width, 3).
            embedded: Unit vector of the sentence, as `embed` makes it.
        """
        return _compare(self._graph, self.preparation, self._weights, jnp.asarray(rgb), embedded)

    def compare(self, rgb: np.ndarray, sentence: str) -> np.ndarray:
        """As `clip_similarity.PictureEncoder`."""
        return np.asarray(self.cosines(rgb, self.embed(sentence)))


@partial(jax.jit, static_argnums=0)
def _embed(graph: Any, weights: Any, ids: jax.Array, mask: jax.Array) -> jax.Array:
    with jax.default_matmul_precision("highest"):
        return nnx.merge(graph, weights).encode_text(ids, mask)[0]


@partial(jax.jit, static_argnums=(0, 1))
def _compare(graph: Any, how: Preparation, weights: Any, rgb: jax.Array, embedded: jax.Array) -> jax.Array:
    """Batch by batch; the last one is filled up with the first pictures again."""

    @jax.checkpoint  # a derivative goes through the towers again, batch by batch, instead of keeping all of it
    def look(batch: jax.Array) -> jax.Array:
        return nnx.merge(graph, weights).encode_pictures(prepare(batch, how)) @ embedded

    batches = math.ceil(len(rgb) / BATCH)
    batch = math.ceil(len(rgb) / batches)
    filled = jnp.concatenate([rgb, rgb[: batches * batch - len(rgb)]])
    with jax.default_matmul_precision("highest"):
        return jax.lax.map(look, filled.reshape(batches, batch, *rgb.shape[1:])).reshape(-1)[: len(rgb)]
