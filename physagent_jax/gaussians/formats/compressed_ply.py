"""Reading SuperSplat's compressed PLY: Gaussians quantised within chunks of 256.

Layout (PlayCanvas, "The compressed PLY format"): an element ``chunk`` of bounds as floats, ``min_x .. max_scale_z``,
those of the scales being natural logarithms. Later files also have ``min_r .. max_b`` of the colours. An element
``vertex`` has four 32-bit words. An element ``sh`` of bytes may follow (``f_rest_*``, as in a 3DGS PLY).

The words, from the highest bit on: position and scale 11-10-11, between the chunk's bounds; rotation 2-10-10-10, the
place of the largest component of wxyz and the other three; colour and opacity 8-8-8-8.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import open_regular, shorten
from physagent_jax.gaussians.formats.base import SplatData
from physagent_jax.gaussians.formats.packing import colours_to_sh, expand_smallest_three, unpack_rest
from physagent_jax.gaussians.formats.ply_header import MOST_BYTES, Element, PlyHeader, read_ply_header

CHUNK = 256
_POSITION = ("min_x", "min_y", "min_z", "max_x", "max_y", "max_z")
_SCALE = tuple(name.replace("_", "_scale_") for name in _POSITION)
_COLOUR = ("min_r", "min_g", "min_b", "max_r", "max_g", "max_b")
_WORDS = ("packed_position", "packed_rotation", "packed_scale", "packed_color")
_REST_COUNTS = (9, 24, 45)
_SH_RANGE = 8.0  # coefficients lie in [-4, 4]


class _CompressedPly:
    """SuperSplat's compressed PLY."""

    name = "compressed PLY (SuperSplat)"
    suffixes = (".compressed.ply",)

    def matches(self, head: bytes) -> bool:
        """Return whether the file begins as a PLY that announces packed positions."""
        return head.startswith(b"ply") and b" packed_position" in head.partition(b"end_header")[0]

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Read a file; its values have one meaning, so that ``encoding`` changes nothing.

        Raises:
            UserError: It is damaged, or its elements are not those of the layout.
        """
        header = read_ply_header(path)
        tables = _read_tables(path, header)
        chunk, vertex = tables["chunk"], tables["vertex"]
        which = np.arange(len(vertex)) // CHUNK
        position, rotation, scale, colour = (vertex[name].astype(np.uint32) for name in _WORDS)

        def within(names: tuple[str, ...], parts: np.ndarray) -> np.ndarray:
            low, high = (
                np.stack([chunk[n] for n in part], -1, dtype=np.float64) for part in (names[:3], names[3:])
            )
            return low[which] * (1.0 - parts) + high[which] * parts

        with np.errstate(
            over="ignore", invalid="ignore"
        ):  # bounds that are no numbers: such Gaussians are dropped
            means = within(_POSITION, _split_11_10_11(position))
            scales = np.exp(within(_SCALE, _split_11_10_11(scale)))
            channels = _split(colour, (24, 16, 8, 0), (8, 8, 8, 8))
            bounded = set(_COLOUR) <= set(chunk.dtype.names or ())
            colours = within(_COLOUR, channels[:, :3]) if bounded else channels[:, :3]
        sh, degree = colours_to_sh(colours)[:, None, :], 0
        if "sh" in tables:
            rest = _read_rest(tables["sh"])
            sh, degree = np.concatenate([sh, rest], axis=1), round((rest.shape[1] + 1) ** 0.5) - 1
        return SplatData(
            means=means,
            quats=_read_quats(rotation),
            scales=scales,
            opacities=channels[:, 3],
            sh=sh,
            encoding=f"chunks of {CHUNK} quantised to 11-10-11 bits, SH of degree {degree}",
        )


COMPRESSED_PLY = _CompressedPly()


def _read_tables(path: Path, header: PlyHeader) -> dict[str, np.ndarray]:
    """The elements as record arrays, checked against the layout."""
    shown = shorten(path)
    if not header.order:
        raise _explain_other(shown, "a PLY in text")
    tables = {}
    with open_regular(path, most=MOST_BYTES) as file:
        file.seek(header.size)
        for element in header.elements:
            dtype = _make_dtype(element, header.order, shown)
            data = file.read(dtype.itemsize * element.count)
            tables[element.name] = np.frombuffer(
                data, dtype, min(element.count, len(data) // max(dtype.itemsize, 1))
            )
    for name, needed in {"chunk": (*_POSITION, *_SCALE), "vertex": _WORDS}.items():
        names = tables[name].dtype.names if name in tables else ()
        if missing := [each for each in needed if each not in (names or ())]:
            raise _explain_other(shown, f"no `{name}` property {', '.join(missing)}")
    if any(tables["vertex"][name].dtype.kind not in "iu" for name in _WORDS):
        raise _explain_other(shown, "packed values that are no integers")
    rows, chunks = len(tables["vertex"]), len(tables["chunk"])
    if rows == 0:
        raise UserError(f"{shown} holds no Gaussians", got="0 vertices", do="Export the scene again")
    if chunks != -(-rows // CHUNK):
        raise _explain_other(shown, f"{chunks} chunks for {rows} Gaussians")
    if "sh" in tables:
        names = [f"f_rest_{i}" for i in range(len(tables["sh"].dtype.names or ()))]
        bytes_only = all(tables["sh"].dtype[i] == np.uint8 for i in range(len(names)))
        if (
            len(names) not in _REST_COUNTS
            or set(tables["sh"].dtype.names or ()) != set(names)
            or not bytes_only
        ):
            raise _explain_other(shown, f"an `sh` element of {len(names)} properties")
        if len(tables["sh"]) != rows:
            raise _explain_other(shown, f"{len(tables['sh'])} rows of `sh` for {rows} Gaussians")
    return tables


def _make_dtype(element: Element, order: str, shown: str) -> np.dtype:
    if any(prop.length_dtype is not None for prop in element.properties):
        raise _explain_other(shown, f"a list in `{element.name}`")
    try:
        return np.dtype([(prop.name, order + prop.dtype) for prop in element.properties])
    except ValueError:
        raise _explain_other(shown, f"a property twice in `{element.name}`") from None


def _explain_other(shown: str, found: str) -> UserError:
    return UserError(
        f"{shown} is not laid out as a compressed PLY",
        got=found,
        do="Export it again, or convert it: `splat-transform in.compressed.ply out.ply`",
    )


def _split(words: np.ndarray, shifts: tuple[int, ...], bits: tuple[int, ...]) -> np.ndarray:
    """Parts of 32-bit words as fractions of their largest value, shape (n, len(bits)), in [0, 1]."""
    parts = [((words >> shift) & (2**each - 1)) / (2**each - 1) for shift, each in zip(shifts, bits)]
    return np.stack(parts, axis=-1)


def _split_11_10_11(words: np.ndarray) -> np.ndarray:
    return _split(words, (21, 11, 0), (11, 10, 11))


def _read_quats(words: np.ndarray) -> np.ndarray:
    """Unit quaternions wxyz, shape (n, 4); a component reaches from -1/sqrt(2) to 1/sqrt(2)."""
    three = (_split(words, (20, 10, 0), (10, 10, 10)) - 0.5) * np.sqrt(2.0)
    return expand_smallest_three(three, words >> 30)


def _read_rest(table: np.ndarray) -> np.ndarray:
    """Higher coefficients, shape (n, k, 3): the middles of 256 bins, the outermost at the ends of the range."""
    count = len(table.dtype.names or ())
    level = np.stack([table[f"f_rest_{i}"] for i in range(count)], axis=-1)
    lookup = (np.arange(256) + 0.5) / 256
    lookup[[0, 255]] = 0.0, 1.0
    return unpack_rest(((lookup - 0.5) * _SH_RANGE)[level])
