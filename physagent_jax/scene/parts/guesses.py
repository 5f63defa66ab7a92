"""The likeliest limb or shell for a word, where nothing tells it for certain: a tail is behind, slim and far out.

`guesses.yaml` says how the part of each word looks. The best one is taken, and said to be unsure, so that a person can
name another one. Where none looks so, nothing is guessed. Shells of a mesh (`shells.py`) are looked through before
limbs: their borders are those of what was modelled.
"""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Collection, Iterable, Sequence
from importlib import resources
from typing import Any

import numpy as np
import yaml
from scipy.spatial import KDTree

from physagent_jax.forces.part import SIDES, Part, get_singular, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts.cells import fit_part
from physagent_jax.scene.parts.figures import is_figure_on_base
from physagent_jax.scene.parts.heading import find_heading, find_overhang
from physagent_jax.scene.parts.lattice import make_lattice
from physagent_jax.scene.parts.looks import Looks
from physagent_jax.scene.parts.mirror import Mirror, find_mirrors
from physagent_jax.scene.parts.regions import Frame
from physagent_jax.scene.parts.shells import Shells, find_shells
from physagent_jax.scene.parts.tools import Tool, find_tool

_LEAST, _LEAST_SHELL = 0.5, 0.62  # mean of the measures of what is taken, of a limb and of shells
_CHANCE = 0.5  # that it is meant
_LIKELY = 0.75  # the same of what looks like it in nearly all
_CLEAR, _AHEAD = (
    0.85,
    0.15,
)  # mean of the measures of such, and by how much more that is than of anything else
_ALONE, _FAR_AHEAD = (
    0.75,
    0.4,
)  # the same of what is alone of its kind: a slim cork, where no other piece is like one
_LARGEST = 0.4  # share of the figure that a limb has at most
_BULK = 0.5  # the same of shells: what is more is the object itself
_LOOSE = frozenset(("side", "top", "bottom"))  # roles of limbs of which only the place is known
_ON_TOP = 0.6  # of the height, above which the axle of what turns is upright
_THIN = 0.5  # spread along an axle over that across, up to which it tells the axle
_NEAR = 0.06  # of the length, within which the image of a particle meets the object
_MET = 0.6  # share of a limb's image that does, where it has one
_FEWEST = 8  # particles
_LIKE, _AS_LIKELY = 1.5, 0.85  # ratio of what is alike, at most; of the best score, that it has at least
_NEARLY = 0.9  # of the best score, that what holds the best one has at least
_NAMED = 0.75  # overlap (intersection over union) from which on a shell is a part that has a name: a hat is half a head
_APART_BY = 0.15  # of the length, by which places are on different sides
_APART = 0.1  # share of the smaller one in the larger, up to which two are apart


_SWEPT, _BORDER = 1.05, 0.02  # of the radius of a disc; share of a shell beyond that of what turns with it
_TOPPER = "topper"  # its row is that of whatever sits on top
_RAISED = "rotor"  # its row is that of whatever turns on a stand
_BLADE, _WHEEL = "blade", "wheel"  # of a tool: a wheel is a blade that is a disc
_BORNE = re.compile(
    r"\b(?:legs?|feet|stand|base|frame|supports?|tower|pole|post|tripod|pedestal|mount)\b[^,;.]*? "
    r"(?:stays?|keeps?|remains?|stands?|is|are|held|do not move|does not move|don't move|doesn't move)\b"
)
_ON_TOP_OF = re.compile(
    r"\b(?:the|its|his|her|their) (?:[a-z]+ ){0,3}?([a-z]+) (?:on|atop|on top of) (?:the|its|his|her|their)(?: [a-z]+)?"
    r" (?:roof|top|lid|head)\b|\b(?:the|its|his|her|their) (?:[a-z]+ ){0,3}?([a-z]+) on top\b"
)


@functools.cache
def read_guesses() -> dict[str, dict[str, Any]]:
    """The rows of the table by their words."""
    text = (resources.files("physagent_jax.scene.parts") / "guesses.yaml").read_text("utf-8")
    return {word: row for row in yaml.safe_load(text) for word in row["words"].split(", ")}


