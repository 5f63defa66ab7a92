"""The roles of the limbs of things: handles, spouts, lids and knobs, and parts of which only the place is known."""

from __future__ import annotations

import numpy as np

from physagent_jax.forces.part import PartRole
from physagent_jax.scene.parts.limbs import LARGEST, Limb, list_inner, list_outer
from physagent_jax.scene.parts.pairs import Pairs, are_alike

_ON_GROUND = 0.06  # of the height
_UPRIGHT = 0.8  # cosine to up, from which on a limb is on top
_OPPOSITE = -0.3  # cosine between the sides of a spout and a handle, or a tail and a head, at most
_FINGER = 0.2  # share of a limb, above which what is one of several inside it is no finger
_SLENDER, _REACH = (
    2.4,
    0.15,
)  # slimness and length over the object's, from which on one of a pair may be an arm
_RISE = 0.6  # cosine to up, above which it is an ear
_LOWER = 0.1  # of the height of what arms are on, by which their joints are below its middle
_SHOULDER = 0.2  # the same of those of slender ones above it, at most
_CENTRED = 0.2  # of a lid's width, by which a knob may be off its middle
_ROW, _SMALL = 3, 0.02  # spikes, at least; share of the object that one has, at most
_HIGH = 0.7  # of the height, above which what a limb stands on is the top
_SLIM = 3.5  # slimness from which on a limb is no head
_BESIDE = 0.3  # their spread across the line that they are nearest to over that along it, at least
_CLEAR = 2.0  # prominence from which on a limb is one, whatever is inside it

Told = dict[int, tuple[PartRole, ...]]
"""Roles by place of the limb, surest first."""


