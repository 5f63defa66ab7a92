"""The Force Field Skill Library: one object per skill (paper, appendix A.2).

A skill says everything about itself: its name in the JSON, its meaning for a model, its k, its forces or constraints,
the motion that it causes, its words, its icon. To add one, write its module and name it at the end of this one.
Skills hold no arrays and import none until they make forces.

With L the object's longest extent, E and rho its mean stiffness and density and T the clip's duration, a magnitude of
M = 1 gives what `forces.calibration` says; the formula of each k is in its skill's docstring, its value in SI units in
`forces.scaling`. Forces are per unit mass: filling density and particle count do not change the motion (the paper's
impulse divides by particle mass).
"""

from __future__ import annotations

from physagent_jax.forces.names import ActionType, ConstraintType, SkillName
from physagent_jax.forces.schema import Action, VelocityConstraint
from physagent_jax.forces.skills.base import Skill as Skill
from physagent_jax.forces.skills.impulse import STEEP as STEEP
from physagent_jax.forces.skills.impulse import Impulse
from physagent_jax.forces.skills.moving_plate import MovingPlate
from physagent_jax.forces.skills.particle_impulse import ParticleImpulse
from physagent_jax.forces.skills.particle_rotation import ParticleRotation
from physagent_jax.forces.skills.particle_translation import ParticleTranslation
from physagent_jax.forces.skills.quiver import Quiver
from physagent_jax.forces.skills.scale import Scale
from physagent_jax.forces.skills.shatter import Shatter
from physagent_jax.forces.skills.torque import Torque
from physagent_jax.forces.skills.translation import Translation
from physagent_jax.forces.skills.vortex import Vortex
from physagent_jax.forces.skills.wind_gust import WindGust

_NAMES: dict[str, type[SkillName]] = {"actions": ActionType, "constraints": ConstraintType}


def register_skill(skill: Skill) -> None:
    """Make a skill known to the schema, agents, simulation, report and search methods.

    Raises:
        ValueError: There is a skill of this name.
    """
    if any(skill.name in names.known for names in _NAMES.values()):
        raise ValueError(f"there is a skill {skill.name!r} already")
    _NAMES[skill.group].add(skill.name, skill)


def unregister_skill(name: str) -> None:
    """Take a skill away again."""
    _NAMES[find_skill(name).group].remove(name)


def list_skills(group: str | None = None) -> list[Skill]:
    """Registered skills, in order.

    Args:
        group: "actions" or "constraints"; None = both.
    """
    return [name.skill for key, names in _NAMES.items() if group in (None, key) for name in names]


def find_skill(name: str) -> Skill:
    """The skill of a name.

    Raises:
        KeyError: There is none.
    """
    for names in _NAMES.values():
        if name in names.known:
            return names.known[name].skill
    raise KeyError(f"there is no skill {name!r}")


def get_skill(entry: Action | VelocityConstraint) -> Skill:
    """The skill of an entry of a force field."""
    name = entry.action_type if isinstance(entry, Action) else entry.constraint_type
    return name.skill


for _skill in (
    Translation(),
    Scale(),
    Impulse(),
    Torque(),
    Vortex(),
    WindGust(),
    ParticleTranslation(),
    ParticleRotation(),
    ParticleImpulse(),
    MovingPlate(),
    Quiver(),
    Shatter(),
):
    register_skill(_skill)
