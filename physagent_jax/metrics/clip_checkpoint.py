"""CLIP checkpoints as Hugging Face keeps them: config.json and model.safetensors into a `ClipModel`.

The path of a parameter is its name: `text_model.encoder.layers.0.mlp.fc1.kernel` is
`text_model.encoder.layers.0.mlp.fc1.weight`, transposed.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import jax.numpy as jnp
import numpy as np
from flax import nnx  # pyright: ignore[reportMissingImports]
from numpy.typing import DTypeLike
from pydantic import ValidationError
from safetensors import SafetensorError  # pyright: ignore[reportMissingImports]
from safetensors.numpy import load_file  # pyright: ignore[reportMissingImports]

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error, read_json
from physagent_jax.metrics.clip_model import ClipConfig, ClipModel

_LEAVES = {"kernel": "weight", "scale": "weight", "embedding": "weight"}
_AXES = {2: (1, 0), 4: (2, 3, 1, 0)}  # of a kernel in the file: torch keeps outputs first, and pixels last
_DERIVED = "embeddings.position_ids"  # in files of older versions: 0, 1, 2, ...


def read_config(path: Path) -> ClipConfig:
    """The sizes that `config.json` says.

    Raises:
        UserError: It cannot be read, or is not of a CLIP model.
    """
    said = read_json(path)
    if not isinstance(said, dict) or said.get("model_type") != "clip":
        kind = said.get("model_type") if isinstance(said, dict) else type(said).__name__
        raise UserError(f"{path} is not of a CLIP model", got=kind, do="Give the folder of a `CLIPModel`")
    for part in ("text_config", "vision_config"):  # older files have a second one, which counts for more
        said[part], older = said.get(part) or {}, said.get(f"{part}_dict")
        if isinstance(said[part], dict) and isinstance(older, dict):
            said[part] |= older
    try:
        return ClipConfig.model_validate(said)
    except ValidationError as error:
        raise format_validation_error(error, str(path), do="Take a CLIP model's own file") from None


def read_tensors(folder: Path) -> dict[str, np.ndarray]:
    """The arrays of a folder's safetensors files, by name.

    Raises:
        UserError: There are none, or they cannot be read.
    """
    files = sorted(folder.glob("model*.safetensors"))
    if not files:
        raise UserError(
            "this folder holds no weights that can be read",
            got=folder,
            do="Add model.safetensors: `save_pretrained` of transformers makes it of pytorch_model.bin",
        )
    try:
        return {name: array for path in files for name, array in load_file(path).items()}
    except (SafetensorError, OSError) as error:
        raise UserError(f"the weights cannot be read ({error})", got=folder) from None


def make_model(
    config: ClipConfig, tensors: Mapping[str, np.ndarray], dtype: DTypeLike = np.float32
) -> ClipModel:
    """The model with the weights of a checkpoint.

    Args:
        config: Its sizes.
        tensors: By the names of `transformers.CLIPModel`, in any floating type.
        dtype: Type in which it computes.

    Raises:
        UserError: Weights are missing, have another shape, or are not of this model.
    """
    graph, blank = nnx.split(nnx.eval_shape(lambda: ClipModel(config, nnx.Rngs(0))))
    made, names = {}, set()
    for path, wanted in nnx.to_flat_state(blank):
        *place, leaf = map(str, path)
        name = ".".join([*place, _LEAVES.get(leaf, leaf)])
        if name not in tensors:
            raise UserError("the checkpoint lacks a weight of its model", got=name)
        values = np.asarray(tensors[name]).astype(dtype)
        if leaf == "kernel" and values.ndim in _AXES:
            values = values.transpose(_AXES[values.ndim])
        if values.shape != wanted.shape:
            raise UserError(
                f"`{name}` must have the shape that config.json says, {wanted.shape}", got=values.shape
            )
        made[path] = wanted.replace(jnp.asarray(values))
        names.add(name)
    if others := sorted(name for name in tensors if name not in names and not name.endswith(_DERIVED)):
        raise UserError("the checkpoint has weights that are not of its model", got=", ".join(others[:3]))
    return nnx.merge(graph, nnx.from_flat_state(made))
