"""A part of an object where forces may act. Pure data, no arrays."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field, model_validator

from physagent_jax.core.strict import Direction, Numbers, Strict
from physagent_jax.forces.schema import CellsRegion

_WORD = re.compile(r"[^\W\d_]+|\d+")
_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")
_EACH = ("each", "every")
_PLURALS = frozenset("feet teeth antennae".split())
_SINGULARS = dict(
    leaves="leaf", feet="foot", teeth="tooth", hooves="hoof", antennae="antenna", branches="branch"
)
_SINGULARS |= dict(torches="torch", canvas="canvas", chassis="chassis", canopies="canopy", glass="glass")
_SINGULARS |= dict(knives="knife", cherries="cherry")
_LETTERS: dict[str, tuple[str, ...]] = {"l": ("left",), "r": ("right",)}
_LETTERS |= {
    code: (end, side)
    for first, end in (("f", "front"), ("r", "rear"), ("b", "back"))
    for second, side in (("l", "left"), ("r", "right"))
    for code in (first + second, second + first)
}  # of wheels and legs
SIDES = frozenset("left right upper lower front back rear top bottom inner outer middle".split())
"""Words for a side, which a name begins with."""
PartRole = Literal[
    "head",
    "ear",
    "horn",
    "arm",
    "wing",
    "leg",
    "tail",
    "handle",
    "spout",
    "lid",
    "knob",
    "back",
    "finger",
    "thumb",
    "forefinger",
    "middlefinger",
    "ringfinger",
    "littlefinger",
    "toe",
    "heel",
    "tip",
    "nose",
    "bow",
    "stern",
    "blade",
    "grip",
    "stem",
    "crown",
    "neck",
    "spike",
    "top",
    "bottom",
    "side",
]


PartOrigin = Literal["shape", "place", "file", "option"]
ORIGINS = {
    "shape": "found by its shape",
    "place": "told by its place",
    "file": "named in the file",
    "option": "named by --part",
}
Coordinate = Annotated[float, Field(ge=-1e12, le=1e12)]
FRONT = frozenset("front avant vorn vorne anteriore frente delantera delantero dianteira dianteiro".split())
REAR = frozenset("rear back arriere hinten posteriore trasera trasero traseira traseiro".split())
"""Words of names for the front and the rear, in English and other languages that objects are made in."""
ROLLING = frozenset(
    "wheel wheels tyre tyres tire tires pneu pneus roda rodas roue roues rueda ruedas rad reifen".split()
)
"""The same for what rolls."""
MOST_LETTERS = 60
_SURE = 0.6  # confidence from which on a role is certain


class PartChoice(Strict):
    """A part that a person names: in a box, at a point, or by its number in the list of `physagent inspect`.

    Attributes:
        name: What it is called.
        box: Two corners, low and high [file units, along the file's axes].
        point: The part that is nearest to it is meant [file units].
        number: Its place among the parts that are found without choices, from 1.
    """

    name: Annotated[str, Field(min_length=1, max_length=MOST_LETTERS)]
    box: tuple[Coordinate, Coordinate, Coordinate, Coordinate, Coordinate, Coordinate] | None = None
    point: tuple[Coordinate, Coordinate, Coordinate] | None = None
    number: Annotated[int, Field(ge=1, le=10_000)] | None = None

    @model_validator(mode="after")
    def _check_one_place(self) -> PartChoice:
        if not split_name(self.name):
            raise ValueError(f"a part's name needs letters (got {self.name!r})")
        if sum(each is not None for each in (self.box, self.point, self.number)) != 1:
            raise ValueError(f"the part {self.name!r} is a box, a point or a number: give one of them")
        if self.box is not None and any(a >= b for a, b in zip(self.box[:3], self.box[3:])):
            raise ValueError(
                f"the box of the part {self.name!r} is x0 y0 z0 x1 y1 z1, each x0 < x1 (got {self.box})"
            )
        return self

    def format(self) -> str:
        """The text of the option `--part` that says the same."""
        place = self.box or self.point or (self.number,)
        return f"{self.name}={','.join(f'{each:.12g}' for each in place)}"


class Part(Strict):
    """A part of the object: it sticks out, or the object's file or a person names it.

    Attributes:
        name: What the file or a person calls it; empty = nobody has named it.
        origin: What told of it.
        stands_for: What the object itself calls the part, where its name is that of a sentence; else empty.
        label: What people are told that it is, with its place: "left arm"; empty until the viewer is known.
        seated: Whether it is a piece of its own that sits on the rest with a broad face, as a lid does: it moves
            as a whole, and about its own middle. Others turn about their joint.
        roles: What it may be, surest first: "ear" and "horn" come in pairs on a head, "arm" in pairs elsewhere, "wing"
            is a flat one; "leg" stands on the ground with another, "back" on legs; "handle" is a loop, "spout" is
            across from it; "tail" is across from the head; "lid" and "knob" are on top. "finger" and "thumb" are on a
            hand. "toe" to "neck" are ends and sections, told by how broad the object is along its axis; a "grip" is the
            end of a handle. A "spike" is one of several alike that point up. "top", "bottom" and "side" tell its place
            alone.
        moved: Particles that move with it: all but those next to its joint.
        rest: Particles of the rest of the object.
        joint: Where it joins the rest (bounding-box fractions).
        arm: From there to its tip [body lengths].
        side: Where it is, seen from the object's middle (unit world vector).
        share: Share of the object's volume.
        axle: The line about which a disc or a wheel turns (unit world vector); None for what is none.
        neck: Spread of where it joins the rest along each world axis (standard deviations) [body lengths]; 0 = not
            known, or nothing joins them.
        front: The level way in which the object looks, as what juts out high up tells it (unit world vector); None =
            not known.
        confidence: Chance that its first role is right, by how clearly its shape tells.
    """

    name: Annotated[str, Field(max_length=MOST_LETTERS)] = ""
    origin: PartOrigin = "shape"
    stands_for: Annotated[str, Field(max_length=2 * MOST_LETTERS)] = ""
    label: Annotated[str, Field(max_length=200)] = ""
    seated: bool = False
    roles: tuple[PartRole, ...] = ()
    moved: CellsRegion
    rest: CellsRegion
    joint: Numbers
    arm: Numbers
    side: Direction
    share: float = Field(ge=0, le=1)
    axle: Direction | None = None
    neck: Numbers = (0.0, 0.0, 0.0)
    front: Direction | None = None
    confidence: float = Field(default=1.0, ge=0, le=1)

    @property
    def unsure(self) -> bool:
        """Return whether its shape does not tell its role for certain."""
        return self.confidence < _SURE


def split_name(name: str) -> tuple[str, ...]:
    """The words and numbers of a name, in lower case, sides first: "Arm_L" is the left arm; none without letters.

    "Wheel_FR" is the front right wheel.
    """
    found: list[str] = _WORD.findall(_HUMP.sub(" ", name).lower())
    words = [said for word in found for said in _LETTERS.get(word, (word,))]
    words.sort(key=lambda word: word not in SIDES)
    return tuple(words) if any(not word.isdigit() for word in words) else ()


def list_end_words(parts: Sequence[Part]) -> list[set[str]]:
    """The words of each part's name, with "front" of "f tyre" and "rear" of "b tyre", where there are both."""
    names = [split_name(part.name) for part in parts]
    words = [{*name} for name in names]
    for k, name in enumerate(names):
        rest = [word for word in name if word != "f"]
        for j, other in enumerate(names):
            if "f" in name and [word for word in other if word != "b"] == rest != [*other]:
                words[k].add("front")
                words[j].add("rear")
    return words


def list_parts(parts: Sequence[Part]) -> str:
    """All parts with their numbers, for messages: "1 head, 2 left arm (unsure)"; "none" if there are none."""
    told = [
        f"{index} {part.label or part.name or part.roles[0]}{' (unsure)' if part.unsure else ''}"
        for index, part in enumerate(parts, 1)
        if not part.stands_for
    ]
    return ", ".join(told) or "none"


def get_singular(word: str) -> str:
    """The singular of a part's word: "leaf" of "leaves"."""
    if word in _SINGULARS:
        return _SINGULARS[word]
    return word[:-1] if word.endswith("s") and not word.endswith("ss") else word


def is_plural(text: str) -> bool:
    """Return whether a part's word means several: "both wings", "each wing", but not "one of its wings"."""
    words = text.lower().split() or [""]
    several = words[0] in _EACH or words[-1].endswith("s") or words[-1] in _PLURALS
    return words[:2] != ["one", "of"] and several
