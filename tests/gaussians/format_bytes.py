"""Small files of splat formats, packed value by value from the published layouts and not by the package."""

from __future__ import annotations

import gzip
import io
import json
import struct
import zipfile

import cv2
import numpy as np

CHUNK_NAMES = [f"{end}_{axis}" for end in ("min", "max") for axis in ("x", "y", "z")]
CHUNK_NAMES += [f"{end}_scale_{axis}" for end in ("min", "max") for axis in ("x", "y", "z")]
COLOUR_NAMES = [f"{end}_{axis}" for end in ("min", "max") for axis in ("r", "g", "b")]


def compressed_ply(rows, chunks, *, coloured=True, rest=(), format_name="binary_little_endian") -> bytes:
    """A compressed PLY.

    Args:
        rows: Four words for each Gaussian: position, rotation, scale, colour.
        chunks: Bounds of each chunk, 12 numbers, or 18 with the colours'.
        coloured: Whether there are bounds of colours.
        rest: Bytes of the element `sh`, one row for each Gaussian; empty = there is none.
        format_name: Byte order by name.
    """
    names = CHUNK_NAMES + (COLOUR_NAMES if coloured else [])
    lines = ["ply", f"format {format_name} 1.0", f"element chunk {len(chunks)}"]
    lines += [f"property float {name}" for name in names]
    lines += [f"element vertex {len(rows)}"]
    lines += [f"property uint packed_{name}" for name in ("position", "rotation", "scale", "color")]
    if len(rest):
        lines += [f"element sh {len(rest)}", *(f"property uchar f_rest_{i}" for i in range(len(rest[0])))]
    order = "<" if format_name.endswith("little_endian") else ">"
    data = b"".join(struct.pack(f"{order}{len(names)}f", *chunk[: len(names)]) for chunk in chunks)
    data += b"".join(struct.pack(f"{order}4I", *row) for row in rows)
    return "\n".join([*lines, "end_header", ""]).encode() + data + b"".join(bytes(row) for row in rest)


def spz_streams(version, gaussians) -> list[bytes]:
    """Attributes of an SPZ file.

    Args:
        version: 1 to 4.
        gaussians: Dicts of raw values: `position` (floats for version 1, integers else), `alpha`, `colour`, `scale`,
            `rotation` (bytes), `rest` (bytes).
    """

    def pack_position(values):
        if version == 1:
            return struct.pack("<3e", *values)
        return b"".join((value & 0xFFFFFF).to_bytes(3, "little") for value in values)

    return [
        b"".join(pack_position(each["position"]) for each in gaussians),
        bytes(each["alpha"] for each in gaussians),
        b"".join(bytes(each["colour"]) for each in gaussians),
        b"".join(bytes(each["scale"]) for each in gaussians),
        b"".join(bytes(each["rotation"]) for each in gaussians),
        b"".join(bytes(each.get("rest", ())) for each in gaussians),
    ]


def spz(version, gaussians, *, degree=0, fractional_bits=12, flags=0, extensions=b"", count=None) -> bytes:
    """An SPZ file of version 1 to 3; ``count`` = the number that its header tells."""
    count = len(gaussians) if count is None else count
    header = struct.pack("<4sIIBBBB", b"NGSP", version, count, degree, fractional_bits, flags, 0)
    return gzip.compress(header + b"".join(spz_streams(version, gaussians)) + extensions, mtime=0)


def raw_zstd(data) -> bytes:
    """A zstd frame (RFC 8878) of raw blocks, which hold the bytes as they are."""
    size = 2**16
    blocks = [data[start : start + size] for start in range(0, len(data), size)] or [b""]
    frame = struct.pack("<IBI", 0xFD2FB528, 0b10100000, len(data))  # one segment, its length in four bytes
    for index, block in enumerate(blocks):
        frame += (len(block) << 3 | (index == len(blocks) - 1)).to_bytes(3, "little") + block
    return frame


def spz4(gaussians, compress=raw_zstd, *, degree=0, fractional_bits=12, flags=0, extensions=b"") -> bytes:
    """An SPZ file of version 4; ``compress`` makes a zstd frame."""
    streams = [(len(data), compress(data)) for data in spz_streams(4, gaussians) if data]
    fields = (4, len(gaussians), degree, fractional_bits, flags, len(streams), 32 + len(extensions))
    header = struct.pack("<4sIIBBBBI12x", b"NGSP", *fields)
    table = b"".join(struct.pack("<QQ", len(packed), size) for size, packed in streams)
    return header + extensions + table + b"".join(packed for _, packed in streams)


def smallest_three(place, parts) -> bytes:
    """A rotation of SPZ version 3: the place of the component left out, and sign and size of the others."""
    word = place
    for negative, size in parts:
        word = word << 10 | negative << 9 | size
    return struct.pack("<I", word)


def splat(gaussians) -> bytes:
    """A .splat file of (position, scale, rgba, rotation) with colours and rotations in bytes."""
    return b"".join(
        struct.pack("<6f8B", *position, *scale, *rgba, *rotation)
        for position, scale, rgba, rotation in gaussians
    )


def webp(pixels) -> bytes:
    """A lossless WebP of RGBA pixels, shape (rows, columns, 4)."""
    bgra = np.asarray(pixels, np.uint8)[..., [2, 1, 0, 3]]
    done, data = cv2.imencode(".webp", bgra, [cv2.IMWRITE_WEBP_QUALITY, 101])
    assert done
    return data.tobytes()


