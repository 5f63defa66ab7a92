"""The roles of an object's protrusions: a leg stands on the ground, ears come in pairs on a head, a tail hangs alone.

A role is told by place and pair alone, for objects that stand upright. Words that may mean a role are the lexicon's.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.forces.part import Part, PartRole
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.scene.parts.protrusions import Graph, Protrusion, find_protrusions, make_graph

_LARGEST = 0.45  # share of the object: more is the object itself
_LEAST = 0.004  # share of the object
_SMALLEST = 0.04  # length over the object's
_ON_GROUND = 0.06  # of the height
_HEAD = 0.55  # of the height, above which the middle of a head lies
_TOP = 0.8  # of the height, above which it is no tail
_SLIM, _SLIM_BRANCHED = (
    1.4,
    2.0,
)  # least slimness: boxes and cylinders have corners of up to 1.3, and ends of 1.7
_MIRROR = 0.12  # of the length, by which two of a pair may miss each other's mirror image
_JOINT = 0.3  # of the way from neck to tip that bends
_SEEDS = 20  # that mark a part, at most


@dataclasses.dataclass(frozen=True)
class _Limb:
    """A protrusion with its measures.

    Attributes:
        protrusion: Its nodes.
        centre, joint, tip: Places [m], shape (3,).
        length: From joint to tip, over the object's.
        slimness: The length over the radius of gyration of the neck; about 1 for the corner of a box.
        share: Share of the object.
        low: Height of its lowest node [m].
    """

    protrusion: Protrusion
    centre: np.ndarray
    joint: np.ndarray
    tip: np.ndarray
    length: float
    slimness: float
    share: float
    low: float


def find_parts(points: np.ndarray) -> tuple[Part, ...]:
    """The parts that stick out of an upright object.

    Args:
        points: Positions of its particles, z up [m], shape (n, 3).

    Returns:
        Parts with at least one role each; none for an object without protrusions.
    """
    graph = make_graph(points)
    low, high = points.min(0), points.max(0)
    size = float((high - low).max())
    limbs = [_measure(graph, each, low, size) for each in find_protrusions(graph)]
    parts = []
    for index, limb in enumerate(limbs):
        roles = _find_roles(index, limbs, low, high)
        slim = limb.slimness >= (_SLIM if not limb.protrusion.children else _SLIM_BRANCHED)
        if roles and slim and limb.length >= _SMALLEST and limb.share >= _LEAST:
            parts.append(_make_part(graph, limb, roles, low, high, size))
    return tuple(parts)


def _measure(graph: Graph, protrusion: Protrusion, low: np.ndarray, size: float) -> _Limb:
    nodes, weights = protrusion.nodes, graph.weights[protrusion.nodes]
    places = graph.places[nodes]
    centre = np.average(places, axis=0, weights=weights)
    joint, tip = graph.places[protrusion.neck].mean(0), graph.places[protrusion.tip]
    length = float(np.linalg.norm(tip - joint)) / size
    width = np.sqrt(((graph.places[protrusion.neck] - joint) ** 2).sum(1).mean()) / size
    slimness = length / max(float(width), 1e-9)
    return _Limb(
        protrusion, centre, joint, tip, length, slimness, float(weights.sum()), float(places[:, 2].min())
    )


def _find_roles(index: int, limbs: list[_Limb], low: np.ndarray, high: np.ndarray) -> tuple[PartRole, ...]:
    limb, size = limbs[index], float((high - low).max())
    height = float(high[2] - low[2])
    if limb.share > _LARGEST:
        return ()
    grounded = limb.low < low[2] + _ON_GROUND * height
    head = _find_head(limbs, low, height)
    inside = head is not None and index in _list_inner(head, limbs)
    paired = _has_partner(index, limbs, low, high, size)
    leaf = not limb.protrusion.children
    if index == head:
        return ("head",)
    if grounded:
        return ("leg",) if leaf and limb.tip[2] < limb.joint[2] else ()
    if inside:
        return ("ear",) if paired and leaf else ()
    if not leaf:
        return ()
    if limb.centre[2] > low[2] + _TOP * height:
        return ("ear", "side")
    return ("arm", "side") if paired else ("tail", "side")


def _find_head(limbs: list[_Limb], low: np.ndarray, height: float) -> int | None:
    """The largest protrusion that is high up and does not stand on the ground; None if there is none.

    Ears sit above its middle; where what it is made of sits lower, as arms do, it is half of the body.
    """
    high = [
        index
        for index, limb in enumerate(limbs)
        if limb.share <= _LARGEST
        and limb.centre[2] > low[2] + _HEAD * height
        and limb.tip[2] >= limb.joint[2] - 0.02 * height
        and limb.low > low[2] + _ON_GROUND * height
        and not any(limbs[child].joint[2] < limb.centre[2] for child in limb.protrusion.children)
    ]
    return max(high, key=lambda index: limbs[index].share, default=None)


def _list_inner(index: int, limbs: list[_Limb]) -> set[int]:
    found, waiting = set(), list(limbs[index].protrusion.children)
    while waiting:
        child = waiting.pop()
        found.add(child)
        waiting += limbs[child].protrusion.children
    return found


def _has_partner(index: int, limbs: list[_Limb], low: np.ndarray, high: np.ndarray, size: float) -> bool:
    """Return whether another protrusion is its mirror image in an upright plane along x or y through the middle."""
    limb, middle = limbs[index], 0.5 * (low + high)
    for axis in (0, 1):
        if abs(limb.centre[axis] - middle[axis]) < 0.5 * _MIRROR * size:
            continue
        image = limb.centre.copy()
        image[axis] = 2 * middle[axis] - image[axis]
        for other in limbs:
            near = np.linalg.norm(other.centre - image) < _MIRROR * size
            if other is not limb and near and 0.4 < other.share / limb.share < 2.5:
                return True
    return False


def _make_part(graph: Graph, limb: _Limb, roles, low: np.ndarray, high: np.ndarray, size: float) -> Part:
    box = np.maximum(high - low, 1e-12)

    def mark(nodes: np.ndarray) -> tuple[tuple[float, float, float], ...]:
        chosen = _spread(graph.places[nodes], _SEEDS)
        return tuple(tuple(np.round((place - low) / box, 4).tolist()) for place in chosen)

    nodes = limb.protrusion.nodes
    out = (graph.places[nodes] - limb.joint) @ (limb.tip - limb.joint)
    far = out > _JOINT * float(((limb.tip - limb.joint) ** 2).sum())
    if not far.any() or far.all():
        far = out >= np.median(out)
    rest = np.setdiff1d(np.arange(len(graph.places)), nodes)
    moved, joint, still = (
        mark(nodes[far]),
        mark(nodes[~far]),
        mark(rest) + mark(_find_near(graph, nodes, rest)),
    )
    away = limb.centre - 0.5 * (low + high)
    return Part(
        roles=roles,
        moved=CellsRegion(inside=moved, outside=(*joint, *still)),
        rest=CellsRegion(inside=still, outside=(*moved, *joint)),
        joint=tuple(np.round((limb.joint - low) / box, 4).tolist()),
        arm=tuple(np.round((limb.tip - limb.joint) / size, 4).tolist()),
        side=tuple(np.round(away / max(float(np.linalg.norm(away)), 1e-12), 4).tolist()),
        share=round(limb.share, 4),
    )


def _find_near(graph: Graph, nodes: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """The nodes of the rest beside a part: they bound it."""
    inside = np.zeros(len(graph.places), bool)
    inside[nodes] = True
    beside = np.concatenate([graph.second[inside[graph.first]], graph.first[inside[graph.second]]])
    found = np.unique(beside[~inside[beside]])
    return found if len(found) else rest


def _spread(places: np.ndarray, count: int) -> np.ndarray:
    """At most ``count`` of the places, each far from those before (farthest-point sampling)."""
    chosen = [int(np.linalg.norm(places - places.mean(0), axis=1).argmax())]
    distance = np.linalg.norm(places - places[chosen[0]], axis=1)
    while len(chosen) < min(count, len(places)):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return places[chosen]
