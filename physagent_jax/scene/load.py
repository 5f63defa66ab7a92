"""Object files: which reader a file needs, and a hash that tells whether it changed."""

from __future__ import annotations

import hashlib
import warnings
from pathlib import Path
from typing import NoReturn

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_regular, open_regular, shorten
from physagent_jax.gaussians.formats import (
    LoadedSplats,
    explain_unknown,
    find_format,
    read_head,
    read_splats,
)
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES
from physagent_jax.scene import mesh_formats
from physagent_jax.scene.config import Photo, Source
from physagent_jax.scene.config.source import MESH_SUFFIXES
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.photo.lift import lift_photo
from physagent_jax.scene.photo.picture import is_picture


def load_object(source: Source, base_dir: str | Path) -> LoadedSplats:
    """Read the object's file, in its own frame and units; what a user should know of it is warned of.

    Args:
        source: The file, and what to keep of it; a ``sha256`` in it is checked.
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
    if is_photo(path):
        return _lift_photo(source, Path(base_dir))
    if source.photo is not None:
        refuse_photo(path)
    if holds_splats(path):
        loaded = read_splats(path, opacity_threshold=source.opacity_threshold, encoding=source.splat_encoding)
        for note in loaded.notes:
            warnings.warn(note, stacklevel=2)
        return loaded
    return _sample_mesh(path, source)


def load_named_parts(source: Source, base_dir: str | Path) -> list[MeshPart]:
    """The surfaces that the object's file names, in its own frame and units; none for what is no mesh.

    Raises:
        UserError: The file cannot be read.
    """
    if (path := _find_mesh(source, base_dir)) is None:
        return []
    from physagent_jax.scene.mesh_files import read_named_parts  # trimesh takes long to import

    return read_named_parts(path)


def load_shells(source: Source, base_dir: str | Path) -> list[MeshPart]:
    """The shells of the object's surface, in its own frame and units; none for what is no mesh, or one shell alone.

    Raises:
        UserError: The file cannot be read.
    """
    if (path := _find_mesh(source, base_dir)) is None:
        return []
    from physagent_jax.scene.mesh_files import read_shells  # trimesh takes long to import

    return read_shells(path)


def _find_mesh(source: Source, base_dir: str | Path) -> Path | None:
    """The object's file if it is a mesh."""
    path = Path(base_dir) / source.path
    return None if is_photo(path) or holds_splats(path) else path


def is_photo(path: Path) -> bool:
    """Return whether a file holds a picture, by its content.

    Raises:
        UserError: It cannot be read.
    """
    return is_picture(read_head(path, what="the object file"))


def check_object(path: str | Path) -> None:
    """Refuse an object file that is missing, no regular file or too large to be read."""
    check_regular(path, most=MOST_BYTES, what="the object file")


def hash_file(path: str | Path) -> str:
    """SHA-256 of a file's bytes, in hexadecimal.

    Raises:
        UserError: The file cannot be read.
    """
    with open_regular(path, most=MOST_BYTES, what="the object file") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def refuse_photo(path: Path) -> NoReturn:
    """Refuse what should be a photo and is none."""
    raise UserError(
        f"{shorten(path)} is no image",
        got=path.suffix or "no suffix",
        do="Give a PNG, JPEG, WebP, BMP or TIFF file, or pass 3D Gaussians and meshes by --object",
    )


def _lift_photo(source: Source, base_dir: Path) -> LoadedSplats:
    """The object in a photo as Gaussians; what was made up is warned of."""
    if source.splat_encoding is not None or source.up != "+z":
        given = "up" if source.splat_encoding is None else "splat_encoding"
        raise UserError(
            f"`{given}` means nothing for an image", got=getattr(source, given), do="Leave it out"
        )
    lifted = lift_photo(Path(source.path), source.photo or Photo(), base_dir)
    for note in lifted.notes:
        warnings.warn(note, stacklevel=3)
    how, count = "its object lifted to Gaussians", lifted.cloud.count
    return LoadedSplats(lifted.cloud, np.zeros(3), "photo", how, "+z", lifted.notes, count)


def _sample_mesh(path: Path, source: Source) -> LoadedSplats:
    """A mesh as Gaussians on its surface."""
    if source.splat_encoding is not None:
        raise UserError(
            f"`splat_encoding` means nothing for the mesh {shorten(path)}",
            got=source.splat_encoding,
            do="Leave it out",
        )
    from physagent_jax.scene.mesh import sample_mesh  # trimesh takes long to import

    cloud, plain = sample_mesh(path, count=source.surface_samples, seed=0, up=source.up)
    found = mesh_formats.find_mesh_format(read_head(path), path)
    assert found is not None  # or it would not have been read
    name, how = f"{found.name} mesh", "Gaussians sampled on its surface"
    return LoadedSplats(cloud, np.zeros(3), name, how, found.up, (), cloud.count, plain, found.front)


def holds_splats(path: Path) -> bool:
    """Return whether a file holds 3D Gaussians rather than a mesh, by its content.

    Raises:
        UserError: It holds neither.
    """
    head = read_head(path, what="the object file")
    if find_format(head, path) is not None:
        return True
    if mesh_formats.find_mesh_format(head, path) is not None:
        return False
    raise explain_unknown(path, (".ply", *MESH_SUFFIXES), "PNG, JPEG, WebP, BMP, TIFF")
