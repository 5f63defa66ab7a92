"""The interface of a mesh file format, and the surfaces that a reader hands on."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from typing import Protocol

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import MIB, read_bytes, shorten
from physagent_jax.scene.config.common import SignedAxis
from physagent_jax.scene.mesh_formats.look import Look

_MOST_TEXTURE = 256 * MIB


@dataclasses.dataclass(frozen=True)
class MeshPart:
    """Triangles that share a look.

    Attributes:
        vertices: Positions [file units], float64, shape (n, 3).
        faces: Vertices of the triangles, int, shape (m, 3).
        look: Declared colours; None = the file declares none.
        normals: Normals of the vertices, of any length, shape (n, 3); None = the file has none.
        names: What the file calls it, and what it belongs to; the nearest name first.
        bones: The joint of a skin that moves each triangle most, shape (m,), and what each joint's limb is called, as
            ``names``; None = it has no skin.
    """

    vertices: np.ndarray
    faces: np.ndarray
    look: Look | None = None
    normals: np.ndarray | None = None
    names: tuple[str, ...] = ()
    bones: tuple[np.ndarray, tuple[tuple[str, ...], ...]] | None = None

    def split(self) -> list[MeshPart]:
        """The surfaces of the limbs that its skin names; itself if that names none."""
        if self.bones is None or not any(self.bones[1]):
            return [self]
        owner, limbs = self.bones
        found = []
        for name in dict.fromkeys(limbs):
            faces = self.faces[np.isin(owner, [k for k, each in enumerate(limbs) if each == name])]
            names = tuple(dict.fromkeys((*name, *self.names)))
            found.append(dataclasses.replace(self, faces=faces, names=names, bones=None))
        return [each for each in found if len(each.faces)]


class Neighbours:
    """Files that a mesh names, from its own folder only.

    Args:
        path: The mesh.

    Attributes:
        missing: Colours that could not be had, one sentence each.
    """

    def __init__(self, path: Path):
        self.missing: list[str] = []
        self._folder = os.path.realpath(path.parent)

    def read(self, name: str) -> bytes:
        """A file's bytes.

        Raises:
            FileNotFoundError: No file of that name may be read.
        """
        name = name.strip()
        reason = f"it names the file {shorten(name, 80)!r}, which is not in its folder"
        for candidate in (name, name.replace("\\", "/").rsplit("/", 1)[-1]):
            try:
                place = os.path.realpath(os.path.join(self._folder, candidate))
            except (OSError, ValueError):  # a name that the system cannot take
                continue
            if os.path.commonpath([self._folder, place]) != self._folder or not os.path.lexists(place):
                continue
            try:
                return read_bytes(place, most=_MOST_TEXTURE, what="a file that the mesh names:")
            except UserError as error:
                reason = str(error)
        raise FileNotFoundError(reason)

    def read_optional(self, name: str) -> bytes | None:
        """A file's bytes; None = it cannot be read, which is noted in ``missing``."""
        try:
            return self.read(name)
        except FileNotFoundError as error:
            self.missing.append(str(error))
            return None


class MeshFormat(Protocol):
    """A mesh file format.

    Attributes:
        name: The format's name as its users write it ("STL").
        suffixes: Usual file name endings; a format is found by content first.
        up: The up axis that the format prescribes; None = it prescribes none.
        front: The axis towards which it says that an object looks; None = it says nothing of that.
    """

    name: str
    suffixes: tuple[str, ...]
    up: SignedAxis | None
    front: SignedAxis | None

    def matches(self, head: bytes, size: int) -> bool:
        """Return whether a file of ``size`` bytes that begins with ``head`` is of this format."""
        ...

    def read(self, data: bytes, path: Path, beside: Neighbours) -> list[MeshPart]:
        """Read a file.

        Args:
            data: Its bytes.
            path: The file, for messages and headers.
            beside: Files that it may name.

        Raises:
            UserError: The file is damaged, or announces more than it holds.
        """
        ...


def decode_utf8(data: bytes) -> bytes:
    """Text in UTF-8; old programs write Latin-1, which differs in names and comments only."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1").encode("utf-8")
    return data
