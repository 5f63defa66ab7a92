"""glTF and GLB: whether buffers, views, accessors and nodes hold what they say, before a library believes them."""

from __future__ import annotations

import base64
import struct
from collections.abc import Callable
from typing import Any

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_counts, decode_json

MOST_VERTICES = 50_000_000  # of all nodes together: one mesh may stand in many places
_COMPONENTS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}  # bytes
_SHAPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_MAGIC, _JSON = b"glTF", 0x4E4F534A
_DATA_URI = "base64,"


def check_glb(data: bytes, place: str, fetch: Callable[[str], bytes]) -> None:
    """Checks a GLB; arguments and errors as for `check_gltf`."""
    if len(data) < 20 or not data.startswith(_MAGIC):
        raise UserError(f"{place} is no GLB file", do="Export it again")
    version, _, length, kind = struct.unpack("<4I", data[4:20])
    if version != 2 or kind != _JSON:
        raise UserError(
            f"{place} is no GLB file of version 2", got=f"version {version}", do="Export it again"
        )
    check_counts(place, "bytes of JSON", length, 1, len(data) - 20)
    at, chunks = 20 + length, []
    while at + 8 <= len(data):
        (size,) = struct.unpack("<I", data[at : at + 4])
        check_counts(place, "bytes in a chunk", size, 1, len(data) - at - 8)
        chunks.append(size)
        at += 8 + size
    check_gltf(data[20 : 20 + length], place, fetch, chunks[:1])


def check_gltf(
    data: bytes, place: str, fetch: Callable[[str], bytes], inside: list[int] | None = None
) -> None:
    """Checks a glTF file.

    Args:
        data: Its JSON.
        place: The file, for messages.
        fetch: Reads a file that a buffer names; raises FileNotFoundError.
        inside: Sizes of the buffers that the file itself holds.

    Raises:
        UserError: It is no glTF, or says that it holds more than it does.
    """
    tree = decode_json(data, place)
    try:
        sizes = _check_buffers(tree, place, fetch, inside or [])
        views = _check_views(tree, place, sizes)
        _check_accessors(tree, place, views)
        _check_nodes(tree, place)
    # What is missing, of another type, or an index that points nowhere.
    except (KeyError, TypeError, IndexError, AttributeError, ValueError) as error:
        if isinstance(error, UserError):
            raise
        reason = f"{type(error).__name__}: {error}"
        raise UserError(f"{place} is no valid glTF", got=reason[:80], do="Export it again") from None


def _check_buffers(tree: Any, place: str, fetch: Callable[[str], bytes], inside: list[int]) -> list[int]:
    """What each buffer has [bytes]."""
    sizes = []
    for index, buffer in enumerate(tree.get("buffers", [])):
        uri = buffer.get("uri")
        if uri is None:
            sizes.append(inside[index])
        elif _DATA_URI in uri:
            sizes.append(len(base64.b64decode(uri[uri.index(_DATA_URI) + len(_DATA_URI) :])))
        else:
            try:
                sizes.append(len(fetch(uri)))
            except FileNotFoundError as error:
                raise UserError(f"{place}: buffers[{index}]: {error}", do="Put the file there") from None
    return sizes


def _check_views(tree: Any, place: str, sizes: list[int]) -> list[tuple[int, int]]:
    """Length and stride of each view of a buffer [bytes]; a stride of 0 = densely packed."""
    views = []
    for index, view in enumerate(tree.get("bufferViews", [])):
        start, length, stride = (
            _read_whole(view, "byteOffset", 0),
            _read_whole(view, "byteLength"),
            _read_whole(view, "byteStride", 0),
        )
        left = sizes[_read_whole(view, "buffer")] - start
        check_counts(f"{place}: bufferViews[{index}]", "bytes", length, 1, left)
        views.append((length, stride))
    return views


def _check_accessors(tree: Any, place: str, views: list[tuple[int, int]]) -> None:
    for index, accessor in enumerate(tree.get("accessors", [])):
        where = f"{place}: accessors[{index}]"
        count, each = (
            _read_whole(accessor, "count"),
            _SHAPES[accessor["type"]] * _COMPONENTS[accessor["componentType"]],
        )
        if count == 0:
            raise UserError(f"{where} is empty", do="Export the file again")
        if "bufferView" not in accessor:  # all zero, or what an extension unpacks
            check_counts(where, "values", count, each, MOST_VERTICES)
            continue
        length, stride = views[_read_whole(accessor, "bufferView")]
        left = length - _read_whole(accessor, "byteOffset", 0)
        check_counts(where, "values", count, max(stride, each), left + max(stride - each, 0))


def _check_nodes(tree: Any, place: str) -> None:
    """Nodes make trees, and all meshes where they stand together are not too many."""
    nodes, meshes, accessors = (tree.get(key, []) for key in ("nodes", "meshes", "accessors"))
    children = [child for node in nodes for child in node.get("children", [])]
    if len(children) != len(set(children)):
        raise UserError(f"{place}: a node has two parents", do="Export it again, each node with one parent")
    vertices = [
        sum(accessors[part["attributes"]["POSITION"]]["count"] for part in mesh["primitives"])
        for mesh in meshes
    ]
    total = sum(vertices[_read_whole(node, "mesh")] for node in nodes if "mesh" in node)
    if total > MOST_VERTICES:
        raise UserError(
            f"{place} has too many vertices",
            got=f"{total:,}, at most {MOST_VERTICES:,}",
            do="Simplify the mesh",
        )


def _read_whole(data: Any, key: str, default: int | None = None) -> int:
    value = data[key] if default is None else data.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"`{key}` is {value!r}, no count")
    return value
