"""Small valid files to damage, made by the product's own writers or by hand; no case needs more than these."""

from __future__ import annotations

import functools
import io
import json
import struct
import tempfile
from pathlib import Path
from typing import Any

import jax
import numpy as np
import trimesh

from physagent_jax.gaussians import GaussianCloud, read_ply, write_ply
from physagent_jax.output.motion_file import Motion, write_motion

ROBOT = Path(__file__).resolve().parents[2] / "examples" / "assets" / "robot.ply"
OBJECT = "object.ply"


@functools.cache
def small_cloud(count: int = 60, degree: int = 0) -> GaussianCloud:
    """Some Gaussians of the bundled robot."""
    cloud = read_ply(ROBOT, opacity_threshold=0.1)
    keep = np.sort(np.random.default_rng(0).choice(cloud.count, count, replace=False))
    small: GaussianCloud = jax.tree.map(lambda leaf: leaf[keep], cloud)
    return GaussianCloud(
        small.means, small.quats, small.scales, small.opacities, small.sh[:, : (degree + 1) ** 2]
    )


@functools.cache
def gaussians(count: int = 60, degree: int = 0) -> bytes:
    """They as a binary PLY."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, OBJECT)
        write_ply(path, small_cloud(count, degree))
        return path.read_bytes()


@functools.cache
def gaussians_ascii() -> bytes:
    """They as an ASCII PLY."""
    from plyfile import PlyData

    data = PlyData.read(io.BytesIO(gaussians(12)))
    data.text = True
    out = io.BytesIO()
    data.write(out)
    return out.getvalue()


@functools.cache
def gaussians_big_endian() -> bytes:
    """They with the other byte order."""
    from plyfile import PlyData

    data = PlyData.read(io.BytesIO(gaussians(12)))
    data.byte_order = ">"
    out = io.BytesIO()
    data.write(out)
    return out.getvalue()


def table(properties: list[tuple[str, str]], rows: np.ndarray) -> bytes:
    """A binary PLY of one element ``vertex`` with columns of the given types, rows (n, k)."""
    names = {"float": "<f4", "double": "<f8", "int": "<i4", "uchar": "u1", "short": "<i2", "uint": "<u4"}
    lines = [f"property {kind} {name}" for name, kind in properties]
    header = "\n".join(
        ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}", *lines, "end_header\n"]
    )
    dtype = [(f"c{index}", names[kind]) for index, (_, kind) in enumerate(properties)]
    with np.errstate(all="ignore"):
        columns = [np.asarray(rows[:, index]).astype(kind) for index, (_, kind) in enumerate(dtype)]
    return header.encode() + np.rec.fromarrays(columns, dtype=dtype).tobytes()


@functools.cache
def meshes() -> dict[str, bytes]:
    """A closed box in every mesh format that is read, by suffix and a number."""
    box = trimesh.creation.box((1.0, 0.7, 0.5))
    ball = trimesh.creation.icosphere(subdivisions=1)
    made: dict[str, bytes] = {}
    for name, mesh in (("box", box), ("ball", ball)):
        for suffix in ("obj", "stl", "off", "glb", "ply"):
            content: Any = mesh.export(file_type=suffix)
            made[f"{name}.{suffix}"] = content.encode() if isinstance(content, str) else content
        made[f"{name}-ascii.stl"] = str(mesh.export(file_type="stl_ascii")).encode()
        made[f"{name}-ascii.ply"] = bytes(mesh.export(file_type="ply", encoding="ascii"))
    made["box.gltf"] = _make_gltf()
    made["hand.obj"] = (
        b"mtllib none.mtl\no thing\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\nvt 0 0\nvn 0 0 1\n"
        b"usemtl red\nf 1/1/1 3/1/1 2/1/1\nf 1//1 2//1 4//1\nf 2 3 4\nf -4 -1 -2\n"
    )
    return made


@functools.cache
def picture() -> bytes:
    """A small picture with transparent pixels."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (5, 7, 4), np.uint8)).save(out, "png")
    return out.getvalue()


@functools.cache
def textured_obj() -> dict[str, bytes]:
    """An OBJ with two materials, one of them with a picture; the first file is the mesh."""
    return {
        "house.obj": b"mtllib house.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 2 0\nvt 2 1\n"
        b"usemtl wall\nf 1/1 2/2 3/3\nf 1/1 3/3 4/2\nusemtl roof\nf 1 2 5\nf 2 3 5\n",
        "house.mtl": b"newmtl wall\nKd 0.8 0.7 0.6\nmap_Kd -clamp on -s 2 1 1 skin.png\nmap_d skin.png\n"
        b"newmtl roof\nKd 0.5 0.1 0.1\n",
        "skin.png": picture(),
    }


