"""Object files: which reader a file needs, and a hash that tells whether it changed."""

from __future__ import annotations

import hashlib
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_regular, open_regular
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.formats import read_ply
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES, read_ply_header
from physagent_jax.scene.config import Source
from physagent_jax.scene.config.source import MESH_SUFFIXES

# Formats of splat viewers that are not read here.
_OTHER_SPLATS = {
    ".spz": "Niantic SPZ",
    ".splat": "antimatter15 splat",
    ".ksplat": "mkkellogg ksplat",
    ".sog": "PlayCanvas SOG",
}
_GAUSSIAN_PROPERTIES = {"f_dc_0", "scale_0", "rot_0", "opacity"}


def load_object(source: Source, base_dir: str | Path) -> GaussianCloud:
    """Reads the object's file, in its own frame and units.

    Args:
        source: Which file, and what to keep of it; a ``sha256`` in it is checked.
        base_dir: Folder that a relative path starts from.

    Raises:
        UserError: The file is missing, of an unknown kind, unreadable, or not the one that was hashed.
    """
    path = Path(base_dir) / source.path
    check_object(path)
    if source.sha256 is not None and (found := hash_file(path)) != source.sha256.lower():
        raise UserError(
            f"{path} is not the file that this scene was made with",
            got=f"sha256 {found[:12]}..., expected {source.sha256[:12]}...",
            do="Restore the file, or remove `source.sha256` from the scene",
        )
    if _is_mesh(path):
        from physagent_jax.scene.mesh import gaussians_from_mesh  # trimesh takes long to import

        return gaussians_from_mesh(path, count=source.surface_samples, seed=0, up=source.up)
    return read_ply(path, opacity_threshold=source.opacity_threshold)


def check_object(path: str | Path) -> None:
    """Refuses an object file that is missing, no regular file or too large to be read."""
    check_regular(path, most=MOST_BYTES, what="the object file")


def hash_file(path: str | Path) -> str:
    """SHA-256 of a file's bytes, in hexadecimal.

    Raises:
        UserError: The file cannot be read.
    """
    with open_regular(path, most=MOST_BYTES, what="the object file") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _is_mesh(path: Path) -> bool:
    """Whether a file is a mesh rather than 3D Gaussians.

    Raises:
        UserError: It is neither.
    """
    suffix = path.suffix.lower()
    if suffix in MESH_SUFFIXES:
        return True
    if suffix in _OTHER_SPLATS:
        raise UserError(
            f"{path} is a {_OTHER_SPLATS[suffix]} file, which is not supported",
            do="Convert it to a 3DGS .ply, e.g. with `npx @playcanvas/splat-transform in.spz out.ply`",
        )
    if suffix != ".ply":
        known = ", ".join((".ply", *MESH_SUFFIXES))
        raise UserError(f"{path} is of an unknown kind", got=suffix or "no suffix", do=f"Give one of {known}")
    header = read_ply_header(path)
    face, vertex = header.element("face"), header.element("vertex")
    faces, properties = face.count if face else 0, vertex.names if vertex else set()
    if faces == 0 and not _GAUSSIAN_PROPERTIES & properties and "packed_position" not in properties:
        raise UserError(
            f"{path} holds neither faces nor 3D Gaussians",
            got=f"vertex properties {sorted(properties)}",
            do="Give a 3DGS .ply (with f_dc_*, scale_*, rot_*, opacity) or a mesh",
        )
    return faces > 0 and not _GAUSSIAN_PROPERTIES <= properties
