"""Hinges: the edge at which a piece that opens and closes is joined to the rest, as a laptop's screen is.

Where it touches the rest tells it. What touches along a line at one end of itself turns about that line. What touches
it all around tells no line: a thin upright piece is a door and has its hinge at one side, a lid with corners has it at
the back. A round one, as a pot's lid is, has none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import Part, split_name
from physagent_jax.motion.doors import find_edge
from physagent_jax.motion.schema import Amount, ExpectedMotion, SceneBrief
from physagent_jax.motion.vectors import add, clamp, cosine, cross, dot, norm, normalise, scale, subtract

_NEAR = 0.06  # [body lengths] beyond the least distance, within which a piece touches the rest
_OFF = 0.25  # of its reach across the hinge, by which its middle is away from it at least
_LONG = 2.5  # length of a hinge over its breadth, at least
_STEPS = 20  # of the search for the direction of a hinge
_GAP = 4.0  # [degrees] that are left where it is closed
_OPENED, _FURTHER = 100.0, 30.0  # [degrees] by which it opens, and what stands open already
_STEEP = 0.5  # cosine to the way out, from which on the way from where it touches is how it stands
_OPEN = 45.0  # [degrees] to the rest from which on it stands open
_LEAST_OPENED = 0.35  # of that angle, at most so little where it opens slightly
_SLIDES = frozenset("drawer drawers curtain curtains".split())
_UNHINGED = _SLIDES.union("jaw mouth beak eye eyes".split())  # what opens in another way


@dataclass(frozen=True)
class Hinge:
    """The hinge of a piece.

    Attributes:
        joint: A point on it (bounding-box fractions).
        axis: Unit world vector about which it closes.
        angle: Angle between the piece and the rest [degrees].
    """

    joint: Vector
    axis: Vector
    angle: float

    def follow(self, lead: Hinge | None, axis: Vector | None) -> Vector:
        """The axis about which it opens where another hinge opens about an axis, or closes likewise."""
        opens = lead is not None and axis is not None and dot(axis, lead.axis) < 0
        return scale(self.axis, -1.0 if opens else 1.0)

    def find_angle(self, axis: Vector | None, strength: float = 1.0) -> float:
        """The angle by which it opens or closes about an axis, opens less with less strength [degrees]."""
        if axis is not None and dot(axis, self.axis) < 0:
            return (_FURTHER if self.angle > _OPEN else _OPENED) * clamp(strength, _LEAST_OPENED, 1.0)
        return max(self.angle - _GAP, _GAP)

    def swing(
        self, lead: Hinge | None, motion: ExpectedMotion, before: Sequence[ExpectedMotion]
    ) -> ExpectedMotion:
        """A motion with its axis and its angle: what was opened is closed by as much, and opened by as much again.

        Args:
            lead: The hinge that the motion's direction is told of; None = it has none.
            motion: The motion.
            before: Those of the same piece before it.
        """
        way = self.follow(lead, motion.direction)
        angles = [(e.direction or way, self.find_angle(e.direction, e.strength)) for e in before]
        turned = [angle for axis, angle in angles if dot(axis, way) < 0]
        opens = dot(way, self.axis) < 0
        likewise = [angle for axis, angle in angles if turned and opens and dot(axis, way) > 0]
        led = likewise or turned or [self.find_angle(way, motion.strength)]
        amount = motion.amount or Amount(value=led[-1], unit="degrees")
        loose = motion.amount is None and opens  # half open is open
        return motion.model_copy(update=dict(direction=way, amount=amount, may_stop_short=loose))


def find_hinge(part: Part, brief: SceneBrief) -> Hinge | None:
    """The hinge of a rigid piece of the object; None if nothing tells one."""
    if not part.moved.rigid or not _UNHINGED.isdisjoint(split_name(part.name)):
        return None
    box = find_box(brief)
    inside, outside, gaps = _find_gaps(part, box)
    found = _find_line_hinge(inside, outside, [a for a, _ in gaps])
    if found is None and (edge := find_edge(part, brief, inside, gaps, box)):
        found = Hinge(edge[0], scale(edge[1], -1.0), 0.0)
    if found is None:
        return None
    x, y, z = (a / b for a, b in zip(found.joint, box))
    return replace(found, joint=(x, y, z))


def slides_open(part: Part) -> bool:
    """Return whether a part is one that opens without a turn."""
    return not _SLIDES.isdisjoint(split_name(part.name))


def stand_up(part: Part, brief: SceneBrief) -> Part:
    """A part that sits on the rest, as what sways on it: its joint is where it touches that.

    What is broad and low touches it at one of its sides as well as below: it is stood up as far as it is high.
    """
    box = find_box(brief)
    inside, _, gaps = _find_gaps(part, box)
    base, middle, out = _average([here for here, _ in gaps]), _find_middle(inside), normalise(part.arm)
    if out is not None and cosine(subtract(middle, base), out) < _STEEP:
        base = subtract(middle, scale(out, dot(subtract(middle, base), out)))
    arm = scale(subtract(middle, base), 2.0)
    if norm(arm) < _OFF * max(math.dist(base, each) for each in inside):
        return part
    x, y, z = (a / b for a, b in zip(base, box))
    return part.model_copy(update=dict(joint=(x, y, z), arm=arm, seated=False))


def _find_gaps(part: Part, box: Vector) -> tuple[list[Vector], list[Vector], list[tuple[Vector, Vector]]]:
    """Places in a part, in the rest, and those of the part that touch the rest with what they touch [body lengths]."""
    inside, outside = (
        [_stretch(seed, box) for seed in seeds] for seeds in (part.moved.inside, part.moved.outside)
    )
    near = [(here, min(outside, key=lambda there: math.dist(here, there))) for here in inside]
    least = min(math.dist(here, there) for here, there in near) + _NEAR
    return inside, outside, [each for each in near if math.dist(*each) < least]


def _find_line_hinge(inside: list[Vector], outside: list[Vector], touching: list[Vector]) -> Hinge | None:
    """The hinge where a piece touches the rest in a line at one of its ends; its joint in body lengths."""
    place, middle, rest = _average(touching), _find_middle(inside), _find_middle(outside)
    line = _find_line(touching, place)
    if line is None:
        return None
    arm, other = (_reject(subtract(end, place), line) for end in (middle, rest))
    reach = max(norm(_reject(subtract(seed, place), line)) for seed in inside)
    axis = normalise(cross(arm, other))
    if norm(arm) < _OFF * reach or axis is None:
        return None
    angle = math.degrees(math.atan2(norm(cross(arm, other)), dot(arm, other)))
    return Hinge(place, scale(line, 1.0 if dot(line, axis) > 0 else -1.0), angle)


def find_hinged(brief: SceneBrief) -> tuple[int, ...]:
    """The place in the brief's parts of what opens and closes, where none is named: the highest with a hinge."""
    hinged = [index for index, part in enumerate(brief.parts) if find_hinge(part, brief)]
    return tuple(sorted(hinged, key=lambda index: -brief.parts[index].side[2])[:1])


