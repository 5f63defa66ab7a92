"""Shells that show one side of an object, as lifters of a single photo give them, and the matter behind them.

Such a shell encloses nothing, so that no test of what is inside finds any cell. It is told by five signs along the line
of sight: nearly all columns of cells hold one wall, the wall bulges towards the viewer, its rim lies behind the rest,
the sight is level (a bowl and a dome bulge as much, along the vertical), and nothing was found inside.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

FEWEST = 16  # cells across the outline; in fewer, the front and the back of a thin object are one wall
SINGLE = 0.93  # share of the columns that hold one wall
BULGE = (
    0.15  # of the shorter side of the outline, by which the rim lies behind the most forward part at least
)
BEHIND = 0.85  # share of the rim that lies behind the middle
FULL = 0.5  # of the walls' cells, from which on the inside has been found without this
FAR = 0.9  # quantile of the rim's depth at which the matter ends
STRAYS = 0.02  # share of the columns that may lie before the most forward part
SIDES = {
    "-y": (1, 1),
    "+y": (1, -1),
    "-x": (0, 1),
    "+x": (0, -1),
}  # axis, and the direction of sight along it


def find_behind(wall: np.ndarray, inside: np.ndarray) -> tuple[str, np.ndarray] | None:
    """The cells behind a shell that shows one side of an object.

    Args:
        wall: Cells that hold matter, z up, bool, shape (nx, ny, nz).
        inside: Empty cells that they enclose, bool.

    Returns:
        The side that the shell shows ("-y"), and the empty cells behind it up to its rim, bool; None = it is no shell.
    """
    if inside.sum() > FULL * wall.sum():
        return None
    for side, (axis, sight) in SIDES.items():
        view = np.moveaxis(wall, axis, 0)[::sight]
        behind = _look(view)
        if behind is not None:
            cells = np.moveaxis(behind[::sight], 0, axis)
            return side, cells & ~wall & ~inside
    return None


def _look(view: np.ndarray) -> np.ndarray | None:
    """The cells behind the wall of ``view``, whose first axis runs along the sight, and the wall's; None = no shell."""
    outline = view.any(axis=0)
    runs = view[0].astype(int) + (view[1:] & ~view[:-1]).sum(axis=0)
    if (runs[outline] == 1).mean() < SINGLE:
        return None
    depth = view.argmax(axis=0)
    whole = np.asarray(ndimage.binary_fill_holes(outline))
    rim = outline & ~np.asarray(ndimage.binary_erosion(whole, iterations=2), bool)
    rows, columns = np.nonzero(outline)
    breadth = min(np.ptp(rows), np.ptp(columns)) + 1
    if breadth < FEWEST:
        return None
    most = np.quantile(depth[outline], STRAYS)
    last = (
        view.shape[0] - 1 - view[::-1].argmax(axis=0)
    )  # of each column's wall: the rim itself runs along the sight
    if np.median(last[rim]) - most < BULGE * breadth:
        return None
    if (last[rim] > np.median(depth[outline & ~rim])).mean() < BEHIND:
        return None
    end = int(np.quantile(last[rim], FAR))
    index = np.arange(len(view))[:, None, None]
    return whole & np.logical_or.accumulate(view, axis=0) & (index <= end)
