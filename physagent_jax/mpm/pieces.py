"""Pieces of matter: particles that feel each other through the grid, and fragments that matter is divided into."""

from __future__ import annotations

import numpy as np
from scipy import ndimage
from scipy.spatial import KDTree

CELL = 0.75  # of the simulation's: particles in cells that touch feel each other through the grid

_SEED = 7
_ROUNDS = 2  # of Lloyd's algorithm: cells of different sizes, none of them tiny


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


def place_seeds(x: np.ndarray, count: int) -> np.ndarray:
    """Points whose Voronoi cells divide matter at ``x`` [m], shape (n, 3), into so many fragments, shape (count, 3)."""
    seeds = x[np.random.default_rng(_SEED).choice(len(x), count, replace=False)]
    for _ in range(_ROUNDS):
        nearest = KDTree(seeds).query(x)[1]
        sizes = np.bincount(nearest, minlength=count)
        sums = np.stack([np.bincount(nearest, x[:, axis], minlength=count) for axis in range(3)], axis=1)
        seeds = np.where(sizes[:, None] > 0, sums / np.maximum(sizes, 1)[:, None], seeds)
    return seeds
