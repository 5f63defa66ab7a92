"""Writing 3D Gaussians as PLY files in the layout of the original 3DGS code.

Layout (INRIA, Kerbl et al. 2023, "3D Gaussian Splatting for Real-Time Radiance Field Rendering"): one
``vertex`` per Gaussian with float properties ``x y z``, ``nx ny nz`` (unused), ``f_dc_0..2``,
``f_rest_*`` (channel-major: all coefficients of red, then green, then blue), ``opacity`` (logit),
``scale_0..2`` (natural logarithm of the standard deviation) and ``rot_0..3`` (quaternion wxyz, any norm).
"""

from __future__ import annotations

import os
from typing import Any, BinaryIO

import numpy as np
from plyfile import PlyData, PlyElement

from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.formats.encoding import COMMENT, STANDARD, is_evident
from physagent_jax.gaussians.formats.ply_gaussians import DC, POSITION, ROTATION, SCALE

_NORMAL = ("nx", "ny", "nz")

# The largest |logit| that is written. float32 cannot tell sigmoid(17) from 1, and a viewer that computes
# with an infinite logit shows nothing at all.
_LOGIT_LIMIT = 16.0


def write_ply(
    path: str | os.PathLike[str] | BinaryIO, cloud: GaussianCloud, *, origin: np.ndarray | None = None
) -> None:
    """Write a cloud as a little-endian binary PLY that ordinary 3DGS viewers open.

    Opacity logits are clipped to +-16 and scales to the smallest positive float32, so that every number
    in the file is finite. Values that do not show by themselves how they are encoded get a comment that says it.

    Args:
        path: The file to write, whose folder must exist, or a stream.
        cloud: The Gaussians to write.
        origin: Point that the positions are relative to, shape (3,); positions are then written as doubles, unless
            it is zero. None = zero.
    """
    means, quats, scales, opacities, sh = (
        np.asarray(values, np.float64)
        for values in (cloud.means, cloud.quats, cloud.scales, cloud.opacities, cloud.sh)
    )
    origin = np.zeros(3) if origin is None else origin
    far = bool(np.any(origin))
    with np.errstate(divide="ignore"):  # opacity 0 or 1: an infinite logit, clipped
        logits = np.clip(np.log(opacities) - np.log1p(-opacities), -_LOGIT_LIMIT, _LOGIT_LIMIT)
    log_scales = np.log(np.maximum(scales, np.finfo(np.float32).tiny))
    rest = sh[:, 1:, :].transpose(0, 2, 1).reshape(len(means), -1)
    rest_names = tuple(f"f_rest_{i}" for i in range(rest.shape[1]))

    positions = means + origin if far else means
    table = np.concatenate(
        [positions, np.zeros_like(means), sh[:, 0, :], rest, logits[:, None], log_scales, quats], axis=1
    )
    names = (*POSITION, *_NORMAL, *DC, *rest_names, "opacity", *SCALE, *ROTATION)
    types = [(name, "<f8" if far and name in POSITION else "<f4") for name in names]
    vertex = np.rec.fromarrays(
        [column.astype(kind) for column, (_, kind) in zip(table.T, types)], dtype=types
    )
    # After the line of the element, where readers that count lines do not look.
    comments = [] if is_evident(means, log_scales, logits) else [f"{COMMENT} {STANDARD}"]
    target: Any = os.fspath(path) if isinstance(path, str | os.PathLike) else path
    element = PlyElement.describe(np.asarray(vertex), "vertex", comments=comments)
    PlyData([element], byte_order="<").write(target)
