"""glTF 2.0, as text and in its binary container GLB.

The loader that reads the other formats takes integer texture coordinates and positions for plain numbers, knows one
set of texture coordinates, repeats every texture, and drops colours of vertices beside a material. Colours need all
of that, and the attributes once read are the mesh.
"""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.scene.config.common import SignedAxis
from physagent_jax.scene.mesh_formats.base import MeshPart, Neighbours
from physagent_jax.scene.mesh_formats.gltf_document import (
    MAGIC,
    Document,
    explain_invalid,
    read_glb,
    read_gltf,
)
from physagent_jax.scene.mesh_formats.gltf_materials import Materials
from physagent_jax.scene.mesh_formats.names import list_limbs, list_names

_TRIANGLES, _STRIP, _FAN = 4, 5, 6


class GLB:
    """A glTF document and its buffer in one binary file."""

    name = "GLB"
    suffixes: tuple[str, ...] = (".glb",)
    up: SignedAxis | None = "+y"  # section 3.4 of the specification
    front: SignedAxis | None = "+z"

    def matches(self, head: bytes, size: int) -> bool:
        """Return whether the file begins with its magic word."""
        return head.startswith(MAGIC)

    def read(self, data: bytes, path: Path, beside: Neighbours) -> list[MeshPart]:
        """The file's parts, one for each primitive in each place."""
        return _read_parts(read_glb(data, shorten(path), beside), shorten(path), beside)


class GLTF:
    """A glTF document as JSON."""

    name = "glTF"
    suffixes: tuple[str, ...] = (".gltf",)
    up: SignedAxis | None = "+y"  # section 3.4 of the specification
    front: SignedAxis | None = "+z"

    def matches(self, head: bytes, size: int) -> bool:
        """Return whether the file begins like a JSON object that has keys of glTF."""
        return head.lstrip().startswith(b"{") and any(
            key in head for key in (b'"asset"', b'"buffers"', b'"accessors"', b'"meshes"')
        )

    def read(self, data: bytes, path: Path, beside: Neighbours) -> list[MeshPart]:
        """The file's parts, one for each primitive in each place."""
        return _read_parts(read_gltf(data, shorten(path), beside), shorten(path), beside)


def _read_parts(document: Document, place: str, beside: Neighbours) -> list[MeshPart]:
    parts: list[MeshPart] = []
    with explain_invalid(place):
        materials, made = Materials(document, beside), {}
        worlds, names = _place_nodes(document.tree, place), _name_nodes(document.tree)
        looks = [each.get("name", "") for each in document.tree.get("materials", [])]
        for index, world in worlds.items():
            node = document.tree["nodes"][index]
            if "mesh" not in node:
                continue
            mesh = node["mesh"]
            if mesh not in made:
                primitives = document.tree["meshes"][mesh]["primitives"]
                shown = [
                    each for each in primitives if each.get("mode", _TRIANGLES) in (_TRIANGLES, _STRIP, _FAN)
                ]
                made[mesh] = [(each, _read_primitive(document, each, materials)) for each in shown]
            for primitive, part in made[mesh]:
                skin = _read_skin(document, node, primitive, worlds)
                moved, limbs = _move(part, world if skin is None else skin.transforms), None
                if skin is not None:
                    limbs = skin.find_owners(part.faces), _name_limbs(document.tree, node["skin"])
                parts.append(dataclasses.replace(moved, names=list_names(names[index], looks), bones=limbs))
    return parts


@dataclasses.dataclass(frozen=True)
class _Skin:
    """The skin of a mesh.

    Attributes:
        transforms: Transforms of its vertices in the pose of the nodes, shape (n, 4, 4).
        joints: The joints that move each vertex, shape (n, 4).
        weights: How much, shape (n, 4).
    """

    transforms: np.ndarray
    joints: np.ndarray
    weights: np.ndarray

    def find_owners(self, faces: np.ndarray) -> np.ndarray:
        """The joint that moves each triangle most, shape (m,)."""
        joints, weights = (each[faces].reshape(len(faces), -1) for each in (self.joints, self.weights))
        totals = (weights[:, None] * (joints[:, None] == joints[..., None])).sum(-1)
        return np.take_along_axis(joints, totals.argmax(1)[:, None], 1)[:, 0]


def _place_nodes(tree: Any, place: str) -> dict[int, np.ndarray]:
    """Transforms to the world of all nodes of the scene, shape (4, 4) each."""
    nodes = tree.get("nodes", [])
    if tree.get("scenes"):
        roots = tree["scenes"][tree.get("scene", 0)].get("nodes", [])
    else:
        roots = sorted(
            set(range(len(nodes))) - {child for node in nodes for child in node.get("children", [])}
        )
    worlds: dict[int, np.ndarray] = {}
    waiting = [(root, np.eye(4)) for root in reversed(roots)]
    while waiting:
        index, parent = waiting.pop()
        if index in worlds:
            raise UserError(
                f"{place}: a node has two parents", do="Export it again, each node with one parent"
            )
        worlds[index] = parent @ _read_transform(nodes[index])
        waiting += [(child, worlds[index]) for child in reversed(nodes[index].get("children", []))]
    return worlds


