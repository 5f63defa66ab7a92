"""Fragments into which brittle matter breaks: it is weak where two of them meet, and strong inside.

The simulated matter has no flaws, and would fail everywhere at once where it hits the ground. Real matter breaks along
flaws into pieces. The fragments here are the Voronoi cells of points that are spread over the object.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.mpm.pieces import place_seeds

FIRM = 1e4
"""Factor of the strength inside a fragment over that between two."""
CHUNK, FEWEST = 5.0, 4
"""Cells across a fragment at least, of which the seams around it leave some whole; and how many there are of what is
small or slender all the same."""


def count_fragments(most: int, volume: float, dx: float) -> int:
    """The number of fragments that the grid can show: smaller ones would be nothing but seams, and crumble like sand.

    Args:
        most: Number that is asked for.
        volume: The volume of all that breaks [m^3].
        dx: Grid spacing [m].
    """
    return min(most, max(round(volume / (CHUNK * dx) ** 3), FEWEST))


def find_seams(x: np.ndarray, count: int, width: float) -> np.ndarray:
    """Particles where two of ``count`` fragments meet, shape (n,).

    Args:
        x: Positions at rest [m], shape (n, 3).
        count: Number of fragments.
        width: Thickness of the weak layer [m]; less than a cell does not part on the grid.
    """
    count = min(count, len(x))
    if count < 2:
        return np.zeros(len(x), bool)
    seeds = place_seeds(x, count)
    distance, pair = map(np.asarray, KDTree(seeds).query(x, k=2))
    apart = np.linalg.norm(seeds[pair[:, 0]] - seeds[pair[:, 1]], axis=1)
    return (distance[:, 1] ** 2 - distance[:, 0] ** 2) / np.maximum(2 * apart, 1e-12) < width / 2
