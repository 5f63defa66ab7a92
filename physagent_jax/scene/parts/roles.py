"""The roles of an object's limbs: a leg stands on the ground, ears come in pairs on a head, a handle is a loop.

A role is told by place, pair and shape alone, for objects that stand upright, and only where the object shows more than
the limb itself: a lone knob may be a head, so it is what is on top. Words that may mean a role are the lexicon's.
"""

from __future__ import annotations

import math

import numpy as np

from physagent_jax.forces.part import PartRole
from physagent_jax.scene.parts.limbs import LARGEST, Limb

_ON_GROUND = 0.06  # of the height
_HEAD = 0.55  # of the height, above which the middle of a head lies
_UPRIGHT = 0.8  # cosine to up, from which on a limb is on top
_MIRROR = 0.12  # of the length, by which the plane between two of a pair may miss the middle
_LEVEL = 0.5  # rise over distance between two of a pair, at most
_ALIKE = 2.5  # ratio of the shares of a pair, at most
_OPPOSITE = -0.3  # cosine between the sides of a tail and a head, or a spout and a handle, at most
_SMALL = 0.3  # share of the head, above which what is inside it is no ear
_FINGER = 0.2  # share of a limb, above which what is one of several inside it is no finger
_CLEAR = 2.0  # prominence from which on a limb is one, whatever is inside it
_RIVAL, _HIGHER = (
    0.4,
    0.08,
)  # share of the largest that may be a head too, and of the height that a head is higher by
_BROAD = 0.5  # of the object's width: a plate on legs that is broader is a back


