"""Meshes with the answers: which surfaces a person would call by a word, and the same meshes without their names."""

from __future__ import annotations

import dataclasses
import fnmatch
import functools
from pathlib import Path

import numpy as np
import trimesh
import yaml
from scipy.spatial import KDTree

from benchmarks.first_results.pins import PinnedFile
from physagent_jax.scene.mesh_files import join_parts, read_named_parts

_SAMPLES = 100_000  # on all surfaces


@dataclasses.dataclass(frozen=True)
class Thing:
    """An object whose file names its parts.

    Attributes:
        name: What a person calls it.
        file: Its file.
        path: The same below the folder of its repository.
        parts: The words for its parts, each with patterns of names.
    """

    name: str
    file: PinnedFile
    path: str
    parts: dict[str, tuple[str, ...]]

    @property
    def half(self) -> str:
        """The half that it belongs to, by its hash: one is developed with, one is looked at twice."""
        return ("developed with", "held back")[int(self.file.sha256, 16) % 2]


@functools.cache
def read_things() -> tuple[Thing, ...]:
    """The objects of the table."""
    table = yaml.safe_load((Path(__file__).parent / "objects.yaml").read_text("utf-8"))
    found = []
    for row in table["objects"]:
        root, credit = table["repositories"][row["from"]].split(", ", 1)
        folder, _, name = f"{root}/{row['path']}".rpartition("/")
        words = {word: tuple(each.strip() for each in told.split(",")) for word, told in row["parts"].items()}
        file = PinnedFile(name, folder, row["sha256"], f"mesh, {credit}")
        found.append(Thing(row["name"], file, row["path"], words))
    return tuple(found)


def find_file(thing: Thing, data: Path) -> Path | None:
    """The object's file below a folder, by its hash; None if it is not there. Buffers of glTF lie beside it."""
    return next((path for path in sorted(data.rglob(thing.file.name)) if thing.file.is_in(path)), None)


class Answers:
    """The surfaces of an object with their names.

    Args:
        path: Its file.
    """

    def __init__(self, path: Path):
        self.surfaces = [each for each in read_named_parts(path) if len(each.faces)]
        triangles = np.concatenate([each.vertices[each.faces] for each in self.surfaces])
        owner = np.repeat(np.arange(len(self.surfaces)), [len(each.faces) for each in self.surfaces])
        areas = trimesh.triangles.area(triangles)
        chance = np.random.default_rng(0)
        face = chance.choice(len(triangles), _SAMPLES, p=areas / areas.sum())
        u, v = np.sqrt(chance.random((_SAMPLES, 1))), chance.random((_SAMPLES, 1))
        a, b, c = (triangles[face, k] for k in range(3))
        self._tree, self._owner = KDTree((1 - u) * a + u * (1 - v) * b + u * v * c), owner[face]

    def list_owners(self, points: np.ndarray) -> np.ndarray:
        """The surface that is nearest to each point in the file's frame, shape (n,)."""
        return self._owner[self._tree.query(points)[1]]

    def list_fitting(self, patterns: tuple[str, ...]) -> list[int]:
        """Places of the surfaces whose nearest name fits a pattern."""
        return [
            k
            for k, each in enumerate(self.surfaces)
            if any(fnmatch.fnmatch((each.names or ("",))[0], pattern) for pattern in patterns)
        ]

    def write(self, path: Path) -> None:
        """Write the object as one mesh without names."""
        vertices, faces = join_parts(self.surfaces)
        path.write_bytes(
            trimesh.Scene([trimesh.Trimesh(vertices, faces, process=False)]).export(file_type="glb")
        )
