"""Swaying of free objects where they stand: the foot stays, and the rest bends to and fro over it.

Pushes cannot do this for every object: what is stiff slides instead, what stands on thin ankles breaks down under its
own weight, and pushes in time with it swing it farther each time. So the bending is prescribed, as a limb's is.
"""

from __future__ import annotations

import itertools
import re

from physagent_jax.core.strict import Vector
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import Bend, CellsRegion, VelocityConstraint
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import cross, dot, normalise
from physagent_jax.motion.windows import Window

_FOOT = 0.1  # of its height, that stays
_LOW, _HIGH = ((0.5, 0.5, 0.0),), ((0.5, 0.5, 2 * _FOOT),)  # the plane between them is where the foot ends
_ANGLE = 16.0  # [degrees] that its top turns by to either side with a strength of 1
_DEPTH = 0.2  # [body lengths] over which it bends, over its foot
_REACH = 2.0  # [body lengths]: all of its foot borders on the rest
_LEVEL = 0.7  # cosine to the vertical below which a way leads aside
_BENDS = re.compile(r"\b(bend|bent|bow|lean|droop|sway|rock|wobbl|jiggl|teeter|totter)")
FOOT = CellsRegion(inside=_LOW, outside=_HIGH, label="its foot")


def bends(motion: ExpectedMotion) -> bool:
    """Return whether a motion of the whole is one over its foot, by its verb: what is shaken may slide as well."""
    kinds = (MotionKind.MOVE, MotionKind.SWAY)
    return motion.kind in kinds and _BENDS.search(motion.words.lower()) is not None


def leads_aside(way: Vector | None, brief: SceneBrief) -> bool:
    """Return whether a way (unit world vector) is one to sway; None = any is."""
    return way is None or abs(dot(way, brief.directions.up)) < _LEVEL


def sway(
    brief: SceneBrief, way: Vector, strength: float, count: int, window: Window
) -> list[VelocityConstraint]:
    """The turns of what stands over its foot, to either side and back to where it was.

    Args:
        brief: The scene.
        way: Where its top goes first (unit world vector), level.
        strength: Factor on the angle.
        count: How often it goes to and fro.
        window: First and last frame.
    """
    axis = normalise(cross(brief.directions.up, way))
    assert axis is not None  # the way is level
    joint = (0.5, 0.5, _FOOT)
    upper = CellsRegion(inside=_HIGH, outside=_LOW, label="all but its foot")
    body = Part(
        moved=upper, rest=FOOT, joint=joint, arm=brief.directions.up, side=brief.directions.up, share=1.0
    )
    driver = PartDriver(body, brief.frame_dt, brief.frame_count)
    strokes = [1.0, *[-2.0, 2.0] * (count - 1), -2.0, 1.0]
    ends = list(itertools.accumulate([0.0, *map(abs, strokes)]))
    edges = [window[0] + (window[1] - window[0]) * each / ends[-1] for each in ends]
    bend = Bend(joint=joint, rest=FOOT, reach=_REACH, depth=_DEPTH)
    return [
        driver.turn(axis, stroke * strength * _ANGLE, span, None).model_copy(update=dict(bend=bend))
        for stroke, span in zip(strokes, itertools.pairwise(edges))
    ]
