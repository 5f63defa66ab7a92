"""Splat formats other than plain PLY: every container damaged from without and from within."""

from __future__ import annotations

import gzip
import json
import zlib
from pathlib import Path

import numpy as np

from physagent_jax.gaussians.formats import read_splats
from physagent_jax.scene.body import make_body
from physagent_jax.scene.config import Domain, Filling, Source
from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw, altered, damaged
from tests.gaussians import format_bytes as fb

_BOUNDS = [-1, 0, 10, 3, 2, 20, -4, -5, -6, 0, -1, -2, 0.1, 0.2, 0.3, 0.6, 0.7, 0.9]


def make_compressed_ply(draw: Draw) -> Case:
    """A compressed PLY, its header or its data damaged."""
    rng = np.random.default_rng(draw.getrandbits(32))
    count, degree = draw.one([1, 3, 257]), draw.one([0, 0, 1, 2, 3])
    content = fb.compressed_ply(
        rng.integers(0, 2**32, (count, 4)).tolist(),
        [_BOUNDS] * -(-count // 256),
        coloured=draw.chance(0.5),
        rest=rng.integers(0, 256, (count, 3 * ((degree + 1) ** 2 - 1))).tolist() if degree else (),
        format_name=draw.one([*["binary_little_endian"] * 2, "binary_big_endian", "ascii"]),
    )
    return _finish(draw, "a.compressed.ply", *_damage(draw, content))


def make_spz(draw: Draw) -> Case:
    """An SPZ file of any version; gzip streams are damaged within too, where their checksum would hide it."""
    rng = np.random.default_rng(draw.getrandbits(32))
    version, degree = draw.one([1, 2, 3, 4, 4]), draw.one([0, 1, 3, 4])
    options = dict(
        degree=degree,
        flags=draw.one([0, 0, 1, 2, 3, 255]),
        extensions=bytes.fromhex(
            draw.one(["", "0300beda04000000", "0300bead0400000006000000", "ffffffffffffffff"])
        ),
        fractional_bits=draw.one([12, 0, 20, 255]),
    )
    gaussians = [_draw_spz(rng, version, degree) for _ in range(draw.one([1, 5, 100]))]
    if version == 4:
        return _finish(draw, "a.spz", *_damage(draw, fb.spz4(gaussians, **options)))
    content = fb.spz(version, gaussians, **options)
    if draw.chance(0.6):
        what, inner = _damage(draw, gzip.decompress(content))
        return _finish(draw, "a.spz", f"within: {what}", gzip.compress(inner, mtime=0))
    return _finish(draw, "a.spz", *_damage(draw, content))


def _draw_spz(rng: np.random.Generator, version: int, degree: int) -> dict:
    levels = rng.integers(0, 256, 11 + 3 * ((degree + 1) ** 2 - 1)).tolist()
    position = rng.normal(size=3) if version == 1 else rng.integers(-(2**23), 2**23, 3).tolist()
    return dict(
        position=position,
        alpha=levels[0],
        colour=levels[1:4],
        scale=levels[4:7],
        rotation=levels[7 : 10 if version < 3 else 11],
        rest=levels[11:],
    )


def make_splat(draw: Draw) -> Case:
    """A .splat file."""
    rng = np.random.default_rng(draw.getrandbits(32))

    def gaussian():
        quat = rng.normal(size=4)
        levels = np.clip(quat / np.linalg.norm(quat) * 128 + 128, 0, 255).astype(int)
        return rng.normal(size=3), np.exp(rng.normal(-3, 1, 3)), rng.integers(0, 256, 4), levels

    content = fb.splat([gaussian() for _ in range(draw.one([1, 60, 400]))])
    return _finish(draw, "a.splat", *_damage(draw, content))


def make_sog(draw: Draw) -> Case:
    """A SOG bundle or folder: its JSON, an image or the archive damaged, or an image that is another's."""
    meta, images = fb.small_sog(draw.one([1, 2, 2]), draw.one([1, 3, 4]), draw.one([1, 2, 3]))
    files = fb.sog_files(meta, images)
    what, name = draw.one(["json", "json", "image", "image", "swap", "archive"]), draw.one(sorted(images))
    if what == "json":
        done, files["meta.json"] = altered(draw, meta)
        what = f"meta.json: {done}"
    elif what == "image":
        done, files[name] = damaged(draw, files[name], list(files.values()))
        what = f"{name}: {done}"
    elif what == "swap":
        other = draw.one(sorted(files))
        files[name], what = files[other], f"{name} is {other}"
    if what != "archive" and draw.chance(0.4):
        return _finish(draw, "meta.json", what, files.pop("meta.json"), files)
    content = fb.zipped(files, draw.one([0, 8]))
    if what == "archive":
        what, content = damaged(draw, content)
    return _finish(draw, "a.sog", what, content)


_NODES = (
    [{"mesh": 0}],
    [{"children": [1, 2]}, {"mesh": 0, "scale": [1, 2, 3]}, {"mesh": 0, "rotation": [0, 1, 0, 0]}],
    [{"mesh": 0, "matrix": np.diag([2.0, 2.0, 2.0, 1.0]).ravel().tolist()}],
)
_SPZ_GAUSSIAN = dict(position=(1, 2, 3), alpha=9, colour=(1, 2, 3), scale=(9, 9, 9), rotation=(99, 9, 9))


def make_gltf(draw: Draw) -> Case:
    """A glTF file with Gaussians: its JSON, its buffer or the whole file damaged."""
    values = fb.gaussian_values(draw.one([1, 5, 40]), draw.one([0, 1, 3]))
    tree, buffer = fb.gltf_parts(values, nodes=draw.one(_NODES))
    if draw.chance(0.3):
        packed = fb.spz(2, [_SPZ_GAUSSIAN])
        tree["bufferViews"].append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(packed)})
        buffer += packed
        tree["buffers"][0]["byteLength"] = len(buffer)
        inner = {"KHR_gaussian_splatting_compression_spz_2": {"bufferView": len(tree["bufferViews"]) - 1}}
        tree["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"]["extensions"] = inner
    what, name = draw.one(["json", "json", "json", "buffer", "file"]), "a.glb"
    if what == "buffer":
        what, buffer = damaged(draw, buffer)
    if draw.chance(0.2):
        name, tree["buffers"][0]["uri"] = "a.gltf", "a.bin"
    text = json.dumps(tree).encode()
    if what == "json":
        what, text = altered(draw, tree)
    content = text if name == "a.gltf" else fb.glb_of(text, buffer)
    if what == "file":
        what, content = damaged(draw, content)
    return _finish(draw, name, what, content, {"a.bin": buffer} if name == "a.gltf" else {})


def _damage(draw: Draw, content: bytes) -> tuple[str, bytes]:
    """Damaged bytes, and now and then whole ones."""
    return ("whole", content) if draw.chance(0.1) else damaged(draw, content, [zlib.compress(content)])


def _finish(draw: Draw, name: str, what: str, content: bytes, beside: dict[str, bytes] | None = None) -> Case:
    files = {name: content, **(beside or {})}
    threshold = draw.one([0.0, 0.02, 0.5])
    if draw.chance(0.2):
        return Case(f"{name}: {what}; as an object", lambda f: _make_body(f, name, threshold), files)
    return Case(f"{name}: {what}", lambda f: read_splats(f / name, opacity_threshold=threshold), files)


def _make_body(folder: Path, name: str, threshold: float):
    source = Source(path=name, opacity_threshold=threshold)
    return make_body(source, Filling(cells=6, max_particles=100), Domain(size=2.0, cells=16), folder)
