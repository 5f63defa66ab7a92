"""What of a model takes part in a stretch of time.

Forces, obstacles and prescribed motions have windows. Outside them they change nothing but would be computed in every
substep all the same, so that each frame is run with a model that has only those whose windows it meets. Another set
of them is another compiled program; sets recur, so that few are compiled.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from physagent_jax.mpm.fields import iterate_windows
from physagent_jax.mpm.state import Model

_SLACK = 1e-3  # of the stretch: the clock is a sum of substeps, and may be off by round-off


def select_acting(model: Model, begin: float, end: float) -> Model:
    """``model`` with only those forces, boundaries and constraints that may act between ``begin`` and ``end`` [s].

    What has no window (`fields.START`) always acts. The results are those of the whole model.
    """
    slack = _SLACK * (end - begin)

    def select(parts: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(part for part in parts if _may_act(part, begin - slack, end + slack))

    return model.replace(
        forces=select(model.forces),
        boundaries=select(model.boundaries),
        constraints=select(model.constraints),
    )


def _may_act(part: Any, begin: float, end: float) -> bool:
    """Whether a part has no window, or one of them meets [begin, end]."""
    own = list(iterate_windows(part))
    return not own or any(
        np.any((np.asarray(start) <= end) & (np.asarray(stop) >= begin)) for start, stop in own
    )
