"""Names that a mesh file gives to its pieces, as a person would say them.

Programs name what nobody has named ("Object.001", "mesh_0", "pCube3"), add words of their own to a person's name
("lid_geo", "lidShape"), and append the material's name. What is left is a name: "arm_L" is "left arm".
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from physagent_jax.forces.part import MOST_LETTERS, split_name

_MACHINE = frozenset(
    """
    default object objects obj mesh meshes group groups grp node nodes geometry geometries geom geo polygon polygons
    poly polysurface shape shapes root rootnode scene world model material materials mat primitive primitives prim
    instance untitled none null unnamed noname submesh part parts element item entity layer collection surface
    surf solid sketchfab gltf glb fbx dae usd blender cleaner merged merger materialmerger gles export exported import
    imported empty transform locator component copy cut duplicate dup clone low lod
    """.split()
)
_PRIMITIVES = frozenset(
    """
    cube pcube sphere psphere cylinder pcylinder plane pplane cone pcone torus ptorus icosphere circle box capsule grid
    """.split()
)
_SIDES = frozenset({"left", "right", "front", "back", "rear"})
_MOST_NUMBERS = 3  # in a name
_RIG = frozenset(
    """
    mixamorig mixamo rig armature bip biped bone bones bn joint jnt def org mch ctrl control fk tweak valve cc sk base
    """.split()
)
"""Words of rigs that say nothing of the limb."""

_TRUNK = frozenset(
    """
    root hips hip pelvis spine chest torso clavicle collar waist center cog origin master main parent ik pole target
    twist roll end nub helper dummy locator
    """.split()
)
"""Words of joints that no limb hangs on, or none of its own."""

_JOINTS = {
    ("up", "arm"): ("arm",),
    ("upperarm",): ("arm",),
    ("fore", "arm"): ("forearm",),
    ("lower", "arm"): ("forearm",),
    ("lowerarm",): ("forearm",),
    ("up", "leg"): ("leg",),
    ("upperleg",): ("leg",),
    ("thigh",): ("leg",),
    ("upper", "leg"): ("leg",),
    ("upper", "arm"): ("arm",),
    ("lower", "leg"): ("shin",),
    ("lowerleg",): ("shin",),
    ("calf",): ("shin",),
    ("index",): ("index", "finger"),
    ("middle",): ("middle", "finger"),
    ("ring",): ("ring", "finger"),
    ("pinky",): ("little", "finger"),
}
"""Limbs that joints move with all that hangs on them, by the words of the joints."""


def list_limbs(raw: Iterable[str]) -> tuple[str, ...]:
    """The limbs that a joint of a skin belongs to, nearest first: "mixamorig:LeftForeArm" is the left forearm.

    Joints that are numbered along one limb ("Tail01", "Tail02") go by one name.

    Args:
        raw: Names of the joint and of the nodes above it, the nearest first.
    """
    return tuple(dict.fromkeys(name for each in raw if (name := _read_limb(each))))


def _read_limb(raw: str) -> str:
    words = [word for word in split_name(raw) if not word.isdigit() and len(word) > 1]
    words = [word for word in words if word not in _RIG and word not in _MACHINE]
    if not _TRUNK.isdisjoint(words):
        return ""
    sides = [word for word in words if word in _SIDES]
    rest = tuple(word for word in words if word not in sides)
    if len(rest) > 1 and rest[0] == "hand":
        rest = rest[1:]  # "LeftHandThumb1"
    rest = _JOINTS.get(rest, rest)
    return " ".join((*sides, *rest))[:MOST_LETTERS] if rest else ""


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
            if _tell(words[:-size]) or any(word.isdigit() for word in words[-size:]):
                words = words[:-size]  # a material may have the thing's name: "wheel_fl" of "Wheel"
            break
    words = [word for word in words if word not in _MACHINE]
    if sum(word.isdigit() for word in words) > _MOST_NUMBERS:  # a checksum
        return ""
    told = _tell(words)
    if not told or told <= _PRIMITIVES and any(word.isdigit() for word in words):
        return ""
    return " ".join(str(int(word)) if word.isdigit() else word for word in words)[:MOST_LETTERS]


def _tell(words: Sequence[str]) -> set[str]:
    """The words of a name that say what something is: no numbers, letters, sides or a machine's words."""
    return {word for word in words if not word.isdigit() and word not in _SIDES | _MACHINE and len(word) > 1}
