"""The likeliest limb for a word, where shape and file tell none for certain: a tail is behind, slim and far out.

`guesses.yaml` says how the limb of each word looks. The best one is taken, and said to be unsure, so that a person can
name another one. Where none looks so, nothing is guessed.
"""

from __future__ import annotations

import functools
from collections.abc import Collection, Sequence
from importlib import resources
from typing import Any

import numpy as np
import yaml
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts.cells import fit_part
from physagent_jax.scene.parts.figures import is_figure_on_base
from physagent_jax.scene.parts.heading import find_overhang
from physagent_jax.scene.parts.lattice import make_lattice
from physagent_jax.scene.parts.mirror import find_mirrors
from physagent_jax.scene.parts.regions import Frame

_LEAST = 0.5  # mean of the measures of what is taken
_CHANCE = 0.5  # that it is meant
_LARGEST, _LARGE = 0.4, 0.08  # share of the figure that a limb has at most, and from which on it is large
_LOOSE = frozenset(("side", "top", "bottom"))  # roles of limbs of which only the place is known
_ON_TOP = 0.6  # of the height, above which the axle of what turns is upright
_NEAR = 0.06  # of the length, within which the image of a particle meets the object
_MET = 0.6  # share of a limb's image that does, where it has one
_FEWEST = 8  # particles


@functools.cache
def read_guesses() -> dict[str, dict[str, Any]]:
    """The rows of the table by their words."""
    text = (resources.files("physagent_jax.scene.parts") / "guesses.yaml").read_text("utf-8")
    return {word: row for row in yaml.safe_load(text) for word in row["words"].split(", ")}


def guess_parts(
    points: np.ndarray, parts: Sequence[Part], words: Collection[str], viewer: Frame
) -> tuple[Part, ...]:
    """The parts that some words are taken to mean, for want of surer ones, so named.

    Args:
        points: Particles at rest, z up [m], shape (n, 3).
        parts: Parts that are known.
        words: Words of a sentence, in lower case.
        viewer: The viewer's directions.
    """
    named = {word.removesuffix("s") for part in parts if part.name for word in split_name(part.name)}
    roles = {role for part in parts for role in part.roles[:1]}
    found: list[Part] = []
    for word in dict.fromkeys(words):
        noun = next((each for each in (word, word.removesuffix("s")) if each in read_guesses()), None)
        row = read_guesses().get(noun or "", {})
        if noun is None or noun in named or roles & {*row.get("role", "").split()}:
            continue
        found += _Looks(points, parts).guess(noun, row, viewer)
    return tuple(found)


