"""PLY with faces, binary or text."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.formats.ply_header import read_ply_header
from physagent_jax.scene.config.common import SignedAxis
from physagent_jax.scene.mesh_formats.base import MeshPart, Neighbours, decode_utf8
from physagent_jax.scene.mesh_formats.look import Look, Texture, as_rgba, read_pixels

_TEXTURE = re.compile(rb"^comment[ \t]+texturefile[ \t]+([^\r\n]+)", re.I | re.M)
_INDEX_NAMES = ("vertex_index", "vertex_indices")


class PLY:
    """Elements of named columns; colours of vertices or faces, or one texture."""

    name = "PLY"
    suffixes: tuple[str, ...] = (".ply",)
    up: SignedAxis | None = None
    front: SignedAxis | None = None

    def matches(self, head: bytes, size: int) -> bool:
        """Return whether the first line is ``ply``."""
        return head[:4] in (b"ply\n", b"ply\r")

    def read(self, data: bytes, path: Path, beside: Neighbours) -> list[MeshPart]:
        """The file's one part; without faces, none."""
        from trimesh import Trimesh
        from trimesh.exchange.ply import load_ply  # takes long to import

        header = read_ply_header(path)
        names = _TEXTURE.findall(data[: header.size])
        loaded = load_ply(
            io.BytesIO(data if header.order else decode_utf8(data)),
            fix_texture=bool(names),
            skip_materials=True,
        )
        if loaded.get("faces") is None:
            return []
        mesh = Trimesh(loaded["vertices"], loaded["faces"], process=False)
        look = _read_texture(loaded, names, beside) or _read_colours(loaded, mesh)
        return [
            MeshPart(
                np.asarray(mesh.vertices, np.float64),
                np.asarray(mesh.faces),
                look,
                _read_normals(loaded, len(mesh.vertices)),
            )
        ]


def _read_texture(loaded: dict[str, Any], names: list[bytes], beside: Neighbours) -> Look | None:
    if not names or "visual" not in loaded:
        return None
    if len(names) > 1:
        beside.missing.append(f"it has {len(names)} textures, of which a PLY file's faces name one each")
        return None
    data = beside.read_optional(names[0].decode("utf-8", "replace"))
    if data is None:
        return None
    try:
        pixels = read_pixels(data)
    except UserError as error:
        beside.missing.append(str(error))
        return None
    uv = np.asarray(loaded["visual"].uv) * [1, -1] + [0, 1]
    return Look(texture=Texture(pixels, uv))


def _read_colours(loaded: dict[str, Any], mesh: Any) -> Look | None:
    """Colours of the vertices, else of the faces."""
    colours = loaded.get("vertex_colors")
    if colours is not None and len(colours) == len(mesh.vertices):
        return Look(vertex_colours=as_rgba(_scale_integers(colours)))
    colours = loaded.get("face_colors")
    if colours is None:
        return None
    owners = _find_owners(loaded, len(colours))
    if len(owners) != len(mesh.faces):
        return None
    return Look(face_colours=as_rgba(_scale_integers(colours))[owners])


def _scale_integers(colours: np.ndarray) -> np.ndarray:
    """Integers of any width that hold bytes, as fractions."""
    if colours.dtype.kind in "ui" and colours.size and colours.max() <= 255:
        return colours / 255
    return colours


def _find_owners(loaded: dict[str, Any], count: int) -> np.ndarray:
    """The polygon of each triangle, in the order in which the loader cuts them: triangles, quads, others."""
    faces = np.asarray(loaded["faces"])
    if faces.shape == (count, 4):
        return np.tile(np.arange(count), 2)
    if faces.shape == (count, 3):
        return np.arange(count)
    data = loaded["metadata"]["_ply_raw"]["face"]["data"]
    lists = next((data[name] for name in _INDEX_NAMES if name in data), []) if isinstance(data, dict) else []
    lengths = np.array([len(each) for each in lists], int)
    triangles, quads, others = (np.flatnonzero(each) for each in (lengths == 3, lengths == 4, lengths > 4))
    return np.concatenate([triangles, np.tile(quads, 2), np.repeat(others, lengths[others] - 2)])


def _read_normals(loaded: dict[str, Any], count: int) -> np.ndarray | None:
    normals = loaded.get("vertex_normals")
    return np.asarray(normals, np.float64) if normals is not None and len(normals) == count else None
