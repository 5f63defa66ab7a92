"""The header of a PLY file, checked against the file's size before its data are read."""

from __future__ import annotations

import dataclasses
import mmap
import os
from pathlib import Path
from typing import BinaryIO

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_counts, open_regular, shorten

MOST_BYTES = 16 * 2**30  # 60 million Gaussians with all their colours
_HEADER_BYTES = 2**20
_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDER = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_ASCII_VALUE = 2  # bytes at least: a digit and what divides it from the next


@dataclasses.dataclass(frozen=True)
class Property:
    """A column of an element.

    Attributes:
        name: Its name.
        dtype: NumPy's name of its type (of the entries, for a list), without byte order.
        length_dtype: The same of the lengths of a list; None = no list.
    """

    name: str
    dtype: str
    length_dtype: str | None = None


@dataclasses.dataclass
class Element:
    """Rows of equal columns.

    Attributes:
        name: Its name.
        count: How many rows the header announces.
        properties: Columns in order.
    """

    name: str
    count: int
    properties: list[Property] = dataclasses.field(default_factory=list)

    @property
    def names(self) -> set[str]:
        """Names of the columns."""
        return {prop.name for prop in self.properties}


@dataclasses.dataclass(frozen=True)
class PlyHeader:
    """A PLY file's header.

    Attributes:
        elements: In the order of the file.
        order: Byte order as NumPy writes it; "" = the file is text.
        size: Bytes of the header.
        comments: Texts of the comment lines.
    """

    elements: tuple[Element, ...]
    order: str
    size: int
    comments: tuple[str, ...] = ()

    def element(self, name: str) -> Element | None:
        """The element of that name, if there is one."""
        return next((each for each in self.elements if each.name == name), None)


def read_ply_header(path: str | Path) -> PlyHeader:
    """Read the header and hold what it announces against the file's size.

    Raises:
        UserError: The file is missing or no PLY, its header makes no sense, or it cannot hold what it announces.
    """
    shown = shorten(path)
    with open_regular(path, most=MOST_BYTES) as file:
        size = os.fstat(file.fileno()).st_size
        header = _parse(file.read(_HEADER_BYTES), shown)
        left = size - header.size
        for element in header.elements:
            left -= _check_rows(element, header, file, left, shown)
    return header


def parse_ply_head(head: bytes) -> PlyHeader | None:
    """The header at the beginning of a file's bytes; None if there is no whole and sensible one."""
    try:
        return _parse(head, "the file")
    except UserError:
        return None


def _parse(data: bytes, shown: str) -> PlyHeader:
    end = data.find(b"end_header")
    newline = data.find(b"\n", end)
    if not data.startswith(b"ply") or end < 0 or newline < 0:
        raise _explain_no_ply(shown, "no PLY header, from `ply` to `end_header`")
    elements: list[Element] = []
    comments: list[str] = []
    order = None
    # The lines of a header end like those of its author's machine.
    for line in data[:end].decode("latin-1").splitlines()[1:]:
        match line.split():
            case ["format", name, _]:
                order = _ORDER.get(name)
            case ["element", name, count]:
                elements.append(Element(name, _read_count(count, shown)))
            case ["property", "list", length, entry, name] if elements:
                elements[-1].properties.append(
                    Property(name, _read_type(entry, shown), _read_type(length, shown))
                )
            case ["property", kind, name] if elements:
                elements[-1].properties.append(Property(name, _read_type(kind, shown)))
            case ["comment", *words]:
                comments.append(" ".join(words))
            case [] | ["obj_info", *_]:
                pass
            case _:
                raise _explain_no_ply(shown, f"the line {shorten(line, 60)!r}")
    if order is None:
        raise _explain_no_ply(shown, "an unknown format")
    return PlyHeader(tuple(elements), order, newline + 1, tuple(comments))


def _read_count(text: str, shown: str) -> int:
    if len(text) > 20 or not text.lstrip("-").isascii() or not text.lstrip("-").isdecimal():
        raise _explain_no_ply(shown, f"a count of {shorten(text, 40)!r}")
    return int(text)


def _read_type(name: str, shown: str) -> str:
    if name not in _TYPES:
        raise _explain_no_ply(shown, f"a property of type {shorten(name, 40)!r}")
    return _TYPES[name]


def _check_rows(element: Element, header: PlyHeader, file: BinaryIO, left: int, shown: str) -> int:
    """Bytes that an element takes of the file's last ``left``: in text at least, else exactly."""
    columns = element.properties
    if not header.order:
        each = max(_ASCII_VALUE * len(columns), 1)
        # The last line of a file need not end.
        check_counts(shown, f"{element.name} rows", element.count, each, left + 1)
        return element.count * each
    each = sum(np.dtype(prop.length_dtype or prop.dtype).itemsize for prop in columns)
    check_counts(shown, f"{element.name} rows", element.count, max(each, 1), left)
    if all(prop.length_dtype is None for prop in columns):
        return element.count * each
    mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    return _count_list_bytes(element, header.order, memoryview(mapped)[len(mapped) - left :], shown)


def _count_list_bytes(element: Element, order: str, data: memoryview, shown: str) -> int:
    """Bytes of an element with lists; rows of one and the same length, as in most files, are checked at once."""
    if element.count == 0:
        return 0
    used = _count_row_bytes(element, order, data, 0, shown)
    if used * element.count <= len(data):
        rows = np.frombuffer(data, np.uint8, used * element.count).reshape(element.count, used)
        at = 0
        for prop in element.properties:
            if prop.length_dtype is not None:
                width = np.dtype(prop.length_dtype).itemsize
                if (rows[:, at : at + width] != rows[0, at : at + width]).any():
                    break
                length = _read_length(prop, order, data, at)
                at += width + length * np.dtype(prop.dtype).itemsize
            else:
                at += np.dtype(prop.dtype).itemsize
        else:
            return used * element.count
    at = 0
    for _ in range(element.count):
        at += _count_row_bytes(element, order, data, at, shown)
    return at


def _count_row_bytes(element: Element, order: str, data: memoryview, start: int, shown: str) -> int:
    at = start
    for prop in element.properties:
        if prop.length_dtype is not None:
            width = np.dtype(prop.length_dtype).itemsize
            check_counts(shown, f"lengths of `{prop.name}`", 1, width, len(data) - at)
            length = _read_length(prop, order, data, at)
            each = np.dtype(prop.dtype).itemsize
            check_counts(shown, f"entries of `{prop.name}`", length, each, len(data) - at - width)
            at += width + length * each
        else:
            at += np.dtype(prop.dtype).itemsize
    check_counts(shown, f"{element.name} row", 1, at - start, len(data) - start)
    return at - start


def _read_length(prop: Property, order: str, data: memoryview, at: int) -> int:
    assert prop.length_dtype is not None
    if prop.length_dtype.startswith("f"):
        return -1  # a list of half an entry makes no sense
    size = np.dtype(prop.length_dtype).itemsize
    signed = prop.length_dtype.startswith("i")
    return int.from_bytes(data[at : at + size], "little" if order == "<" else "big", signed=signed)


def _explain_no_ply(shown: str, reason: str) -> UserError:
    return UserError(f"{shown} is not a readable PLY file", got=reason, do="Give a 3DGS .ply file or a mesh")
