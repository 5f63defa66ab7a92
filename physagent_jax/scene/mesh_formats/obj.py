"""Wavefront OBJ."""

from __future__ import annotations

import collections
import io
import re
from pathlib import Path
from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.scene.config.common import SignedAxis
from physagent_jax.scene.mesh_formats.base import MeshPart, Neighbours, decode_utf8
from physagent_jax.scene.mesh_formats.look import Look, Texture, as_rgba
from physagent_jax.scene.mesh_formats.mtl import CUTOFF, Material, parse_mtl, read_picture
from physagent_jax.scene.mesh_formats.names import list_names

_NUMBER = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_BAD_VERTEX = re.compile(rb"^v[ \t]+(?![ \t]|(?:%b[ \t]+){2}%b(?=\s|$))[^\n]*" % (_NUMBER, _NUMBER), re.M)
_BAD_FACE = re.compile(rb"^f[ \t][^\n]*?(?<=[ \t])0+(?=[/\s]|$)[^\n]*", re.M)  # OBJ counts from 1
_LINE = re.compile(rb"^[ \t]*(?:v|vt|vn|f)[ \t]+[-+.\d]", re.M)
_GROUP = re.compile(rb"^[ \t]*[og][ \t]+([^\r\n]+)", re.M)
_LIBRARY = re.compile(rb"^mtllib[ \t]+([^\r\n]+)", re.M)


class OBJ:
    """Lines of vertices and faces, grouped by material."""

    name = "OBJ"
    suffixes: tuple[str, ...] = (".obj",)
    up: SignedAxis | None = None
    front: SignedAxis | None = None

    def matches(self, head: bytes, size: int) -> bool:
        """Return whether the text has a line of a vertex or a face."""
        return b"\0" not in head and _LINE.search(head) is not None

    def read(self, data: bytes, path: Path, beside: Neighbours) -> list[MeshPart]:
        """The file's parts, one for each material."""
        from trimesh.exchange.obj import load_obj  # takes long to import

        data = decode_utf8(data)
        for pattern, what in ((_BAD_VERTEX, "three numbers"), (_BAD_FACE, "vertices counted from 1")):
            if found := pattern.search(data):
                line = repr(shorten(found.group().decode(), 60))
                raise UserError(
                    f"{shorten(path)}: a line does not have {what}", got=line, do="Export it again"
                )
        materials = _read_libraries(data, beside)
        # The loader shall group faces by material; it gets the names alone.
        names = "\n".join(f"newmtl {name}" for name in materials).encode()
        loaded: Any = load_obj(io.BytesIO(data), resolver=collections.defaultdict(lambda: names))  # pyright: ignore
        return [_make_part(each, materials, beside) for each in loaded.get("geometry", {}).values()]


def read_groups(data: bytes) -> list[MeshPart]:
    """The surfaces of an OBJ file by object and group, with their names; none for a file that has one group for all.

    `OBJ.read` has them by material. Polygons are cut into fans: only where the surfaces lie is asked of them.
    """
    if len(set(_GROUP.findall(data))) < 2:
        return []
    lines = [line.split() for line in decode_utf8(data).decode().replace("\\\n", " ").splitlines()]
    places: list[list[str]] = []
    groups: dict[tuple[str, ...], list[tuple[int, int, int]]] = {}
    looks, group, thing = set(), (), ()
    for words in filter(None, lines):
        match words[0]:
            case "v":
                places.append(words[1:4])
            case "f":
                corners = [int(each.partition("/")[0]) for each in words[1:]]
                corners = [each - 1 if each > 0 else len(places) + each for each in corners]
                fan = groups.setdefault((*group, *thing), [])
                fan += [(corners[0], *pair) for pair in zip(corners[1:], corners[2:])]
            case "g":  # of several names a face is in each; most programs mean one name with blanks in it
                group = (" ".join(words[1:]), *words[1:])
            case "o":
                thing = (" ".join(words[1:]),)
            case "usemtl":
                looks.add(" ".join(words[1:]))
    vertices = np.array(places, np.float64).reshape(-1, 3)
    return [
        MeshPart(vertices, np.array(faces), names=list_names(names, looks))
        for names, faces in groups.items()
        if faces
    ]


def _read_libraries(data: bytes, beside: Neighbours) -> dict[str, Material]:
    materials: dict[str, Material] = {}
    for name in dict.fromkeys(_LIBRARY.findall(data)):
        for text in _read_library(name.decode(), beside):
            materials |= parse_mtl(decode_utf8(text).decode())
    return materials


def _read_library(name: str, beside: Neighbours) -> list[bytes]:
    """The file of that name, which may hold blanks, or the files that it names one after the other."""
    try:
        return [beside.read(each) for each in name.split()]
    except FileNotFoundError:
        text = beside.read_optional(name)
        return [] if text is None else [text]


def _make_part(loaded: dict[str, Any], materials: dict[str, Material], beside: Neighbours) -> MeshPart:
    from trimesh import Trimesh

    mesh = Trimesh(loaded["vertices"], loaded["faces"], process=False)  # cuts polygons
    count, visual = len(mesh.vertices), loaded.get("visual")
    material = materials.get(visual.material.name, Material()) if visual is not None else Material()
    uv = visual.uv if visual is not None and visual.uv is not None and len(visual.uv) == count else None
    normals = loaded.get("vertex_normals")
    return MeshPart(
        np.asarray(mesh.vertices, np.float64),
        np.asarray(mesh.faces),
        _make_look(material, uv, loaded.get("vertex_colors"), beside),
        np.asarray(normals, np.float64) if normals is not None and len(normals) == count else None,
    )


def _make_look(
    material: Material, uv: np.ndarray | None, vertex_colours: np.ndarray | None, beside: Neighbours
) -> Look | None:
    """A picture times Kd, else colours of the vertices, else Kd."""
    factor = None if material.diffuse is None else np.append(material.diffuse, 1.0)
    pixels = read_picture(material.picture, beside) if material.picture and uv is not None else None
    if material.picture and uv is not None and pixels is not None:
        picture = material.picture
        placed = (uv * picture.scale + picture.offset) * [1, -1] + [0, 1]
        if factor is not None and not factor[:3].any():
            factor = None  # programs write a black Kd for "the picture alone"
        cutoff = CUTOFF if material.cut_out and pixels[..., 3].any() else None
        return Look(factor, texture=Texture(pixels, placed, (picture.wrap, picture.wrap)), cutoff=cutoff)
    if vertex_colours is not None:
        return Look(vertex_colours=as_rgba(vertex_colours))
    return None if factor is None else Look(factor)
