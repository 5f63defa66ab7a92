"""Connected pieces of a particle cloud, counted frame by frame."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

MOST_PARTICLES = 3000
"""As many are looked at: pieces are large, and a tree over all particles in every frame costs seconds."""
REACH = 3.5
"""Particles belong together up to this many median distances to the nearest neighbour; a random cloud of this reach has
some 30 neighbours per particle, ten times what it needs to hang together."""
LEAST_REACH = 0.02
"""The reach is at least this: a narrower gap is not seen [body lengths]."""
LEAST_SHARE = 0.02
"""Fewer particles are a splinter, not a piece [share of all]."""


def count_pieces(x: np.ndarray, stretches: np.ndarray, size: float) -> list[int]:
    """Connected pieces per frame, without splinters.

    The spacing is learned from frame 0. Each frame is mapped back by the object's overall deformation first, so that a
    uniform stretch, which moves all neighbours apart, tears nothing.

    Args:
        x: Particle positions [m], shape (T, n, 3).
        stretches: Linear part of the overall affine map from frame 0, shape (T, 3, 3).
        size: The body length [m].

    Returns:
        At least 1 per frame.
    """
    x = x[:, :: max(1, x.shape[1] // MOST_PARTICLES)]
    if x.shape[1] < 2:
        return [1] * len(x)
    nearest = KDTree(x[0]).query(x[0], k=2)[0][:, 1]
    reach = max(REACH * float(np.median(nearest)), LEAST_REACH * size)
    return [_count(frame @ _undo(stretch).T, reach) for frame, stretch in zip(x, stretches)]


def _undo(matrix: np.ndarray) -> np.ndarray:
    """Inverse of a deformation where it expands; what it shrinks, it brings no nearer than it is."""
    u, s, vt = np.linalg.svd(matrix)
    return vt.T @ np.diag(1.0 / np.maximum(s, 1.0)) @ u.T


def _count(points: np.ndarray, reach: float) -> int:
    pairs = KDTree(points).query_pairs(reach, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(len(points),) * 2)
    sizes = np.bincount(connected_components(links, directed=False)[1])
    return max(int((sizes >= LEAST_SHARE * len(points)).sum()), 1)
