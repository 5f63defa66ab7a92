"""The roles of an object's limbs: a leg stands on the ground, ears come in pairs on a head, a handle is a loop.

A role is told by place, pair and shape alone, for objects that stand upright, and only where the object shows more than
the limb itself: a lone knob may be a head, so it is what is on top. Head and tail lie on the object's mirror plane;
ears, arms and wings are pairs across it. What else an animal or a person has gets no role: a wrong name is worse than
none. Words that may mean a role are the lexicon's.
"""

from __future__ import annotations

import numpy as np

from physagent_jax.forces.part import PartRole
from physagent_jax.scene.parts.lattice import Lattice
from physagent_jax.scene.parts.limbs import LARGEST, Limb, list_inner, list_outer
from physagent_jax.scene.parts.pairs import are_alike, find_pairs
from physagent_jax.scene.parts.things import Things, Told, holds_arms, is_free, is_lump

_ON_GROUND = 0.06  # of the height
_HEAD = 0.55  # of the height, above which the middle of a head lies
_LARGE = 0.6  # share of the object that a head may have if arms are below it
_SMALL = 0.3  # share of the head, above which what is inside it is no ear
_RIVAL = 0.4  # share of the largest that may be a head too
_HIGHER = 0.08  # of the height, that a head is higher than its rivals by
_BROAD = 0.5  # of the object's width: a plate on legs that is broader is a back
_MIDDLE = 0.1  # of the length, by which what lies on the mirror plane may be off it
_SLIM, _THIN = 3.5, 3.0  # slimness from which on a limb is no head, and is a tail
_SINKS = 0.02  # of the height, by which the tip of a head may be below its joint
_SLENDER = 2.4  # slimness from which on what a limb has several of, or a large one, is no ear or nose
_NOSE, _TRUNK = 1.5, 0.1  # slimness of a trunk, at least; share of the object, at most
_TAIL = 0.06  # length over the object's, at least
_LEAST = 0.1  # the same of wings and arms, where no head is found
_END = 0.18  # of the length, from the middle to what lies at an end of the object
_EAR_END, _TOP = 0.15, 0.75  # of the length from the middle, and of the height, beyond which ears are
_BROW = 0.4  # of the height, above which the ears and horns of what is all head are
_ALIKE = 0.9  # likeness to its image from which on an object is clearly its own
_TINY = 0.03  # share of the object, above which nothing is an ear of a head that is not found
_FIN, _FIN_END = 0.15, 0.35  # share of the object, at most, and place of a fish's tail
_SHEET = 0.45  # its thickness over its breadth, at most
_UNDER = 0.15  # of the length, by which the feet of what stands on two legs may be off its middle
_FOOT, _BORNE = (
    0.15,
    0.8,
)  # of the height, below which the middle of a foot is; share of the ground that feet cover
_LEG, _HALF = (
    0.16,
    0.6,
)  # of the height, from which on legs are long; share of the ground that shorter ones cover


