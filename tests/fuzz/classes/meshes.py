"""Meshes in every format, as objects and as obstacles."""

from __future__ import annotations

import json
from pathlib import Path

from physagent_jax.scene.config import Source
from physagent_jax.scene.load import load_object
from physagent_jax.scene.mesh import gaussians_from_mesh
from physagent_jax.scene.signed_distance import load_solid, sample
from tests.fuzz import seeds
from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw, altered, damaged

OBJ_LINES = (
    "v 1", "v 1 2", "v nan 0 0", "v 1e39 0 0", "v 1e400 0 0", "v 1 2 3 4 5 6 7 8", "v a b c", "f 1 2",
    "f 1 2 99", "f 0 0 0", "f 1 1 1", "f -9 1 2", "f 1 2 3 4 5", "f 1/ 2/ 3/", "f 1/9/9 2/9/9 3/9/9",
    "f 1.5 2 3", "vt nan", "vn 0 0 0", "mtllib ../x", "usemtl \u00e9", "l 1 2", "p 1", "o", "#" * 5000,
    "f " + "1 " * 3000, "v 9e37 9e37 9e37",
)  # fmt: skip


MTL_LINES = (
    "newmtl", "newmtl wall", "newmtl \u00e9", "Kd", "Kd 1", "Kd nan 0 0", "Kd 1e400 0 0", "Kd -1 2 0",
    "Kd spectral a.rfl", "map_Kd", "map_Kd skin.png", "map_Kd -s", "map_Kd -s 1 2 skin.png", "map_Kd -clamp on",
    "map_Kd -o nan 0 0 skin.png", "map_Kd -bm 1 -clamp on skin.png", "map_Kd ../skin.png", "map_Kd /dev/zero",
    "map_Kd house.mtl", "map_d skin.png", "d 0", "#" * 3000, "map_Kd -s 1e300 1e300 1e300 skin.png",
)  # fmt: skip


def make(draw: Draw) -> Case:
    """One mesh file, read as an object or as an obstacle."""
    if draw.chance(0.4):
        return _make_coloured(draw)
    kind = draw.one([_damage, _damage, _damage, _damage_obj, _damage_obj, _damage_gltf])
    what, name, content = kind(draw)
    if draw.chance(0.3):
        place = draw.one([0.0, 1.0]), draw.one([1e-30, 1e-3, 0.3, 0.3, 0.3, 1.0, 30.0, 1e6, 1e30])
        return Case(
            f"{name}: {what}; as an obstacle {place}",
            lambda f: _load_obstacle(f / name, *place),
            {name: content},
        )
    return Case(f"{name}: {what}", lambda folder: _load_object(folder, name), {name: content})


def _make_coloured(draw: Draw) -> Case:
    """A mesh with textures and colours, damaged in one of its files, read as an object under some name."""
    files = dict(draw.one([seeds.textured_obj, seeds.textured_glb, seeds.textured_gltf])())
    name = next(iter(files))
    spoilt = draw.one(sorted(files))
    if name == "house.gltf" and draw.chance(0.7):
        what, content = altered(draw, json.loads(files[name]))
        name, files = (
            (name, {name: content})
            if draw.chance(0.5)
            else ("house.glb", {"house.glb": seeds.glb_of(content)})
        )
        spoilt = name
    elif spoilt.endswith(".mtl") and draw.chance(0.7):
        lines = files[spoilt].decode().splitlines()
        for _ in range(draw.one([1, 1, 2])):
            lines.insert(draw.randrange(len(lines) + 1), draw.one(MTL_LINES))
        what, files[spoilt] = (
            "with other lines",
            "\n".join(lines).encode(draw.one(["utf-8", "latin-1"]), "replace"),
        )
    else:
        others = [files[other] for other in sorted(files)]
        what, files[spoilt] = damaged(draw, files[spoilt], others)
    if draw.chance(0.1):  # found by content, whatever the name
        other = "house" + draw.one([".obj", ".glb", ".stl", ".off"])
        files = {other if each == name else each: content for each, content in files.items()}
        name = other
    return Case(f"{name}: {spoilt}: {what}", lambda folder: _load_object(folder, name), files)


def _load_object(folder: Path, name: str):
    if name.endswith(".ply"):
        return gaussians_from_mesh(folder / name, count=40)
    return load_object(Source(path=name, surface_samples=40), folder)


def _load_obstacle(path: Path, position: float, scale: float):
    triangles = load_solid(path, "boundaries[1].path") * scale + position
    return sample(triangles, 0.125, 0.0, 2.0, "boundaries[1]")


def _damage(draw: Draw) -> tuple[str, str, bytes]:
    files = seeds.meshes()
    name = draw.one(sorted(files))
    what, content = damaged(draw, files[name], [files[other] for other in sorted(files)])
    return what, name, content


def _damage_obj(draw: Draw) -> tuple[str, str, bytes]:
    lines = seeds.meshes()["hand.obj"].decode().splitlines()
    done = []
    for _ in range(draw.one([1, 1, 2, 3])):
        line = draw.one(OBJ_LINES)
        lines.insert(draw.randrange(len(lines) + 1), line)
        done.append(line[:30])
    encoding = draw.one(["utf-8", "utf-8", "latin-1", "utf-16"])
    return f"with {done} in {encoding}", "hand.obj", "\n".join(lines).encode(encoding)


def _damage_gltf(draw: Draw) -> tuple[str, str, bytes]:
    what, content = altered(draw, json.loads(seeds.meshes()["box.gltf"]))
    if draw.chance(0.5):
        return what, "box.gltf", content
    return what, "box.glb", seeds.glb_of(content)
