"""Per-frame 3DGS PLYs that ordinary viewers open, in the object file's own frame and units."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.files import replace_file
from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.cloud import GaussianCloud, Splats
from physagent_jax.gaussians.covariance import transform_covariances
from physagent_jax.gaussians.export import splats_to_cloud
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.body import Body
from physagent_jax.scene.placement import Placement


def write_splat_frames(folder: Path, body: Body, x: np.ndarray, F: np.ndarray) -> list[Path]:
    """Writes ``folder/0000.ply``, ... for every frame.

    Args:
        folder: Made if needed.
        body: The object at rest.
        x: Particle positions in the body's order [m], shape (T, n, 3).
        F: Deformation gradients, shape (T, n, 3, 3).
    """
    paths = [folder / name for name in make_splat_names("", len(x))]
    bend = jax.jit(deform)
    for path, positions, gradients in zip(paths, x, F):
        splats = bend(
            body.cloud,
            body.binding,
            jnp.asarray(positions, jnp.float32),
            jnp.asarray(gradients, jnp.float32),
            body.placement.rotation,
        )
        with replace_file(path) as temporary:
            write_ply(temporary, to_source_frame(splats, body.placement), origin=body.placement.origin)
    return paths


def make_splat_names(folder: str, count: int) -> list[str]:
    """Names of the files of ``count`` frames in ``folder``."""
    return [str(PurePosixPath(folder, f"{index:04d}.ply")) for index in range(count)]


def to_source_frame(splats: Splats, placement: Placement) -> GaussianCloud:
    """Undoes the placement, so that frame 0 equals the object file (SH turned along), relative to its origin."""
    back = jnp.asarray(placement.rotation.T, jnp.float32)
    shrink = jnp.broadcast_to(back / placement.scale, (splats.means.shape[0], 3, 3))
    return splats_to_cloud(
        Splats(
            means=jnp.asarray(placement.to_origin(splats.means), jnp.float32),
            covariances=transform_covariances(shrink, splats.covariances),
            opacities=splats.opacities,
            sh=splats.sh,
            rotations=back @ splats.rotations,
        )
    )
