"""The part that a word means, of those that stick out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import FRONT, REAR, Part, list_end_words, split_name
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.vectors import add, cosine, cross, norm, normalise, scale

_WORLD_AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_LEVEL = 0.5  # cosine to the vertical below which a line is level
_ALIKE = 0.7  # share of the object over the largest's, from which on a part is as likely as that
_SPREAD = 0.9  # cosine to the longest line, from which on a pair of parts is spread along it, as wings are
_THERE = 0.2  # cosine to a side from which on a limb is on it
_FRONTS = FRONT | frozenset(
    "head hood bonnet nose beak snout bow grille headlight headlights windshield windscreen".split()
)
_REARS = REAR | frozenset("tail stern taillight taillights stoplights exhaust boot trunk spare".split())
_TOLD = 0.3  # of a unit vector, from which on parts with names tell where the front is
_OWN_SIDES = frozenset(("left", "right"))
PLACES = ("top", "bottom", "side")
"""Roles that tell a part's place alone: a word for another part takes it where it is the only one there."""
STEMS = frozenset(("trunk", "stem", "stalk", "pole", "mast", "post", "handle", "shaft", "haft"))
"""Words for parts that all the rest may stand on."""
LOW = 0.15
"""Share of the object's height below which a part stands on the ground."""
SEATED = frozenset(("crown", "lid", "knob", "top"))
"""Roles of what sits on the rest with a broad face."""
LOOSE = frozenset((*PLACES, "lid", "knob", "crown"))
"""Roles of what may sit loose on the rest."""


def choose_parts(
    parts: Sequence[Part],
    roles: Sequence[str],
    side: Vector | None,
    plural: bool,
    adjective: str = "",
    toward: Vector = (0.0, 0.0, 0.0),
) -> tuple[int, ...]:
    """Places of the parts that a word means.

    Args:
        parts: The object's parts.
        roles: Roles that the word may mean, likeliest first: the first that the object has is meant.
        side: Where the part is (world vector); None = not told. One part is chosen then.
        plural: Whether all of them are meant.
        adjective: The sentence's word for its side: where the file has a left and a right one, left is as the file
            has it.
        toward: The viewer's direction: of parts that are alike, the one that is seen best is likeliest.

    Returns:
        Places in ``parts``, likeliest first; empty if there is none, or several of which only the place is known.
    """
    for role in roles:
        fitting = [index for index, each in enumerate(parts) if role in each.roles]
        fitting = [index for index in fitting if parts[index].name] or fitting  # what is named goes first
        sided = [index for index in fitting if adjective in _OWN_SIDES & {*split_name(parts[index].name)}]
        if sided:
            return tuple(sided if plural else sided[:1])
        paired = len(fitting) == 2 and role not in PLACES
        pair = [parts[index].side for index in fitting] if paired else []
        nearness = {
            index: _find_nearness(take_middle_off(parts[index].side, pair), side) for index in fitting
        }
        there = [index for index in fitting if nearness[index] > _THERE]
        behind = [index for index in fitting if nearness[index] > -_THERE]  # two may stand behind each other
        fitting = there or behind * (len(behind) == len(fitting) == 2)
        least = _ALIKE * max((parts[index].share for index in fitting), default=0.0)
        seen = {
            index: (cosine(parts[index].side, toward) if parts[index].share >= least else -1.0)
            for index in fitting
        }
        fitting.sort(key=lambda index: (-nearness[index], -round(seen[index], 1), -parts[index].share))
        if role in PLACES and len(fitting) > 1 and not (plural or side):
            continue
        if fitting:
            return tuple(fitting if plural else fitting[:1])
    return ()


def take_middle_off(place: Vector, alike: Sequence[Vector]) -> Vector:
    """Place of a part, seen from the middle of those that are like it: the left ear of a head on the right.

    Args:
        place: Where the part is, seen from the object's middle.
        alike: The same of all that are like it; none = the object's middle stays.
    """
    return add([place, *(scale(each, -1.0 / len(alike)) for each in alike)])


def _find_nearness(place: Vector, side: Vector | None) -> float:
    """Cosine between where a part is and a side, seen from above if that is level; 1 if no side is told."""
    if side is None or not norm(side):
        return 1.0
    level = abs(side[2]) < 1e-6 * norm(side)
    return cosine((place[0], place[1], 0.0 if level else place[2]), side)


