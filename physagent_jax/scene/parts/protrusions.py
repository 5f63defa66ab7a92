"""The protrusions of a particle cloud, as a tree of parts.

Arms, ears, handles and heads are where matter is far from the rest of the object, along the object. The average
geodesic distance says how far (Hilaga et al., SIGGRAPH 2001, "Topology matching"). Its superlevel sets begin at the
tips and grow until they merge: a tip whose set has grown by enough before it merges with that of a farther tip is a
protrusion, cut where they meet (persistence, as in Skraba et al., NORDIA 2010, "Persistence-based segmentation of
deformable shapes"). What has merged goes on growing as one: two ears and a muzzle make a head.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

_CELLS = 30  # along the longest side, of the grid that the graph lives on
_BASES = 48  # nodes from which distances are averaged
_LEAST = 0.07  # growth of a protrusion over the range of the average distance
_FEWEST = 5  # nodes
_LARGER = 1.4  # times the protrusions inside it, that one more has to be


@dataclasses.dataclass(frozen=True)
class Graph:
    """A cloud as a graph of occupied grid cells.

    Attributes:
        places: Centre of mass of each cell's particles [m], shape (n, 3).
        weights: Share of the particles, shape (n,).
        first, second: Ends of its edges, each once, shape (e,).
    """

    places: np.ndarray
    weights: np.ndarray
    first: np.ndarray
    second: np.ndarray


def make_graph(points: np.ndarray) -> Graph:
    """The largest connected piece of a cloud, as occupied cells joined to their 26 neighbours.

    Args:
        points: Positions [m], shape (n, 3).
    """
    low, size = points.min(0), max(float(np.ptp(points, axis=0).max()), 1e-12)
    step = 2  # room for the neighbours' offsets
    index = np.floor((points - low) / size * (_CELLS - 1e-6)).astype(np.int64) + step
    stride = np.array([(_CELLS + 2 * step) ** 2, _CELLS + 2 * step, 1])
    keys, inverse, counts = np.unique(index @ stride, return_inverse=True, return_counts=True)
    places = np.stack([np.bincount(inverse, points[:, k]) / counts for k in range(3)], axis=1)
    offsets = np.array([(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]) @ stride
    firsts, seconds = [], []
    for offset in offsets[offsets > 0]:
        at = np.searchsorted(keys, keys + offset)
        found = (at < len(keys)) & (keys[np.minimum(at, len(keys) - 1)] == keys + offset)
        firsts.append(np.flatnonzero(found))
        seconds.append(at[found])
    first, second = np.concatenate(firsts), np.concatenate(seconds)
    count = len(keys)
    labels = connected_components(coo_matrix((np.ones(len(first)), (first, second)), (count, count)))[1]
    kept = labels == np.bincount(labels, counts).argmax()
    new = np.cumsum(kept) - 1
    inside = kept[first]
    return Graph(places[kept], counts[kept] / counts[kept].sum(), new[first[inside]], new[second[inside]])


def measure_distance(graph: Graph, seed: int = 0) -> np.ndarray:
    """The average geodesic distance of each node [m], shape (n,), from a sample of all."""
    count = len(graph.places)
    length = np.linalg.norm(graph.places[graph.first] - graph.places[graph.second], axis=1)
    matrix = coo_matrix((length, (graph.first, graph.second)), (count, count)).tocsr()
    chance = np.random.default_rng(seed)
    bases = chance.choice(count, min(_BASES, count), replace=False, p=graph.weights)
    return dijkstra(matrix, directed=False, indices=bases).mean(0)


def find_protrusions(graph: Graph) -> list[np.ndarray]:
    """The nodes of each protrusion, each of shape (k,), smaller ones before those that they are part of."""
    distance = measure_distance(graph)
    neighbours = _list_neighbours(graph)
    least = _LEAST * float(np.ptp(distance))
    root = np.full(len(distance), -1)
    sets: dict[int, _Set] = {}
    found: list[np.ndarray] = []

    def find(node: int) -> int:
        while root[node] != node:
            root[node] = root[root[node]]
            node = root[node]
        return node

    for node in map(int, np.argsort(-distance)):
        level = float(distance[node])
        met = {find(int(other)) for other in neighbours[node] if root[other] >= 0}
        grown = [each for each in met if distance[sets[each].tip] - level >= least]
        if len(grown) > 1:
            for each in grown:
                inner = sum(len(found[child]) for child in sets[each].children)
                if len(sets[each].nodes) >= max(_FEWEST, _LARGER * inner):
                    found.append(np.array(sets[each].nodes))
                    sets[each].children = [len(found) - 1]
        root[node], sets[node] = node, _Set(node, [node], [])
        for each in met:
            here = find(node)
            big, small = sorted((here, each), key=lambda one: -len(sets[one].nodes))
            root[small] = big
            sets[big].merge(sets.pop(small), distance)
    return found


@dataclasses.dataclass
class _Set:
    """A growing superlevel set: its farthest node, its nodes, and the protrusions inside it."""

    tip: int
    nodes: list[int]
    children: list[int]

    def merge(self, other: _Set, distance: np.ndarray) -> None:
        self.tip = max(self.tip, other.tip, key=lambda node: distance[node])
        self.nodes += other.nodes
        self.children += other.children


def _list_neighbours(graph: Graph) -> list[np.ndarray]:
    count = len(graph.places)
    ends = np.concatenate([graph.first, graph.second])
    others = np.concatenate([graph.second, graph.first])
    order = np.argsort(ends, kind="stable")
    return np.split(others[order], np.cumsum(np.bincount(ends, minlength=count))[:-1])
