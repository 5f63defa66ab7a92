"""STL, binary or text."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_counts, shorten
from physagent_jax.scene.config.common import SignedAxis
from physagent_jax.scene.mesh_formats.base import MeshPart, Neighbours, decode_utf8
from physagent_jax.scene.mesh_formats.look import Look

_HEADER, _FACE = 84, 50  # bytes
_VALID = 0x8000


class STL:
    """Triangles without connection; in two bytes of each, some programs write a colour."""

    name = "STL"
    suffixes: tuple[str, ...] = (".stl",)
    up: SignedAxis | None = None
    front: SignedAxis | None = None

    def matches(self, head: bytes, size: int) -> bool:
        """Return whether the size is that of the announced faces, or the text begins with a solid and a facet."""
        if len(head) >= _HEADER and size == _HEADER + _FACE * _count_faces(head):
            return True
        return head.lstrip()[:5].lower() == b"solid" and b"facet" in head.lower()

    def read(self, data: bytes, path: Path, beside: Neighbours) -> list[MeshPart]:
        """The file's parts, a text's solids one each."""
        from trimesh.exchange.stl import load_stl  # takes long to import

        place, count = shorten(path), _count_faces(data) if len(data) >= _HEADER else -1
        binary = len(data) == _HEADER + _FACE * count
        if not binary and not data.lstrip()[:5].lower() == b"solid":
            if count >= 0:
                check_counts(place, "faces", count, _FACE, len(data) - _HEADER)
            raise UserError(f"cannot read {place}: it is no STL file", do="Export it again")
        loaded = load_stl(io.BytesIO(data if binary else decode_utf8(data)))
        solids = loaded["geometry"].values() if "geometry" in loaded else [loaded]
        look = _read_colours(data) if binary else None
        return [
            MeshPart(np.asarray(solid["vertices"], np.float64), np.asarray(solid["faces"]), look)
            for solid in solids
        ]


def _count_faces(data: bytes) -> int:
    return struct.unpack("<I", data[80:84])[0]


def _read_colours(data: bytes) -> Look | None:
    """Colours of a binary file's faces; five bits each, of which two conventions are known.

    A header with ``COLOR=`` gives a default and stores red in the lowest bits of the faces whose highest bit is 0
    (Materialise Magics). Without it, blue is lowest, and the highest bit marks the faces that have a colour (VisCAM).
    """
    faces = np.frombuffer(data, np.uint8, offset=_HEADER).reshape(-1, _FACE)
    bits = np.ascontiguousarray(faces[:, 48:50]).view("<u2")[:, 0].astype(int)
    parts = np.stack([bits & 31, bits >> 5 & 31, bits >> 10 & 31], axis=1) / 31
    at = data[:80].find(b"COLOR=")
    if 0 <= at <= 70:
        default = np.frombuffer(data, np.uint8, 3, at + 6) / 255
        rgb = np.where((bits & _VALID == 0)[:, None], parts, default)
    else:
        valid = bits & _VALID != 0
        if not valid.any():
            return None
        rgb = np.where(valid[:, None], parts[:, ::-1], 1.0)  # a face without colour is white
    return Look(face_colours=np.concatenate([rgb, np.ones((len(rgb), 1))], axis=1))
