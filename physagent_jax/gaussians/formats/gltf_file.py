"""The parts of a glTF 2.0 file that point clouds need: JSON, buffers, accessors and the nodes' transforms."""

from __future__ import annotations

import base64
import binascii
import os
import struct
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import (
    JSON_BYTES,
    check_counts,
    decode_json,
    open_regular,
    read_bytes,
    shorten,
)
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES

GLB_MAGIC = b"glTF"
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
_DTYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_UNSET = object()


class GltfFile:
    """A glTF file, opened.

    Attributes:
        tree: Its JSON.
        shown: The file, for messages.
        size: Bytes of the file.
    """

    def __init__(self, path: Path):
        """Open a GLB or a .gltf file.

        Raises:
            UserError: It is none, or announces more than it holds.
        """
        self.shown = shorten(path)
        self._folder = path.parent
        with open_regular(path, most=MOST_BYTES) as file:
            self.size = os.fstat(file.fileno()).st_size
            binary = file.read(len(GLB_MAGIC)) == GLB_MAGIC
        if binary:
            text, self._inside = _split_glb(read_bytes(path, most=MOST_BYTES), self.shown)
        else:
            text, self._inside = read_bytes(path, most=JSON_BYTES), None
        self.tree: dict = _check_type(decode_json(text, self.shown), dict, "top level", self.shown)
        self._buffers: dict[int, bytes | memoryview] = {}

    def get(self, data: Any, key: str, kind: type, default: Any = _UNSET) -> Any:
        """A value of a JSON object, of the given type.

        Raises:
            UserError: It is missing and there is no default, or is of another type.
        """
        if not isinstance(data, dict) or key not in data:
            if default is _UNSET:
                raise explain_damage(self.shown, f"no `{key}`")
            return default
        return _check_type(data[key], kind, key, self.shown)

    def count(self, data: Any, key: str, default: Any = _UNSET) -> int:
        """A count or an index of a JSON object."""
        value = self.get(data, key, int, default)
        if isinstance(value, bool) or value < 0:
            raise explain_damage(self.shown, f"`{key}` is {value!r}")
        return value

    def item(self, key: str, index: int) -> dict:
        """The object of that index in one of the top lists."""
        items = self.get(self.tree, key, list, [])
        if index >= len(items):
            raise explain_damage(self.shown, f"no {key}[{index}]")
        return _check_type(items[index], dict, key, self.shown)

    def read_view(self, index: int) -> memoryview:
        """The bytes of a buffer view."""
        view = self.item("bufferViews", index)
        if compression := [name for name in self.get(view, "extensions", dict, {}) if "compression" in name]:
            raise UserError(
                f"{self.shown} is compressed in a way that is not read",
                got=shorten(compression[0], 60),
                do="Export it without compression",
            )
        start, length = self.count(view, "byteOffset", 0), self.count(view, "byteLength")
        buffer = self._read_buffer(self.count(view, "buffer"))
        check_counts(f"{self.shown}: bufferViews[{index}]", "bytes", length, 1, len(buffer) - start)
        return memoryview(buffer)[start : start + length]

    def read_accessor(self, index: int, kinds: tuple[str, ...]) -> np.ndarray:
        """The values of an accessor, float64 of shape (n, width); normalised integers become fractions.

        Args:
            index: The accessor.
            kinds: Types that it may have ("VEC3").
        """
        accessor = self.item("accessors", index)
        where = f"{self.shown}: accessors[{index}]"
        kind, component = self.get(accessor, "type", str), self.count(accessor, "componentType")
        if kind not in kinds or component not in _DTYPES:
            raise explain_damage(self.shown, f"accessors[{index}] of type {shorten(kind, 20)}, {component}")
        if "sparse" in accessor or "bufferView" not in accessor:
            raise explain_damage(self.shown, f"accessors[{index}] is sparse or without data")
        dtype, width, count = np.dtype(_DTYPES[component]), _WIDTHS[kind], self.count(accessor, "count")
        view_index, offset = self.count(accessor, "bufferView"), self.count(accessor, "byteOffset", 0)
        data, each = self.read_view(view_index), dtype.itemsize * width
        stride = self.count(self.item("bufferViews", view_index), "byteStride", 0) or each
        if stride < each:
            raise explain_damage(self.shown, f"a stride of {stride} bytes for values of {each}")
        check_counts(where, "values", count, stride, len(data) - offset + stride - each)
        if count == 0:
            return np.empty((0, width))
        rows = np.ndarray((count, width), dtype, data, offset, (stride, dtype.itemsize))
        with np.errstate(invalid="ignore"):  # signalling NaNs
            values = rows.astype(np.float64)
        if self.get(accessor, "normalized", bool, False) and dtype.kind != "f":
            values = np.maximum(values / np.iinfo(dtype).max, -1.0)
        return values

    def _read_buffer(self, index: int) -> bytes | memoryview:
        if index not in self._buffers:
            uri = self.get(self.item("buffers", index), "uri", str, None)
            if uri is None:
                if index > 0 or self._inside is None:
                    raise explain_damage(self.shown, f"buffers[{index}] has no data")
                self._buffers[index] = self._inside
            elif uri.startswith("data:"):
                try:
                    self._buffers[index] = base64.b64decode(uri.partition("base64,")[2], validate=True)
                except binascii.Error as error:
                    raise explain_damage(self.shown, f"buffers[{index}]: {error}") from None
            else:
                self._buffers[index] = self._read_beside(uri)
        return self._buffers[index]

    def _read_beside(self, uri: str) -> bytes:
        place = PurePosixPath(unquote(uri))
        if place.is_absolute() or ".." in place.parts or not place.parts or {"\\", ":"} & set(str(place)):
            raise UserError(
                f"{self.shown} names a file outside its folder",
                got=shorten(uri, 60),
                do="Save it as one .glb file",
            )
        return read_bytes(self._folder / place, most=MOST_BYTES, what="the glTF buffer")

    def walk_meshes(self) -> Iterator[tuple[int, np.ndarray]]:
        """The mesh and the global transform, shape (4, 4), of every node of the scene that has a mesh.

        Raises:
            UserError: A node has two parents, or a transform is no affine map.
        """
        scenes = self.get(self.tree, "scenes", list, [])
        if scenes:
            roots = self.get(self.item("scenes", self.count(self.tree, "scene", 0)), "nodes", list, [])
        else:
            nodes = self.get(self.tree, "nodes", list, [])
            below = {
                child
                for node in nodes
                for child in self.get(node, "children", list, [])
                if type(child) is int
            }
            roots = [index for index in range(len(nodes)) if index not in below]
        todo, seen = [(root, np.eye(4)) for root in roots], set()
        while todo:
            index, above = todo.pop()
            if type(index) is not int or index < 0 or index in seen:
                raise explain_damage(
                    self.shown, f"nodes[{shorten(index, 20)}] stands in two places or nowhere"
                )
            seen.add(index)
            node = self.item("nodes", index)
            transform = above @ self._read_transform(node)
            if "mesh" in node:
                yield self.count(node, "mesh"), transform
            todo += [(child, transform) for child in self.get(node, "children", list, [])]

    def _read_transform(self, node: dict) -> np.ndarray:
        """A node's own transform, shape (4, 4)."""
        if "matrix" in node:
            return self._read_numbers(node, "matrix", 16, None).reshape(4, 4).T  # column by column
        transform = np.eye(4)
        quat = self._read_numbers(node, "rotation", 4, (0.0, 0.0, 0.0, 1.0))
        if not np.linalg.norm(quat) > 0:
            raise explain_damage(self.shown, "a rotation of norm zero")
        transform[:3, :3] = Rotation.from_quat(quat).as_matrix() * self._read_numbers(
            node, "scale", 3, (1, 1, 1)
        )
        transform[:3, 3] = self._read_numbers(node, "translation", 3, (0, 0, 0))
        return transform

    def _read_numbers(self, data: dict, key: str, count: int, default: Any) -> np.ndarray:
        values = self.get(data, key, list, list(default or ()))
        numbers = [value for value in values if type(value) in (int, float) and abs(value) <= 1e12]
        if len(numbers) != count or len(values) != count:
            raise explain_damage(self.shown, f"`{key}` is not {count} numbers")
        return np.array(numbers, np.float64)