def find_box(brief: SceneBrief) -> Vector:
    """The object's extents along the world's axes [body lengths]; where not measured, from those along the viewer's."""
    if brief.box is not None:
        return brief.box
    (width, height, depth), table = brief.extents, brief.directions
    c, s = (abs(each) for each in table.right[:2])
    if c + s < 0.5:  # another axis than z points up
        ways = zip((table.right, table.up, table.toward), brief.extents)
        x, y, z = zip(*(scale(way, extent) for way, extent in ways))
        return norm(x), norm(y), norm(z)
    if abs(c - s) < 0.1:
        return width / (c + s), depth / (c + s), height
    along = ((width * c - depth * s) / (c * c - s * s), (depth * c - width * s) / (c * c - s * s))
    return max(along[0], 0.05), max(along[1], 0.05), height


def _stretch(place: Vector, box: Vector) -> Vector:
    return place[0] * box[0], place[1] * box[1], place[2] * box[2]


def _average(places: list[Vector]) -> Vector:
    return scale(add(places), 1.0 / len(places))


def _find_middle(places: list[Vector]) -> Vector:
    """The middle of the box around places, which are denser where parts meet."""
    x, y, z = (0.5 * (min(along) + max(along)) for along in zip(*places))
    return x, y, z


def _reject(way: Vector, line: Vector) -> Vector:
    return subtract(way, scale(line, dot(way, line)))


def _find_line(places: list[Vector], middle: Vector) -> Vector | None:
    """The line along which places lie (unit vector); None if they are as broad as they are long."""
    ways = [subtract(place, middle) for place in places]
    line = normalise(max(ways, key=norm))
    for _ in range(_STEPS):  # towards the direction in which they are spread most
        line = line and normalise(add(scale(way, dot(way, line)) for way in ways))
    if line is None:
        return None
    broad = max(norm(_reject(way, line)) for way in ways)
    return line if max(abs(dot(way, line)) for way in ways) > _LONG * broad else None
