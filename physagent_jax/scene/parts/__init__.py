"""The parts of an object: what its file or a person names, and what sticks out of it; for sentences that name it.

`lattice` makes a solid of the particles, `openings` finds what is thin and `protrusions` what is far from the rest,
`caps` what sits on a seam. `limbs` makes one tree of them, `roles` says what each may be called and `digits` which are
fingers; `evidence` weighs that. `ends` finds toes, tips, handles and stems, which do not stick out. `marking` makes
data of all of them. `named` finds the particles of what is named, `places` those of a region that has a word for its
place, and `cells` makes a part of them. `branches` joins pieces that are numbered, or sections of a limb. `figures`
looks at what stands on a base by itself. `guesses` takes the likeliest limb for a word that is none of these for
certain, or the likeliest of the surfaces that a mesh is built of (`shells`), by their `looks`, and `tools` those of a
blade and a handle. `aliases` gives parts the names that a sentence has for them. `store` keeps what was found on disk.
"""

from physagent_jax.scene.parts.aliases import find_aliases as find_aliases
from physagent_jax.scene.parts.aliases import list_wholes as list_wholes
from physagent_jax.scene.parts.branches import branch_numbered as branch_numbered
from physagent_jax.scene.parts.branches import join_chains as join_chains
from physagent_jax.scene.parts.coloured import find_coloured as find_coloured
from physagent_jax.scene.parts.coloured import list_hues as list_hues
from physagent_jax.scene.parts.guesses import guess_parts as guess_parts
from physagent_jax.scene.parts.marking import find_parts as find_parts
from physagent_jax.scene.parts.named import choose_parts as choose_parts
from physagent_jax.scene.parts.named import find_groups as find_groups
from physagent_jax.scene.parts.named import find_pieces as find_pieces
from physagent_jax.scene.parts.named import join_parts as join_parts
from physagent_jax.scene.parts.named import make_parts as make_parts
from physagent_jax.scene.parts.places import find_places as find_places
from physagent_jax.scene.parts.regions import Frame as Frame
from physagent_jax.scene.parts.shells import Shells as Shells
from physagent_jax.scene.parts.shells import find_shells as find_shells
