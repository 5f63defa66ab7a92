"""The thin parts of a solid: what a ball that fills the thick parts cannot reach.

Opening a solid by balls of growing radius (Serra, "Image analysis and mathematical morphology", 1982) leaves first
ears and tails, then legs and handles, then heads. A connected residue that stays about the same over a range of radii
is a part: it is thin to its end and the body is thick. Where it touches the body at two places, it is a loop.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.scene.parts.lattice import Lattice, find_depth, find_pieces

_FIRST = 1.3  # cells, radius of the smallest ball
_RATIO = 1.17  # of two radii that follow each other
_AROUND = (
    1.45  # radii from a ball's centre that count as filled: edges of a box, at 1.42, do, and corners do not
)
_FEWEST = 6  # cells of a residue
_SAME = 0.6  # share of a residue that has to be in the one before, for both to be one part
_LASTING = 1.3  # range of radii over which a part stays the same


@dataclasses.dataclass(eq=False)
class _Chain:
    """Residues at radii that follow each other, of one part.

    Attributes:
        sets: Nodes of each.
        first, last: Radii of the first and the last [cells].
    """

    sets: list[np.ndarray]
    first: float
    last: float


def find_thin_parts(lattice: Lattice) -> list[np.ndarray]:
    """The nodes of each thin part, each of shape (k,)."""
    depth = find_depth(lattice.fill_vessels())  # thin walls are no parts of a vessel
    done: list[_Chain] = []
    open_chains: list[_Chain] = []
    radius = _FIRST
    while radius < depth.max():
        residues = _find_residues(lattice, depth, radius)
        going, open_chains = open_chains, []
        for nodes in residues:
            before = [chain for chain in going if _is_same(nodes, chain.sets[-1])]
            if len(before) == 1:
                (chain,) = before
                going.remove(chain)
            else:
                chain = _Chain([], radius, radius)
            chain.sets.append(nodes)
            chain.last = radius
            open_chains.append(chain)
        done += going
        radius *= _RATIO
    for chain in open_chains:
        chain.last = float(depth.max())
    return [_choose(chain) for chain in done + open_chains if chain.last / chain.first >= _LASTING]


def _find_residues(lattice: Lattice, depth: np.ndarray, radius: float) -> list[np.ndarray]:
    """The connected sets of nodes that balls of a radius [cells] leave."""
    filled = find_depth(depth < radius) < _AROUND * radius
    labels = find_pieces(lattice.solid & ~filled, corners=False)[lattice.solid]  # in the order of the nodes
    sizes = np.bincount(labels)
    return [np.flatnonzero(labels == k) for k in range(1, len(sizes)) if sizes[k] >= _FEWEST]


def _is_same(one: np.ndarray, other: np.ndarray) -> bool:
    shared = len(np.intersect1d(one, other, assume_unique=True))
    return shared >= _SAME * max(len(one), len(other))


def _choose(chain: _Chain) -> np.ndarray:
    """The first of a chain that is about as large as its largest: later ones lose some of the root."""
    most = max(map(len, chain.sets))
    return next(nodes for nodes in chain.sets if len(nodes) >= 0.9 * most)
