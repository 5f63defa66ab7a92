"""Names that a mesh file gives to its pieces, as a person would say them.

Programs name what nobody has named ("Object.001", "mesh_0", "pCube3"), add words of their own to a person's name
("lid_geo", "lidShape"), and append the material's name. What is left is a name: "arm_L" is "left arm".
"""

from __future__ import annotations

import re
from collections.abc import Iterable

MOST_LETTERS = 60
_TOKEN = re.compile(r"[^\W\d_]+|\d+")
_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")
_LETTERS = {"l": "left", "r": "right"}
_SIDES = "left right upper lower front back rear top bottom inner outer middle".split()
_MACHINE = frozenset(
    """
    default object objects obj mesh meshes group groups grp node nodes geometry geometries geom geo polygon polygons
    poly polysurface shape shapes root rootnode scene world model material materials mat primitive primitives prim
    instance untitled none null unnamed noname submesh part parts element item entity layer collection surface
    surf solid sketchfab gltf glb fbx dae usd blender cleaner merger materialmerger gles export exported import imported empty
    transform locator component
    """.split()
)
_PRIMITIVES = frozenset(
    """
    cube pcube sphere psphere cylinder pcylinder plane pplane cone pcone torus ptorus icosphere circle box capsule grid
    """.split()
)


def list_names(raw: Iterable[str], materials: Iterable[str] = ()) -> tuple[str, ...]:
    """The names that a person gave, each once, in the order of ``raw``.

    Args:
        raw: Names as they stand in the file.
        materials: Names of the file's materials, which name no part.
    """
    looks = {" ".join(_split(each)) for each in materials}
    return tuple(dict.fromkeys(name for each in raw if (name := _read_name(each, looks))))


def _read_name(raw: str, looks: set[str]) -> str:
    """A name in lower case with single spaces, sides first; empty if a machine made it."""
    words = _split(raw)
    if " ".join(words) in looks:
        return ""
    for size in range(len(words) - 1, 0, -1):  # "lid_lambert1_0": the material's name, and a number
        if " ".join(words[-size:]) in looks or words[-1].isdigit() and " ".join(words[-size:-1]) in looks:
            words = words[:-size]
            break
    words = [_LETTERS.get(word, word) for word in words]
    if set(words) - _MACHINE:
        words = [word for word in words if word not in _MACHINE]
    told = [word for word in words if not word.isdigit() and word not in ("left", "right") and len(word) > 1]
    counted = any(word.isdigit() for word in words)
    if not told or set(told) <= _MACHINE or counted and set(told) <= _PRIMITIVES:
        return ""
    sides = [word for word in words if word in _SIDES]
    rest = [str(int(word)) if word.isdigit() else word for word in words if word not in _SIDES]
    return " ".join((*sides, *rest))[:MOST_LETTERS]


def _split(name: str) -> list[str]:
    return _TOKEN.findall(_HUMP.sub(" ", name).lower())