class Roles:
    """The roles of limbs, found once for all.

    Attributes:
        limbs: The limbs.
        low, high: Corners of the object's box [m], shape (3,).
        middle: Its centre of mass [m], shape (3,).
        mirror: Its upright mirror plane.
        partners: Place of each limb's image.
        missed: How far that is off its partner.
    """

    def __init__(self, limbs: list[Limb], lattice: Lattice):
        self.limbs, self.places = limbs, lattice.places
        self.low, self.high = self.places.min(0), self.places.max(0)
        self.middle = self.places.mean(0)
        self.size, self.height = float((self.high - self.low).max()), float((self.high - self.low)[2])
        found = find_pairs(limbs, lattice)
        self.mirror, self.partners, self.missed = found.mirror, found.partners, found.missed
        self.things = Things(limbs, found, self.places)
        self.axis = np.cross((0.0, 0.0, 1.0), self.mirror.normal)
        self.pairs = sorted(
            ((k, j) for k, j in enumerate(self.partners) if j is not None and k < j),
            key=lambda pair: -sum(limbs[k].share for k in pair),
        )  # larger ones first
        self.fin = self._find_fin()
        self.legs = self._find_legs()
        self.back = self._find_back()
        self.head = self._find_head()

    @property
    def mirrored(self) -> frozenset[int]:
        """The limbs that have an image, of an object that is clearly its own."""
        alike = self.mirror.likeness > _ALIKE
        return frozenset(k for k, partner in enumerate(self.partners) if alike and partner is not None)

    def assign(self) -> Told:
        """Roles by place of the limb; what is part of another one, or of no use by itself, is left out."""
        found: Told = {leg: ("leg",) for leg in self.legs}
        if self.back is not None:
            found[self.back] = ("back",)
            return self.things.assign(found)
        if self.head is not None:
            found |= self._name_head(self.head)
        if self.head is None and not self.legs and self.things.find_spikes():
            return self.things.assign({})
        found |= self._name_horns(self._name_pairs(found))
        tail = self._find_tail(found)
        if tail is None and self.head is None and self.legs and self.fin not in found:
            tail = self.fin  # of a fish that lies on its fins
        if tail is not None:
            found[tail] = ("tail",)
            found |= self._name_across(tail, found)
        found |= dict.fromkeys(self._find_nose(found), ("nose",))
        # What stands on legs and is no figure has other things on it, too: a lander its dish.
        return self.things.assign(found) if all(each == ("leg",) for each in found.values()) else found

    def _find_fin(self) -> int | None:
        """The thin blade on the mirror plane at one end of what has pairs of limbs, as a fish's tail is; else None."""
        fins = [
            k
            for k, limb in enumerate(self.limbs)
            if self.pairs and self._is_long() and self._is_middle(limb) and not limb.loop
            if abs(self._find_place(limb)) > _FIN_END and limb.share < _FIN and self.partners[k] is None
            if self._is_thin(limb)
        ]
        fins = [k for k in fins if not set(list_outer(self.limbs, k)) & set(fins)]
        return fins[0] if len(fins) == 1 else None

    def _is_thin(self, limb: Limb) -> bool:
        """Return whether a limb is a sheet in the mirror plane, where a head is thick."""
        own = self.places[limb.nodes]
        spread = np.linalg.eigvalsh(np.cov(own[:, 2], own @ self.axis)) if len(own) > 2 else np.zeros(2)
        return bool(np.std(own @ self.mirror.normal) < _SHEET * np.sqrt(max(spread[0], 0.0)))

    def _find_legs(self) -> list[int]:
        """Limbs that stand on the ground, two or more alike; or the feet that bear all."""
        standing = [
            k
            for k, limb in enumerate(self.limbs)
            if self.things.is_grounded(limb)
            and not limb.loop
            and len(limb.children) < 2
            and limb.share < LARGEST
            if self._find_way(limb)[2] < -0.5
        ]
        fin = set() if self.fin is None else {self.fin, *list_inner(self.limbs, self.fin)}
        outer = [k for k in standing if k not in fin and not set(list_outer(self.limbs, k)) & set(standing)]
        legs = [k for k in outer if any(k != j and are_alike(self.limbs[k], self.limbs[j]) for j in outer)]
        return legs if self.bear(legs) else self._find_feet()

    def bear(self, legs: list[int]) -> bool:
        """Return whether legs bear the object, or are long: ragged edges below a pedestal do not, and are short."""
        long = max((self.limbs[k].length for k in legs), default=0.0) * self.size > _LEG * self.height
        return bool(long) or self._measure_borne(legs) > _HALF

    def _measure_borne(self, feet: list[int]) -> float:
        """The share of what is on the ground that belongs to some limbs."""
        ground = self.places[:, 2] < self.low[2] + _ON_GROUND * self.height
        return sum(int(ground[self.limbs[k].nodes].sum()) for k in feet) / max(int(ground.sum()), 1)

    def _find_feet(self) -> list[int]:
        """The pairs of low limbs without which nothing is on the ground."""
        feet = [
            k
            for k, limb in enumerate(self.limbs)
            if self.partners[k] is not None and not limb.flat and self.things.is_grounded(limb)
            if limb.centre[2] < self.low[2] + _FOOT * self.height and not limb.children
        ]
        return feet if self._measure_borne(feet) > _BORNE else []

    def _find_back(self) -> int | None:
        """The broad plate that stands on what has three legs or more."""
        width = float((self.high - self.low)[:2].max())
        fitting = [
            k
            for k, limb in enumerate(self.limbs)
            if len(self.legs) > 2 and limb.flat and limb.share <= LARGEST and limb.centre[2] > self.middle[2]
            if limb.tip[2] > limb.joint[2] and np.hypot(*limb.extent[:2]) > _BROAD * width
            if self.partners[k] is None
        ]
        return max(fitting, key=lambda k: self.limbs[k].share, default=None)

    def _find_head(self) -> int | None:
        """The largest limb on the mirror plane that is high up, or at an end of what has four legs; else None."""
        fitting = [k for k in range(len(self.limbs)) if self._may_be_head(k)]
        fitting = [k for k in fitting if self._list_ears(k)] or fitting
        largest = max(fitting, key=lambda k: self.limbs[k].share, default=None)
        if largest is None or self.back is not None:
            return None
        within, least = {largest, *list_inner(self.limbs, largest)}, _RIVAL * self.limbs[largest].share
        rivals = [k for k in fitting if k not in within and self.limbs[k].share > least]
        *lower, head = sorted((largest, *rivals), key=lambda k: self.limbs[k].centre[2])
        if lower and self.limbs[head].centre[2] - self.limbs[lower[-1]].centre[2] < _HIGHER * self.height:
            return None
        return head if self.legs or self._list_ears(head) or self._list_below(head) else None

    def _may_be_head(self, index: int) -> bool:
        """Return whether a limb is where a head is, and no slim one. What has arms is half of the body."""
        limb, inner = self.limbs[index], list_inner(self.limbs, index)
        most = _LARGE if self._list_ears(index) and self._list_below(index) else LARGEST
        if limb.share > most or limb.loop or self.partners[index] is not None or not self._is_middle(limb):
            return False
        if self.things.is_grounded(limb) or holds_arms(self.limbs, self.partners, index):
            return False
        if self.fin is not None and self.fin in (index, *list_outer(self.limbs, index), *inner):
            return False
        slim = [
            self.limbs[k]
            for k in inner
            if self.limbs[k].slimness > _SLENDER and self.partners[k] not in inner
        ]
        if len(slim) > 1 or any(each.share > _SMALL * limb.share for each in slim):
            return False
        around = [k for k in (index, *list_outer(self.limbs, index)) if self.limbs[k].slimness > _SLIM]
        if any(
            self.limbs[k].share <= LARGEST and not self._list_ears(k) for k in around
        ):  # the end of a tail, too
            return False
        if self._has_four_legs():
            return abs(self._find_place(limb)) > _END and bool(limb.centre[2] > self._find_hips())
        high = limb.centre[2] > self.low[2] + _HEAD * self.height
        upright = self.legs or not self._is_long()
        rises = limb.tip[2] >= limb.joint[2] - _SINKS * self.height
        return bool(high and (upright and rises or self._list_ears(index)))

    def _list_below(self, head: int) -> list[int]:
        """Limbs in pairs beside a limb, off the ground, none larger than it."""
        inner, limb = {head, *list_inner(self.limbs, head)}, self.limbs[head]
        sides = [
            k for pair in self.pairs for k in pair if k not in inner and self.limbs[k].share < limb.share
        ]
        return [
            k
            for k in sides
            if not self.limbs[k].loop and not self.things.is_grounded(self.limbs[k])
            if self.limbs[k].joint[2] < limb.centre[2]
        ]

    def _has_four_legs(self) -> bool:
        """Return whether there are more legs than two, or those two are not under the middle."""
        feet = np.mean([self._find_place(self.limbs[k]) for k in self.legs]) if self.legs else 0.0
        return len(self.legs) > 2 or bool(abs(feet) > _UNDER)

    def _find_hips(self) -> float:
        return float(np.mean([self.limbs[k].joint[2] for k in self.legs]))

    def _list_ears(self, head: int) -> list[int]:
        """Small limbs in pairs on a head, lower ones first."""
        most = _SMALL * self.limbs[head].share
        inner = list_inner(self.limbs, head)
        ears = [k for k in inner if self.limbs[k].share < most and not self.limbs[k].children]
        return sorted((k for k in ears if self.partners[k] in ears), key=lambda k: self.limbs[k].joint[2])

    def _name_head(self, head: int) -> Told:
        """The head, and the ears and horns on it."""
        ears = self._list_ears(head)
        found: Told = {head: ("head",)}
        for place, k in enumerate(ears):
            found[k] = ("horn",) if len(ears) >= 4 and place >= len(ears) - 2 else ("ear",)
        return found

    def _name_pairs(self, found: Told) -> Told:
        """Arms, wings, and the ears of a head that is not found; larger pairs first."""
        named: Told = {}
        for k, j in (*self.pairs, *self.pairs):  # ears are told by the wings or arms below them
            if k in named:
                continue
            limb, other, told = self.limbs[k], self.limbs[j], found | named
            if any(not is_free(self.limbs, each, told) or is_lump(self.limbs, each) for each in (k, j)):
                continue
            flat = limb.flat and other.flat and not (self.legs and all(self.limbs[k].flat for k in self.legs))
            role = self._name_pair(limb, flat, named)
            if role is not None:
                named |= {k: (role,), j: (role,)}
        return named

    def _name_horns(self, named: Told) -> Told:
        """The pairs of a figure, or the ears and the horns of what is a head and no more: neither pair bears it."""
        pairs = {role: [k for k, told in named.items() if told == (role,)] for role in ("arm", "ear")}
        small = all(self.limbs[k].share < _TINY for k in named)
        high = all(self.limbs[k].joint[2] > self.low[2] + _BROW * self.height for k in named)
        if self.legs or self.head is not None or not (small and high) or not all(map(len, pairs.values())):
            return named
        return named | dict.fromkeys(pairs["ear"], ("horn",)) | dict.fromkeys(pairs["arm"], ("ear",))

    def _name_pair(self, limb: Limb, flat: bool, named: Told) -> PartRole | None:
        """The role of a pair that is neither legs nor on a head that is found; None if it may be several things."""
        taken = {role for (role, *_) in named.values()}
        if self.head is None and self._is_ear(limb, [self.limbs[k] for k in named]):
            return "ear"
        if self.head is None and (limb.length < _LEAST or limb.loop) or "ear" in taken:
            return None
        if flat and "wing" not in taken and abs(self._find_way(limb) @ self.mirror.normal) > 0.5:
            return "wing"
        figure = self.head is not None or self.legs or self._has_ears_above(limb)
        if self._has_four_legs() or "arm" in taken or not figure or self.things.is_grounded(limb):
            return None
        return "wing" if flat and "wing" not in taken else "arm" if not flat else None

    def _is_ear(self, limb: Limb, larger: list[Limb]) -> bool:
        """Return whether one of a pair is small and at the top, or at an end of what has four legs."""
        if limb.share > _TINY or limb.children or self.things.is_grounded(limb) or not (self.legs or larger):
            return False
        if self._has_four_legs():
            return abs(self._find_place(limb)) > _EAR_END and bool(limb.joint[2] > self._find_hips())
        off, high = abs(self.mirror.measure(limb.joint)), self.low[2] + _TOP * self.height
        lower = all(
            abs(self.mirror.measure(each.joint)) > off and each.joint[2] < limb.joint[2] for each in larger
        )
        return bool(lower and limb.joint[2] > high)

    def _has_ears_above(self, limb: Limb) -> bool:
        return any(self._is_ear(self.limbs[k], [limb]) for k, _ in self.pairs)

    def _find_tail(self, found: Told) -> int | None:
        """The limb on the mirror plane across from the head; else the slim one, or that at an end of what has wings."""
        fitting = [
            k
            for k, limb in enumerate(self.limbs)
            if _TAIL < limb.length and limb.share <= LARGEST and self.partners[k] is None and not limb.loop
            if abs(float(self.mirror.measure(limb.joint))) < _MIDDLE * self.size  # its tip may be bent aside
            if not self.things.is_grounded(limb) or not self.legs and abs(self._find_place(limb)) > _END
            if is_free(self.limbs, k, found) and not is_lump(self.limbs, k)
        ]
        fitting = [k for k in fitting if not set(list_outer(self.limbs, k)) & set(fitting)]
        if self.head is not None:
            fitting = [k for k in fitting if self.things.is_across(self.limbs[k], self.limbs[self.head])]
            return max(fitting, key=lambda k: self.limbs[k].share, default=None)
        ends = [k for k in fitting if abs(self._find_place(self.limbs[k])) > _END]
        slim = [k for k in ends if self.limbs[k].slimness > _THIN]
        figure = self.legs or any(role in (("arm",), ("ear",)) for role in found.values())
        if figure or len(slim) == 1 and self._find_far_end(slim[0], ends) is not None:
            return slim[0] if len(slim) == 1 else None
        if not self.pairs or not self._is_long():
            return None
        ends = [k for k in ends if self.limbs[k].children] or ends  # the nose of a plane has no fins
        return ends[0] if len(ends) == 1 else None

    def _find_nose(self, found: Told) -> list[int]:
        """The lone limb on the mirror plane that hangs from a head, or high up in front of a figure: a trunk."""
        figure = any(role in (("leg",), ("arm",)) for role in found.values())
        fitting = [
            k
            for k, limb in enumerate(self.limbs)
            if figure
            and k not in found
            and self.fin not in list_outer(self.limbs, k)
            and self.partners[k] is None
            and not limb.loop
            and not limb.children
            if limb.share < _TRUNK and _TAIL < limb.length and limb.slimness > _NOSE and self._is_middle(limb)
            if limb.joint[2] > self.middle[2] and not self.things.is_grounded(limb)
            if abs(self._find_place(limb)) > _END
            if self.head is None or self.head in list_outer(self.limbs, k)
        ]
        return fitting if len(fitting) == 1 else []

    def _find_far_end(self, tail: int, ends: list[int]) -> int | None:
        """The only limb at the end across from a slim one, if it is thicker and both are off the ground."""
        here = self._find_place(self.limbs[tail])
        far = [k for k in ends if self._find_place(self.limbs[k]) * here < 0]
        limbs = [self.limbs[k] for k in (*far, tail)]
        loose = not any(self.things.is_grounded(each) or each.loop for each in limbs)
        thick = len(far) == 1 and limbs[0].slimness < _SLIM and limbs[0].share > 2 * limbs[1].share
        return far[0] if thick and loose and self._is_long() else None

    def _name_across(self, tail: int, found: Told) -> Told:
        """The head of what has no legs, across from its tail, or the fins beside that."""
        if self.legs or self.head is not None or any(role == ("wing",) for role in found.values()):
            return {}
        ends = [k for k in range(len(self.limbs)) if abs(self._find_place(self.limbs[k])) > _END]
        head = self._find_far_end(tail, [k for k in ends if is_free(self.limbs, k, found)])
        if head is not None and self.limbs[tail].slimness > _SLIM:
            return {head: ("head",)}
        fins = [pair for pair in self.pairs if all(is_free(self.limbs, k, found) for k in pair)]
        return dict.fromkeys(fins[0] if fins else (), ("wing",))

    def _is_long(self) -> bool:
        """Return whether the object is longer along its mirror plane than it is high."""
        return float(np.ptp(self.places @ self.axis)) > self.height

    def _is_middle(self, limb: Limb) -> bool:
        return abs(float(self.mirror.measure(limb.centre))) < _MIDDLE * self.size

    def _find_place(self, limb: Limb) -> float:
        """The place of a limb along the mirror plane, from the middle, over the object's length."""
        return float((limb.centre - self.middle) @ self.axis) / self.size

    def _find_way(self, limb: Limb) -> np.ndarray:
        """The unit vector from a limb's joint to its tip, shape (3,)."""
        return (limb.tip - limb.joint) / max(float(np.linalg.norm(limb.tip - limb.joint)), 1e-12)