def guess_parts(
    points: np.ndarray,
    parts: Sequence[Part],
    words: Collection[str],
    viewer: Frame,
    shells: Shells | None = None,
    name: str = "",
    sentence: str = "",
    colours: np.ndarray | None = None,
) -> tuple[Part, ...]:
    """The parts that some words are taken to mean, for want of surer ones, so named.

    Args:
        points: Particles at rest, z up [m], shape (n, 3).
        parts: Parts that are known.
        words: Words of a sentence, in lower case.
        viewer: The viewer's directions.
        shells: Its shells; None = it has one alone.
        name: What the object is called; its words are no part's.
        sentence: The sentence, which may tell that something sits on top: "the cone on the roof".
        colours: Colours of the particles, 0 .. 1, shape (n, 3); None = not known.
    """
    on_top = {noun for pair in _ON_TOP_OF.findall(sentence.lower()) for noun in pair if noun}
    named = {word.removesuffix("s") for part in parts if part.name for word in split_name(part.name)}
    own, found = {*split_name(name)}, []
    search = _Search(points, parts, viewer, shells or find_shells(points), colours)
    for word in dict.fromkeys(words):
        noun = next((each for each in (word, get_singular(word)) if each in read_guesses()), None)
        noun = noun or (word if word in on_top else None)
        row = read_guesses().get(noun or "", read_guesses()[_TOPPER] if noun else {})
        if noun is None or {noun, noun.removesuffix("s")} & named:
            continue
        if any(each.endswith(noun) for each in own) and (row.get("rolls") or row.get("spins")):
            if _BORNE.search(
                sentence.lower()
            ):  # "the wheel turns while the legs stay put", of a ferris wheel
                found += search.guess(noun, read_guesses()[_RAISED], several=False, whole=True)
        elif noun not in own and not search.knows(row):
            found += search.find_of_tool(noun, row) or search.guess(
                noun, row, several=word != noun or not SIDES.isdisjoint(words)
            )
    return tuple(found)


@dataclasses.dataclass(frozen=True)
class _Candidate:
    """A limb or some shells that a word may mean.

    Attributes:
        mask: Its particles, shape (n,).
        part: The limb; None = shells.
        label: What it is told to be.
    """

    mask: np.ndarray
    part: Part | None
    label: str


