"""Objects that are hard to let stand, made of primitives, about 1 m in size."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from trimesh import creation

Parts = list[trimesh.Trimesh]


def _make_rod(radius: float, start, end) -> trimesh.Trimesh:
    return creation.cylinder(radius, segment=[start, end], sections=12)


def make_tree() -> Parts:
    """A trunk with thin branches that carry heavy crowns."""
    parts = [_make_rod(0.03, (0, 0, 0), (0, 0, 0.6)), creation.box((0.3, 0.3, 0.05))]
    for index in range(12):
        angle, height = 2.4 * index, 0.3 + 0.03 * index
        end = np.array([0.3 * np.cos(angle), 0.3 * np.sin(angle), height + 0.15])
        crown = creation.icosphere(subdivisions=1, radius=0.05).apply_translation(end)
        parts += [_make_rod(0.012, (0, 0, height), end), crown]
    return parts


def make_table() -> Parts:
    """A slab on thin legs."""
    parts = [creation.box((1.0, 0.7, 0.06)).apply_translation((0, 0, 0.6))]
    for x in (-0.45, 0.45):
        parts += [creation.box((0.05, 0.05, 0.6)).apply_translation((x, y, 0.3)) for y in (-0.3, 0.3)]
    return parts


def make_statue() -> Parts:
    """A figure on thin ankles."""
    parts = [
        creation.capsule(0.35, 0.15).apply_translation((0, 0, 0.45)),
        creation.icosphere(subdivisions=2, radius=0.1).apply_translation((0, 0, 0.93)),
    ]
    for side in (-1, 1):
        parts += [
            _make_rod(0.035, (0, 0.08 * side, 0.03), (0, 0.08 * side, 0.4)),
            creation.box((0.2, 0.1, 0.04)).apply_translation((0.03, 0.08 * side, 0.02)),
            _make_rod(0.03, (0, 0.1 * side, 0.75), (0.1, 0.35 * side, 0.5)),
        ]
    return parts


def make_shoe() -> Parts:
    """A flat sole with a heel and a toe cap."""
    return [
        creation.box((1.0, 0.35, 0.05)).apply_translation((0, 0, 0.025)),
        creation.box((0.45, 0.33, 0.3)).apply_translation((-0.27, 0, 0.2)),
        creation.box((0.5, 0.3, 0.12)).apply_translation((0.2, 0, 0.1)),
    ]


def make_vase() -> Parts:
    """A vessel with thin walls and a narrow neck."""
    outside = [(0, 0), (0.12, 0), (0.2, 0.3), (0.22, 0.5), (0.08, 0.8), (0.12, 1.0)]
    inside = [(0.1, 1.0), (0.06, 0.8), (0.2, 0.5), (0.18, 0.3), (0.1, 0.03), (0, 0.03)]
    return [creation.revolve(np.array(outside + inside))]


def make_lamp() -> Parts:
    """A heavy shade on a stem that is thinner than a cell."""
    return [
        creation.cylinder(0.2, 0.04).apply_translation((0, 0, 0.02)),
        _make_rod(0.018, (0, 0, 0), (0, 0, 0.7)),
        creation.cone(0.25, 0.3).apply_translation((0, 0, 0.68)),
    ]


OBJECTS: dict[str, tuple[str, Callable[[], Parts]]] = {
    "tree": ("plant", make_tree),
    "table": ("furniture", make_table),
    "statue": ("toy", make_statue),
    "shoe": ("object", make_shoe),
    "vase": ("vessel", make_vase),
    "lamp": ("furniture", make_lamp),
}
"""Kind and parts by name."""


def export(name: str, folder: Path) -> dict:
    """The spec's ``object`` of one of `OBJECTS`, written below ``folder``."""
    kind, make = OBJECTS[name]
    path = folder / f"{name}.obj"
    if not path.exists():
        trimesh.util.concatenate(make()).export(path)
    return {"path": str(path), "up": "+z", "kind": kind}
