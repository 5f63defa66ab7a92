"""The parts of a figure on its base: what stands on a pedestal is looked at by itself, and as finely as any object.

Seen with its pedestal it is a mere lump on top. What is found is told in the frame of the whole.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from physagent_jax.forces.part import Part, PartRole
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.scene.parts.cells import spread

_BASED = 0.3  # length over the object's, above which what is on top is no head but a figure on its base
_LEAST = 0.004  # share of a figure that a part of it has: less is a speck of the capture
_MOST_SEEDS = 256  # of a region
_BASE_SEEDS = 48  # that tell the base from a part of the figure
_HEADS = frozenset(("head", "top", "lid", "crown"))  # roles of what is on top of a figure
_STANDING = frozenset(("top", "bottom"))  # roles of all that is seen of a mere lump on a base
_OWN = frozenset("head ear horn arm wing tail nose finger thumb".split())  # of a figure's other parts
Seeds = tuple[tuple[float, float, float], ...]


def is_figure_on_base(part: Part) -> bool:
    """Return whether a part on top is so high that it is a figure, and what it stands on its base: no loose piece."""
    return part.roles[:1] == ("top",) and abs(part.arm[2]) > _BASED and not part.moved.rigid


def add_figure(
    points: np.ndarray, parts: Sequence[Part], find: Callable[[np.ndarray], tuple[Part, ...]]
) -> tuple[Part, ...]:
    """The parts with those of the figure that is on a base, if there is one.

    Args:
        points: Particles of the object, z up [m], shape (n, 3).
        parts: Its parts.
        find: The parts of what stands by itself.
    """
    figures = [part for part in parts if is_figure_on_base(part)]
    if len(figures) != 1 or not _STANDING.issuperset(part.roles[0] for part in parts):
        return tuple(parts)  # a cactus shows its arms
    mask = ~make_region_mask(figures[0].rest, points)
    if mask.sum() < 2 or mask.all():
        return tuple(parts)
    frame = _Frame(points, points[mask], spread(points[~mask], _BASE_SEEDS))
    told = [part for part in find(points[mask]) if part.share > _LEAST]
    found = [frame.move(part, role) for part in told for role in _name(part)]
    headed = any(part.roles == ("head",) for part in found)
    plain = figures[0].model_copy(update=dict(roles=("top",) if headed else figures[0].roles))
    return (*(plain if part is figures[0] else part for part in parts), *found)


def _name(part: Part) -> tuple[PartRole, ...]:
    """The role that a part has on a figure, as the only item; none for what is no part of one: its feet stay."""
    first = part.roles[0]
    if first in _HEADS:
        return () if is_figure_on_base(part) else ("head",)
    return (first,) if first in _OWN else () if first in ("leg", "bottom") else ("side",)


@dataclasses.dataclass(frozen=True)
class _Frame:
    """The frame of a whole and that of its figure.

    Attributes:
        whole: Particles of the object [m], shape (n, 3).
        figure: Those of the figure [m], shape (k, 3).
        base: Places in what it stands on [m], shape (m, 3).
    """

    whole: np.ndarray
    figure: np.ndarray
    base: np.ndarray

    def move(self, part: Part, role: PartRole) -> Part:
        """A part of the figure, told in the frame of the whole."""
        low, high = self.whole.min(0), self.whole.max(0)
        scale = float(np.ptp(self.figure, axis=0).max() / (high - low).max())
        base = self._place(self.base)
        moved, rest = (self._place(self._lift(seeds)) for seeds in (part.moved.inside, part.rest.inside))
        beside, inner = (self._place(self._lift(seeds)) for seeds in (part.moved.outside, part.rest.outside))
        away = self._lift((part.joint,))[0] + np.asarray(part.arm) * np.ptp(self.figure, axis=0).max()
        side = away - 0.5 * (low + high)
        return part.model_copy(
            update=dict(
                roles=(role,),
                moved=CellsRegion(inside=moved, outside=_thin(beside) + base),
                rest=CellsRegion(inside=_thin(rest) + base, outside=inner),
                joint=self._place(self._lift((part.joint,)))[0],
                arm=tuple(np.round(scale * np.asarray(part.arm), 4).tolist()),
                neck=tuple(np.round(scale * np.asarray(part.neck), 4).tolist()),
                side=tuple(np.round(side / max(float(np.linalg.norm(side)), 1e-12), 4).tolist()),
                share=round(part.share * len(self.figure) / len(self.whole), 4),
            )
        )

    def _lift(self, seeds: Sequence[Sequence[float]]) -> np.ndarray:
        """Places in the world [m] of fractions of the figure's box, shape (k, 3)."""
        return self.figure.min(0) + np.asarray(seeds) * np.ptp(self.figure, axis=0)

    def _place(self, places: np.ndarray) -> Seeds:
        """Fractions of the whole's box."""
        box = np.maximum(np.ptp(self.whole, axis=0), 1e-12)
        return tuple(tuple(np.round((each - self.whole.min(0)) / box, 4).tolist()) for each in places)


def _thin(seeds: Seeds) -> Seeds:
    """At most as many of the seeds as leave a region room for the base's, evenly."""
    return seeds[:: -(-len(seeds) // (_MOST_SEEDS - _BASE_SEEDS))]