@dataclasses.dataclass(frozen=True)
class _Search:
    """The candidates of an object for words."""

    points: np.ndarray
    parts: Sequence[Part]
    viewer: Frame
    shells: Shells
    colours: np.ndarray | None

    def knows(self, row: dict[str, Any]) -> bool:
        """Return whether there are parts of a row's roles whose borders are not across shells."""
        roles = {*row.get("role", "").split()}
        told = [part for part in self.parts if roles & {*part.roles[:1]} and not part.unsure]
        likely = [part for part in self.parts if roles & {*part.roles}]
        told += likely if len(likely) == 2 and not row.get("many") else []  # two that may be it are the pair
        return any(not self.shells.are_cut(~make_region_mask(each.rest, self.points)) for each in told)

    def find_of_tool(self, noun: str, row: dict[str, Any]) -> list[Part]:
        """The blade or the handle of a tool, as the surfaces show it; none if it is no tool, or has no word for it."""
        blade = noun in (_BLADE, _WHEEL)
        tool = self._tool if blade or "handle" in row.get("role", "").split()[:1] else None
        if tool is None or noun == _WHEEL and not tool.turns:
            return []
        mask, turns = tool.blade if blade else tool.handle, blade and tool.turns
        part = fit_part(self.points, mask, joined=not turns, wheel=turns, blades=turns)
        return list(self._name(noun, row, [_Candidate(mask, part, "the surfaces at one end")], _LIKELY))

    def guess(self, noun: str, row: dict[str, Any], *, several: bool, whole: bool = False) -> list[Part]:
        """The parts that a noun is likeliest to mean; none if none looks so.

        Args:
            noun: The noun.
            row: The measures of its looks.
            several: Whether all that are alike are meant.
            whole: Whether all that turns about its axle is meant.
        """
        for faintest, candidates in ((_LEAST_SHELL, self._shells), (_LEAST, self._limbs)):
            own_pieces = candidates is self._shells  # whose borders are the file's, and no guess
            scores = self._looks.score([each.mask for each in candidates], row, coloured=own_pieces)
            best = int(np.argmax(scores)) if scores else -1
            fits = self._looks.knows(row) if own_pieces else row.get("limb")
            if best < 0 or scores[best] < faintest or not fits:
                continue
            chosen = [self._widen(candidates[best], candidates, scores, scores[best])]
            if whole:
                chosen = [self._sweep(chosen[0])]
            if row.get("pair") or row.get("many"):
                chosen += self._list_alike(chosen[0], list(zip(scores, candidates)), scores[best])
                if len(chosen) == 1 and row.get("pair"):
                    chosen += self._find_image(chosen[0])
            least = _CLEAR if len(chosen) == 1 else _LEAST_SHELL  # twins that nothing else is like are meant
            rivals = [
                own
                for each, own in zip(candidates, scores)
                if all((each.mask & one.mask).sum() < _APART * each.mask.sum() for one in chosen)
            ]
            if row.get("many") and not several:
                chosen = [
                    max(chosen, key=lambda each: float((self.points[each.mask] @ self.viewer.toward).mean()))
                ]
            rival = max(rivals, default=0.0)
            alone = scores[best] > max(_ALONE, rival + _FAR_AHEAD)
            clear = own_pieces and (alone or scores[best] > max(least, rival + _AHEAD))
            return list(self._name(noun, row, chosen, _LIKELY if clear else _CHANCE))
        return []

    def _widen(
        self, best: _Candidate, candidates: list[_Candidate], scores: list[float], score: float
    ) -> _Candidate:
        """The largest candidate that holds the best one and looks nearly as likely: a fan of several blades."""
        holding = [
            each
            for each, own in zip(candidates, scores)
            if own > _NEARLY * score and (each.mask & best.mask).sum() > 0.9 * best.mask.sum()
        ]
        return max(holding, key=lambda each: int(each.mask.sum()))

    def _sweep(self, disc: _Candidate) -> _Candidate:
        """A disc with the shells that do not reach out of it, as the spokes, the hub and the other rim do not."""
        own = self.points[disc.mask]
        axle = np.linalg.eigh(np.cov(own.T))[1][:, 0]
        off = self.points - own.mean(0)
        away = np.linalg.norm(off - np.outer(off @ axle, axle), axis=1)
        reach = _SWEPT * float(away[disc.mask].max())
        labels = self.shells.labels
        far = np.bincount(labels, away > reach) > _BORDER * np.bincount(labels)
        return dataclasses.replace(disc, mask=disc.mask | ~far[labels])

    def _name(
        self, noun: str, row: dict[str, Any], chosen: list[_Candidate], chance: float
    ) -> Iterable[Part]:
        """The candidates as parts, with their sides in their names where these tell them apart, else with numbers."""
        sides = self._list_sides([self.points[each.mask].mean(0) for each in chosen], row)
        told: dict[str, Any] = dict(
            roles=tuple(row.get("role", "").split()[:1]), confidence=chance, origin="shape"
        )
        for number, (each, side) in enumerate(zip(chosen, sides), 1):
            wheel = bool(row.get("spins") or row.get("rolls"))
            part = each.part or fit_part(self.points, each.mask, joined=False, wheel=wheel)
            if row.get("spins") and part.axle is None:
                level = np.array([*part.side[:2], 0.0]) / max(float(np.hypot(*part.side[:2])), 1e-9)
                plain = np.array([0.0, 0.0, 1.0]) if part.joint[2] > _ON_TOP else level
                spread, axes = np.linalg.eigh(np.cov(self.points[each.mask].T))
                axle = axes[:, 0] if spread[0] < _THIN**2 * spread[1] else plain  # blades lie across it
                told |= dict(axle=tuple(np.round(axle, 4).tolist()))
            name = f"{side} {noun}" if len({*sides}) == len(sides) else f"{noun} {number}"
            yield part.model_copy(update=told | dict(name=name.strip(), stands_for=each.label))

    def _list_sides(self, places: list[np.ndarray], row: dict[str, Any]) -> list[str]:
        """The words for where each of some places is among them: "front left"; empty for one alone."""
        ways = [(np.array([0.0, 0.0, 1.0]), ("upper", "lower")), (self.viewer.right, ("right", "left"))]
        if self._front is not None and row.get("many"):
            ways.insert(0, (self._front, ("front", "rear")))
        size = float(np.ptp(self.points, axis=0).max())
        words: list[list[str]] = [[] for _ in places]
        for way, names in ways:
            along = np.array([place @ way for place in places])
            if np.ptp(along) > _APART_BY * size:
                for told, here in zip(words, along > 0.5 * (along.min() + along.max())):
                    told.append(names[0] if here else names[1])
        return [" ".join(told) for told in words]

    def _list_alike(
        self, first: _Candidate, others: list[tuple[float, _Candidate]], best: float
    ) -> list[_Candidate]:
        """The candidates that are as large as one, look about as likely, and are apart from it and each other."""
        found = [first]
        slack = 0.02 * float(np.ptp(self.points, axis=0).max())
        for score, each in sorted(others, key=lambda other: -other[0]):
            ratio = each.mask.sum() / first.mask.sum()
            sizes = zip(*(self._measure_sides(one.mask) for one in (first, each)))
            alike = 1 / _LIKE < ratio < _LIKE and any(
                (np.abs(own - other) < 0.25 * max(own[-1], other[-1]) + slack).all() for own, other in sizes
            )
            apart = all((each.mask & one.mask).sum() < _APART * each.mask.sum() for one in found)
            if alike and apart and score > _AS_LIKELY * best:
                found.append(each)
        return found[1:]

    def _measure_sides(self, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sides of a part's box along the world's axes and along its own [m], shape (3,) each."""
        own = self.points[mask]
        axes = np.linalg.eigh(np.cov(own.T))[1]
        return np.sort(np.ptp(own, axis=0)), np.sort(np.ptp(own @ axes, axis=0))

    @functools.cached_property
    def _whole(self) -> np.ndarray:
        """The particles among which limbs are compared, those of a figure without its base, shape (n,)."""
        figures = [part for part in self.parts if is_figure_on_base(part)]
        if len(figures) != 1:
            return np.ones(len(self.points), bool)
        return ~make_region_mask(figures[0].rest, self.points)

    @functools.cached_property
    def _limbs(self) -> list[_Candidate]:
        """The limbs of which only the place is known."""
        found = []
        for index, part in enumerate(self.parts):
            if part.name or is_figure_on_base(part) or _LOOSE.isdisjoint(part.roles[:1]):
                continue
            mask = ~make_region_mask(part.rest, self.points)
            inside = (mask & self._whole).sum() > 0.5 * mask.sum()
            if inside and _FEWEST <= mask.sum() < _LARGEST * self._whole.sum():
                found.append(_Candidate(mask, part, f"{part.roles[0]} (part {index + 1})"))
        return found

    @functools.cached_property
    def _shells(self) -> list[_Candidate]:
        """The shells that the file has no other name for."""
        named = [~make_region_mask(part.rest, self.points) for part in self.parts if part.name]
        free = [
            mask
            for mask in self.shells.candidates
            if all((mask & each).sum() < _NAMED * (mask | each).sum() for each in named)
            and mask.sum() < _BULK * self._whole.sum()
        ]
        return [_Candidate(mask, None, "a piece of the surface") for mask in free]

    @functools.cached_property
    def _tool(self) -> Tool | None:
        return find_tool(self.points, self.shells.labels)

    @functools.cached_property
    def _looks(self) -> Looks:
        return Looks(self.points, self._whole, self._front, self.viewer.toward, self.colours)

    @functools.cached_property
    def _mirror(self) -> Mirror:
        return find_mirrors(make_lattice(self.points[self._whole]))[0]

    def _find_image(self, limb: _Candidate) -> list[_Candidate]:
        """The image of a limb in the upright mirror plane, as a part; none if nothing is there, or it is its own."""
        whole, own = self.points[self._whole], self.points[limb.mask]
        size, mirror = float(np.ptp(whole, axis=0).max()), self._mirror
        images = mirror.reflect(own)
        met = np.asarray(KDTree(whole).query(images)[0]) < _NEAR * size
        across = abs(float(mirror.measure(own.mean(0)))) > 0.5 * float(
            np.abs(mirror.measure(own)).std() + 1e-12
        )
        mask = np.asarray(KDTree(images).query(self.points)[0]) < _NEAR * size
        mask &= self._whole & ~limb.mask
        if met.mean() < _MET or not across or mask.sum() < _FEWEST or limb.part is None:
            return []
        part, like = fit_part(self.points, mask, joined=True), limb.part
        low, box = self.points.min(0), np.maximum(np.ptp(self.points, axis=0), 1e-12)
        joint = (mirror.reflect(low + np.asarray(like.joint) * box) - low) / box
        arm = np.asarray(like.arm) - 2 * (np.asarray(like.arm) @ mirror.normal) * mirror.normal
        told = {key: tuple(np.round(each, 4).tolist()) for key, each in (("joint", joint), ("arm", arm))}
        told |= dict(seated=like.seated, neck=like.neck)
        label = f"the image of {limb.label.partition('(')[2].rstrip(')')}"
        return [_Candidate(mask, part.model_copy(update=told), label)]

    @functools.cached_property
    def _front(self) -> np.ndarray | None:
        """The level way in which it looks, by its head, by what overhangs, or as a vehicle does; None = not told."""
        whole = self.points[self._whole]
        heads = [part for part in self.parts if "head" in part.roles[:1]]
        overhang = find_overhang(whole)
        if len(heads) != 1:
            heading = find_heading(self.points, self.parts) if overhang is None else None
            return overhang if heading is None else heading[0]
        off = self.points[~make_region_mask(heads[0].rest, self.points)].mean(0) - whole.mean(0)
        off[2] = 0.0
        away = float(np.linalg.norm(off))
        return off / away if away > 0.1 * float(np.ptp(whole, axis=0).max()) else overhang
