"""The fingers and the thumb of a hand: slim limbs of one palm that spread like a fan.

The thumb is the one that stands clearly farther from its neighbour than any other finger. The others are counted from
it. Where none stands apart, as in a glove with its fingers together, no thumb is named.
"""

from __future__ import annotations

import numpy as np

from physagent_jax.forces.part import PartRole
from physagent_jax.scene.parts.limbs import Limb

_FEWEST, _MOST = 4, 6  # digits of a hand
_SLIM = 3.0  # length over the radius of gyration of the neck, at least
_FAN = 0.5  # cosine between a digit and the mean of all, at least
_LIKE = 3.0  # ratio of the longest to the shortest, at most
_APART = 1.3  # gap at the thumb over the largest gap elsewhere
_FINGERS: tuple[PartRole, ...] = ("forefinger", "middlefinger", "ringfinger", "littlefinger")


def name_digits(
    limbs: list[Limb], roles: dict[int, tuple[PartRole, ...]], mirrored: frozenset[int]
) -> dict[int, tuple[PartRole, ...]]:
    """The roles with those of fingers and thumbs.

    A hand by itself has no other parts than its digits. On a figure with legs they are parts of its arms.

    Args:
        limbs: All limbs of the object.
        roles: Roles by place of the limb.
        mirrored: Limbs of an object that is its own image whose images are limbs too.
    """
    legs = {k for k, names in roles.items() if "leg" in names}
    if any("spike" in names for names in roles.values()):
        return roles
    found: dict[int, tuple[PartRole, ...]] = {}
    outer = [k for k, limb in enumerate(limbs) if limb.parent is None and k not in legs]
    for group in [[k] for k in outer] if legs else [outer]:
        leaves = [leaf for k in group for leaf in _list_leaves(limbs, k)]
        if _is_fan(leaves, limbs) and not mirrored.issuperset(leaves):  # a hand has one thumb
            found |= _order(leaves, limbs)
    if legs:
        return roles | {k: (*roles.get(k, ()), *names) for k, names in found.items()}
    return found or roles


def _list_leaves(limbs: list[Limb], root: int) -> list[int]:
    """Limbs without limbs inside them, within one limb or that one itself."""
    return [leaf for child in limbs[root].children for leaf in _list_leaves(limbs, child)] or [root]


def _is_fan(leaves: list[int], limbs: list[Limb]) -> bool:
    """Return whether limbs are slim, about as long, and point about the same way."""
    if not _FEWEST <= len(leaves) <= _MOST:
        return False
    told = [limbs[k] for k in leaves]
    lengths = [each.length for each in told]
    ways = np.array([each.tip - each.joint for each in told])
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12)
    mean = ways.mean(0) / max(float(np.linalg.norm(ways.mean(0))), 1e-12)
    slim = all(each.length > _SLIM * each.width and not each.loop for each in told)
    return slim and max(lengths) < _LIKE * min(lengths) and bool((ways @ mean > _FAN).all())


def _order(leaves: list[int], limbs: list[Limb]) -> dict[int, tuple[PartRole, ...]]:
    """Fingers in their order from the thumb; without a thumb they are fingers alone."""
    tips = np.array([limbs[k].tip for k in leaves])
    between = np.linalg.norm(tips[:, None] - tips[None], axis=2)
    gaps = np.where(np.eye(len(leaves)) > 0, np.inf, between).min(1)
    apart = int(gaps.argmax())
    others = np.delete(np.arange(len(leaves)), apart)
    if gaps[apart] < _APART * gaps[others].max():
        return {k: ("finger",) for k in leaves}
    row = sorted(others, key=lambda index: between[apart, index])
    found: dict[int, tuple[PartRole, ...]] = {leaves[index]: ("finger",) for index in row}
    if len(row) == len(_FINGERS):
        found = {leaves[index]: (name, "finger") for index, name in zip(row, _FINGERS)}
    found[leaves[apart]] = ("thumb",)
    return found
