"""Checkpoints of GMFlow, of torch or safetensors, into a `Gmflow`.

The path of a parameter is its name: `transformer.layers.0.self_attn.q_proj.kernel` is
`transformer.layers.0.self_attn.q_proj.weight`, transposed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import jax.numpy as jnp
import numpy as np
from flax import nnx  # pyright: ignore[reportMissingImports]
from safetensors import SafetensorError  # pyright: ignore[reportMissingImports]
from safetensors.numpy import load_file  # pyright: ignore[reportMissingImports]

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import MIB, check_regular
from physagent_jax.core.torch_file import read_torch_file
from physagent_jax.perception.gmflow.network import Gmflow, GmflowConfig

MOST_BYTES = 512 * MIB  # the published ones have 18
_LEAVES = {"kernel": "weight", "scale": "weight"}
_AXES = {2: (1, 0), 4: (2, 3, 1, 0)}  # of a kernel in the file: torch keeps outputs first, and pixels last
_OTHER = (
    "Give a checkpoint of GMFlow (Xu et al. 2022), with refinement or without, not of GMFlow+ or UniMatch"
)


def read_tensors(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a checkpoint, by name.

    Raises:
        UserError: There is none, or it cannot be read.
    """
    if path.suffix != ".safetensors":
        return read_torch_file(path, most=MOST_BYTES)
    check_regular(path, most=MOST_BYTES, what="the checkpoint")
    try:
        return load_file(path)
    except (SafetensorError, OSError) as error:
        raise UserError(f"the weights cannot be read ({error})", got=path) from None


def read_config(tensors: Mapping[str, np.ndarray]) -> GmflowConfig:
    """The sizes of the network whose weights these are.

    Raises:
        UserError: They are of no GMFlow.
    """
    sizes = {}
    for what, name in (
        ("channels", "backbone.conv2.weight"),
        ("hidden", "transformer.layers.0.cross_attn_ffn.mlp.0.weight"),
        ("mixtures", "upsampler.2.weight"),
    ):
        if name not in tensors or tensors[name].ndim < 2 or not tensors[name].size:
            raise UserError(
                "these weights are of another network than GMFlow: one is missing", got=name, do=_OTHER
            )
        sizes[what] = tensors[name].shape[0]
    blocks = {name.split(".")[2] for name in tensors if name.startswith("transformer.layers.")}
    return GmflowConfig(
        scales=2 if "backbone.trident_conv.weight" in tensors else 1,
        channels=sizes["channels"],
        layers=len(blocks),
        expansion=sizes["hidden"] // (2 * sizes["channels"]),
        factor=math.isqrt(sizes["mixtures"] // 9),
    )


def make_network(tensors: Mapping[str, np.ndarray]) -> Gmflow:
    """The network with the weights of a checkpoint.

    Args:
        tensors: By the names of the published code.

    Raises:
        UserError: Weights are missing, have another shape, or are of another network.
    """
    config = read_config(tensors)
    graph, blank = nnx.split(nnx.eval_shape(lambda: Gmflow(config, nnx.Rngs(0))))
    made, names = {}, set()
    for path, wanted in nnx.to_flat_state(blank):
        *place, leaf = map(str, path)
        name = ".".join([*place, _LEAVES.get(leaf, leaf)])
        if name not in tensors:
            raise UserError("the checkpoint lacks a weight of GMFlow", got=name, do=_OTHER)
        values = np.asarray(tensors[name]).astype(np.float32)
        if leaf == "kernel" and values.ndim in _AXES:
            values = values.transpose(_AXES[values.ndim])
        if values.shape != wanted.shape:
            raise UserError(
                f"`{name}` must have the shape {wanted.shape} as GMFlow has", got=values.shape, do=_OTHER
            )
        made[path] = wanted.replace(jnp.asarray(values))
        names.add(name)
    if others := sorted(set(tensors) - names):
        raise UserError(
            "the checkpoint has weights that are not of GMFlow", got=", ".join(others[:3]), do=_OTHER
        )
    return nnx.merge(graph, nnx.from_flat_state(made))
