"""glTF documents: the container, and buffers, views and accessors, checked against their sizes before they are read."""

from __future__ import annotations

import base64
import binascii
import contextlib
import dataclasses
import struct
import urllib.parse
from collections.abc import Iterator
from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_counts, decode_json
from physagent_jax.scene.mesh_formats.base import Neighbours
from physagent_jax.scene.mesh_formats.gltf_draco import decode_primitives

MOST_VERTICES = 50_000_000  # of all nodes together: one mesh may stand in many places
MAGIC = b"glTF"
_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_SHAPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_JSON = 0x4E4F534A
_DATA_URI = "base64,"
_COMPRESSED = ("EXT_meshopt_compression", "KHR_meshopt_compression")


@dataclasses.dataclass(frozen=True)
class Document:
    """A glTF file, checked.

    Attributes:
        tree: Its JSON.
        buffers: Its buffers.
        decoded: Values of accessors that are compressed, by their index.
    """

    tree: dict[str, Any]
    buffers: list[bytes]
    decoded: dict[int, np.ndarray] = dataclasses.field(default_factory=dict)

    def get_view(self, index: int) -> bytes:
        """Bytes of a view of a buffer."""
        view = self.tree["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.buffers[view["buffer"]][start : start + view["byteLength"]]

    def read_accessor(self, index: int, *, normalise: bool = False) -> np.ndarray:
        """Values of an accessor, shape (count, components).

        Args:
            index: The accessor.
            normalise: Whether integers are fractions of their type's range even where the file does not say so, as
                colours and texture coordinates are.
        """
        accessor = self.tree["accessors"][index]
        dtype, width = np.dtype(_TYPES[accessor["componentType"]]), _SHAPES[accessor["type"]]
        count = accessor["count"]
        if index in self.decoded:
            values = self.decoded[index]
        elif "bufferView" in accessor:
            stride = self.tree["bufferViews"][accessor["bufferView"]].get("byteStride", 0)
            data = self.get_view(accessor["bufferView"])
            values = _read_rows(data, accessor.get("byteOffset", 0), stride, count, width, dtype)
        else:
            values = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            values = values.copy()
            where, what = self._read_sparse(accessor["sparse"], width, dtype)
            values[where] = what
        if dtype.kind in "iu" and (normalise or accessor.get("normalized", False)):
            return np.maximum(values / np.iinfo(dtype).max, -1.0)
        return values

    def _read_sparse(self, sparse: Any, width: int, dtype: np.dtype) -> tuple[np.ndarray, np.ndarray]:
        """Rows that differ from the rest of an accessor, and their values."""
        indices, values = sparse["indices"], sparse["values"]
        rows = _read_rows(
            self.get_view(indices["bufferView"]),
            indices.get("byteOffset", 0),
            0,
            sparse["count"],
            1,
            np.dtype(_TYPES[indices["componentType"]]),
        )
        data = self.get_view(values["bufferView"])
        return rows[:, 0], _read_rows(data, values.get("byteOffset", 0), 0, sparse["count"], width, dtype)


def _read_rows(data: bytes, start: int, stride: int, count: int, width: int, dtype: np.dtype) -> np.ndarray:
    stride = stride or width * dtype.itemsize
    if start + (count - 1) * stride + width * dtype.itemsize > len(data):
        raise ValueError(f"{count} rows do not fit into {len(data)} bytes")
    return np.ndarray((count, width), dtype, data, start, (stride, dtype.itemsize))


def read_glb(data: bytes, place: str, beside: Neighbours) -> Document:
    """Read a GLB; arguments and errors as for `read_gltf`."""
    if len(data) < 20 or not data.startswith(MAGIC):
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
        chunks.append(data[at + 8 : at + 8 + size])
        at += 8 + size
    return read_gltf(data[20 : 20 + length], place, beside, chunks[:1])


def read_gltf(data: bytes, place: str, beside: Neighbours, inside: list[bytes] | None = None) -> Document:
    """Read a glTF file.

    Args:
        data: Its JSON.
        place: The file, for messages.
        beside: Files that its buffers may name.
        inside: Buffers that the file itself holds.

    Raises:
        UserError: The data is no glTF, or says that it holds more than it does.
    """
    tree = decode_json(data, place)
    with explain_invalid(place):
        packed = [each for each in _COMPRESSED if each in tree.get("extensionsRequired", [])]
        if packed:
            raise UserError(
                f"{place} is compressed, which is not read",
                got=packed[0],
                do="Export it without compression",
            )
        document = Document(tree, _read_buffers(tree, place, beside, inside or []))
        views = _check_views(tree, place, [len(buffer) for buffer in document.buffers])
        _check_accessors(tree, place, views)
        _check_nodes(tree, place)
        return dataclasses.replace(document, decoded=decode_primitives(tree, document.get_view, place))


@contextlib.contextmanager
def explain_invalid(place: str) -> Iterator[None]:
    """Turns what a document lacks, holds in another type or points to in vain into a `UserError`."""
    try:
        yield
    except (KeyError, TypeError, IndexError, AttributeError, ValueError, OverflowError) as error:
        if isinstance(error, UserError):
            raise
        reason = f"{type(error).__name__}: {error}"
        raise UserError(f"{place} is no valid glTF", got=reason[:80], do="Export it again") from None


def read_uri(uri: str, beside: Neighbours) -> bytes:
    """Bytes that a URI holds or names.

    Raises:
        FileNotFoundError: It names a file that may not be read.
        ValueError: It holds no base64.
    """
    if uri.startswith("data:") and _DATA_URI in uri:
        try:
            return base64.b64decode(uri[uri.index(_DATA_URI) + len(_DATA_URI) :])
        except binascii.Error as error:
            raise ValueError(f"base64: {error}") from None
    try:
        return beside.read(uri)
    except FileNotFoundError:
        if "%" not in uri:
            raise
        return beside.read(urllib.parse.unquote(uri))


def _read_buffers(tree: Any, place: str, beside: Neighbours, inside: list[bytes]) -> list[bytes]:
    buffers = []
    for index, buffer in enumerate(tree.get("buffers", [])):
        uri = buffer.get("uri")
        if uri is None:
            buffers.append(inside[index])
            continue
        try:
            buffers.append(read_uri(uri, beside))
        except FileNotFoundError as error:
            raise UserError(f"{place}: buffers[{index}]: {error}", do="Put the file there") from None
    return buffers


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
            _SHAPES[accessor["type"]] * np.dtype(_TYPES[accessor["componentType"]]).itemsize,
        )
        if count == 0:
            raise UserError(f"{where} is empty", do="Export the file again")
        if "bufferView" not in accessor:  # all zero, but for what is sparse
            check_counts(where, "values", count, each, MOST_VERTICES)
        else:
            length, stride = views[_read_whole(accessor, "bufferView")]
            left = length - _read_whole(accessor, "byteOffset", 0)
            check_counts(where, "values", count, max(stride, each), left + max(stride - each, 0))
        if "sparse" in accessor:
            for part in ("indices", "values"):
                _read_whole(accessor["sparse"][part], "bufferView")
                _read_whole(accessor["sparse"][part], "byteOffset", 0)
            _read_whole(accessor["sparse"], "count")


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
