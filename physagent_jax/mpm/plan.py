"""What of a model takes part in a stretch of time.

Forces, obstacles and prescribed motions have windows. Outside them they change nothing but would be computed in every
substep all the same, so that each frame is run with a model that has only those whose windows it meets. Another set
of them is another compiled program; sets recur, so that few are compiled.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from physagent_jax.mpm.fields import iterate_windows
from physagent_jax.mpm.state import Model

_SLACK = 1e-3  # of the stretch: the clock is a sum of substeps, and may be off by round-off


@dataclasses.dataclass(frozen=True)
class Acting:
    """Which parts of a model may act, by their places in it."""

    forces: tuple[int, ...]
    boundaries: tuple[int, ...]
    constraints: tuple[int, ...]

    def join(self, other: Acting) -> Acting:
        """What is among these or those."""
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


def find_acting(model: Model, begin: float, end: float) -> Acting:
    """The forces, boundaries and constraints that may act between ``begin`` and ``end`` [s].

    What has no window (`fields.START`) always acts. Without the others, the results are those of the whole model.
    """
    slack = _SLACK * (end - begin)

    def find(parts: tuple[Any, ...]) -> tuple[int, ...]:
        return tuple(i for i, part in enumerate(parts) if _may_act(part, begin - slack, end + slack))

    return Acting(find(model.forces), find(model.boundaries), find(model.constraints))


def _may_act(part: Any, begin: float, end: float) -> bool:
    """Whether a part has no window, or one of them meets [begin, end]."""
    own = list(iterate_windows(part))
    return not own or any(np.any((start <= end) & (stop >= begin)) for start, stop in own)
