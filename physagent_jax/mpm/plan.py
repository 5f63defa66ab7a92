"""The parts of a model that act in a stretch of time.

Forces, obstacles and prescribed motions have windows. Outside them they change nothing but would be computed in every
substep all the same, so that each frame is run with a model that has only those whose windows it meets. Another set
of them is another compiled program, which takes seconds: where little work is left, what has acted stays, unless a
part of its kind takes its place. One stroke after another is then one program, and not one more for each. What is to
act later is not let in early: what a simulation and a later one have in common is computed by the same programs.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Hashable
from typing import Any

import jax
import numpy as np

from physagent_jax.mpm.fields import iterate_windows
from physagent_jax.mpm.gridless import needs_grid
from physagent_jax.mpm.state import Model

WORTH = 6e7
"""Particle substeps that are left, above which a frame is run without what does not act in it.

On two cores a part that does not act takes some 0.4 ms of a substep of 20,000 particles, and a program 3 to 8 s.
"""
_SLACK = 1e-3  # of the stretch: the clock is a sum of substeps, and may be off by round-off


@dataclasses.dataclass(frozen=True)
class Acting:
    """The parts of a model that may act, by their places in it."""

    forces: tuple[int, ...]
    boundaries: tuple[int, ...]
    constraints: tuple[int, ...]

    def join(self, other: Acting) -> Acting:
        """The union of these and those."""
        pairs = (
            (getattr(self, field.name), getattr(other, field.name)) for field in dataclasses.fields(self)
        )
        return Acting(*(tuple(sorted({*ours, *theirs})) for ours, theirs in pairs))

    def select(self, model: Model) -> Model:
        """``model`` with only these."""
        return model.replace(
            forces=tuple(model.forces[i] for i in self.forces),
            boundaries=tuple(model.boundaries[i] for i in self.boundaries),
            constraints=tuple(model.constraints[i] for i in self.constraints),
        )


Windows = tuple[tuple[np.ndarray, np.ndarray], ...]
"""Starts and ends [s] of a part's windows; none = it always acts."""


@dataclasses.dataclass(frozen=True)
class Timetable:
    """The times when parts of a model may act: looked up once, asked for every frame.

    Attributes:
        forces, boundaries, constraints: The windows of each, in the model's order.
        kinds: The kinds of these three's parts: one program does for all sets of the same kinds.
    """

    forces: tuple[Windows, ...]
    boundaries: tuple[Windows, ...]
    constraints: tuple[Windows, ...]
    kinds: tuple[tuple[Hashable, ...], ...]

    @classmethod
    def of(cls, model: Model) -> Timetable:
        """Of a model's parts."""
        groups = (model.forces, model.boundaries, model.constraints)
        windows = (tuple(tuple(iterate_windows(part)) for part in parts) for parts in groups)
        return cls(*windows, kinds=tuple(tuple(map(_find_kind, parts)) for parts in groups))

    def find_acting(self, begin: float, end: float) -> Acting:
        """As `find_acting`."""
        slack = _SLACK * (end - begin)

        def find(parts: tuple[Windows, ...]) -> tuple[int, ...]:
            return tuple(i for i, own in enumerate(parts) if _meet(own, begin - slack, end + slack))

        return Acting(find(self.forces), find(self.boundaries), find(self.constraints))

    def choose_acting(
        self, model: Model, begin: float, end: float, work: float, before: Acting | None = None
    ) -> Acting:
        """The parts to compute between ``begin`` and ``end`` [s]: those that act, others if that saves programs.

        Args:
            model: Whose timetable it is.
            begin: Start of the stretch [s].
            end: Its end [s].
            work: Particle substeps that are left.
            before: Parts that were computed in the stretch before; None = there was none.
        """
        acting = self.find_acting(begin, end)
        if before is None or work > WORTH:
            return acting
        kept = Acting(*map(_keep, self.kinds, dataclasses.astuple(before), dataclasses.astuple(acting)))
        spoilt = needs_grid(kept.select(model)) and not needs_grid(acting.select(model))
        return acting if spoilt else kept


def find_acting(model: Model, begin: float, end: float) -> Acting:
    """The forces, boundaries and constraints that may act between ``begin`` and ``end`` [s].

    What has no window (`fields.START`) always acts. Without the others, the results are those of the whole model.
    """
    return Timetable.of(model).find_acting(begin, end)


def _find_kind(part: Any) -> Hashable:
    """Structure of a part, with the shapes and types of its arrays: all that a compiled program depends on."""
    leaves, structure = jax.tree.flatten(part)
    return structure, tuple((np.shape(leaf), np.dtype(getattr(leaf, "dtype", type(leaf)))) for leaf in leaves)


def _keep(kinds: tuple[Hashable, ...], before: tuple[int, ...], acting: tuple[int, ...]) -> tuple[int, ...]:
    """The parts that act, with as many of those before as make up for their kinds, the latest first."""
    spare = Counter(kinds[i] for i in before) - Counter(kinds[i] for i in acting)
    chosen = {*acting}
    for i in reversed(before):
        if i not in chosen and spare[kinds[i]] > 0:
            spare[kinds[i]] -= 1
            chosen.add(i)
    return tuple(sorted(chosen))


def _meet(windows: Windows, begin: float, end: float) -> bool:
    """Return whether there are no windows, or one of them meets [begin, end]."""
    return not windows or any(np.any((start <= end) & (stop >= begin)) for start, stop in windows)