@functools.cache
def _textured_tree() -> tuple[dict, bytes]:
    """A glTF document with a texture, its transform and sampler, colours of vertices and a cut-out; and its buffer."""
    arrays = [
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4"),
        np.array([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2], "<u2"),
        np.array([[0, 0], [2, 0], [0, 2], [1, 1]], "<f4"),
        np.array([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 9, 9, 0]], "u1"),
    ]
    types = ((5126, "VEC3"), (5123, "SCALAR"), (5126, "VEC2"), (5121, "VEC4"))
    parts = [array.tobytes() for array in arrays] + [picture()]
    starts = np.cumsum([0] + [len(part) + -len(part) % 4 for part in parts])
    binary = b"".join(part + b"\0" * (-len(part) % 4) for part in parts)
    transform = {
        "KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 3], "texCoord": 0}
    }
    base = {"index": 0, "texCoord": 0, "extensions": transform}
    attributes = {"POSITION": 0, "TEXCOORD_0": 2, "COLOR_0": 3}
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0},
            {"mesh": 0, "rotation": [0, 0, 1, 0], "scale": [1, -1, 1], "translation": [2, 0, 0]},
        ],
        "meshes": [
            {
                "primitives": [
                    {"attributes": attributes, "indices": 1, "material": 0, "mode": 4},
                    {"attributes": {"POSITION": 0}, "indices": 1, "material": 1, "mode": 5},
                ]
            }
        ],
        "materials": [
            {
                "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.2, 1], "baseColorTexture": base},
                "alphaMode": "MASK",
                "alphaCutoff": 0.2,
            },
            {"pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.2, 0.2, 1]}},
        ],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33648, "wrapT": 33071}],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "accessors": [
            {
                "bufferView": k,
                "componentType": code,
                "count": arrays[k].shape[0],
                "type": shape,
                "normalized": k == 3,
            }
            for k, (code, shape) in enumerate(types)
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": int(start), "byteLength": len(part)}
            for start, part in zip(starts, parts)
        ],
        "buffers": [{"byteLength": len(binary)}],
    }
    return tree, binary


def textured_glb() -> dict[str, bytes]:
    """That document in its binary container."""
    tree, binary = _textured_tree()
    return {"house.glb": glb_of(json.dumps(tree).encode(), binary)}


def textured_gltf() -> dict[str, bytes]:
    """That document as text that holds its buffer."""
    import base64

    tree, binary = _textured_tree()
    uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    return {"house.gltf": json.dumps({**tree, "buffers": [{"byteLength": len(binary), "uri": uri}]}).encode()}


def _make_gltf() -> bytes:
    """A triangle pair, its buffer within the file."""
    import base64

    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
    faces = np.array([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2], "<u2")
    buffer = points.tobytes() + faces.tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    accessors = [
        {
            "bufferView": 0,
            "componentType": 5126,
            "count": 4,
            "type": "VEC3",
            "min": [0, 0, 0],
            "max": [1, 1, 1],
        },
        {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
    ]
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "translation": [0, 0, 0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": accessors,
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
                {"buffer": 0, "byteOffset": points.nbytes, "byteLength": faces.nbytes},
            ],
            "buffers": [{"byteLength": len(buffer), "uri": uri}],
        }
    ).encode()


def glb_of(document: bytes, binary: bytes = b"") -> bytes:
    """A glTF document in its binary container."""
    document += b" " * (-len(document) % 4)
    chunks = struct.pack("<II", len(document), 0x4E4F534A) + document
    if binary:
        binary += b"\0" * (-len(binary) % 4)
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


@functools.cache
def motion_arrays() -> dict[str, np.ndarray]:
    """A motion file's arrays, as they are stored."""
    with np.load(io.BytesIO(motion())) as archive:
        return {key: archive[key] for key in archive.files}


@functools.cache
def motion() -> bytes:
    """Four frames of five particles and three Gaussians."""
    rng = np.random.default_rng(1)
    frames, particles, gaussian_count = 4, 5, 3
    value = Motion(
        times=0.04 * np.arange(frames),
        x=rng.uniform(size=(frames, particles, 3)),
        F=np.eye(3) + 0.1 * rng.normal(size=(frames, particles, 3, 3)),
        binding_indices=rng.integers(0, particles, (gaussian_count, 2)),
        binding_weights=np.full((gaussian_count, 2), 0.5),
        binding_offsets=rng.normal(size=(gaussian_count, 2, 3)),
        cloud_means=rng.uniform(size=(gaussian_count, 3)),
        cloud_quats=np.tile([1.0, 0, 0, 0], (gaussian_count, 1)),
        cloud_scales=np.full((gaussian_count, 3), 0.1),
        cloud_opacities=np.full(gaussian_count, 0.9),
        cloud_sh=np.zeros((gaussian_count, 1, 3)),
    )
    with tempfile.TemporaryDirectory() as folder:
        return write_motion(Path(folder, "motion.npz"), value).read_bytes()


def npz(arrays: dict[str, Any]) -> bytes:
    """Arrays as an uncompressed archive."""
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def npy(array: np.ndarray) -> bytes:
    """An array as a file."""
    out = io.BytesIO()
    np.save(out, array, allow_pickle=True)
    return out.getvalue()
