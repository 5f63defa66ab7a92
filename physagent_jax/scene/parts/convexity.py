"""The blunt parts of a solid: what sees itself, and little of the rest.

A head without a neck, short ears on it and a folded wing are neither thin nor far from the rest, but nearly convex:
within them lines of sight stay inside, and lines to the rest leave the solid where it is concave (Asafi, Goren and
Cohen-Or, SGP 2013, "Weak convex decomposition by lines-of-sight"). Patches that touch are joined by how much of each
other they see, most first. What has been joined is a part while it is about convex, and is cut where it next would meet
what it sees little of.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from physagent_jax.scene.parts.cells import spread
from physagent_jax.scene.parts.lattice import Lattice, find_pieces

_PATCHES, _EYES = 140, 3  # patches of a solid; places of each that are looked from
_STEPS = 24  # of a line of sight
_OUTSIDE = 0.1  # of a line, that may be outside: lattices are rough
_LEVELS = (
    0.9,
    0.85,
    0.8,
)  # shares of its own lines of sight that a part has, and would have no more with the next
_LEAST = 3  # patches
_LOOSE = 0.6  # share of a part that a patch sees, below which it only hangs on it
_WHOLE = 0.98  # share of the rest that is in one piece


def find_convex_parts(lattice: Lattice) -> list[np.ndarray]:
    """The nodes of each part, each of shape (k,), smaller ones first."""
    owner, first, second = _divide(lattice)
    seen = _look(lattice, owner)
    count = len(seen)
    touch = np.zeros((count, count), bool)
    touch[owner[first], owner[second]] = True
    touch |= touch.T
    np.fill_diagonal(touch, False)
    sizes = np.bincount(owner, minlength=count).astype(float)
    lines = seen * np.outer(sizes, sizes)  # between two clusters; on the diagonal within one
    members = [[k] for k in range(count)]
    alive = np.ones(count, bool)
    found: list[np.ndarray] = []
    while alive.sum() > 1:
        share = np.where(touch, lines / np.outer(sizes, sizes), -1.0)
        one, other = np.unravel_index(share.argmax(), share.shape)
        if share[one, other] < 0:
            break
        both = lines[one] + lines[other]
        within = lines[one, one] + lines[other, other] + 2 * lines[one, other]
        joined = within / (sizes[one] + sizes[other]) ** 2
        for k in (one, other):
            own = lines[k, k] / sizes[k] ** 2
            if any(joined < level <= own for level in _LEVELS) and len(members[k]) >= _LEAST:
                kept = np.array(members[k])
                kept = kept[seen[np.ix_(kept, kept)].mean(1) > _LOOSE]
                found.append(np.flatnonzero(np.isin(owner, kept)))
        lines[one], lines[:, one], lines[one, one] = both, both, within
        touch[one] |= touch[other]
        touch[:, one] |= touch[:, other]
        touch[one, one] = False
        touch[other], touch[:, other] = False, False
        sizes[one] += sizes[other]
        members[one] += members[other]
        alive[other] = False
    return sorted((nodes for nodes in found if len(nodes) and _is_end(lattice, nodes)), key=len)


def _is_end(lattice: Lattice, nodes: np.ndarray) -> bool:
    """Return whether the rest holds together without a part: a thigh is no end."""
    sizes = np.bincount(find_pieces(lattice.solid & ~lattice.make_mask(nodes)).ravel())[1:]
    return len(sizes) > 0 and bool(sizes.max() > _WHOLE * sizes.sum())


def _divide(lattice: Lattice) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The patch of each node, shape (n,), and the pairs of nodes that touch, shape (e,) each."""
    firsts, seconds = [], []
    for axis in range(3):
        low, high = (np.moveaxis(lattice.node, axis, 0)[cut] for cut in (slice(None, -1), slice(1, None)))
        both = (low >= 0) & (high >= 0)
        firsts.append(low[both])
        seconds.append(high[both])
    first, second = np.concatenate(firsts), np.concatenate(seconds)
    count = len(lattice.places)
    matrix = coo_matrix((np.ones(len(first)), (first, second)), (count, count)).tocsr()
    seeds = spread(lattice.places, _PATCHES)
    order = {place.tobytes(): k for k, place in enumerate(lattice.places)}
    nodes = np.array([order[place.tobytes()] for place in seeds])
    _, _, source = dijkstra(matrix, directed=False, indices=nodes, min_only=True, return_predecessors=True)
    number = np.full(count + 1, 0)
    number[nodes] = np.arange(len(nodes))
    return number[np.where(source >= 0, source, nodes[0])], first, second


def _look(lattice: Lattice, owner: np.ndarray) -> np.ndarray:
    """The share of lines of sight between each two patches that stay inside, shape (k, k)."""
    chance = np.random.default_rng(0)
    count = owner.max() + 1
    order = chance.permutation(len(owner))
    eyes = np.stack([chance.choice(order[owner[order] == k], _EYES) for k in range(count)])
    at = np.argwhere(lattice.solid)[eyes.ravel()].astype(float)
    a, b = np.triu_indices(len(at))
    starts, ways = at[a].T.copy(), (at[b] - at[a]).T.copy()  # one axis after the other is four times as fast
    air, (_, rows, columns) = ~lattice.solid.ravel(), lattice.solid.shape
    outside = np.zeros(len(a), np.int8)
    for step in (np.arange(_STEPS) + 0.5) / _STEPS:
        i, j, k = np.rint(starts + step * ways)
        outside += air[((i * rows + j) * columns + k).astype(int)]
    sees = np.zeros((len(at), len(at)))
    sees[a, b] = sees[b, a] = outside <= _OUTSIDE * _STEPS
    return sees.reshape(count, _EYES, count, _EYES).mean((1, 3))
