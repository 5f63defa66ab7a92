"""The skill library's description for authors of force fields: a text and a JSON schema.

Both are made from `forces.schema` and the registered skills, so that a change there reaches every agent.
"""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from typing import Any

from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ForceField, VelocityConstraint
from physagent_jax.forces.skills import Skill, list_skills


@dataclass(frozen=True)
class SkillDescription:
    """The skill library as an agent reads it.

    Attributes:
        text: What the entries of a force field mean, for a model's instructions.
        json_schema: JSON schema of `ForceField`, for structured output.
    """

    text: str
    json_schema: dict[str, Any]


def describe_skills() -> SkillDescription:
    """The library's own description."""
    return _describe(tuple(list_skills()))


@functools.cache
def _describe(skills: tuple[Skill, ...]) -> SkillDescription:
    actions, constraints = (
        [f"- `{skill.name}`: {skill.meaning}." for skill in skills if skill.group == group]
        for group in ("actions", "constraints")
    )
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


def describe_entry(skill: Action | VelocityConstraint) -> dict[str, str]:
    """Describe the fields of one entry of a force field in words."""
    name = "action_type" if isinstance(skill, Action) else "constraint_type"
    return {
        name: getattr(skill, name).value,
        "vector": _format(skill.vector),
        "magnitude": f"{skill.magnitude:g}",
        "active_time": _format(skill.active_time),
        "region": getattr(skill.region, "kind", ""),
    }


def _format(values: tuple[float, ...] | None) -> str:
    return "whole clip" if values is None else "[" + ", ".join(f"{round(v, 3):g}" for v in values) + "]"
