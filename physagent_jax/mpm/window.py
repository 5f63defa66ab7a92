"""The grid window: as many nodes as the object needs, where it needs them.

The grid carries nothing from step to step, so between frames the window may follow the object freely.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.mpm.state import Grid

# A new shape means a new compilation, which costs more than many nodes too many: sides are multiples of a granule, the
# first window has room, a side grows by a good share at once, and those nearly full grow with it. The figures are the
# best of those tried on clips, by the number of shapes and of nodes (docs/decisions.md, "the grid is a window").
_GRANULE = 4
ROOM, _GROWTH = 1.2, 1.7
_NEARLY_FULL, _GROWTH_WITH_IT = 0.85, 1.2


def fit_window(grid: Grid, low: np.ndarray, high: np.ndarray, reach: float) -> Grid:
    """The window for particles within ``low``..``high`` [m] that travel at most ``reach`` [m].

    The window never shrinks, because a new shape means a new compilation.

    Args:
        grid: The present window.
        low: Smallest particle coordinates [m], shape (3,).
        high: Largest particle coordinates [m], shape (3,).
        reach: How far particles may travel before the next fit [m].

    Returns:
        A window inside the domain; ``grid`` itself if it still fits.
    """
    nodes = grid.cells + 1
    first = np.floor((low - reach) / grid.dx - 0.5).astype(int)
    last = np.floor((high + reach) / grid.dx - 0.5).astype(int) + 2
    first, last = np.clip(first, 0, nodes - 3), np.clip(last, 2, nodes - 1)
    origin = np.asarray(grid.origin)
    if np.all(origin <= first) and np.all(last < origin + np.asarray(grid.shape)):
        return grid
    needed = last - first + 1
    shape = _choose_sides(needed, grid.shape, nodes)
    slack = np.asarray(shape) - needed
    origin = np.clip(first - slack // 2, 0, nodes - np.asarray(shape))
    return dataclasses.replace(grid, origin=to_device(origin, np.int32), shape=shape)


def _choose_sides(needed: np.ndarray, have: tuple[int, int, int], most: int) -> tuple[int, int, int]:
    """At least what is needed and what there is, but no more than ``most``."""
    if np.all(needed <= have):
        return have

    def side(need: int, present: int) -> int:
        if present == _GRANULE:
            room = ROOM * need
        elif need > present:
            room = max(need, _GROWTH * present)
        else:
            room = present * (_GROWTH_WITH_IT if need > _NEARLY_FULL * present else 1)
        return min(most, _GRANULE * math.ceil(room / _GRANULE))

    nx, ny, nz = (side(*pair) for pair in zip(needed.tolist(), have))
    return nx, ny, nz


def find_smallest_window(size: float, cells: int) -> Grid:
    """A minimal window of a domain of side ``size`` [m]; `fit_window` grows it to the object."""
    return Grid(to_device(np.zeros(3, np.int32)), (_GRANULE, _GRANULE, _GRANULE), size / cells, cells)
