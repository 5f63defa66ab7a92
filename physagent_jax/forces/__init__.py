"""The force field skill library.

`schema` is the agent-facing JSON and `calibration` what its magnitudes mean (no arrays, no jax); `skills` compiles it
into the acceleration terms of `terms`, which the simulator evaluates; `parameters` are its numbers as a pytree.
"""

from physagent_jax.forces.schema import Action as Action
from physagent_jax.forces.schema import ActionType as ActionType
from physagent_jax.forces.schema import ForceField as ForceField
