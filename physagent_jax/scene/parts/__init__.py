"""The parts of an object: what sticks out of it, found once, for sentences that name it.

`lattice` makes a solid of the particles, `openings` finds what is thin and `protrusions` what is far from the rest,
`caps` what sits on a seam. `limbs` makes one tree of them, `roles` says what each may be called, and `marking` makes
data of them.
"""

from physagent_jax.scene.parts.marking import find_parts as find_parts
