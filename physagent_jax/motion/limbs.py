"""The part that a word means, of those that stick out."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import Part
from physagent_jax.motion.vectors import cosine, norm, normalise

_THERE = 0.2  # cosine to a side from which on a limb is on it
PLACES = ("top", "bottom", "side")
"""Roles that tell a part's place alone: a word for another part takes it where it is the only one there."""
LOOSE = frozenset((*PLACES, "lid", "knob"))
"""Roles of what may sit loose on the rest."""


def choose_parts(
    parts: Sequence[Part], roles: Sequence[str], side: Vector | None, plural: bool
) -> tuple[int, ...]:
    """Places of the parts that a word means.

    Args:
        parts: The object's parts.
        roles: Roles that the word may mean, likeliest first: the first that the object has is meant.
        side: Where the part is (world vector); None = not told. One part is chosen then.
        plural: Whether all of them are meant.

    Returns:
        Places in ``parts``, likeliest first; empty if there is none, or several of which only the place is known.
    """
    for role in roles:
        fitting = [index for index, each in enumerate(parts) if role in each.roles]
        fitting = [index for index in fitting if parts[index].name] or fitting  # what is named goes first
        nearness = {index: _find_nearness(parts[index], side) for index in fitting}
        fitting = [index for index in fitting if nearness[index] > _THERE]
        fitting.sort(key=lambda index: (-nearness[index], -parts[index].share))
        if role in PLACES and len(fitting) > 1 and not plural:
            continue
        if fitting:
            return tuple(fitting if plural else fitting[:1])
    return ()


def _find_nearness(part: Part, side: Vector | None) -> float:
    """Cosine between where a part is and a side, seen from above if that is level; 1 if no side is told."""
    if side is None or not norm(side):
        return 1.0
    level = abs(side[2]) < 1e-6 * norm(side)
    return cosine((part.side[0], part.side[1], 0.0 if level else part.side[2]), side)


def find_front(parts: Sequence[Part]) -> Vector | None:
    """The level way in which an animal looks: where its head is, seen from its middle; None if that is not known."""
    heads = [each for each in parts if "head" in each.roles[:1]]
    if len(heads) != 1 or sum("leg" in each.roles[:1] for each in parts) < 3:
        return None
    return normalise((heads[0].side[0], heads[0].side[1], 0.0))
