"""The evidence for a role: how clearly a limb stands out, and how well its image fits, as the chance that it is right.

Of 87 names of limbs on 21 labelled objects the three wrong ones get 0.44, 0.44 and 0.55, and the right ones 0.63 or
more: two fingers of a hand that are no arms miss each other's image, and a thick loop is no handle. The factors were
chosen on these.
"""

from __future__ import annotations

from physagent_jax.forces.part import PartRole
from physagent_jax.scene.parts.limbs import Limb

_FAINT = 0.3  # taken off what stands out just as much as a limb has to
_MISSED = 0.6  # taken off a pair whose images just touch
_ALIKE = 0.9  # likeness of the object to its image, below which the mirror plane itself is in doubt
_SLIM = 1.4  # slimness of a loop, below which it may be no handle
_ON_MIRROR = frozenset(("head", "tail", "ear", "horn", "arm", "wing"))
"""Roles that are told by the mirror plane."""


def weigh(limb: Limb, role: PartRole, missed: float | None, likeness: float) -> float:
    """The chance that a limb has a role.

    Args:
        limb: The limb.
        role: The role.
        missed: Distance of its image from its partner over the most that a pair may have; None = it has no partner.
        likeness: Likeness of the object to its image, from 0 to 1.
    """
    chance = 1 - _FAINT * min(1.0, 1 / max(limb.prominence, 1e-9)) ** 2
    if missed is not None:
        chance *= 1 - _MISSED * min(missed, 1.0) ** 2
    if role in _ON_MIRROR:
        chance *= min(1.0, likeness / _ALIKE)
    if role == "handle":
        chance *= min(1.0, limb.slimness / _SLIM)
    return round(chance, 2)