def find_front(parts: Sequence[Part]) -> Vector | None:
    """The level way in which an animal looks: where its head is, seen from its middle; None if that is not known.

    What has arms stands upright, however many pieces its legs are made of.
    """
    heads = [each for each in parts if "head" in each.roles[:1]]
    upright = any("arm" in each.roles[:1] for each in parts)
    if len(heads) != 1 or upright or sum("leg" in each.roles[:1] for each in parts) < 3:
        return None
    return normalise((heads[0].side[0], heads[0].side[1], 0.0))


def find_facing(parts: Sequence[Part]) -> Vector | None:
    """The level way in which a figure looks: by its head and legs, else by what overhangs; None if neither tells it."""
    return find_front(parts) or next((part.front for part in parts if part.front), None)


def stands_on_legs(parts: Sequence[Part]) -> bool:
    """Return whether an animal's legs are seen: its head and ears need not be what is highest, as a raised tail is."""
    return any("leg" in each.roles[:1] for each in parts)


def find_level_line(brief: SceneBrief) -> Vector:
    """The level line through something from end to end, about which it rolls over (unit vector).

    It is longest along it, unless two like parts are what makes it so long; or looks along it, or has two like parts on
    either side of it (wings, or a left and a right arm); else it points at the viewer.
    """
    pairs = [
        (math.dist(one.side, other.side), _is_right(one) - _is_right(other), one, other)
        for one, other in itertools.combinations(brief.parts, 2)
        if _are_alike(one, other)
    ]
    _, sided, one, other = max(pairs, key=lambda pair: pair[0], default=(0.0, 0, None, None))
    across = (0.0, 0.0, 0.0) if one is None or other is None else add([one.side, scale(other.side, -1.0)])
    long = brief.long_axis
    if long is not None and abs(long[2]) < _LEVEL and abs(cosine(long, across)) < _SPREAD:
        return long
    beside = normalise(cross(brief.directions.up, across))
    if beside is not None and (sided or cosine(beside, brief.directions.toward)) < 0:
        beside = scale(beside, -1.0)
    told = find_front(brief.parts) or find_named_front(brief.parts)
    return told or (beside if abs(across[2]) < _LEVEL else None) or brief.directions.toward


def _is_right(part: Part) -> bool:
    return "right" in split_name(part.name)


def _are_alike(one: Part, other: Part) -> bool:
    """Return whether two parts are a pair by what they are, or by their names; legs are two in more than one way."""
    names = [[word for word in split_name(each.name) if word not in _OWN_SIDES] for each in (one, other)]
    role = one.roles[:1] == other.roles[:1] != () and "leg" not in one.roles[:1]
    return role or bool(names[0]) and names[0] == names[1] and one.name != other.name


def find_way_ahead(brief: SceneBrief) -> Vector:
    """The level way in which something looks (unit vector).

    Its head, the names of its parts or its level line tell it; else it looks at the viewer.
    """
    told = find_front(brief.parts) or find_named_front(brief.parts)
    return told or find_facing(brief.parts) or find_level_line(brief)


def find_named_front(parts: Sequence[Part]) -> Vector | None:
    """The level way in which something looks, by parts whose names or roles say that they are in front or behind."""
    words = zip(parts, list_end_words(parts))
    told = [scale(_level(part), sign) for part, own in words if (sign := _tell_front(part, own))]
    mean = scale(add(told), 1.0 / len(told)) if told else (0.0, 0.0, 0.0)
    return normalise(mean) if norm(mean) > _TOLD else None


def _tell_front(part: Part, words: set[str]) -> int:
    """1 for a part whose name's ``words`` or first role say that it is in front, -1 for one behind, 0 for others."""
    words = {*words, *part.roles[:1]}
    return bool(words & _FRONTS) - bool(words & _REARS)


def _level(part: Part) -> Vector:
    return part.side[0], part.side[1], 0.0


def sum_directions(names: Sequence[str], brief: SceneBrief) -> Vector:
    """Sum of directions by their names, those of the viewer, of the world and of the object (not normalised).

    Args:
        names: Such as "left", "x", "long" (its long axis), "own" (its level line), "beside" (across that),
            "ahead" and "behind" (as it looks).
        brief: The scene.
    """
    table, long, own = brief.directions, brief.long_axis, find_level_line(brief)
    lines = {"long": long or table.up, "lengthwise": long or table.right, "own": own}
    lines["beside"] = normalise(cross(own, table.up)) or table.left
    lines |= {"ahead": find_way_ahead(brief), "behind": scale(find_way_ahead(brief), -1.0)}
    known = _WORLD_AXES | lines
    return add(known.get(name) or getattr(table, name) for name in names)
