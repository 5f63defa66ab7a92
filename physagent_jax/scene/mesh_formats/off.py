"""OFF, the text of Geomview, with colours of vertices and faces."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from physagent_jax.scene.config.common import SignedAxis
from physagent_jax.scene.mesh_formats.base import MeshPart, Neighbours, decode_utf8
from physagent_jax.scene.mesh_formats.look import Look, as_rgba

_HEADER = re.compile(rb"(?:\s|#[^\n]*\n)*(ST)?(C?)(N?)OFF\b")


class OFF:
    """Vertices and polygons; the header COFF announces colours of vertices."""

    name = "OFF"
    suffixes: tuple[str, ...] = (".off",)
    up: SignedAxis | None = None
    front: SignedAxis | None = None

    def matches(self, head: bytes, size: int) -> bool:
        """Return whether the first word is OFF, or COFF, NOFF and the like."""
        return _HEADER.match(head) is not None

    def read(self, data: bytes, path: Path, beside: Neighbours) -> list[MeshPart]:
        """The file's one part."""
        from trimesh import Trimesh
        from trimesh.exchange.off import load_off  # takes long to import

        loaded = load_off(io.BytesIO(decode_utf8(data)))
        mesh = Trimesh(loaded["vertices"], loaded["faces"], process=False)
        vertices = np.asarray(mesh.vertices, np.float64)
        return [MeshPart(vertices, np.asarray(mesh.faces), _read_colours(data, len(vertices)))]


def _read_colours(data: bytes, count: int) -> Look | None:
    """Colours of a COFF's vertices: the last three or four numbers of each line, bytes or fractions."""
    header = _HEADER.match(data)
    if header is None or not header.group(2):
        return None
    text = re.sub(rb"#[^\n]*", b"", data[header.end() :]).decode("latin-1")
    lines = [words for line in text.splitlines() if (words := line.split())][1 : count + 1]
    before = 6 if header.group(3) else 3  # a position, and a normal
    columns = min((len(words) - before for words in lines), default=0)
    if columns < 3:
        return None
    words = [line[before : before + (4 if columns >= 4 else 3)] for line in lines]
    colours = np.array(words, np.float64)
    whole = not any("." in word or "e" in word.lower() for word in words[0])
    return Look(vertex_colours=as_rgba(colours / 255 if whole else colours))
