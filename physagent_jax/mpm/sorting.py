"""The order of particles in memory.

Neighbours in space that are neighbours in memory find their nodes in the processor's caches, and threads with
contiguous shares of the particles touch few of the same planes of the grid. A solid keeps its neighbours, so that
sorting it once, at rest, pays for the whole run.
"""

from __future__ import annotations

import numpy as np


def cell_order(x: np.ndarray, dx: float, group: np.ndarray | None = None) -> np.ndarray:
    """The particles' indices, cell by cell, the cells in the grid's own order in memory.

    Args:
        x: Positions [m], shape (n, 3).
        dx: Spacing of the grid [m].
        group: Particles of equal group stay together, the groups in ascending order; shape (n,). Materials need this
            (`Model.materials`). None = one group.

    Returns:
        Shape (n,). Particles of the same cell keep their order.
    """
    i, j, k = np.floor(np.asarray(x) / dx).astype(np.int64).T
    keys = (k, j, i) if group is None else (k, j, i, np.asarray(group))
    return np.lexsort(keys)
