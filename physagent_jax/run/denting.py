"""Dents: a piece that is pressed into the rest takes along what lies around it.

A roof or a hood is a piece of its own in the file. Pressed alone it would sink into the car and leave a hole.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import Bend, CellsRegion, ConstraintType, VelocityConstraint
from physagent_jax.motion.schema import AnchorRequest, ExpectedMotion, MotionKind
from physagent_jax.scene.body import Body

REACH = 0.12  # [body lengths] around the piece that give way with it
DEPTH = 0.1  # [body lengths] that a plain word presses it in by, at least
_DOWN = -0.7  # vertical component below which a way presses what lies on top
_MOST_SEEDS = 256  # of a region
_NOTE = "'{}': what lies around that part gives way with it."


def dent(reply: SemanticReply, body: Body, part: Part, frame_dt: float) -> SemanticReply:
    """The reply in which a piece of the file that is pressed down dents what lies around it; as it is for others.

    Args:
        reply: A semantic agent's, in which that part alone moves.
        body: The object at rest.
        part: What moves.
        frame_dt: Seconds per frame [s].
    """
    made, field = reply.force_field.constraints, reply.force_field
    pressed = [each for each in made if _presses(each) and reply.anchor.kind == "rest"]
    moved = [each for each in reply.expectations if each.kind is MotionKind.MOVE]
    if part.origin != "file" or part.moved.rigid or len(pressed) != len(made) or not pressed or not moved:
        return reply
    near, far = _divide(part, body)
    if not len(near) or not len(far):
        return reply
    inside, around = (tuple(map(tuple, each)) for each in (far, (*part.moved.inside, *near)))
    rest = CellsRegion(inside=_thin(inside), outside=_thin(around))
    bend = Bend(joint=part.joint, rest=rest, reach=2.0, depth=REACH)
    deep = [_deepen(each, moved[0], part, body, frame_dt) for each in made]
    constraints = tuple(each.model_copy(update=dict(bend=bend)) for each in deep)
    return reply.model_copy(
        update=dict(
            force_field=field.model_copy(update=dict(constraints=constraints)),
            anchor=AnchorRequest(kind="rest", words=reply.anchor.words, region=rest),
            notes=(_NOTE.format(moved[0].words), *reply.notes),
        )
    )


def _presses(made: VelocityConstraint) -> bool:
    shifts = made.constraint_type is ConstraintType.PARTICLE_TRANSLATION and made.bend is None
    return shifts and made.vector[2] < _DOWN


def _divide(part: Part, body: Body) -> tuple[np.ndarray, np.ndarray]:
    """Seeds of the rest within `REACH` of the part, and beyond [bounding-box fractions], shapes (m, 3)."""
    size = np.ptp(body.particles.x, axis=0).astype(float)
    seeds = np.unique(np.array((*part.rest.inside, *part.moved.outside), float), axis=0)
    distance = KDTree(np.array(part.moved.inside) * size).query(seeds * size)[0]
    near = distance < REACH * size.max()
    return seeds[near], seeds[~near]


def _deepen(made: VelocityConstraint, motion: ExpectedMotion, part: Part, body: Body, frame_dt: float):
    """The constraint that goes at least `DEPTH` times the strength, unless the sentence tells how far."""
    if motion.amount is not None or made.active_time is None:
        return made
    size = np.ptp(body.particles.x, axis=0)  # a part goes by shares of the extent along its way
    length = DEPTH * motion.strength * float(size.max() / max(size[2], 1e-9))
    driver = PartDriver(part, frame_dt, 2)
    deep = driver.shift(made.vector, length, made.active_time, made.held_until)
    return max(made, deep, key=lambda each: abs(each.magnitude) * each.gain)


def _thin(seeds: tuple) -> tuple:
    """At most as many seeds as a region holds, evenly."""
    return seeds[:: -(-len(seeds) // _MOST_SEEDS)]
