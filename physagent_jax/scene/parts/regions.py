"""The regions of an object that rows of `places.yaml` tell, each as a part: which end of which parent they are."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from importlib import resources
from typing import Any

import numpy as np
import yaml

from physagent_jax.forces.part import Part, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts.cells import find_contact, fit_part
from physagent_jax.scene.parts.decks import Deck, find_deck
from physagent_jax.scene.parts.figures import is_figure_on_base
from physagent_jax.scene.parts.heading import find_heading, find_hood, find_overhang
from physagent_jax.scene.parts.shells import ROUGH, Shells

_LIMBS = frozenset("head ear horn arm wing leg tail handle spout nose".split())  # the body is the rest
_FIGURE = frozenset("head leg arm wing tail".split())  # of which something shows that the rest is a body
_ASIDE = frozenset("arm wing tail".split())  # what an upright figure has beside it
_FORE = frozenset(("head", "nose"))  # what tells where it looks, if there is one of them
_OWN = ("head", "skull", "mask")  # what the object is called that is a head as a whole
_OFF = 0.15  # of the length, by which an animal's head is off its middle in the way that it looks
_TRIMMED = 2.0  # percent of a parent on either side, that its ends are without
_CROTCH, _GAP = 0.7, 0.1  # of a region's height, and of its half width, within which two legs leave a gap
_SHOULDER = 0.15  # of a region that hangs, by which it is held
_TALL = 1.3  # height over width of a figure whose legs are not seen
_DECKS = ("face", "back", "arms")  # of what bears something
_FINGERS = frozenset(("finger", "thumb"))
_LAID = 0.5  # of its height, along which a limb touches the body that it lies on
_HELD = 0.6  # share of a limb that lies in a region, from which on it is what is meant
_FEWEST = 24  # particles of a region
_MOST, _DECK = 0.5, 0.95  # share of the object, and of a table that is its top
_WIDE = ("face", "main", "tower", "base", "canopy", "stalk")  # parents that may be nearly all of the object
_ENDS = frozenset("bow stern toe heel tip grip bottom blade".split())  # of the main body itself
_BEARING = frozenset(("leg", "stem"))  # what a tower stands on is part of it
_SLICES = 40  # of the height, of which the breadth is taken
_STEP = 1.3  # breadth over three slices, from which on a foot ends there
_BROADER, _FLARES = (
    1.4,
    0.35,
)  # breadth of a canopy over its stalk's; of the way between them that still is stalk
_SLIM_FOR, _FOOT = (
    0.1,
    0.3,
)  # of the height, that a stalk has at least; of a stalk, that stays as the rest bends
_UP = np.array([0.0, 0.0, 1.0])


@dataclasses.dataclass(frozen=True)
class Frame:
    """The viewer's directions.

    Attributes:
        toward, right: Unit world vectors, level, shape (3,).
    """

    toward: np.ndarray
    right: np.ndarray


@functools.cache
def read_places() -> dict[str, dict[str, Any]]:
    """The rows of the table by their words."""
    text = (resources.files("physagent_jax.scene.parts") / "places.yaml").read_text("utf-8")
    return {word: row for row in yaml.safe_load(text) for word in row["words"].split(", ")}


@dataclasses.dataclass(frozen=True)
class Regions:
    """The regions of an object, and the parents that they lie on."""

    points: np.ndarray
    parts: Sequence[Part]
    masks: list[np.ndarray]
    name: str
    viewer: Frame
    shells: Shells
    heading: np.ndarray | None = None

    def find(self, word: str, row: dict[str, Any]) -> list[Part]:
        """The regions of a word."""
        legs = self._count("leg")
        row = row | row.get("four" if legs > 2 else "standing" if legs == 0 else "", {})
        found = self._find_vehicle(word, row) if row["of"] == "vehicle" else []
        for parent, part in self._list(row["of"]):
            inside = parent & self._is_within(parent, part, row)
            if row.get("parted") and not self._is_parted(inside):
                continue
            across = (self.points - self.points[parent].mean(0)) @ self._side
            sides = (("left ", -1), ("right ", 1)) if "side" in row else (("", 0),)
            for side, sign in sides:
                mask = inside & (across * sign >= 0)
                shell = self.shells.snap(mask, ROUGH)
                mask = mask if shell is None else shell
                limb = self._find_limb(mask) if row.get("hangs") and sign else None
                if limb is not None:
                    found.append(limb.model_copy(update=dict(name=side + word)))
                    continue
                if _FEWEST <= mask.sum() < (_DECK if row["of"] in _WIDE else _MOST) * len(mask):
                    told = dict(
                        name=row.get("end", "") + side + word,
                        origin="place",
                        seated=True,
                        front=None if self._overhang is None else tuple(self._overhang.tolist()),
                        arm=self._find_arm(mask, row, sign),
                    )
                    told |= dict(confidence=row.get("chance", 1.0 if part is None else part.confidence))
                    if row.get("hangs"):
                        told |= (sign and self._stick_out(mask)) or self._hang(mask, -_UP)
                    told |= self._hang(mask, _UP) if row.get("nods") else {}
                    if part is not None and row.get("hinged"):
                        told |= self._hang(mask, np.asarray(part.arm) / max(np.linalg.norm(part.arm), 1e-12))
                    told |= self._hang(mask, sign * self._side) if row.get("flap") else {}
                    told |= self._hang(mask, self._front) if row.get("juts") else {}
                    told |= self._hang(mask, -self._front) if row.get("trails") else {}
                    found.append(fit_part(self.points, mask, joined=shell is None).model_copy(update=told))
        return found or (self.find(word, row["else"]) if "else" in row else [])

    def _find_vehicle(self, word: str, row: dict[str, Any]) -> list[Part]:
        """The regions of what has wheels; a word for one at either end means both."""
        told = find_heading(self.points, self.parts)
        if told is None or self._count("head") and self._count("leg"):  # no animal
            return []
        own, (start, height) = dataclasses.replace(self, heading=told[0]), find_hood(self.points, told[0])
        low = dict(front=[start, 0.97], up=[0.4 * height, height])
        behind = dict(front=[start - 0.15, start + 0.03], up=[height, 1])
        row |= dict(low=low, behind=behind).get(row.get("hood", ""), {})
        ends = (("front ", 1), ("rear ", -1)) if row.get("both") else (("", 1),)
        found = []
        for name, sign in ends:
            front = row["front"] if sign > 0 else [1 - each for each in reversed(row["front"])]
            found += own.find(word, row | dict(of="whole", front=front, end=name, four={}, standing={}))
        return [each.model_copy(update=dict(confidence=told[1])) for each in found]

    def _find_limb(self, mask: np.ndarray) -> Part | None:
        """The limb of which only the place is known that lies in a region: an arm of a cactus."""
        loose = [(part, m) for part, m in zip(self.parts, self.masks) if part.roles[:1] == ("side",)]
        inside = [part for part, m in loose if (m & mask).sum() > _HELD * m.sum()]
        return inside[0] if len(inside) == 1 else None

    def _find_arm(self, mask: np.ndarray, row: dict[str, Any], sign: int) -> tuple[float, ...]:
        """The way out of the parent, as long as the region is that way [body lengths]."""
        out = sum(
            (np.mean(row[key]) - 0.5) * way
            for key, way in (("front", self._front), ("up", _UP))
            if key in row
        )
        plain = _UP if row["of"] == "face" else self._front
        way = out + 0.5 * sign * self._side if "front" in row or "up" in row else plain
        way = np.asarray(way) / max(float(np.linalg.norm(way)), 1e-12)
        length = float(np.ptp(self.points[mask] @ way) / np.ptp(self.points, axis=0).max())
        return tuple(np.round(length * way, 4).tolist())

    def _stick_out(self, mask: np.ndarray) -> dict[str, Any]:
        """The joint of a region that stands off from the rest, as `_hang`; empty where it lies on it all along."""
        own, low, size = self.points[mask], self.points.min(0), float(np.ptp(self.points, axis=0).max())
        contact = find_contact(own, self.points[~mask], size)
        joint = contact.mean(0)
        if np.ptp(contact[:, 2]) > _LAID * np.ptp(own[:, 2]):
            return {}
        tip = own[np.linalg.norm(own - joint, axis=1).argmax()]
        box = np.maximum(np.ptp(self.points, axis=0), 1e-12)
        told = dict(joint=(joint - low) / box, arm=(tip - joint) / size, neck=contact.std(0) / size)
        return dict(seated=False) | {key: tuple(np.round(each, 4).tolist()) for key, each in told.items()}

    def _hang(self, mask: np.ndarray, way: np.ndarray) -> dict[str, Any]:
        """The joint of a region that points a way, from there to its far end, and the spread of the joint."""
        own, low = self.points[mask], self.points.min(0)
        box, size = np.maximum(np.ptp(self.points, axis=0), 1e-12), float(np.ptp(self.points, axis=0).max())
        along = own @ way
        levels = np.quantile(along, [_SHOULDER, 1 - _SHOULDER])
        near, far = own[along <= levels[0]], own[along >= levels[1]]
        joint = near.mean(0)
        told = dict(joint=(joint - low) / box, arm=(far.mean(0) - joint) / size, neck=near.std(0) / size)
        return dict(seated=False) | {key: tuple(np.round(each, 4).tolist()) for key, each in told.items()}

    def _list(self, of: str) -> list[tuple[np.ndarray, Part | None]]:
        """The parents of a kind, each as a mask of particles, shape (n,), and as a part; None = it is none."""
        every = np.ones(len(self.points), bool)
        upright = self._count("leg") == 2 or not self._count("leg") and self._is_tall()
        upright |= not self._count("leg") and self._count("head") == 1 and self._count("arm") == 2
        if of == "whole" or of == "overhang" and self._overhang is not None:
            return [(every, None)]
        if of in ("main", "tower"):
            thing = of == "tower" or not self._is_figure()
            return [(self._find_main(bearing=of == "tower"), None)] if thing else []
        if of in _DECKS:
            mask = ~every if self._deck is None else getattr(self._deck, of)
            return [(mask, None)] if mask.any() else []
        if of in ("canopy", "stalk"):
            if self._stalk is None:
                return []
            height = self._measure(every, _UP)
            return [(height > (self._stalk if of == "canopy" else _FOOT * self._stalk), None)]
        if of == "hand":
            fingers = [mask for mask, part in zip(self.masks, self.parts) if _FINGERS & {*part.roles}]
            palm = ~np.logical_or.reduce([~every, *fingers])
            return [(palm, None)] if len(fingers) > 2 and not self._count("head") else []
        based = [m for m, part in zip(self.masks, self.parts) if is_figure_on_base(part)]
        if of == "base":
            return [(~based[0], None)] if len(based) == 1 else []
        if of == "upright":
            arms = [m for m, part in zip(self.masks, self.parts) if not _ASIDE.isdisjoint(part.roles[:1])]
            figure = based[0] if len(based) == 1 else every
            return [(figure & ~np.logical_or.reduce([~every, *arms]), None)] if upright else []
        limbs = [mask for mask, part in zip(self.masks, self.parts) if not _LIMBS.isdisjoint(part.roles[:1])]
        if of == "body":
            body = ~np.logical_or.reduce([~every, *limbs])
            figure = upright or self._is_figure()
            return [(body, None)] if figure and body.any() else []
        snout, of = of == "head", of.replace("skull", "head")
        if of == "head" and self._count("handle"):
            return []  # a hammer's head has no face
        found = [(mask, part) for mask, part in zip(self.masks, self.parts) if of in part.roles[:1]]
        if not found and of == "head" and any(word.endswith(_OWN) for word in split_name(self.name)):
            return [(~np.logical_or.reduce([~every, *limbs]), None)]
        if not found and snout:  # of what is one with its body there is a snout at most
            found = [(mask, part) for mask, part in zip(self.masks, self.parts) if "nose" in part.roles[:1]]
        if not found and of == "head":  # a word for what is on a head tells that there is one
            found = [(m, part) for m, part in zip(self.masks, self.parts) if "head" in part.roles]
            found *= len(found) == 1
        if not found and of == "head" and (upright or self._overhang is not None):
            masks = [
                make_region_mask(each.moved, self.points) for each in self.find("head", read_places()["head"])
            ]
            return [(mask, None) for mask in masks]
        if of == "head":  # not that with its neck
            found = sorted(found, key=lambda each: int(each[0].sum()))[:1]
        inner = [
            m for m, each in zip(self.masks, self.parts) if not {"ear", "horn"}.isdisjoint(each.roles[:1])
        ]
        return [(mask & ~np.logical_or.reduce([~every, *inner]), part) for mask, part in found]

    def _is_figure(self) -> bool:
        """Return whether something of it shows that it is an animal or a person; a chair has but legs."""
        legs = self._count("leg") and not (self._deck is not None and self._deck.back.any())
        return bool(legs) or any(map(self._count, _FIGURE - {"leg"}))

    def _find_main(self, *, bearing: bool) -> np.ndarray:
        """The particles of the main body: the part that is called as the object is, or all that is no other part."""
        every, own = np.ones(len(self.points), bool), split_name(self.name)
        named = [m for m, part in zip(self.masks, self.parts) if part.name and split_name(part.name) == own]
        if len(named) == 1:
            return named[0]
        inner = _ENDS | (_BEARING if bearing else frozenset())
        off = [m for m, part in zip(self.masks, self.parts) if part.name or inner.isdisjoint(part.roles[:1])]
        return ~np.logical_or.reduce([~every, *off])

    def _is_within(self, parent: np.ndarray, part: Part | None, row: dict[str, Any]) -> np.ndarray:
        """The particles in the ranges of a parent, shape (n,)."""
        mask = np.ones(len(self.points), bool)
        ways = dict(front=self._front, up=_UP)
        ways |= {} if part is None else dict(along=np.asarray(part.arm))
        for key, way in ways.items():
            if key in row:
                place = self._measure(parent, way)
                mask &= (place >= row[key][0]) & (place <= row[key][1])
        if "ring" in row:
            places = [2 * self._measure(parent, way) - 1 for way in np.eye(3)[:2]]
            away = np.hypot(*places)
            mask &= (away >= row["ring"][0]) & (away <= row["ring"][1] * np.sqrt(2))
        aside = row.get("side", row.get("centred"))
        if aside is not None:
            place = np.abs(2 * self._measure(parent, self._side) - 1)
            mask &= (place >= aside[0]) & (place <= aside[1])
        return mask

    def _is_parted(self, inside: np.ndarray) -> bool:
        """Return whether the lower part of a region has a gap in its middle, as two legs have."""
        low = inside & (self._measure(inside, _UP) < _CROTCH)
        off = np.abs(2 * self._measure(low, self._side) - 1)[low]
        return bool((off < _GAP).mean() < 0.4 * _GAP)

    def _measure(self, parent: np.ndarray, way: np.ndarray) -> np.ndarray:
        """Places along a way, from 0 to 1 within a parent, beyond what is trimmed off 0 or 1; shape (n,)."""
        along = self.points @ way
        low, high = np.percentile(along[parent], [_TRIMMED, 100 - _TRIMMED])
        return ((along - low) / max(float(high - low), 1e-12)).clip(0, 1)

    @functools.cached_property
    def _front(self) -> np.ndarray:
        """The level way in which it looks, shape (3,)."""
        if self.heading is not None:
            return self.heading
        heads = [m for m, part in zip(self.masks, self.parts) if not _FORE.isdisjoint(part.roles[:1])]
        if not any(map(self._count, _FIGURE)) and self._deck is not None and self._deck.front is not None:
            return self._deck.front
        off = self.points[heads[0]].mean(0) - self.points.mean(0) if len(heads) == 1 else np.zeros(3)
        off[2] = 0.0
        away = float(np.linalg.norm(off))
        if away > _OFF * np.ptp(self.points, axis=0).max():
            return off / away
        return self.viewer.toward if self._overhang is None else self._overhang

    @functools.cached_property
    def _overhang(self) -> np.ndarray | None:
        return find_overhang(self.points)

    @functools.cached_property
    def _deck(self) -> Deck | None:
        return find_deck(self.points)

    @functools.cached_property
    def _stalk(self) -> float | None:
        """The height at which a slim foot ends below what is broad, as a mushroom's, 0 .. 1; None = it has none."""
        height = np.minimum(
            (self._measure(np.ones(len(self.points), bool), _UP) * _SLICES).astype(int), _SLICES - 1
        )
        known = np.unique(height)
        sides = [np.ptp(self.points[height == k, :2], axis=0).max() for k in known]
        breadth = np.interp(np.arange(_SLICES), known, sides)
        broad = int(breadth.argmax())
        slim = breadth[:broad].min(initial=np.inf)
        if breadth[broad] < _BROADER * slim:
            return None
        is_slim = breadth < slim + _FLARES * (breadth[broad] - slim)
        start = int(is_slim.argmax())  # a foot may be broader than what stands on it
        end = start + int(np.append(~is_slim[start:], True).argmax())
        if end - start < _SLIM_FOR * _SLICES or end > broad:
            return None
        step = breadth[min(end + 1, broad)] / breadth[max(end - 2, start)]  # an egg gets broader evenly
        return end / _SLICES if step > _STEP else None

    @functools.cached_property
    def _side(self) -> np.ndarray:
        """The level way across, to the viewer's right or away from the viewer, shape (3,)."""
        across = np.cross(self._front, _UP)
        turned = float(across @ self.viewer.right)
        return across if turned >= -1e-6 else -across

    def _is_tall(self) -> bool:
        """Return whether it is clearly higher than it is wide, as a statue is."""
        across, deep, height = np.ptp(self.points, axis=0)
        return bool(height > _TALL * max(across, deep))

    def _count(self, role: str) -> int:
        return sum(role in part.roles[:1] for part in self.parts)
