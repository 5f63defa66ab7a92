"""The parts of an object: what sticks out of it, found once, for sentences that name it.

`protrusions` cuts a particle cloud into a tree of what sticks out; `roles` says what each may be called.
"""

from physagent_jax.scene.parts.roles import find_parts as find_parts
