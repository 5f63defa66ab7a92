"""Swaying and bending of objects where they stand: the foot stays, and the rest bends over it.

Pushes cannot do this for every object: what is stiff slides instead, what stands on thin ankles breaks down under its
own weight, and pushes in time with it swing it farther each time. So the bending is prescribed, as a limb's is. What
rocks does not bend: it is tilted over the edges of its foot, to either side.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import Bend, CellsRegion, VelocityConstraint
from physagent_jax.motion.schema import Amount, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import add, cross, dot, norm, normalise, scale
from physagent_jax.motion.windows import SPRING, Window, list_springs

_FOOT = 0.1  # of its height, that stays
_LOW, _HIGH = ((0.5, 0.5, 0.0),), ((0.5, 0.5, 2 * _FOOT),)  # the plane between them is where the foot ends
_ANGLE = 16.0  # [degrees] that its top turns by to either side with a strength of 1
_DEPTH, _CURVED = 0.2, 0.5  # [body lengths] over which it sways, and is bent, over its foot
_BENT, _FARTHEST = 45.0, 75.0  # [degrees] that a bend of strength 1, and of any, turns its top by
_MOST = 120.0  # [degrees] that a quantity may tell
_TIME = 1.0  # [s] in which it is bent, at most
_TILT = 14.0  # [degrees] that it rocks by to either side with a strength of 1
_SHAKEN = 0.12  # [body lengths] that it is shaken by to either side with a strength of 1
_MILD = 0.5  # power of a strength that an angle to either side grows with: what is gentle is seen as well
_WALKED, _STEP = 0.9, 0.04  # [body lengths] that it walks, and rises at each step, with a strength of 1
_SETTLED = 0.2  # [s] for which it is kept upright where it has stopped rocking
_NEAR = 0.7  # cosine to a way, from which on an edge of the foot is tipped over instead
_REACH = 2.0  # [body lengths]: all of its foot borders on the rest
_LEVEL = 0.7  # cosine to the vertical below which a way leads aside
_FOLDED, _UPRIGHT_FOLD = (
    172.0,
    150.0,
)  # [degrees] that one half turns by onto the other: of what lies, and stands
_CREASE = 0.15  # [body lengths] over which it is bent there
HALF = "one half"  # the name of what bends about its middle
FOOT = CellsRegion(inside=_LOW, outside=_HIGH, label="its foot")


def bends(motion: ExpectedMotion) -> bool:
    """Return whether a motion of the whole is one over its foot, by its manner: what is shaken may slide as well."""
    kinds = (MotionKind.MOVE, MotionKind.SWAY)
    return motion.kind in kinds and motion.manner in ("bend", "rock", "wobble")


def leads_aside(way: Vector | None, brief: SceneBrief) -> bool:
    """Return whether a way (unit world vector) is one to sway; None = any is."""
    return way is None or abs(dot(way, brief.directions.up)) < _LEVEL


def sway(
    brief: SceneBrief, way: Vector, strength: float, count: int, window: Window
) -> list[VelocityConstraint]:
    """The turns of what stands over its foot, to either side and back to where it was.

    It is kept there for a moment: let go with the speed of its last stroke, what is soft would be flung over.

    Args:
        brief: The scene.
        way: Where its top goes first (unit world vector), level.
        strength: Factor on the angle.
        count: How often it goes to and fro.
        window: First and last frame.
    """
    strokes, rest = [1.0, *[-2.0, 2.0] * (count - 1), -2.0, 1.0], brief.count_frames(_SETTLED)
    end = max(window[1] - rest, 0.5 * (window[0] + window[1]))  # it rests before the next motion
    stops = [*[None] * (len(strokes) - 1), window[1]]
    return [
        turn
        for stroke, span, stop in zip(strokes, _divide((window[0], end), strokes), stops)
        for turn in _turn(
            brief, [make_upper(brief)], way, stroke * strength**_MILD * _ANGLE, span, stop, _DEPTH
        )
    ]


def bend(
    brief: SceneBrief, way: Vector, strength: float, amount: Amount | None, window: Window, released: bool
) -> list[VelocityConstraint]:
    """The turns by which something bends evenly, and swings back: of what stands over its foot, or of both its ends.

    By itself something would hardly come back in a clip whose crown is heavy and whose stem is thin.

    Args:
        brief: The scene.
        way: Where its top or its ends go (unit world vector).
        strength: Factor on the angle, unless that is told.
        amount: Quantity that the sentence tells, or None.
        window: First and last frame in which it is bent and kept bent.
        released: Whether it then springs back, as far as there is time.
    """
    told = amount is not None and amount.unit == "degrees"
    angle = min(amount.value, _MOST) if amount and told else min(_BENT * strength, _FARTHEST)
    bodies = [_make_half(brief, 1.0), _make_half(brief, -1.0)] if lies(brief) else [make_upper(brief)]
    angle = angle / len(bodies) if told else angle
    end = min(window[1], window[0] + max(brief.count_frames(_TIME), 2.0))
    last, swings = float(brief.last), [(1.0, (window[0], end), window[1])]
    back = list_springs(window[1], last, brief.count_frames(SPRING)) if released else []
    swings += [(share, span, last if span is back[-1][1] else 0.0) for share, span in back]
    return [
        turn
        for share, span, stop in swings
        for turn in _turn(
            brief,
            bodies,
            way,
            share * angle,
            span,
            stop if stop > span[1] else None,
            _CURVED,
            not lies(brief),
        )
    ]


def find_fold(brief: SceneBrief) -> Part:
    """The half of something that is laid onto the other: the far end of what lies, the upper half of what stands.

    It turns about the face that comes to lie inside.
    """
    long, table = brief.long_axis, brief.directions
    if long is not None and abs(dot(long, table.up)) > _LEVEL:
        half, inside = _make_half(brief, 1.0 if dot(long, table.up) > 0 else -1.0), scale(table.toward, 0.3)
    else:
        level = table.right if long is None else long
        flat = brief.model_copy(update=dict(long_axis=level))
        half, inside = _make_half(flat, 1.0 if dot(level, table.right) > 0 else -1.0), scale(table.up, 0.5)
    return half.model_copy(update=dict(joint=add((half.joint, inside))))


def fold(brief: SceneBrief, window: Window) -> tuple[list[VelocityConstraint], Vector]:
    """The turn of one half onto the other, where it is held, and the way in which its end goes (unit vector)."""
    half, table = find_fold(brief), brief.directions
    stands = abs(dot(half.arm, table.up)) > _LEVEL
    way, angle = (table.toward, _UPRIGHT_FOLD) if stands else (table.up, _FOLDED)
    end = min(window[1], window[0] + max(brief.count_frames(1.5 * _TIME), 2.0))
    turns = _turn(brief, [half], way, angle, (window[0], end), float(brief.last), _CREASE)
    return turns, scale(half.arm, -1.0)


def lies(brief: SceneBrief) -> bool:
    """Return whether it is longest along a level line and nothing holds it: its ends are bent, and no top is."""
    long = brief.long_axis
    return long is not None and abs(dot(long, brief.directions.up)) < _LEVEL and brief.anchored is None


def stands_slim(brief: SceneBrief) -> bool:
    """Return whether it is longest upright."""
    long = brief.long_axis
    return long is not None and abs(dot(long, brief.directions.up)) >= _LEVEL


def find_bend(way: Vector, brief: SceneBrief, rooted: bool) -> Vector | None:
    """The way in which it bends (unit vector), or None: ends that cannot go along themselves go up.

    Args:
        way: As told.
        brief: The scene.
        rooted: Whether its foot is held.
    """
    up, long = dot(way, brief.directions.up), brief.long_axis
    if lies(brief) and long is not None:
        ahead = abs(dot(way, long)) > _LEVEL
        return None if up < -_LEVEL else brief.directions.up if ahead else way
    return way if rooted and abs(up) < _LEVEL else None


def find_tipping_way(way: Vector, brief: SceneBrief) -> Vector:
    """The way in which it tips when its top is to go a way: over the nearest edge of its foot, and over no corner.

    Over a corner, it would go on over the next edge. A way far from all edges stays as it is.
    """
    nearest = max((edge.way for edge in brief.edges), key=lambda each: dot(each, way), default=way)
    return nearest if dot(nearest, way) >= _NEAR else way


def rock(
    brief: SceneBrief, way: Vector, strength: float, count: int, window: Window
) -> list[VelocityConstraint]:
    """The tilts of what stands over the edges of its foot, to either side and back to where it was; as `sway`."""
    strokes = [1.0, -1.0, -1.0, 1.0] * count
    axis = normalise(cross(brief.directions.up, find_tipping_way(way, brief)))
    assert axis is not None  # the way is level
    driver = PartDriver(make_upper(brief), brief.frame_dt, brief.frame_count, held=False)
    end = max(window[1] - brief.count_frames(_SETTLED), 0.5 * (window[0] + window[1]))
    spans = _divide((window[0], end), strokes)
    made = [driver.turn(axis, s * strength**_MILD * _TILT, span, None) for s, span in zip(strokes, spans)]
    made[-1] = made[-1].model_copy(update=dict(held_until=window[1] if window[1] > end else None))
    return [each.model_copy(update=dict(region=None, pivot=None)) for each in made]


def shake(
    brief: SceneBrief, way: Vector, strength: float, count: int, window: Window, kept: bool
) -> list[VelocityConstraint]:
    """The strokes of what is shaken as by a hand, foot and all, to either side and back; as `sway`.

    Args:
        brief: The scene.
        way: Where it goes first (unit world vector).
        strength: Factor on the way.
        count: How often it goes to and fro.
        window: First and last frame.
        kept: Whether it is kept up afterwards.
    """
    strokes = [1.0, *[-2.0, 2.0] * (count - 1), -2.0, 1.0]
    driver = PartDriver(make_upper(brief), brief.frame_dt, brief.frame_count, held=False)
    reach, last, rest = _SHAKEN * strength, float(brief.last), brief.count_frames(_SETTLED)
    end = max(window[1] - rest, 0.5 * (window[0] + window[1]))  # it rests before the next motion
    spans = _divide((window[0], end), strokes)
    made = [driver.shift(way, reach * s, span, None) for s, span in zip(strokes, spans)]
    stop = last if kept else min(end + rest, last)
    made[-1] = made[-1].model_copy(update=dict(held_until=stop if stop > end else None))
    return [each.model_copy(update=dict(region=None)) for each in made]


def walk(
    brief: SceneBrief, way: Vector, strength: float, count: int, window: Window, lengths: float | None
) -> list[VelocityConstraint]:
    """The steps of what goes on its feet: at each it rises a little and comes down again, and stands at last.

    Args:
        brief: The scene.
        way: Where it goes (unit world vector).
        strength: Factor on the distance and the rise.
        count: Number of steps.
        window: First and last frame.
        lengths: Distance that the sentence tells [body lengths], or None.
    """
    driver = PartDriver(make_upper(brief), brief.frame_dt, brief.frame_count, held=False)
    step = (lengths or _WALKED * strength) / (2 * count)
    end = max(window[1] - brief.count_frames(_SETTLED), 0.5 * (window[0] + window[1]))
    shifts = [
        add((scale(way, step), scale(brief.directions.up, sign * _STEP * strength**2)))
        for sign in (1.0, -1.0) * count
    ]
    made = [
        driver.shift(normalise(shift) or way, norm(shift), span, None)
        for shift, span in zip(shifts, _divide((window[0], end), [1.0] * len(shifts)))
    ]
    made[-1] = made[-1].model_copy(update=dict(held_until=window[1]))
    return [each.model_copy(update=dict(region=None)) for each in made]


def _divide(window: Window, strokes: Sequence[float]) -> list[Window]:
    """The window of each stroke, as long as its size needs."""
    ends = list(itertools.accumulate([0.0, *map(abs, strokes)]))
    edges = [window[0] + (window[1] - window[0]) * each / ends[-1] for each in ends]
    return list(itertools.pairwise(edges))


def make_upper(brief: SceneBrief) -> Part:
    """All but its foot, which turns about that."""
    upper = CellsRegion(inside=_HIGH, outside=_LOW, label="all but its foot")
    up = brief.directions.up
    return Part(moved=upper, rest=FOOT, joint=(0.5, 0.5, _FOOT), arm=up, side=up, share=1.0)


def _make_half(brief: SceneBrief, side: float) -> Part:
    """One half of what lies, on a side of its middle."""
    long = scale(brief.long_axis or brief.directions.right, side)
    here, there = (add(((0.5, 0.5, 0.5), scale(long, sign))) for sign in (0.25, -0.25))
    half, rest = (
        CellsRegion(inside=(a,), outside=(b,), label=HALF) for a, b in ((here, there), (there, here))
    )
    return Part(moved=half, rest=rest, joint=(0.5, 0.5, 0.5), arm=long, side=long, share=0.5)


def _turn(
    brief: SceneBrief,
    bodies: Sequence[Part],
    way: Vector,
    angle: float,
    window: Window,
    stop: float | None,
    depth: float,
    held: bool = True,
) -> list[VelocityConstraint]:
    """Bodies turned so that their tips go a way, by an angle [degrees], bending over ``depth``; ``held`` as it is."""
    made = []
    for body in bodies:
        axis = normalise(cross(body.arm, way))
        assert axis is not None  # the way leads across
        driver = PartDriver(body, brief.frame_dt, brief.frame_count, held=held)
        turn = driver.turn(axis, angle, window, stop if stop is not None and stop > window[1] else None)
        place = Bend(joint=body.joint, rest=body.rest, reach=_REACH, depth=depth)
        made.append(turn.model_copy(update=dict(bend=place)))
    return made
