"""Reading and writing 3D Gaussians as PLY files in the layout of the original 3DGS code.

Layout (INRIA, Kerbl et al. 2023, "3D Gaussian Splatting for Real-Time Radiance Field Rendering"): one
``vertex`` per Gaussian with float properties ``x y z``, ``nx ny nz`` (unused), ``f_dc_0..2``,
``f_rest_*`` (channel-major: all coefficients of red, then green, then blue), ``opacity`` (logit),
``scale_0..2`` (natural logarithm of the standard deviation) and ``rot_0..3`` (quaternion wxyz, any norm).
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from plyfile import PlyData, PlyElement, PlyListProperty, PlyParseError

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.formats.base import SplatData
from physagent_jax.gaussians.formats.ply_header import read_ply_header

_POSITION = ("x", "y", "z")
_NORMAL = ("nx", "ny", "nz")
_DC = ("f_dc_0", "f_dc_1", "f_dc_2")
_SCALE = ("scale_0", "scale_1", "scale_2")
_ROTATION = ("rot_0", "rot_1", "rot_2", "rot_3")
_REQUIRED = (*_POSITION, *_DC, "opacity", *_SCALE, *_ROTATION)

# Number of `f_rest_*` properties -> coefficients per channel beyond the constant one.
_REST_COUNTS = {0: 0, 9: 3, 24: 8, 45: 15}

# The largest |logit| that is written. float32 cannot tell sigmoid(17) from 1, and a viewer that computes
# with an infinite logit shows nothing at all.
_LOGIT_LIMIT = 16.0


class _Ply3dgs:
    """The layout of the original 3DGS code."""

    name = "3DGS PLY"
    suffixes = (".ply",)

    def matches(self, head: bytes) -> bool:
        """Whether a file begins like a PLY."""
        return head.startswith(b"ply")

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Reads a file; see `Format.read`."""
        vertex = _read_vertices(path)
        rest_names = _check_properties(path, vertex)

        # Copies, because plyfile maps the file into memory, and a mapped file must not be overwritten.
        def columns(names: Iterable[str]) -> np.ndarray:
            with np.errstate(invalid="ignore"):  # a signalling NaN, which is dropped with the others
                return np.stack([np.asarray(vertex[name], np.float64) for name in names], axis=-1)

        sh = columns(_DC)[:, None, :]
        if rest_names:
            rest = columns(rest_names).reshape(len(sh), 3, -1)
            sh = np.concatenate([sh, rest.transpose(0, 2, 1)], axis=1)
        with np.errstate(over="ignore"):  # what overflows is dropped
            scales = np.exp(columns(_SCALE))
            opacities = 1.0 / (1.0 + np.exp(-columns(["opacity"])[:, 0]))
        return SplatData(
            columns(_POSITION), columns(_ROTATION), scales, opacities, sh, "log scales, logit opacities"
        )


PLY_3DGS = _Ply3dgs()


def write_ply(path: str | os.PathLike[str] | BinaryIO, cloud: GaussianCloud) -> None:
    """Writes a cloud as a little-endian binary PLY that ordinary 3DGS viewers open.

    Opacity logits are clipped to +-16 and scales to the smallest positive float32, so that every number
    in the file is finite.

    Args:
        path: The file to write, whose folder must exist, or a stream.
        cloud: What to write.
    """
    means, quats, scales, opacities, sh = (
        np.asarray(values, np.float64)
        for values in (cloud.means, cloud.quats, cloud.scales, cloud.opacities, cloud.sh)
    )
    with np.errstate(divide="ignore"):  # opacity 0 or 1: an infinite logit, clipped
        logits = np.clip(np.log(opacities) - np.log1p(-opacities), -_LOGIT_LIMIT, _LOGIT_LIMIT)
    log_scales = np.log(np.maximum(scales, np.finfo(np.float32).tiny))
    rest = sh[:, 1:, :].transpose(0, 2, 1).reshape(len(means), -1)
    rest_names = tuple(f"f_rest_{i}" for i in range(rest.shape[1]))

    table = np.concatenate(
        [means, np.zeros_like(means), sh[:, 0, :], rest, logits[:, None], log_scales, quats], axis=1
    )
    names = (*_POSITION, *_NORMAL, *_DC, *rest_names, "opacity", *_SCALE, *_ROTATION)
    vertex = np.rec.fromarrays(table.astype("<f4").T, dtype=[(name, "<f4") for name in names])
    target: Any = os.fspath(path) if isinstance(path, str | os.PathLike) else path
    PlyData([PlyElement.describe(np.asarray(vertex), "vertex")], byte_order="<").write(target)


def _read_vertices(path: Path) -> PlyElement:
    """The `vertex` element of a PLY file, or a `UserError` that says why there is none."""
    read_ply_header(path)  # checks it
    try:
        data = PlyData.read(os.fspath(path))
    except (PlyParseError, ValueError) as error:  # ValueError: words where text should hold numbers
        message = shorten(error)
        if "early end-of-file" in message and "element" in message:
            what, do = f"{path} is truncated", "Copy or export the file again"
        else:
            what, do = f"{path} is not a readable PLY file", "Give a 3DGS .ply file"
        raise UserError(what, got=message, do=do) from error
    if "chunk" in data:
        raise UserError(
            f"{path} is a compressed PLY (SuperSplat's quantised chunks), which is not read",
            do="Convert it to a standard PLY, e.g. `splat-transform in.compressed.ply out.ply`",
        )
    if "vertex" not in data:
        found = ", ".join(element.name for element in data.elements) or "none"
        raise UserError(f"{path} has no element `vertex`", got=found, do="Give a 3DGS .ply file")
    if data["vertex"].count == 0:
        raise UserError(f"{path} holds no Gaussians", got="0 vertices", do="Export the scene again")
    return data["vertex"]


def _check_properties(path: Path, vertex: PlyElement) -> list[str]:
    """Checks that a vertex is a Gaussian; returns the names of its higher SH coefficients in order."""
    present = {prop.name for prop in vertex.properties if not isinstance(prop, PlyListProperty)}
    rest_count = sum(name.startswith("f_rest_") for name in present)
    rest_names = [f"f_rest_{i}" for i in range(rest_count)]
    missing = [name for name in (*_REQUIRED, *rest_names) if name not in present]
    if missing:
        raise UserError(
            f"{path} is not a 3D Gaussian PLY: it lacks the properties {', '.join(missing)}",
            do="Export it from a 3DGS trainer in the INRIA layout (a mesh or a point cloud is not enough)",
        )
    if rest_count not in _REST_COUNTS:
        raise UserError(
            f"{path} has an impossible number of `f_rest_*` properties",
            got=rest_count,
            do="Keep 0, 9, 24 or 45 of them (spherical harmonics of degree 0 to 3)",
        )
    return rest_names
