"""The parts of an object: what its file or a person names, and what sticks out of it; for sentences that name it.

`protrusions` cuts a particle cloud into a tree of what sticks out; `roles` says what each may be called. `named` finds
the particles of what is named, and `cells` makes a part of them.
"""

from physagent_jax.scene.parts.named import choose_parts as choose_parts
from physagent_jax.scene.parts.named import find_groups as find_groups
from physagent_jax.scene.parts.named import find_pieces as find_pieces
from physagent_jax.scene.parts.named import join_parts as join_parts
from physagent_jax.scene.parts.named import make_parts as make_parts
from physagent_jax.scene.parts.roles import find_parts as find_parts