def _name_nodes(tree: Any) -> list[list[str]]:
    """Names of each node: its own, its mesh's, and those of the nodes above it; of a skin's joint, its limb's.

    What hangs on a joint, as a tool in a hand, belongs to the same limbs as the skin there. A mesh that several nodes
    show, and that is called as one of them ("wheel_frontLeft" of all four wheels), names the others nothing.
    """
    nodes = tree.get("nodes", [])
    owners = {
        (node["mesh"], _drop_number(node.get("name", ""))): index
        for index, node in enumerate(nodes)
        if "mesh" in node
    }
    joints = {joint for skin in tree.get("skins", []) for joint in skin["joints"]}
    above = {child: index for index, node in enumerate(nodes) for child in node.get("children", [])}
    found = []
    for index, node in enumerate(nodes):
        names = [node.get("name", "")]
        if "mesh" in node:
            name = tree["meshes"][node["mesh"]].get("name", "")
            names += [name] if owners.get((node["mesh"], _drop_number(name)), index) == index else []
        while (index := above.get(index, -1)) >= 0:
            name = nodes[index].get("name", "")
            names += list_limbs([name]) if index in joints and isinstance(name, str) else [name]
        found.append([each for each in names if isinstance(each, str)])
    return found


def _drop_number(name: Any) -> tuple[str, ...]:
    """A name without the number that a program has added, as a person would say it: "Mesh lid.002" is a lid."""
    return list_names([re.sub(r"\.\d+$", "", name)]) if isinstance(name, str) else ()


def _name_limbs(tree: Any, skin: int) -> tuple[tuple[str, ...], ...]:
    """The limbs that each joint of a skin belongs to, by its name and those of the joints above it."""
    nodes, joints = tree["nodes"], tree["skins"][skin]["joints"]
    above = {child: joint for joint in joints for child in nodes[joint].get("children", [])}
    found = []
    for joint in joints:
        names = [nodes[joint].get("name", "")]
        while (joint := above.get(joint, -1)) >= 0:
            names.append(nodes[joint].get("name", ""))
        found.append(list_limbs(each for each in names if isinstance(each, str)))
    return tuple(found)


def _read_transform(node: Any) -> np.ndarray:
    if "matrix" in node:
        return np.asarray(node["matrix"], np.float64).reshape(4, 4).T
    transform = np.eye(4)
    quaternion = np.asarray(node.get("rotation", [0, 0, 0, 1]), np.float64).reshape(4)
    if np.linalg.norm(quaternion) > 0:
        transform[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    transform[:3, :3] *= np.asarray(node.get("scale", [1, 1, 1]), np.float64).reshape(3)
    transform[:3, 3] = np.asarray(node.get("translation", [0, 0, 0]), np.float64).reshape(3)
    return transform


def _read_primitive(document: Document, primitive: Any, materials: Materials) -> MeshPart:
    attributes = primitive["attributes"]
    vertices = np.asarray(document.read_accessor(attributes["POSITION"]), np.float64).reshape(-1, 3)
    normals = None
    if "NORMAL" in attributes:
        normals = np.asarray(document.read_accessor(attributes["NORMAL"]), np.float64).reshape(-1, 3)
    index = np.arange(len(vertices))
    if "indices" in primitive:
        index = document.read_accessor(primitive["indices"]).ravel().astype(np.int64)
    faces = _make_triangles(index, primitive.get("mode", _TRIANGLES))
    for name in attributes:
        if document.tree["accessors"][attributes[name]]["count"] != len(vertices):
            raise ValueError(f"{name} has another count than POSITION")
    return MeshPart(vertices, faces, materials.make_look(primitive), normals)


def _make_triangles(index: np.ndarray, mode: int) -> np.ndarray:
    if mode == _TRIANGLES:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    count = max(len(index) - 2, 0)
    k = np.arange(count)
    if mode == _FAN:
        return np.stack([index[k + 1], index[k + 2], np.broadcast_to(index[:1], k.shape)], axis=1)
    odd = k % 2
    return np.stack([index[k], index[k + 1 + odd], index[k + 2 - odd]], axis=1)


def _read_skin(document: Document, node: Any, primitive: Any, worlds: dict) -> _Skin | None:
    """The skin of a mesh; None = it has none."""
    attributes = primitive["attributes"]
    if "skin" not in node or not {"JOINTS_0", "WEIGHTS_0"} <= attributes.keys():
        return None
    skin = document.tree["skins"][node["skin"]]
    joints = np.stack([worlds.get(joint, np.eye(4)) for joint in skin["joints"]])
    if "inverseBindMatrices" in skin:
        inverse = document.read_accessor(skin["inverseBindMatrices"])[: len(joints)]
        joints = joints @ inverse.reshape(-1, 4, 4).transpose(0, 2, 1)
    weights = np.asarray(document.read_accessor(attributes["WEIGHTS_0"], normalise=True), np.float64)
    total = weights.sum(1, keepdims=True)
    weights = np.where(total > 0, weights / np.where(total > 0, total, 1), 0.25)
    index = document.read_accessor(attributes["JOINTS_0"]).astype(np.int64)
    moved = sum(weights[:, k, None, None] * joints[index[:, k]] for k in range(4))
    return _Skin(np.asarray(moved), index, weights)


def _move(part: MeshPart, transform: np.ndarray) -> MeshPart:
    """The part under one transform, shape (4, 4), or one of each vertex, shape (n, 4, 4)."""
    linear, shift = transform[..., :3, :3], transform[..., :3, 3]
    vertices = np.einsum("...ij,...j->...i", linear, part.vertices) + shift
    mirrored = np.linalg.det(linear).mean() < 0
    normals = None
    if (
        part.normals is not None
    ):  # cofactors: the inverse transposed, but for a positive factor, and never singular
        rows = linear[..., 0, :], linear[..., 1, :], linear[..., 2, :]
        cofactors = np.stack([np.cross(rows[(k + 1) % 3], rows[(k + 2) % 3]) for k in range(3)], axis=-2)
        normals = np.einsum("...ij,...j->...i", cofactors, part.normals) * (-1 if mirrored else 1)
    faces = part.faces[:, ::-1] if mirrored else part.faces
    return MeshPart(vertices, faces, part.look, normals)
