"""Reading mesh files with trimesh, after what they announce was held against what they hold."""

from __future__ import annotations

import io
import os
import re
import struct
import warnings
from pathlib import Path

import numpy as np
import trimesh
from trimesh.resolvers import FilePathResolver

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name
from physagent_jax.core.reading import MIB, check_counts, read_bytes, shorten
from physagent_jax.gaussians.formats.ply_header import read_ply_header
from physagent_jax.scene.config.source import MESH_SUFFIXES, MOST_MESH_BYTES
from physagent_jax.scene.gltf_check import check_glb, check_gltf

_MOST_TEXTURE = 256 * MIB
_FARTHEST = 1e12  # in the file's units; float32 holds its square

_NUMBER = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_BAD_VERTEX = re.compile(rb"^v[ \t]+(?!(?:%b[ \t]+){2}%b(?=\s|$))[^\n]*" % (_NUMBER, _NUMBER), re.M)
_BAD_FACE = re.compile(rb"^f[ \t][^\n]*?(?<=[ \t])0+(?=[/\s]|$)[^\n]*", re.M)  # OBJ counts from 1


def read_mesh(path: str | Path) -> trimesh.Trimesh:
    """Reads a file as one triangle mesh.

    Files that it names (materials, textures, buffers) are read from its own folder only. Colours whose files
    cannot be had are left out with a warning.

    Raises:
        UserError: The file is missing, of an unknown kind, damaged, or holds no faces; its faces have no area or
            coordinates that are not finite or beyond sense.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in (".ply", *MESH_SUFFIXES):
        raise explain_unknown_name(f"the kind of mesh of {shorten(path)}", suffix, (".ply", *MESH_SUFFIXES))
    data = read_bytes(path, most=MOST_MESH_BYTES, what="the mesh file")
    beside = _Beside(path)
    data = _check(data, path, suffix, beside)
    try:
        with np.errstate(all="ignore"):  # what overflows is found by the check
            mesh = trimesh.load(
                io.BytesIO(data), file_type=suffix[1:], resolver=beside, force="mesh", process=True
            )
            if isinstance(mesh, trimesh.Trimesh):
                _check_mesh(mesh, path)
    except UserError:
        raise
    except Exception as error:  # trimesh's loaders raise whatever their parsers meet
        reason = beside.missing[0] if beside.missing else f"{type(error).__name__}: {error}"
        raise UserError(
            f"cannot read the mesh {shorten(path)}",
            got=shorten(reason),
            do="Export it again as .obj or .glb",
        ) from None
    if not isinstance(mesh, trimesh.Trimesh):
        raise UserError(f"{shorten(path)} holds no faces", do="Give a mesh with triangles, or a 3DGS .ply")
    if beside.missing:
        warnings.warn(f"{path}: colours are left out: {beside.missing[0]}", stacklevel=2)
    return mesh


def _check(data: bytes, path: Path, suffix: str, beside: _Beside) -> bytes:
    """The file's bytes, text in UTF-8, once its counts have been checked."""
    place = shorten(path)
    match suffix:
        case ".ply":
            return data if read_ply_header(path).order else _decode_utf8(data)
        case ".glb":
            check_glb(data, place, beside.get)
        case ".gltf":
            check_gltf(data, place, beside.get)
        case ".stl":
            return _check_stl(data, place)
        case ".obj":
            data = _decode_utf8(data)
            for pattern, what in ((_BAD_VERTEX, "three numbers"), (_BAD_FACE, "vertices counted from 1")):
                if found := pattern.search(data):
                    line = repr(shorten(found.group().decode(), 60))
                    raise UserError(f"{place}: a line does not have {what}", got=line, do="Export it again")
            return data
        case ".off":
            return _decode_utf8(data)
    return data


def _check_stl(data: bytes, place: str) -> bytes:
    """STL is binary if its size is what the count of faces says, else text."""
    count = struct.unpack("<I", data[80:84])[0] if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        return data
    if not data.lstrip().startswith(b"solid"):
        if count >= 0:
            check_counts(place, "faces", count, 50, len(data) - 84)
        raise UserError(f"cannot read {place}: it is no STL file", do="Export it again")
    return _decode_utf8(data)


def _decode_utf8(data: bytes) -> bytes:
    """Text of old programs is in Latin-1, which differs in names and comments only."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1").encode("utf-8")
    return data


def _check_mesh(mesh: trimesh.Trimesh, path: Path) -> None:
    shown, vertices, faces = shorten(path), np.asarray(mesh.vertices), np.asarray(mesh.faces)
    if len(faces) == 0:
        raise UserError(f"{shown} holds no faces", do="Give a mesh with triangles, or a 3DGS .ply")
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not (0 <= faces.min() and faces.max() < len(vertices)):
        raise UserError(
            f"the faces of {shown} name vertices that it does not hold",
            got=f"vertex {faces.max()} of {len(vertices)}",
            do="Export it again",
        )
    if not (np.abs(vertices) <= _FARTHEST).all():
        raise UserError(
            f"{shown} has vertices that are not finite, or beyond {_FARTHEST:g}", do="Mend the mesh"
        )
    if not (np.isfinite(mesh.area) and mesh.area > 0):
        raise UserError(f"the faces of {shown} have no finite area", got=mesh.area, do="Mend the mesh")


class _Beside(FilePathResolver):
    """Files that a mesh names, from its own folder only.

    Attributes:
        missing: What could not be had, a sentence each.
    """

    def __init__(self, path: Path):
        super().__init__(str(path))
        self.missing: list[str] = []
        self._folder = os.path.realpath(path.parent)

    def get(self, name: str) -> bytes:
        """A file's bytes.

        Raises:
            FileNotFoundError: There is none that may be read; trimesh goes on without colours.
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
                data = read_bytes(place, most=_MOST_TEXTURE, what="a file that the mesh names:")
                return _decode_utf8(data) if place.lower().endswith(".mtl") else data
            except UserError as error:
                reason = str(error)
        self.missing.append(reason)
        raise FileNotFoundError(reason)