class _Looks:
    """The loose limbs of an object, and how they look.

    Attributes:
        points: Particles [m], shape (n, 3).
        parts: All parts.
        whole: The particles among which limbs are compared, those of a figure without its base, shape (n,).
        masks: The particles of each loose limb by its place in ``parts``.
    """

    def __init__(self, points: np.ndarray, parts: Sequence[Part]):
        self.points, self.parts = points, parts
        figures = [part for part in parts if is_figure_on_base(part)]
        self.whole = (
            ~make_region_mask(figures[0].rest, points) if len(figures) == 1 else np.ones(len(points), bool)
        )
        self.masks = {}
        for index, part in enumerate(parts):
            if part.name or part in figures or _LOOSE.isdisjoint(part.roles[:1]):
                continue
            mask = ~make_region_mask(part.rest, points)
            inside = (mask & self.whole).sum() > 0.5 * mask.sum()
            if inside and _FEWEST <= mask.sum() < _LARGEST * self.whole.sum():
                self.masks[index] = mask

    def guess(self, noun: str, row: dict[str, Any], viewer: Frame) -> list[Part]:
        """The limb that a noun is likeliest to mean, with its image if there are two; none if none looks so."""
        scores = {index: self._score(mask, row) for index, mask in self.masks.items()}
        best = max(scores, key=lambda index: scores[index], default=None)
        if best is None or scores[best] < _LEAST:
            return []
        chosen = [(self.parts[best], f"{self.parts[best].roles[0]} (part {best + 1})")]
        if row.get("pair"):
            chosen += self._find_image(best)
        places = [float(np.asarray(part.side) @ viewer.right) for part, _ in chosen]
        names = (
            [noun] if len(chosen) == 1 else [f"{('left', 'right')[p == max(places)]} {noun}" for p in places]
        )
        told = dict(roles=tuple(row.get("role", "").split()[:1]), confidence=_CHANCE, origin="shape")
        if row.get("spins"):
            part = chosen[0][0]
            level = np.array([*part.side[:2], 0.0]) / max(float(np.hypot(*part.side[:2])), 1e-9)
            told |= dict(axle=(0.0, 0.0, 1.0) if part.joint[2] > _ON_TOP else tuple(level.tolist()))
        return [
            part.model_copy(update=told | dict(name=name, stands_for=label))
            for (part, label), name in zip(chosen, names)
        ]

    def _score(self, mask: np.ndarray, row: dict[str, Any]) -> float:
        """The mean of the measures of a limb by their weights, 0 .. 1; those that are not known do not count."""
        known = self._measure(mask)
        weights = {key: row[key] for key in known if key in row}
        return sum(weights[key] * known[key] for key in weights) / max(sum(weights.values()), 1e-9)

    def _measure(self, mask: np.ndarray) -> dict[str, float]:
        own, whole = self.points[mask], self.points[self.whole]
        middle, centre, low = whole.mean(0), own.mean(0), whole[:, 2].min()
        reach = np.linalg.norm((whole - middle)[:, :2], axis=1).max()
        spread = np.sqrt(np.linalg.eigvalsh(np.cov(own.T)).clip(1e-18))
        high = float((own[:, 2].max() - low) / np.ptp(whole[:, 2]))
        away = float(np.linalg.norm((own - middle)[:, :2], axis=1).max() / reach)
        large = min(float(mask.sum() / self.whole.sum()) / _LARGE, 1.0)
        told = dict(high=high, low=1 - float((centre[2] - low) / np.ptp(whole[:, 2])), away=away)
        told |= dict(centred=1 - float(np.linalg.norm((centre - middle)[:2]) / reach))
        told |= dict(slim=1 - spread[1] / spread[2], flat=1 - spread[0] / spread[1], large=large)
        told |= dict(small=1 - large, long=float(np.ptp(own, axis=0).max() / np.ptp(whole, axis=0).max()))
        if self._front is not None:
            along = float((centre - middle) @ self._front / np.abs((whole - middle) @ self._front).max())
            told |= dict(ahead=max(along, 0.0), behind=max(-along, 0.0))
        return {key: float(np.clip(value, 0.0, 1.0)) for key, value in told.items()}

    def _find_image(self, index: int) -> list[tuple[Part, str]]:
        """The image of a limb in the upright mirror plane, as a part; none if nothing is there, or it is its own."""
        whole, own = self.points[self.whole], self.points[self.masks[index]]
        size = float(np.ptp(whole, axis=0).max())
        mirror = find_mirrors(make_lattice(whole))[0]
        images = mirror.reflect(own)
        met = np.asarray(KDTree(whole).query(images)[0]) < _NEAR * size
        across = abs(float(mirror.measure(own.mean(0)))) > 0.5 * float(
            np.abs(mirror.measure(own)).std() + 1e-12
        )
        mask = np.asarray(KDTree(images).query(self.points)[0]) < _NEAR * size
        mask &= self.whole & ~self.masks[index]
        if met.mean() < _MET or not across or mask.sum() < _FEWEST:
            return []
        part, like = fit_part(self.points, mask, joined=True), self.parts[index]
        low, box = self.points.min(0), np.maximum(np.ptp(self.points, axis=0), 1e-12)
        joint = (mirror.reflect(low + np.asarray(like.joint) * box) - low) / box
        arm = np.asarray(like.arm) - 2 * (np.asarray(like.arm) @ mirror.normal) * mirror.normal
        told = {key: tuple(np.round(each, 4).tolist()) for key, each in (("joint", joint), ("arm", arm))}
        told |= dict(seated=like.seated, neck=like.neck)
        return [(part.model_copy(update=told), f"the image of part {index + 1}")]

    @functools.cached_property
    def _front(self) -> np.ndarray | None:
        """The level way in which it looks, by its head, else by what overhangs; None if neither tells it."""
        whole = self.points[self.whole]
        heads = [part for part in self.parts if "head" in part.roles[:1]]
        if len(heads) != 1:
            return find_overhang(whole)
        off = self.points[~make_region_mask(heads[0].rest, self.points)].mean(0) - whole.mean(0)
        off[2] = 0.0
        away = float(np.linalg.norm(off))
        return off / away if away > 0.1 * float(np.ptp(whole, axis=0).max()) else find_overhang(whole)
