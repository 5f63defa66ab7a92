"""The vertices of a PLY file as columns of doubles."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from plyfile import PlyData, PlyElement, PlyListProperty, PlyParseError

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.gaussians.formats.ply_header import read_ply_header


@dataclasses.dataclass(frozen=True)
class Vertices:
    """The element `vertex` of a PLY file.

    Attributes:
        shown: The file's name, for messages.
        types: NumPy types of the columns that are no lists, by name.
        comments: Comments of the file's header.
        face_count: Number of faces beside the vertices.
    """

    shown: str
    types: dict[str, np.dtype]
    comments: tuple[str, ...]
    face_count: int
    _element: PlyElement

    def read_columns(self, names: Iterable[str]) -> np.ndarray:
        """Columns side by side, float64, shape (n, number of names)."""
        # Copies, because plyfile maps the file into memory, and a mapped file must not be overwritten.
        with np.errstate(invalid="ignore"):  # a signalling NaN, which is dropped with the others
            return np.stack([np.asarray(self._element[name], np.float64) for name in names], axis=-1)


def read_vertices(path: str | Path) -> Vertices:
    """Read the vertices of a PLY file, binary or text, in either byte order.

    Raises:
        UserError: The file is missing, is no PLY, is truncated, or has no vertices.
    """
    shown, header = shorten(path), read_ply_header(path)  # checks the counts
    try:
        data = PlyData.read(os.fspath(path))
    except (PlyParseError, ValueError) as error:  # ValueError: words where text should hold numbers
        message = shorten(error)
        if "early end-of-file" in message and "element" in message:
            what, do = f"{shown} is truncated", "Copy or export the file again"
        else:
            what, do = f"{shown} is not a readable PLY file", "Give a 3DGS .ply file"
        raise UserError(what, got=message, do=do) from error
    if "vertex" not in data:
        found = ", ".join(element.name for element in data.elements) or "none"
        raise UserError(f"{shown} has no element `vertex`", got=found, do="Give a 3DGS .ply file")
    vertex, face = data["vertex"], header.element("face")
    if vertex.count == 0:
        raise UserError(f"{shown} holds no Gaussians", got="0 vertices", do="Export the scene again")
    types = {
        p.name: vertex.data.dtype[p.name] for p in vertex.properties if not isinstance(p, PlyListProperty)
    }
    return Vertices(shown, types, header.comments, face.count if face else 0, vertex)