def sog_files(meta, images) -> dict[str, bytes]:
    """Files of a SOG bundle, ``images`` by file name."""
    return {"meta.json": json.dumps(meta).encode()} | {name: webp(pixels) for name, pixels in images.items()}


def zipped(files, compression=zipfile.ZIP_STORED) -> bytes:
    """A zip archive."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", compression) as archive:
        for name, data in files.items():
            archive.writestr(zipfile.ZipInfo(name), data, compression)
    return stream.getvalue()


def small_sog(version=2, count=3, bands=1):
    """meta.json and images of a SOG bundle of 2 x 2 pixels with every attribute."""
    rng = np.random.default_rng(count)
    image = lambda: rng.integers(0, 256, (2, 2, 4))  # noqa: E731
    quats = image()
    quats[..., 3] = 252 + rng.integers(0, 4, (2, 2))
    coefficients = (bands + 1) ** 2 - 1
    labels = np.zeros((2, 2, 4), int)
    labels[..., 0], labels[..., 3] = rng.integers(0, 64, (2, 2)), 255
    images = {"means_l.webp": image(), "means_u.webp": image(), "quats.webp": quats, "scales.webp": image(),
              "sh0.webp": image(), "shN_centroids.webp": rng.integers(0, 256, (1, 64 * coefficients, 4)),
              "shN_labels.webp": labels}  # fmt: skip
    for name in ("means_l.webp", "means_u.webp", "scales.webp", "shN_centroids.webp"):
        images[name][..., 3] = 255
    means = {"mins": [-1.0, -2.0, 0.0], "maxs": [1.0, 0.5, 0.25], "files": ["means_l.webp", "means_u.webp"]}
    files = {"scales": ["scales.webp"], "sh0": ["sh0.webp"], "shN": ["shN_centroids.webp", "shN_labels.webp"]}
    if version == 2:
        book = {key: np.linspace(-3, 2, 256).tolist() for key in ("scales", "sh0", "shN")}
        meta = {key: {"codebook": book[key], "files": files[key]} for key in files}
        meta["shN"] |= {"count": 64, "bands": bands}
        meta |= {"version": 2, "count": count, "means": means}
    else:
        meta = {
            "scales": {"mins": [-4.0, -3.0, -2.0], "maxs": [-1.0, -1.5, -0.5], "files": files["scales"]},
            "sh0": {"mins": [-1, -2, -3, -4], "maxs": [1, 2, 3, 5], "files": files["sh0"]},
            "shN": {"mins": -0.5, "maxs": 0.75, "files": files["shN"]},
            "means": means | {"shape": [count, 3]},
        }
    return meta | {"quats": {"files": ["quats.webp"]}}, images


PREFIX = "KHR_gaussian_splatting:"


def gltf_parts(values, *, nodes=({"mesh": 0},), extension=None, used=True):
    """JSON tree and buffer of a glTF file.

    Args:
        values: Arrays by attribute name (without the prefix), float32 or integers.
        nodes: Nodes of the scene; the first is its root.
        extension: Content of the primitive's extension.
        used: Whether the extension is listed.
    """
    codes = {"float32": 5126, "uint8": 5121, "int8": 5120, "uint16": 5123, "int16": 5122}
    kinds = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
    buffer, views, accessors, attributes = b"", [], [], {}
    for name, array in values.items():
        array = np.asarray(array)
        array = array.astype(np.float32) if array.dtype == np.float64 else array
        attributes[name if name in ("POSITION", "COLOR_0") else PREFIX + name] = len(views)
        accessors.append({"bufferView": len(views), "componentType": codes[array.dtype.name], "count": len(array),
                          "type": kinds[array.shape[1]]})  # fmt: skip
        if array.dtype != np.float32:
            accessors[-1]["normalized"] = True
        views.append({"buffer": 0, "byteOffset": len(buffer), "byteLength": array.nbytes})
        buffer += array.tobytes()
        buffer += b"\0" * (-len(buffer) % 4)
    kernel = {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"} if extension is None else extension
    primitive = {"attributes": attributes, "mode": 0, "extensions": {"KHR_gaussian_splatting": kernel}}
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": json.loads(json.dumps(nodes)),
        "meshes": [{"primitives": [primitive]}], "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(buffer)}],
    }  # fmt: skip
    return tree | ({"extensionsUsed": ["KHR_gaussian_splatting"]} if used else {}), buffer


def glb(tree, buffer) -> bytes:
    """A GLB file."""
    return glb_of(json.dumps(tree).encode(), buffer)


def glb_of(text, buffer) -> bytes:
    """A GLB file of JSON text."""
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def gaussian_values(count=5, degree=1, seed=0):
    """Attributes of some Gaussians for `gltf_parts`."""
    rng = np.random.default_rng(seed)
    quats = rng.normal(size=(count, 4))
    values = {
        "POSITION": rng.normal(size=(count, 3)),
        "ROTATION": quats / np.linalg.norm(quats, axis=1, keepdims=True),
        "SCALE": np.exp(rng.normal(-3, 1, (count, 3))),
        "OPACITY": rng.uniform(size=(count, 1)),
    }
    for d in range(degree + 1):
        values |= {f"SH_DEGREE_{d}_COEF_{n}": rng.normal(size=(count, 3)) for n in range(2 * d + 1)}
    return values