class Things:
    """The roles of the limbs of a thing, which has neither legs nor a head.

    Attributes:
        limbs: The limbs.
        partners: Place of each limb's image.
        mirror: The object's upright mirror plane.
        low: Height of the ground [m].
        height: The object's [m].
        middle: Its centre of mass [m], shape (3,).
    """

    def __init__(self, limbs: list[Limb], pairs: Pairs, places: np.ndarray):
        self.limbs, self.partners, self.middle = limbs, pairs.partners, places.mean(0)
        self.mirror = pairs.mirror
        self.low, self.height = float(places[:, 2].min()), float(np.ptp(places[:, 2]))

    def assign(self, told: Told) -> Told:
        """The roles that are told already, with those of the limbs beside them."""
        found: Told = dict(told) | dict.fromkeys(self.find_spikes(), ("spike",))
        for k in filter(self._is_handle, range(len(self.limbs))):
            found[k] = ("handle",)
        for index in sorted(range(len(self.limbs)), key=lambda k: -self.limbs[k].share):
            limb = self.limbs[index]
            free = is_free(self.limbs, index, found) or self._is_on_lid(index, found)
            lump = is_lump(self.limbs, index) and not self._stands_on_top(limb)
            lump = lump or holds_arms(self.limbs, self.partners, index)
            if limb.share <= LARGEST and free and not lump:
                found[index] = self._name_side(index, found)
        return found

    def find_spikes(self) -> list[int]:
        """Several small limbs alike that point up, beside each other both ways, as candles do on a cake."""
        small = [
            k
            for k, limb in enumerate(self.limbs)
            if not limb.children and not limb.loop and limb.share < _SMALL and not self.is_grounded(limb)
            if (limb.tip - limb.joint)[2] > _UPRIGHT * float(np.linalg.norm(limb.tip - limb.joint))
        ]
        rows = [[k for k in small if are_alike(self.limbs[k], self.limbs[j])] for j in small]
        row = max(rows, key=len, default=[])
        joints = np.array([self.limbs[k].joint[:2] for k in row]).reshape(-1, 2)
        spread = np.linalg.svd(joints - joints.mean(0), compute_uv=False) if len(row) >= _ROW else np.zeros(2)
        return row if spread[1] > _BESIDE * spread[0] else []  # fingers stand in a line

    def _stands_on_top(self, limb: Limb) -> bool:
        """Return whether a small limb stands out clearly on top, whatever is on it: a dish with its feed."""
        on_top = self.find_side(limb)[2] > _UPRIGHT or limb.joint[2] > self.low + _HIGH * self.height
        return limb.prominence > _CLEAR and limb.share < _SMALL and on_top

    def list_possible(self, index: int, found: Told) -> tuple[PartRole, ...]:
        """The roles that a limb may have as well, of which only the place is known, and no other one like it.

        A pair across the mirror plane may be ears or horns if it points up, else wings or arms; wings and arms may be
        ears of what is a mere head. A lone limb on the plane may be a head if it is on top, a neck if it is a slim one,
        and a tail if it is at a side.
        """
        limb, (place, *told), partner = self.limbs[index], found[index], self.partners[index]
        if (
            place in ("wing", "arm")
            and not told
            and {("head",), ("leg",), ("ear",)}.isdisjoint(found.values())
        ):
            return ("ear",)
        if told or place not in ("top", "side"):
            return ()
        if partner is not None:
            points_up = (limb.tip - limb.joint)[2] > _RISE * float(np.linalg.norm(limb.tip - limb.joint))
            paired = found.get(partner) == found[index] and len(self._list_pairs(found)) == 2
            up = ("horn",) if {("wing",), ("arm",)} & set(found.values()) else ("ear", "horn")
            return () if not paired else up if points_up else ("wing", "arm")
        alone = [k for k in found if found[k] == (place,)] == [index]
        off = abs(float(self.mirror.measure(limb.centre)))
        if not alone or off > _CENTRED * self.height:
            return ()
        if place == "top" and limb.slimness > _SLIM:
            return ("neck",)
        return ("head",) if place == "top" else ("tail",)

    def _list_pairs(self, found: Told) -> list[int]:
        """The limbs of which only the place is known, and that have an image like them."""
        placed = [k for k in found if found[k] in (("top",), ("side",))]
        return [k for k in placed if (p := self.partners[k]) is not None and found.get(p) == found[k]]

    def _name_side(self, index: int, found: Told) -> tuple[PartRole, ...]:
        """The roles of a limb that is no handle."""
        limb, partner = self.limbs[index], self.partners[index]
        if limb.loop and partner is not None:
            return ("side", "arm", "handle")
        side, handles = self.find_side(limb), [self.limbs[k] for k in found if found[k] == ("handle",)]
        if side[2] > _UPRIGHT:
            if self._is_on_lid(index, found):
                return ("knob",)
            return ("lid",) if handles else ("top",)
        if self.is_grounded(limb):
            return ("bottom",) if side[2] < -_UPRIGHT else ("side",)
        if partner is not None and self._is_free_arm(partner, found):
            return ("arm",)
        if handles and all(self.is_across(limb, each) for each in handles):
            return ("spout",)
        return ("side",)

    def _is_free_arm(self, partner: int, found: Told) -> bool:
        free = found.get(partner) == ("arm",) or is_free(self.limbs, partner, found)
        return free and not self.is_grounded(self.limbs[partner])

    def find_side(self, limb: Limb) -> np.ndarray:
        """The unit vector from the object's middle to a limb's, shape (3,)."""
        away = limb.centre - self.middle
        return away / max(float(np.linalg.norm(away)), 1e-12)

    def is_across(self, limb: Limb, other: Limb) -> bool:
        """Return whether a limb is on the other side than another one, or that is overhead."""
        side, way = self.find_side(limb)[:2], self.find_side(other)
        return bool(way[2] > _UPRIGHT or side @ way[:2] < _OPPOSITE * np.linalg.norm(way[:2]))

    def is_grounded(self, limb: Limb) -> bool:
        """Return whether a limb reaches down to the ground."""
        return limb.low < self.low + _ON_GROUND * self.height

    def _is_handle(self, index: int) -> bool:
        """Return whether a limb is a loop of its own above the ground, without an image."""
        limb, outer = self.limbs[index], list_outer(self.limbs, index)
        if not limb.loop or limb.share > LARGEST or self.partners[index] is not None:
            return False
        if self.is_grounded(limb) or is_lump(self.limbs, index):
            return False
        return all(is_lump(self.limbs, k) or self.limbs[k].share > LARGEST for k in outer)

    def _is_on_lid(self, index: int, found: Told) -> bool:
        """Return whether a limb is the only one on a lid, in its middle."""
        parent = self.limbs[index].parent
        if parent is None or found.get(parent) not in (("lid",), ("top",)) or self.limbs[index].children:
            return False
        lid = self.limbs[parent]
        off = np.hypot(*(self.limbs[index].centre - lid.centre)[:2])
        return len(lid.children) == 1 and bool(off < _CENTRED * lid.extent[:2].max())


def is_lump(limbs: list[Limb], index: int) -> bool:
    """Return whether a limb is a piece of the body with limbs, or lies around one that stands out more."""
    limb, inner = limbs[index], [limbs[k] for k in limbs[index].children]
    if len(inner) == 1:
        return limb.prominence < min(_CLEAR, inner[0].prominence)
    return any(each.share > _FINGER * limb.share for each in inner)


def is_free(limbs: list[Limb], index: int, found: Told) -> bool:
    """Return whether neither a limb nor what is inside or around it has a role."""
    return not any(k in found for k in (index, *list_outer(limbs, index), *list_inner(limbs, index)))


def holds_arms(limbs: list[Limb], partners: tuple[int | None, ...], index: int) -> bool:
    """Return whether a limb is half of the body with arms: a pair that is no ears is inside it."""
    inner = list_inner(limbs, index)
    return any(partners[k] is not None and _is_arm(limbs[k], limbs[index]) for k in inner)


def _is_arm(limb: Limb, outer: Limb) -> bool:
    """Return whether one of a pair is an arm of the limb that it is on, rather than an ear."""
    above = (limb.joint - outer.centre)[2] / max(float(outer.extent[2]), 1e-12)
    rise = (limb.tip - limb.joint)[2] / max(float(np.linalg.norm(limb.tip - limb.joint)), 1e-12)
    slender = not limb.flat and limb.slimness > _SLENDER and limb.length > _REACH and rise < _RISE
    return bool(above < -_LOWER or slender and above < _SHOULDER)