class Roles:
    """The roles of limbs, found once for all.

    Attributes:
        limbs: The limbs.
        low, high: Corners of the object's box [m], shape (3,).
        middle: Its centre of mass [m], shape (3,).
    """

    def __init__(self, limbs: list[Limb], low: np.ndarray, high: np.ndarray, middle: np.ndarray):
        self.limbs, self.low, self.high, self.middle = limbs, low, high, middle
        self.size, self.height = float((high - low).max()), float(high[2] - low[2])
        self.legs = self._find_legs()
        self.back = self._find_back()
        self.head = self._find_head()

    def assign(self) -> dict[int, tuple[PartRole, ...]]:
        """Roles by place of the limb; what is part of another one, or of no use by itself, is left out."""
        found: dict[int, tuple[PartRole, ...]] = {leg: ("leg",) for leg in self.legs}
        if self.back is not None:
            found[self.back] = ("back",)
        if self.head is not None:
            found |= self._name_head(self.head)
        if self.head is None:
            found |= {k: ("handle",) for k in range(len(self.limbs)) if self._is_handle(k)}
        for index in sorted(range(len(self.limbs)), key=lambda k: -self.limbs[k].share):
            limb = self.limbs[index]
            taken = any(each in found for each in (index, *self._list_outer(index), *self._list_inner(index)))
            if (
                limb.share <= LARGEST
                and not self._is_lump(limb)
                and (not taken or self._is_on_lid(index, found))
            ):
                found[index] = self._name_side(index, found)
        return found

    def _name_side(self, index: int, found: dict[int, tuple[PartRole, ...]]) -> tuple[PartRole, ...]:
        """The roles of a limb that is neither leg nor of the head."""
        limb, partner = self.limbs[index], self._find_partner(index)
        if limb.loop and partner is not None:
            return ("arm",) if self.head is not None else ("side", "arm", "handle")
        if partner is not None and not self._is_grounded(limb):
            return ("wing",) if limb.flat else ("arm",)
        side, handles = self._find_side(limb), [self.limbs[k] for k in found if found[k] == ("handle",)]
        if side[2] > _UPRIGHT:
            if self._is_on_lid(index, found):
                return ("knob",)
            return ("lid",) if handles else ("top",)
        if self._is_grounded(limb):
            return ("bottom",) if side[2] < -_UPRIGHT else ("side",)
        if handles and self._is_across(limb, handles):
            return ("spout",)
        if self.head is not None and self._is_across(limb, [self.limbs[self.head]]):
            return ("tail",)
        return ("side",)

    def _name_head(self, head: int) -> dict[int, tuple[PartRole, ...]]:
        """The head, and the ears, horns and nose on it."""
        inner = [k for k in self._list_inner(head) if self.limbs[k].share < _SMALL * self.limbs[head].share]
        paired = [k for k in inner if self._find_partner(k) is not None and not self.limbs[k].children]
        found: dict[int, tuple[PartRole, ...]] = {head: ("head",)}
        paired.sort(key=lambda k: self.limbs[k].joint[2])
        for place, k in enumerate(paired):
            found[k] = ("horn",) if len(paired) >= 4 and place >= len(paired) - 2 else ("ear",)
        return found

    def _find_legs(self) -> list[int]:
        """Limbs that stand on the ground, two or more alike."""
        standing = [
            k
            for k, limb in enumerate(self.limbs)
            if self._is_grounded(limb) and not limb.loop and len(limb.children) < 2 and limb.share < LARGEST
            if (limb.joint - limb.centre)[2] > 0.5 * np.linalg.norm(limb.joint - limb.centre)
        ]
        outer = [k for k in standing if not set(self._list_outer(k)) & set(standing)]
        return [k for k in outer if any(k != j and _are_alike(self.limbs[k], self.limbs[j]) for j in outer)]

    def _find_back(self) -> int | None:
        """The broad plate that stands on what has legs."""
        width = float((self.high - self.low)[:2].max())
        fitting = [
            k
            for k, limb in enumerate(self.limbs)
            if self.legs and limb.flat and limb.share <= LARGEST and limb.centre[2] > self.middle[2]
            if limb.tip[2] > limb.joint[2] and np.hypot(*limb.extent[:2]) > _BROAD * width
        ]
        return max(fitting, key=lambda k: self.limbs[k].share, default=None)

    def _find_head(self) -> int | None:
        """The largest limb that is high up and off the ground, if limbs around tell that it is a head; else None.

        Ears sit above its middle; where what it is made of sits lower, as arms do, it is half of the body.
        """
        high = [
            k
            for k, limb in enumerate(self.limbs)
            if limb.share <= LARGEST
            and limb.centre[2] > self.low[2] + _HEAD * self.height
            and limb.tip[2] >= limb.joint[2] - 0.02 * self.height
            and not (
                self._is_grounded(limb) or limb.loop or k == self.back or self._find_partner(k) is not None
            )
            and not any(self.limbs[child].joint[2] < limb.centre[2] for child in limb.children)
        ]
        largest = max(high, key=lambda k: self.limbs[k].share, default=None)
        if largest is None or self.back is not None:
            return None
        within = {largest, *self._list_inner(largest)}
        rivals = [
            k for k in high if k not in within and self.limbs[k].share > _RIVAL * self.limbs[largest].share
        ]
        *lower, head = sorted((largest, *rivals), key=lambda k: self.limbs[k].centre[2])
        if lower and self.limbs[head].centre[2] - self.limbs[lower[-1]].centre[2] < _HIGHER * self.height:
            return None
        ears = [k for k in self._list_inner(head) if self._find_partner(k) is not None]
        sides = [
            k
            for k, limb in enumerate(self.limbs)
            if self._find_partner(k) is not None and not self._is_grounded(limb) and limb.parent != head
        ]
        vessel = any(self._is_handle(k) for k in range(len(self.limbs)))
        return head if self.legs or ((ears or sides) and not vessel) else None

    def _is_handle(self, index: int) -> bool:
        """Return whether a limb is a loop of its own, without an image."""
        limb, outer = self.limbs[index], [self.limbs[k] for k in self._list_outer(index)]
        if (
            not limb.loop
            or limb.share > LARGEST
            or self._is_lump(limb)
            or self._find_partner(index) is not None
        ):
            return False
        return all(self._is_lump(each) or each.share > LARGEST for each in outer)

    def _is_lump(self, limb: Limb) -> bool:
        """Return whether a limb is a piece of the body with limbs, or lies around one that stands out more."""
        inner = [self.limbs[k] for k in limb.children]
        if len(inner) == 1:
            return limb.prominence < min(_CLEAR, inner[0].prominence)
        return any(each.share > _FINGER * limb.share for each in inner)

    def _is_grounded(self, limb: Limb) -> bool:
        return limb.low < self.low[2] + _ON_GROUND * self.height

    def _find_side(self, limb: Limb) -> np.ndarray:
        """The unit vector from the object's middle to a limb's, shape (3,)."""
        away = limb.centre - self.middle
        return away / max(float(np.linalg.norm(away)), 1e-12)

    def _is_across(self, limb: Limb, others: list[Limb]) -> bool:
        """Return whether a limb is on the other side than others; level, or all others are overhead."""
        side = self._find_side(limb)[:2]
        ways = [self._find_side(each) for each in others]
        return all(way[2] > _UPRIGHT or side @ way[:2] < _OPPOSITE * np.linalg.norm(way[:2]) for way in ways)

    def _is_on_lid(self, index: int, found: dict[int, tuple[PartRole, ...]]) -> bool:
        parent = self.limbs[index].parent
        return (
            parent is not None
            and found.get(parent) in (("lid",), ("top",))
            and not self.limbs[index].children
        )

    def _find_partner(self, index: int) -> int | None:
        """The limb that is its mirror image in an upright plane through the middle of the object, or of their head."""
        nearest = self._find_image(index)
        return nearest if nearest is not None and self._find_image(nearest) == index else None

    def _find_image(self, index: int) -> int | None:
        """The limb that is most like a mirror image of another one; None if there is none."""
        limb = self.limbs[index]
        middle = self.middle if limb.parent is None else self.limbs[limb.parent].centre
        found: dict[int, float] = {}
        for k, other in enumerate(self.limbs):
            if (
                k == index
                or other.parent != limb.parent
                or not _are_alike(limb, other)
                or other.loop != limb.loop
            ):
                continue
            way = other.centre - limb.centre
            across = way[:2] / max(float(np.linalg.norm(way[:2])), 1e-12)
            missed = abs((0.5 * (limb.centre + other.centre) - middle)[:2] @ across) / self.size
            rise = abs(way[2]) / max(float(np.linalg.norm(way)), 1e-12)
            if rise < _LEVEL and missed < _MIRROR:
                found[k] = missed + 0.1 * rise + 0.1 * abs(math.log(limb.share / other.share))
        return min(found, key=lambda k: found[k], default=None)

    def _list_inner(self, index: int) -> list[int]:
        children = self.limbs[index].children
        return [*children, *(k for child in children for k in self._list_inner(child))]

    def _list_outer(self, index: int) -> list[int]:
        parent = self.limbs[index].parent
        return [] if parent is None else [parent, *self._list_outer(parent)]


def _are_alike(one: Limb, other: Limb) -> bool:
    return 1 / _ALIKE < one.share / other.share < _ALIKE and 0.5 < one.length / other.length < 2
