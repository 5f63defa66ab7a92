"""Doors and lids that are closed: which of their edges is the hinge.

A closed piece touches the rest all around, so that its place and shape alone tell. A thin upright piece is a door: it
turns about the side that is away from its twin, else about the side that is farther from the object's middle. What lies
on top is a lid: it turns about a long edge at the back, or about the edge at the object's middle if it lies off it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import Part, split_name
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.vectors import add, cross, dot, norm, scale, subtract

_SQUARE = 1.4  # area of the largest box around a piece seen from above over the least, of what has corners
_FEWEST = 16  # places that tell corners
_TURNS = 12  # directions of such a box in a quarter turn
_TRIMMED = 0.02  # share of seeds at either end that is no part of an extent
_THIN = 0.6  # thickness of a door over its next extent, at most
_ASIDE = 0.12  # [body lengths] from the object's middle, from which on a piece lies on one side of it
_EDGE = 0.8  # length of a lid's hinge over its longest edge, at least
_MOST = 0.5  # share of the object that a door is
_BESIDE = 0.7  # cosine to the level way from a door to its twin
_ABOVE = frozenset("garage hatch tailgate trunk boot shutter".split())  # words for doors that open upwards
_BELOW = frozenset("oven dishwasher ramp drawbridge".split())  # words for those that open downwards


def find_edge(
    part: Part,
    brief: SceneBrief,
    inside: Sequence[Vector],
    gaps: Sequence[tuple[Vector, Vector]],
    box: Vector,
) -> tuple[Vector, Vector] | None:
    """A point on the hinge of a closed piece, and the axis about which it opens; None for what is round.

    Args:
        part: The piece.
        brief: The scene.
        inside: Places in it [body lengths].
        gaps: Those that touch the rest, each with the nearest place there [body lengths].
        box: Extents of the object along the world's axes [body lengths].
    """
    up = brief.directions.up
    corners = _find_corners(inside, up)
    if corners is None:
        return None
    ends = {way: _find_ends(inside, way) for way in (*corners, up)}
    length = {way: high - low for way, (low, high) in ends.items()}
    middle = add(scale(way, 0.5 * (low + high)) for way, (low, high) in ends.items())
    off = subtract(middle, scale(box, 0.5))
    thin, broad = sorted(corners, key=lambda way: length[way])
    faces = add(subtract(here, there) for here, there in gaps)
    level = max(abs(dot(faces, way)) for way in corners) > abs(dot(faces, up))
    door = length[thin] < _THIN * min(length[broad], length[up]) or level
    if part.share > _MOST if door else dot(off, up) < 0:  # the rest turns about it
        return None
    if door:
        ahead = dot(off, thin) if abs(dot(off, thin)) > _ASIDE else dot(thin, brief.directions.toward)
        out, edge = scale(thin, math.copysign(1.0, ahead)), _choose_side(part, brief, off, broad)
    else:
        out, edge = up, _choose_back(brief, off, corners, length)
    reach = sum(abs(dot(edge, way)) * each for way, each in length.items())
    place = add([middle, scale(edge, 0.5 * reach)])
    if out == up:  # on the face that it lies on
        low = sum(dot(each, up) for each, _ in gaps) / len(gaps)
        place = add([place, scale(up, low - dot(place, up))])
    return place, cross(scale(edge, -1.0), out)


def _choose_side(part: Part, brief: SceneBrief, off: Vector, broad: Vector) -> Vector:
    """The way to the edge of a door that its hinge is on."""
    up, words = brief.directions.up, split_name(part.name)
    if not _ABOVE.isdisjoint(words):
        return up
    if not _BELOW.isdisjoint(words):
        return scale(up, -1.0)
    twins = [p for p in brief.parts if p is not part and split_name(p.name)[-1:] == words[-1:]]
    apart = [subtract(part.side, each.side) for each in twins]
    beside = [each for each in apart if abs(dot(each, broad)) > _BESIDE * norm(each)]
    away = beside[0] if beside else off if abs(dot(off, broad)) > _ASIDE else brief.directions.left
    return scale(broad, math.copysign(1.0, dot(away, broad)))


def _choose_back(
    brief: SceneBrief, off: Vector, corners: tuple[Vector, Vector], length: dict[Vector, float]
) -> Vector:
    """The way to the edge of a lid that its hinge is on."""
    level = (off[0], off[1], 0.0)
    front = level if norm(level) > _ASIDE else brief.directions.toward
    most = max(length[way] for way in corners)
    ways = [
        scale(way, sign)
        for way, along in (corners, corners[::-1])
        if length[along] >= _EDGE * most
        for sign in (1.0, -1.0)
    ]
    return min(ways, key=lambda way: dot(way, front))


def _find_ends(places: Sequence[Vector], way: Vector) -> tuple[float, float]:
    along = sorted(dot(place, way) for place in places)
    cut = int(_TRIMMED * len(along))
    return along[cut], along[-1 - cut]


def _find_corners(places: Sequence[Vector], up: Vector) -> tuple[Vector, Vector] | None:
    """The level ways along the sides of the least box around places; None if they are round or few, seen from above."""
    boxes = []
    if len(places) < _FEWEST:
        return None
    for step in range(_TURNS):
        angle = 0.5 * math.pi * step / _TURNS
        one: Vector = (math.cos(angle), math.sin(angle), 0.0)
        other = cross(up, one)
        sizes = [high - low for low, high in (_find_ends(places, one), _find_ends(places, other))]
        boxes.append((sizes[0] * sizes[1], one, other))
    least, most = min(boxes), max(boxes)
    return least[1:] if most[0] > _SQUARE * least[0] else None
