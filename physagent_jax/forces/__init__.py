"""The force field skill library.

`schema` is the agent-facing JSON, `skills` has an object for each skill and `calibration` is what magnitudes mean (no
arrays, no jax); `compilation` turns a force field into the terms of `terms`, which the simulator evaluates, by the
scale factors of `scaling`; `parameters` are its numbers as a pytree.
"""

from physagent_jax.forces.schema import Action as Action
from physagent_jax.forces.schema import ActionType as ActionType
from physagent_jax.forces.schema import ForceField as ForceField
from physagent_jax.forces.skills import Skill as Skill
from physagent_jax.forces.skills import register_skill as register_skill
