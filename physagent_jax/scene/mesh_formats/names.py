"""Names that a mesh file gives to its pieces, as a person would say them.

Programs name what nobody has named ("Object.001", "mesh_0", "pCube3"), add words of their own to a person's name
("lid_geo", "lidShape"), and append the material's name. What is left is a name: "arm_L" is "left arm".
"""

from __future__ import annotations

from collections.abc import Iterable

from physagent_jax.forces.part import MOST_LETTERS, split_name

_MACHINE = frozenset(
    """
    default object objects obj mesh meshes group groups grp node nodes geometry geometries geom geo polygon polygons
    poly polysurface shape shapes root rootnode scene world model material materials mat primitive primitives prim
    instance untitled none null unnamed noname submesh part parts element item entity layer collection surface
    surf solid sketchfab gltf glb fbx dae usd blender cleaner merger materialmerger gles export exported import
    imported empty transform locator component
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
    looks = {split_name(each) for each in materials}
    return tuple(dict.fromkeys(name for each in raw if (name := _read_name(each, looks))))


def _read_name(raw: str, looks: set[tuple[str, ...]]) -> str:
    """A name in lower case with single spaces, sides first; empty if a machine made it."""
    words = split_name(raw)
    for size in range(len(words), 0, -1):  # "lid_lambert1_0": the material's name, and a number
        if words[-size:] in looks or words[-1].isdigit() and words[-size:-1] in looks:
            words = words[:-size]
            break
    words = [word for word in words if word not in _MACHINE]
    told = {word for word in words if not word.isdigit() and word not in ("left", "right") and len(word) > 1}
    if not told or told <= _PRIMITIVES and any(word.isdigit() for word in words):
        return ""
    return " ".join(str(int(word)) if word.isdigit() else word for word in words)[:MOST_LETTERS]
