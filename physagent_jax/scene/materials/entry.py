"""One entry of the library."""

from __future__ import annotations

import dataclasses

from physagent_jax.scene.config.material import Material, MaterialModel


@dataclasses.dataclass(frozen=True)
class NamedMaterial:
    """A real material.

    Attributes:
        name: Key, in lower case with underscores.
        material: Its values in SI units; ``reason`` names the entry.
        what: Which kind of it, in a few words.
        source: Where the values stand.
        notes: Common ranges, what was derived and how, and what the model leaves out.
        aliases: Other names.
    """

    name: str
    material: Material
    what: str
    source: str
    notes: str
    aliases: tuple[str, ...] = ()


def make_entry(
    name: str,
    what: str,
    model: MaterialModel,
    *,
    source: str,
    notes: str,
    aliases: tuple[str, ...] = (),
    **values: float,
) -> NamedMaterial:
    """An entry; ``values`` are the fields of `Material`."""
    reason = f"library material '{name}': {what}; {source}"
    material = Material.model_validate({"model": model, "reason": reason, **values})
    return NamedMaterial(name, material, what, source, notes, aliases)
