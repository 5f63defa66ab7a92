"""Writing clouds as GLB files with the extension KHR_gaussian_splatting."""

from __future__ import annotations

import json
import os
import struct
from typing import BinaryIO

import numpy as np

from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.formats.gltf import EXTENSION, SRGB
from physagent_jax.gaussians.formats.gltf_file import BINARY_CHUNK, GLB_MAGIC, JSON_CHUNK
from physagent_jax.gaussians.formats.packing import SH_C0

_FLOAT, _BYTE = 5126, 5121
_ARRAY_BUFFER = 34962
_KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


def write_glb(
    path: str | os.PathLike[str] | BinaryIO, cloud: GaussianCloud, *, origin: np.ndarray | None = None
) -> None:
    """Write a cloud whose up axis is +y, as glTF prescribes; all values are float32, nothing is quantised.

    Viewers that do not know the extension show points of the Gaussians' colours.

    Args:
        path: The file to write, whose folder must exist, or a stream.
        cloud: The Gaussians.
        origin: Point that the positions are relative to, shape (3,); the translation of the node.
    """
    attributes = {
        "POSITION": np.asarray(cloud.means),
        "COLOR_0": _make_fallback_colours(cloud),
        f"{EXTENSION}:ROTATION": np.asarray(cloud.quats)[:, [1, 2, 3, 0]],
        f"{EXTENSION}:SCALE": np.asarray(cloud.scales),
        f"{EXTENSION}:OPACITY": np.asarray(cloud.opacities)[:, None],
    }
    names = [f"SH_DEGREE_{d}_COEF_{n}" for d in range(cloud.sh_degree + 1) for n in range(2 * d + 1)]
    attributes |= {f"{EXTENSION}:{name}": np.asarray(cloud.sh)[:, i] for i, name in enumerate(names)}
    buffer, views, accessors = bytearray(), [], []
    for name, values in attributes.items():
        data = values.tobytes() if values.dtype == np.uint8 else values.astype("<f4").tobytes()
        views.append(
            {"buffer": 0, "byteOffset": len(buffer), "byteLength": len(data), "target": _ARRAY_BUFFER}
        )
        accessors.append(_describe(values, len(views) - 1, bounds=name == "POSITION"))
        buffer += data
    tree = {
        "asset": {"version": "2.0", "generator": "physagent_jax"},
        "extensionsUsed": [EXTENSION],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"mesh": 0, **({"translation": origin.tolist()} if origin is not None and origin.any() else {})}
        ],
        "meshes": [{"primitives": [_describe_primitive(list(attributes))]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(buffer)}],
    }
    text = json.dumps(tree, separators=(",", ":"), allow_nan=False).encode()
    content = _join_chunks(text + b" " * (-len(text) % 4), bytes(buffer) + b"\0" * (-len(buffer) % 4))
    if isinstance(path, str | os.PathLike):
        with open(path, "wb") as file:
            file.write(content)
    else:
        path.write(content)


def _describe(values: np.ndarray, view: int, *, bounds: bool) -> dict:
    """The accessor of values in a buffer view."""
    byte = values.dtype == np.uint8
    accessor = {
        "bufferView": view,
        "componentType": _BYTE if byte else _FLOAT,
        "count": len(values),
        "type": _KINDS[values.shape[1]],
    }
    if byte:
        accessor["normalized"] = True
    if bounds:
        low, high = values.min(axis=0).astype(np.float32), values.max(axis=0).astype(np.float32)
        accessor |= {"min": low.tolist(), "max": high.tolist()}
    return accessor


def _describe_primitive(names: list[str]) -> dict:
    kernel = {
        "kernel": "ellipse",
        "colorSpace": SRGB,
        "sortingMethod": "cameraDistance",
        "projection": "perspective",
    }
    return {
        "attributes": {name: index for index, name in enumerate(names)},
        "mode": 0,
        "extensions": {EXTENSION: kernel},
    }


def _make_fallback_colours(cloud: GaussianCloud) -> np.ndarray:
    """Colours in linear light and opacities, uint8 of shape (n, 4)."""
    srgb = np.clip(np.asarray(cloud.sh, np.float64)[:, 0] * SH_C0 + 0.5, 0.0, 1.0)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    rgba = np.concatenate([linear, np.asarray(cloud.opacities, np.float64)[:, None]], axis=1)
    return np.round(255.0 * np.clip(rgba, 0.0, 1.0)).astype(np.uint8)


def _join_chunks(text: bytes, buffer: bytes) -> bytes:
    length = 12 + 8 + len(text) + 8 + len(buffer)
    return b"".join(
        (
            GLB_MAGIC,
            struct.pack("<II", 2, length),
            struct.pack("<II", len(text), JSON_CHUNK),
            text,
            struct.pack("<II", len(buffer), BINARY_CHUNK),
            buffer,
        )
    )
