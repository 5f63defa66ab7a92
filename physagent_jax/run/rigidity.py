"""The choice of a rigid body for what is hard: matter that nobody would see deform needs no stress and no small steps.

Wood, plastic, ceramics and metal are 1e4 to 1e6 times as stiff as what a clip can afford to simulate (`scene.priors`),
so that soft stand-ins of them sag, crumple and bounce as rubber does. Where a sentence moves the object as a whole, its
shape is the one thing that does not change: it is then a rigid body, and steps are limited by its speed alone.
"""

from __future__ import annotations

import dataclasses

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.schema import Action, ConstraintType, VelocityConstraint
from physagent_jax.forces.skills import get_skill
from physagent_jax.motion.breaking import SHATTER
from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from physagent_jax.run.spec import MaterialChoice
from physagent_jax.scene import materials, priors
from physagent_jax.scene.config import Bearing, MaterialModel
from physagent_jax.scene.priors import PRIORS, UNKNOWN
from physagent_jax.scene.template import SceneTemplate

STIFFENED = 10.0
"""Factor on the stiffness of parts beyond which a kind's matter is no softer to look at, and slow to simulate."""
STEP = 4e-3
"""Longest substep of a rigid body [s]: at the speed of a fall from its own height it moves by less than half a cell."""
RIGID_NOTE = (
    "the object moves as a rigid body, as it is hard and nothing asks it to deform; `material.youngs_modulus` makes it "
    "deform"
)
"""The note for the user."""
TURNED_NOTE = (
    "the object moves as a rigid body: it is turned over onto what was not made to bear it, and nothing asks it to "
    "deform; `material.youngs_modulus` makes it deform"
)
"""The same of what is not hard."""
STIFF_NOTE = (
    "the object moves as a rigid body: parts of it would have to be {:.2g} times as stiff as its kind is to bear its "
    "weight, and nothing asks it to deform; `material.youngs_modulus` makes it deform"
)
"""The same of what is not hard."""
_AS_A_WHOLE = frozenset((MotionKind.MOVE, MotionKind.FALL, MotionKind.ROTATE, MotionKind.STILL))
_UPRIGHT = 0.9  # component of an axis about which nothing tips over
_LEVEL, _OVER = 0.5, 120.0  # the same, and [degrees], from which on it ends on another side
_FIRM = frozenset(("animal", "food", "toy", "robot", UNKNOWN))  # soft kinds that bear their own weight


def keeps_shape(reply: SemanticReply) -> bool:
    """Return whether a sentence moves the object as a whole, and nothing in it asks for another shape.

    A force field without expectations says nothing of that: it may be one of many that are compared. What leans,
    is not led and does not fall has to give a little, as sizes of forces are (`forces.scaling`).
    """
    field, falls = reply.force_field, any(each.kind is MotionKind.FALL for each in reply.expectations)
    led = any(each.constraint_type is ConstraintType.PARTICLE_ROTATION for each in field.constraints)
    entries = (*field.actions, *field.constraints)
    return bursts(reply) or (
        bool(reply.expectations)
        and all(_is_whole(each, falls or led) for each in reply.expectations)
        and not any(entry.region or _presses(entry) for entry in entries)
    )


def bursts(reply: SemanticReply) -> bool:
    """Return whether it goes to pieces, and is in one until then, whatever it is made of."""
    return any(each.constraint_type == SHATTER for each in reply.force_field.constraints)


def _presses(entry: Action | VelocityConstraint) -> bool:
    skill = get_skill(entry)
    return skill.quantity == "scale" or skill.deforms == "plates"


def _is_whole(motion: ExpectedMotion, falls: bool) -> bool:
    leans = (
        motion.kind is MotionKind.ROTATE
        and motion.direction is not None
        and abs(motion.direction[2]) < _UPRIGHT
        and not falls
    )
    named = motion.partial or motion.part is not None or motion.limb is not None
    shaken = motion.kind is MotionKind.SWAY and motion.manner in ("rock", "shake")
    struck = motion.kind is MotionKind.MOVE and motion.sudden  # or leaps
    once = motion.kind in _AS_A_WHOLE and (motion.repeats == 1 or struck)
    return (once or shaken) and not (named or leans)


def is_hard(choice: MaterialChoice, kind: str, said: str | None, reply: SemanticReply | None = None) -> bool:
    """Return whether the object's matter is hard, and nobody has chosen how stiff it is.

    What nobody knows anything of keeps its shape, unless it jiggles: soft, its thin parts go limp in a gust and a fall.

    Args:
        choice: The user's choice.
        kind: The object's kind.
        said: Kind or library entry that the sentence chooses; None = none.
        reply: What the sentence says; None = it is not read yet.
    """
    if _is_chosen(choice):
        return False
    if reply is not None and bursts(reply):
        return True
    if said is None and kind == UNKNOWN and reply is not None:
        return not any(each.jiggles for each in reply.expectations)
    if said is None or said in PRIORS:
        return priors.is_hard(said or kind)
    return materials.is_hard(materials.find_material(said).material)


def is_turned_over(choice: MaterialChoice, kind: str, said: str | None, reply: SemanticReply) -> bool:
    """Return whether it ends on another side, whose thin parts would buckle: a fish on the fin of its back.

    Args:
        choice: The user's choice.
        kind: The object's kind.
        said: As for `is_hard`.
        reply: What the sentence says.
    """
    over = any(
        each.kind is MotionKind.ROTATE
        and each.direction is not None
        and abs(each.direction[2]) < _LEVEL
        and each.amount is not None
        and each.amount.unit == "degrees"
        and _OVER < each.amount.value % 360.0 < 360.0 - _OVER
        for each in reply.expectations
    )
    return over and said is None and kind in _FIRM and not _is_chosen(choice)


def is_stiffened(choice: MaterialChoice, said: str | None, bearing: Bearing | None) -> bool:
    """Return whether parts had to be made so stiff to bear the weight that the object is as good as hard.

    Args:
        choice: The user's choice.
        said: As for `is_hard`.
        bearing: What was made stiffer.
    """
    return said is None and not _is_chosen(choice) and bearing is not None and bearing.most > STIFFENED


def _is_chosen(choice: MaterialChoice) -> bool:
    return choice.says_stiffness or choice.poissons_ratio is not None or choice.damping_ratio is not None


def make_rigid(template: SceneTemplate, restitution: float | None) -> SceneTemplate:
    """The template with its object as a rigid body of the same density, with a coefficient of restitution."""
    material = template.material.changed(
        model=MaterialModel.RIGID,
        restitution=restitution,
        reason=f"a rigid body, as nothing asks it to deform; {template.material.reason}",
    )
    timing = template.preset.timing
    if timing.substep_dt == "auto":
        timing = timing.model_copy(update=dict(substep_dt=STEP))
    preset = dataclasses.replace(template.preset, timing=timing)
    return dataclasses.replace(template, material=material, preset=preset, damping_ratio=0.0)
