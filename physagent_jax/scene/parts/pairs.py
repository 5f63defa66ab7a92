"""Limbs in pairs: each the other's image in the object's mirror plane."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from physagent_jax.scene.parts.lattice import Lattice
from physagent_jax.scene.parts.limbs import Limb, list_outer
from physagent_jax.scene.parts.mirror import Mirror, find_mirrors

_ALMOST = 0.25  # likeness that a mirror plane may have less than the best one: limbs may be posed
_HALF = 0.15  # share of the object from which on a pair may be its two halves
_ALIKE = 2.5  # ratio of the shares of a pair, at most
_IMAGE = 0.12  # of the length, by which the image of a limb may miss its partner
_POSED = 0.25  # the same of its middle, if it hangs on the same joint
_TURNED = 0.5  # cosine between the object's mirror plane and that of a turned head, at least
_LEVEL = 0.5  # rise over distance between two of a pair on a turned head, at most


@dataclasses.dataclass(frozen=True)
class Pairs:
    """The pairs among limbs.

    Attributes:
        mirror: The plane that they are images in.
        partners: Place of each limb's image; None = it has none.
        missed: Distance of each limb's image from its partner, 1 = no pair any more; None = it has none.
    """

    mirror: Mirror
    partners: tuple[int | None, ...]
    missed: tuple[float | None, ...]


def find_pairs(limbs: list[Limb], lattice: Lattice) -> Pairs:
    """The pairs in the plane in which most of the limbs have images, among those that the object is most alike in."""
    mirrors, size = find_mirrors(lattice), float(np.ptp(lattice.places, axis=0).max())
    told = []
    for mirror in mirrors:
        if mirror.likeness >= mirrors[0].likeness - _ALMOST:
            images = [_find_image(limbs, k, mirror, size) for k in range(len(limbs))]
            partners = tuple(
                j if j is not None and images[j][0] == k else None for k, (j, _) in enumerate(images)
            )
            missed = tuple(None if j is None else apart for j, (_, apart) in zip(partners, images))
            shares = [limb.share for limb, j in zip(limbs, partners) if j is not None and limb.share < _HALF]
            told.append((mirror.likeness + sum(shares), Pairs(mirror, partners, missed)))
    return max(told, key=lambda each: each[0])[1]


def _find_image(limbs: list[Limb], index: int, mirror: Mirror, size: float) -> tuple[int | None, float]:
    """The limb that is most like the image of another one in a plane, or in that of the limb they are both on.

    Returns:
        Its place, and how far the image is off it; None if there is none.
    """
    limb, found = limbs[index], {}
    for k, other in enumerate(limbs):
        nested = k in (index, *list_outer(limbs, index)) or index in list_outer(limbs, k)
        if nested or not are_alike(limb, other):
            continue
        missed = _miss(mirror, limb, other, size)
        if limb.parent is not None and limb.parent == other.parent:
            way = other.centre - limb.centre
            across = np.array([*way[:2], 0.0]) / max(float(np.hypot(*way[:2])), 1e-12)
            turned = Mirror(across, float(limbs[limb.parent].centre @ across), 0.0)
            if abs(across @ mirror.normal) > _TURNED and abs(way[2]) < _LEVEL * np.linalg.norm(way):
                missed = min(missed, _miss(turned, limb, other, size))
        if missed < 1:
            found[k] = missed + abs(math.log(limb.share / other.share)), missed
    image = min(found, key=lambda k: found[k][0], default=None)
    return image, math.inf if image is None else found[image][1]


def _miss(mirror: Mirror, limb: Limb, other: Limb, size: float) -> float:
    """Distance of the image of a limb from another one on the other side; below 1 for a pair."""
    sides = mirror.measure(np.stack([limb.centre, other.centre]))
    if sides[0] * sides[1] >= 0:
        return math.inf
    centre, joint = (
        float(np.linalg.norm(mirror.reflect(one) - two)) / size
        for one, two in ((limb.centre, other.centre), (limb.joint, other.joint))
    )
    return min(centre / _IMAGE, max(joint / _IMAGE, centre / _POSED))


def are_alike(one: Limb, other: Limb) -> bool:
    """Return whether two limbs are about as large."""
    ratio = one.share / other.share
    return 1 / _ALIKE < ratio < _ALIKE and 0.5 < one.length / other.length < 2 and one.loop == other.loop
