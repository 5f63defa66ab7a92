"""One file of 3D Gaussians per frame, which ordinary viewers open, in the units of the object's file."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.files import replace_file
from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.cloud import GaussianCloud, Splats
from physagent_jax.gaussians.covariance import transform_covariances
from physagent_jax.gaussians.export import splats_to_cloud
from physagent_jax.gaussians.formats.gltf_writer import write_glb
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.gaussians.formats.spz_writer import write_spz
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import SignedAxis
from physagent_jax.scene.placement import Placement, find_up_rotation

SplatFormat = Literal["ply", "spz", "glb"]
WRITERS = {"ply": write_ply, "spz": write_spz, "glb": write_glb}
_Y_UP = ("spz", "glb")  # formats that prescribe +y as up


def write_splat_frames(
    folder: Path,
    body: Body,
    x: np.ndarray,
    F: np.ndarray,
    *,
    form: SplatFormat = "ply",
    up: SignedAxis = "+z",
) -> list[Path]:
    """Write ``folder/0000.ply``, ... for every frame.

    Args:
        folder: Made if needed.
        body: The object at rest.
        x: Particle positions in the body's order [m], shape (T, n, 3).
        F: Deformation gradients, shape (T, n, 3, 3).
        form: The files' format.
        up: The up axis of the object's file. PLY files keep its axes, the other formats have +y up.
    """
    paths = [folder / name for name in make_splat_names("", len(x), form)]
    turn = find_frame_turn(form, up)
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
            WRITERS[form](
                temporary, to_source_frame(splats, body.placement, turn), origin=turn @ body.placement.origin
            )
    return paths


def make_splat_names(folder: str, count: int, form: SplatFormat = "ply") -> list[str]:
    """Names of the files of ``count`` frames in ``folder``."""
    return [str(PurePosixPath(folder, f"{index:04d}.{form}")) for index in range(count)]


def find_frame_turn(form: SplatFormat, up: SignedAxis) -> np.ndarray:
    """The rotation from the axes of the object's file to those of a written one, shape (3, 3).

    Args:
        form: Format of the written file.
        up: The up axis of the object's file.
    """
    return find_up_rotation("+y").T @ find_up_rotation(up) if form in _Y_UP else np.eye(3)


def to_source_frame(splats: Splats, placement: Placement, turn: np.ndarray | None = None) -> GaussianCloud:
    """Undo the placement, so that frame 0 equals the object file (SH turned along), relative to its origin.

    Args:
        splats: Gaussians in the world.
        placement: From the file's frame to the world.
        turn: Rotation that follows, shape (3, 3); None = none does.
    """
    turn = np.eye(3) if turn is None else turn
    back = jnp.asarray(turn @ placement.rotation.T, jnp.float32)
    shrink = jnp.broadcast_to(back / placement.scale, (splats.means.shape[0], 3, 3))
    return splats_to_cloud(
        Splats(
            means=jnp.asarray(placement.to_origin(splats.means) @ turn.T, jnp.float32),
            covariances=transform_covariances(shrink, splats.covariances),
            opacities=splats.opacities,
            sh=splats.sh,
            rotations=back @ splats.rotations,
        )
    )
