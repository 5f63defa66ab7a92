"""Pieces of matter: particles that feel each other through the grid, directly or by others between them."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

CELL = 0.75  # of the simulation's: particles in cells that touch feel each other through the grid


def label_pieces(x: np.ndarray, dx: float) -> np.ndarray:
    """The piece of each particle, 0 = the largest, shape (n,); ``x`` [m], shape (n, 3)."""
    cells = np.floor(x / (CELL * dx)).astype(np.int64)
    cells -= cells.min(0)
    filled = np.zeros(cells.max(0) + 1, bool)
    filled[tuple(cells.T)] = True
    found = np.empty(filled.shape, np.int32)
    ndimage.label(filled, structure=np.ones((3, 3, 3)), output=found)
    labels = found[tuple(cells.T)] - 1
    rank = np.argsort(np.argsort(-np.bincount(labels), kind="stable"))
    return np.asarray(rank)[labels]
