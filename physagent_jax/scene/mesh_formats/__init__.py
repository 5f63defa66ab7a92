"""Mesh file formats, one module each, found by content."""

from __future__ import annotations

import os
from pathlib import Path

from physagent_jax.core.reading import open_regular
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES
from physagent_jax.scene.mesh_formats.base import MeshFormat as MeshFormat
from physagent_jax.scene.mesh_formats.base import MeshPart as MeshPart
from physagent_jax.scene.mesh_formats.base import Neighbours as Neighbours
from physagent_jax.scene.mesh_formats.gltf import GLB, GLTF
from physagent_jax.scene.mesh_formats.obj import OBJ
from physagent_jax.scene.mesh_formats.off import OFF
from physagent_jax.scene.mesh_formats.ply import PLY
from physagent_jax.scene.mesh_formats.stl import STL

HEAD_BYTES = 2**16
"""Length of the beginning of a file by which formats are told apart [bytes]."""

# OBJ comes last: it has no mark, only lines of its kind.
FORMATS: tuple[MeshFormat, ...] = (GLB(), PLY(), OFF(), GLTF(), STL(), OBJ())


def find_mesh_format(head: bytes, path: str | Path) -> MeshFormat | None:
    """The format of a mesh file, by its content, or by its suffix where the content belongs to none; None = no mesh.

    Args:
        head: The file's beginning, at least `HEAD_BYTES` where it has them.
        path: The file.

    Raises:
        UserError: The file cannot be read.
    """
    with open_regular(path, most=MOST_BYTES, what="the mesh file") as file:
        size = os.fstat(file.fileno()).st_size
    found = next((each for each in FORMATS if each.matches(head, size)), None)
    if found is not None:
        return found
    suffix = Path(path).suffix.lower()
    return next((each for each in FORMATS if suffix in each.suffixes), None)