def explain_damage(shown: str, found: str) -> UserError:
    """The error of a file that is no valid glTF."""
    return UserError(f"{shown} is no valid glTF", got=found, do="Export it again")


def _check_type(value: Any, kind: type, name: str, shown: str) -> Any:
    if not isinstance(value, kind):
        raise explain_damage(shown, f"`{shorten(name, 40)}` is {type(value).__name__}")
    return value


def _split_glb(data: bytes, shown: str) -> tuple[bytes, memoryview | None]:
    """JSON and buffer of a GLB."""
    if len(data) < 20:
        raise explain_damage(shown, f"{len(data)} bytes")
    version, length, kind = struct.unpack_from("<4xI4xII", data)
    if version != 2 or kind != JSON_CHUNK:
        raise explain_damage(shown, f"GLB of version {version}")
    check_counts(shown, "bytes of JSON", length, 1, len(data) - 20)
    at = 20 + length + (-length) % 4
    if at + 8 > len(data):
        return data[20 : 20 + length], None
    size, kind = struct.unpack_from("<II", data, at)
    check_counts(shown, "bytes of the buffer", size, 1, len(data) - at - 8)
    inside = memoryview(data)[at + 8 : at + 8 + size] if kind == BINARY_CHUNK else None
    return data[20 : 20 + length], inside
