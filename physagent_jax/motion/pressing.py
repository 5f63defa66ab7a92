"""Places that are pressed in: the upper end of a part, where a blow dents what stands, where a hand or a finger hits.

What is soft quivers after a hand. Its own elasticity would show that of a tall jelly alone, so it is led to and fro.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import (
    GAIN_MAX,
    GAIN_MIN,
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    find_reference_time,
)
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import (
    Bend,
    BoxRegion,
    CellsRegion,
    ConstraintType,
    Region,
    VelocityConstraint,
)
from physagent_jax.forces.slabs import make_box
from physagent_jax.motion.schema import ExpectedMotion, SceneBrief
from physagent_jax.motion.swaying import make_upper
from physagent_jax.motion.vectors import add, clamp, cosine, cross, scale
from physagent_jax.motion.windows import Window, divide

_VERTICAL = 0.7  # cosine
_DENT = 0.35  # [box] twice as far as a dent reaches from its middle: up and down, to either side, inwards
_POKED = 0.2  # of the half that is poked, how deep with a strength of 1
_FINGER, _PALM = 0.24, 0.42  # [box] breadths of a finger and of a hand
_PLACE = "place that is poked"
LEAST_ROOM = 4.0  # frames of a poke, without which nothing of it is seen
_QUICK, _STAYS = 0.24, 0.04  # [s] in which a finger goes in, and for which it stays
_COMES = 0.2  # [s] in which it is seen to come
_QUIVERS = 0.08  # [body lengths] by which the top goes to either side at first, with a strength of 1
_FADES, _LASTS = 0.84, 1.7  # of that, which is left after each stroke, and [s] for which it quivers, at most
_STROKE = 0.12  # [s] that a stroke takes
_QUICKLY = 2.5  # [body lengths / s] at which its ends begin to quiver, with a strength of 1
_LIES = 0.5  # [s] in which what tips over has come down, after it has been let go
_RECOVERS = 0.2  # [s] after it has landed, in which it is pressed together
_AROUND = 2.0  # [body lengths]: all of its foot, and all of its height
_DEEP = 1.0  # of a squeeze's strain, by which a dent goes in: much of it is given way to


def find_pressed(
    motion: ExpectedMotion, brief: SceneBrief, region: Region | None, start: float
) -> tuple[Vector, Region, float] | None:
    """The way in which what stands is pressed in, the place, and the share of a squeeze; None if it is squeezed.

    Args:
        motion: The squeeze that is asked for.
        brief: The scene.
        region: The part that is named, if any.
        start: Fraction of the height beyond which a part's upper end is.
    """
    way, up = motion.direction, brief.directions.up
    if way is None or motion.excludes_part:
        return None
    if abs(cosine(way, up)) >= _VERTICAL:
        place = make_box(region)
        return None if place is None else (brief.directions.down, _make_upper_end(place, brief, start), 1.0)
    if not motion.sudden or motion.limb is not None or abs(cosine(way, up)) > 1 - _VERTICAL:
        return None
    return way, _make_dent(way, up), _DEEP


def poke(
    brief: SceneBrief,
    way: Vector,
    height: float,
    strength: float,
    count: int,
    window: Window,
    palm: bool = False,
    held: bool = False,
    quivers: bool = False,
) -> list[VelocityConstraint]:
    """The plates of a finger's size that dent what is soft, each going back as fast as it came.

    Args:
        brief: The scene.
        way: Where the finger goes (unit world vector).
        height: Where it goes in, as a fraction of the object's; what is poked from above is poked in its middle.
        strength: Factor on the depth.
        count: How often.
        window: First and last frame, with `LEAST_ROOM` for each.
        palm: Whether it is of a hand's size.
        held: Whether the object is held somewhere, which its depth goes by.
        quivers: Whether it then quivers.
    """
    breadth = _PALM if palm else _FINGER
    up = brief.directions.up
    across = cross(up, way) if abs(cosine(way, up)) < _VERTICAL else brief.directions.right
    middle = (0.5, 0.5, height if abs(cosine(way, up)) < _VERTICAL else 0.5)
    surface = add((middle, scale(way, -0.5)))
    beside = [scale(each, sign * breadth) for each in (across, cross(across, way)) for sign in (1.0, -1.0)]
    place = CellsRegion(
        inside=(surface,), outside=tuple(add((surface, each)) for each in (*beside, way)), label=_PLACE
    )
    part = Part(moved=place, rest=place, joint=surface, arm=way, side=scale(way, -1.0), share=1.0)
    driver = PartDriver(part, brief.frame_dt, brief.frame_count, held=held)
    room = (window[1] - window[0]) / count  # in which it also goes back
    quick, stays = min(brief.count_frames(_QUICK), 0.4 * room), min(brief.count_frames(_STAYS), 0.2 * room)
    comes = min(brief.count_frames(_COMES), 0.2 * room)
    spans = [(begin + comes, begin + comes + quick) for begin, _ in divide(window, [1.0] * count)]
    plates = [driver.press(way, _POKED * strength, span, span[1] + stays) for span in spans]
    made = [each.model_copy(update=dict(touched=True)) for each in plates]
    after = (find_end_of_poke(made, window), window[1])
    return [*made, *(quiver(brief, way, strength, after, held) if quivers else ())]


def quiver(
    brief: SceneBrief,
    way: Vector,
    strength: float,
    window: Window,
    held: bool = False,
) -> list[VelocityConstraint]:
    """The strokes to and fro, less and less, of what is soft and stands on its foot.

    Args:
        brief: The scene.
        way: Where it goes first (unit world vector); what was hit from above quivers sideways.
        strength: Factor on the way.
        window: First and last frame.
        held: Whether the object is held somewhere.
    """
    level = way if abs(cosine(way, brief.directions.up)) < _VERTICAL else brief.directions.right
    part = make_upper(brief)
    driver = PartDriver(part, brief.frame_dt, brief.frame_count, held=held)
    span = min(window[1] - window[0], brief.count_frames(_LASTS))
    count = max(round(span / brief.count_frames(_STROKE)), 4)
    frames, ends = span / count, [0.0, *((-_FADES) ** k for k in range(count - 1)), 0.0]
    place = Bend(joint=part.joint, rest=part.rest, reach=_AROUND, depth=min(brief.extents[1], _AROUND))
    made = [
        driver.shift(
            level,
            _QUIVERS * strength * (after - before),
            (window[0] + k * frames, window[0] + (k + 1) * frames),
            None,
        )
        for k, (before, after) in enumerate(pairwise(ends))
    ]
    return [each.model_copy(update=dict(bend=place)) for each in made]


def shake_itself(
    brief: SceneBrief, way: Vector, strength: float, window: Window, lies: bool = False
) -> list[VelocityConstraint]:
    """The quiver of what is soft as it has come down, less and less; none if there is no time for it.

    Args:
        brief: The scene.
        way: Where its upper end goes (unit world vector) as long as it stands.
        strength: Factor on the way.
        window: First and last frame.
        lies: Whether it has tipped over, and needs some time until it lies.
    """
    begin = window[0] + brief.count_frames(_LIES if lies else _RECOVERS)
    end = min(begin + brief.count_frames(_LASTS), window[1])
    if end - begin < 2 * brief.count_frames(_STROKE):
        return []
    across = way if abs(cosine(way, brief.directions.up)) < _VERTICAL else brief.directions.right
    size = clamp(strength, MAGNITUDE_MIN, MAGNITUDE_MAX)
    gain = _QUICKLY * find_reference_time(False, brief.seconds) * strength / size
    return [
        VelocityConstraint(
            constraint_type=ConstraintType("quiver"),
            vector=across,
            magnitude=round(size, 3),
            gain=round(clamp(gain, GAIN_MIN, GAIN_MAX), 3),
            active_time=(round(begin, 3), round(end, 3)),
        )
    ]


def find_end_of_poke(made: Sequence[VelocityConstraint], window: Window) -> float:
    """The frame at which a finger begins to go back in a window: later, what is top-heavy would have fallen over."""
    fingers = [e for e in made if isinstance(e.region, CellsRegion) and e.region.label == _PLACE]
    spans = [(each.active_time, each.held_until) for each in fingers]
    ends = [end for span, end in spans if span and end and window[0] <= span[0] < window[1]]
    return min(max([window[0], *ends]), 0.5 * (window[0] + window[1]))


def _make_upper_end(place: BoxRegion, brief: SceneBrief, start: float) -> BoxRegion:
    low, high = list(place.low), list(place.high)
    if 0 < low[2] < high[2] < 1:  # of what is pressed from above, the middle is not half-way up
        sides = [0] if brief.long_axis == (1, 0, 0) else [1] if brief.long_axis == (0, 1, 0) else [0, 1]
        for side in sides:
            low[side], high[side] = place.low[2], place.high[2]
    return BoxRegion(low=(low[0], low[1], start), high=(high[0], high[1], 1.0))


def _make_dent(way: Vector, up: Vector) -> CellsRegion:
    """The surface half-way up on the side that a blow comes from, not as wide as the object."""
    surface = add(((0.5, 0.5, 0.5), scale(way, -0.5)))
    around = [scale(each, sign * _DENT) for each in (up, cross(up, way)) for sign in (1.0, -1.0)]
    outside = tuple(add((surface, each)) for each in (*around, scale(way, _DENT)))
    return CellsRegion(inside=(surface,), outside=outside, label="place that is hit")
