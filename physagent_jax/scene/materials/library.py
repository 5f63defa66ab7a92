"""The library by name."""

from __future__ import annotations

import re

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import find_nearest
from physagent_jax.scene.materials.entry import NamedMaterial
from physagent_jax.scene.materials.granular import GRANULAR
from physagent_jax.scene.materials.hard import HARD
from physagent_jax.scene.materials.liquids import LIQUIDS
from physagent_jax.scene.materials.soft import SOFT

LIBRARY: dict[str, NamedMaterial] = {each.name: each for each in (*HARD, *SOFT, *GRANULAR, *LIQUIDS)}
_BY_ALIAS = {alias: each for each in LIBRARY.values() for alias in each.aliases}


def find_material(name: str) -> NamedMaterial:
    """The entry of a name or alias; case, spaces and hyphens do not matter.

    Raises:
        UserError: There is none; lists what comes close.
    """
    key = re.sub(r"[\s\-_]+", "_", name.strip().lower())
    found = LIBRARY.get(key) or _BY_ALIAS.get(key)
    if found is not None:
        return found
    close = find_nearest(key, [*LIBRARY, *_BY_ALIAS], count=4)
    close += [known for known in (*LIBRARY, *_BY_ALIAS) if key and key in known and known not in close]
    hint = f"Close: {', '.join(close[:6])}. " if close else ""
    raise UserError(
        "there is no such material in the library",
        got=repr(name)[:80],
        do=f"{hint}`physagent materials` lists them",
    )
