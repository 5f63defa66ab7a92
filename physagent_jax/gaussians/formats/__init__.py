"""File formats of 3D Gaussians: one file each, found by content.

A format is an object that fulfils `base.Format`. To add one: its file, and a line in `FORMATS`.
"""

from __future__ import annotations

import dataclasses
import os
import warnings
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import open_regular, shorten
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.formats.antimatter15 import ANTIMATTER15
from physagent_jax.gaussians.formats.base import HEAD_BYTES, Format, SignedAxis, SplatData
from physagent_jax.gaussians.formats.compressed_ply import COMPRESSED_PLY
from physagent_jax.gaussians.formats.finish import LoadedSplats, check_threshold, finish
from physagent_jax.gaussians.formats.gltf import GLTF
from physagent_jax.gaussians.formats.ply_gaussians import PLY_2DGS, PLY_3DGS, PLY_RGB, GaussianPly
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES, read_ply_header
from physagent_jax.gaussians.formats.points import COLMAP_POINTS, PLY_POINTS
from physagent_jax.gaussians.formats.sog import SOG
from physagent_jax.gaussians.formats.spz import SPZ
from physagent_jax.gaussians.formats.unread import UNREAD

FORMATS: tuple[Format, ...] = (
    COMPRESSED_PLY,
    PLY_2DGS,
    PLY_RGB,
    PLY_3DGS,
    PLY_POINTS,
    SPZ,
    SOG,
    GLTF,
    COLMAP_POINTS,
    *UNREAD,
    ANTIMATTER15,  # has no magic number
)
"""Formats in the order in which they are tried: the first that matches reads the file."""

__all__ = [
    "FORMATS",
    "HEAD_BYTES",
    "Format",
    "LoadedSplats",
    "SignedAxis",
    "SplatData",
    "describe_formats",
    "explain_unknown",
    "find_format",
    "read_head",
    "read_ply",
    "read_splats",
]


def read_head(path: str | os.PathLike[str], *, what: str = "the file") -> bytes:
    """The first `HEAD_BYTES` of a file.

    Args:
        path: The file.
        what: The file's role, for messages ("the object file").

    Raises:
        UserError: The file is missing, no regular file or too large.
    """
    with open_regular(Path(path), most=MOST_BYTES, what=what) as file:
        return file.read(HEAD_BYTES)


def find_format(head: bytes, path: str | os.PathLike[str]) -> Format | None:
    """The splat format of a file, told by its content; None if it is none of them.

    Args:
        head: The file's beginning, as of `read_head`.
        path: The file.
    """
    return next((each for each in FORMATS if each.matches(head)), None)


def describe_formats() -> str:
    """The names and suffixes of all formats, for messages and help texts."""
    return ", ".join(f"{each.name} ({', '.join(each.suffixes)})" for each in FORMATS if each.suffixes)


def explain_unknown(
    path: str | os.PathLike[str], meshes: tuple[str, ...] = (), photos: str = ""
) -> UserError:
    """The error for a file that is of none of the formats.

    Args:
        path: The file.
        meshes: Suffixes of meshes, where a mesh would do as well.
        photos: Names of picture formats, where a photo would do as well.
    """
    suffix, shown = Path(path).suffix.lower(), shorten(path)
    unread = next((each for each in UNREAD if each.ending == suffix != ""), None)
    if unread is not None:
        return unread.explain(Path(path))
    named = [each.name for each in FORMATS if suffix in each.suffixes]
    if named:
        return UserError(
            f"{shown} is no readable file of the format that its name says",
            got=f"{suffix} with a content that is not {' or '.join(named)}",
            do="Copy or export the file again",
        )
    beside = f", or a mesh: {', '.join(meshes)}" if meshes else ""
    beside += f", or a photo: {photos}" if photos else ""
    return UserError(
        f"{shown} is of an unknown kind",
        got=suffix or "no suffix",
        do=f"Give 3D Gaussians: {describe_formats()}{beside}",
    )


def read_splats(
    path: str | os.PathLike[str], *, opacity_threshold: float = 0.0, encoding: str | None = None
) -> LoadedSplats:
    """Read 3D Gaussians from a file of any known format, in linear units and the file's own frame.

    Gaussians with a value that is not finite, or so large that float32 cannot compute with it, are dropped with a
    note. Quaternions are normalised; one of norm zero is read as the identity, with a note.

    Args:
        path: The file.
        opacity_threshold: Least opacity of the Gaussians that are kept, in [0, 1].
        encoding: Reading of scales and opacities (`--splat-encoding`); None = found from the content.

    Raises:
        UserError: The file is missing, damaged, ambiguous or of no known format, or no usable Gaussian is left.
    """
    check_threshold(opacity_threshold)
    found = find_format(read_head(path), path)
    if found is None:
        raise explain_unknown(path)
    data = found.read(Path(path), encoding)
    if encoding is not None and not isinstance(found, GaussianPly):
        note = f"{shorten(path)}: `--splat-encoding` changes nothing, because {found.name} has one encoding"
        data = dataclasses.replace(data, notes=(*data.notes, note))
    return finish(data, Path(path), found.name, opacity_threshold)


def read_ply(path: str | os.PathLike[str], *, opacity_threshold: float = 0.0) -> GaussianCloud:
    """Read 3D Gaussians from a PLY file of any known layout, as `read_splats`; its notes become warnings.

    Raises:
        UserError: As `read_splats`, or the file is no PLY.
    """
    check_threshold(opacity_threshold)
    read_ply_header(Path(path))
    loaded = read_splats(path, opacity_threshold=opacity_threshold)
    for note in loaded.notes:
        warnings.warn(note, stacklevel=2)
    if loaded.origin.any():
        warnings.warn(
            f"{shorten(path)}: positions are relative to {loaded.origin.tolist()}, because float32 cannot hold "
            "them; `read_splats` tells the origin",
            stacklevel=2,
        )
    return loaded.cloud
