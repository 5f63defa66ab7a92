"""The skill library's description for authors of force fields: a text and a JSON schema.

Both are made from `forces.schema`, so that a change there reaches every agent.
"""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from typing import Any

from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ConstraintType, ForceField, VelocityConstraint

_MEANING = {
    ActionType.TRANSLATION: "a steady push along `vector`; at magnitude 1, over the whole clip and unopposed, it moves "
    "the object by its own longest extent",
    ActionType.SCALE: "a stretch along the axis `vector` (a squeeze with a negative magnitude), held while it acts",
    ActionType.IMPULSE: "a blow along `vector`, spread over `active_time`; at magnitude 1 and unopposed the object "
    "then travels its own longest extent in a clip's duration",
    ActionType.TORQUE: "a steady turn about the axis `vector` (right-hand rule) through the mass centre; at "
    "magnitude 1, over the whole clip and unopposed, it is a quarter turn",
}
_CONSTRAINTS = {
    ConstraintType.PARTICLE_TRANSLATION: "holds the region's particles at a velocity along `vector` while it acts; a "
    "stretch or squeeze is exactly two of them, on opposite ends and opposed",
    ConstraintType.PARTICLE_ROTATION: "turns the region's particles about the axis `vector` through their own centre; "
    "a twist is two of them, on opposite ends and opposed",
    ConstraintType.PARTICLE_IMPULSE: "adds a velocity along `vector` at once, when `active_time` begins",
    ConstraintType.MOVING_PLATE: "a plate at the object's side moves along `vector` into it; two opposed ones press it",
}


@dataclass(frozen=True)
class SkillDescription:
    """The skill library as an agent reads it.

    Attributes:
        text: What the entries of a force field mean, for a model's instructions.
        json_schema: JSON schema of `ForceField`, for structured output.
    """

    text: str
    json_schema: dict[str, Any]


@functools.cache
def describe_skills() -> SkillDescription:
    """The library's own description."""
    actions = [f"- `{kind.value}`: {_MEANING[kind]}." for kind in ActionType]
    constraints = [f"- `{kind.value}`: {_CONSTRAINTS[kind]}." for kind in ConstraintType]
    text = "\n".join(
        [
            "A force field is JSON. `default_drop` says whether gravity acts and the object falls; if not, it floats "
            "at rest.",
            "`actions` act together or one after another. Each has an `action_type`:",
            *actions,
            f"`magnitude` lies between {MAGNITUDE_MIN} and {MAGNITUDE_MAX} in size, and its sign reverses the action. "
            "`vector` is a direction in world axes, of any length but zero. `active_time` is [first, last] in frames; "
            "without it the action lasts for the whole clip. `region` limits the action to a part, in fractions of "
            "the object's bounding box.",
            "`constraints` prescribe velocities instead of forces. Each has a `constraint_type`:",
            *constraints,
            f"Fields of an action: {_describe_fields(Action)}. "
            f"Of a constraint: {_describe_fields(VelocityConstraint)}. Other keys are refused.",
            f"An example: {_write_example()}",
        ]
    )
    return SkillDescription(text, ForceField.model_json_schema())


def _describe_fields(schema: type[Action] | type[VelocityConstraint]) -> str:
    return ", ".join(
        f"`{name}`{'' if field.is_required() else ' (optional)'}"
        for name, field in schema.model_fields.items()
    )


def _write_example() -> str:
    push = Action(action_type=ActionType.TRANSLATION, vector=(-1, 0, 0), magnitude=0.8, active_time=(0, 24))
    return json.dumps(ForceField(actions=(push,)).model_dump(mode="json", exclude_none=True))
