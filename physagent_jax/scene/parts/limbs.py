"""The limbs of an object: what sticks out of it by thickness or by distance, as one tree with measures.

Thin parts of a thicker body are cut best where the thickness changes (`openings`). A head that is thicker than its
neck's body, or an arm on a body of thin plates, is found by its distance from the rest (`protrusions`). What sits on a
seam is a part however wide it is (`caps`). A head that is a mere bulge is cut where it sees little of the rest
(`convexity`).
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.scene.parts.caps import find_caps
from physagent_jax.scene.parts.convexity import find_convex_parts
from physagent_jax.scene.parts.lattice import Lattice
from physagent_jax.scene.parts.openings import find_thin_parts
from physagent_jax.scene.parts.protrusions import find_protrusions, make_graph

LARGEST = 0.45  # share of the object: more is the object itself
_LEAST = 0.001  # share of the object
_SMALLEST = 0.04  # length over the object's
# Least prominence of what is thin, of what is distant, and of a distant plate, whose neck is wide; ends of boxes and
# eggs have up to 1.05, corners less.
_THIN, _DISTANT, _PLATE = 0.95, 1.2, 1.0
PLAIN = 2.0  # the same of a limb that is a limb even where nothing else tells
_BLUNT = 0.7  # the same of what sees little of the rest
_COARSE = 0.6  # of its prominence counts, where a limb by distance and one by thickness would be in each other's way
_SAME = 0.35  # of the union of two limbs, that both hold, from which on they are one
_MOST = 0.7  # the same where the larger one holds others, too: a head and the shoulders with arms
_APART, _WITHIN = (
    0.2,
    0.8,
)  # share of the smaller one in the larger, below which they are apart, above which nested
_NECK = 0.25  # size of a place of attachment over the largest
_EVEN = (
    1.8  # thickest place of a loop over its usual thickness: an arm that is held at two places ends in a hand
)
_INNER = 0.44  # of the way to a loop's tip, where it is open: a thick one is not halfway
_LOWEST = 5.0  # percent of a limb that may lie lower than its low end
_SAMPLES = 1000  # places at which a loop's thickness is looked at
_FLAT = 0.35  # thickness over width
_LONG = 3.0  # length over width, above which it is no plate


@dataclasses.dataclass(frozen=True)
class Limb:
    """A part that sticks out, with its measures.

    Attributes:
        nodes: Its nodes of the lattice, shape (k,).
        centre, joint, tip: Places [m], shape (3,); the tip lies as far out as it reaches, the way of its centre.
        length: Distance from joint to tip, over the object's.
        width: Radius of gyration of the neck, over the object's length.
        extent: Sides of its box [m], shape (3,).
        share: Share of the object.
        low: Height of its lowest nodes [m].
        prominence: How deep it is beyond its neck over the neck's radius of gyration, and how much smaller the rest
            beside the neck is than the part; below 1 for the corners of a box.
        slimness: Length over mean thickness, which is the root of the section: a ball on a neck has 1, a tail 4.
        loop: Whether it is attached at two places, and as thick everywhere.
        flat: Whether it is a plate.
        children: Places of the limbs directly inside it, in the list it belongs to.
        parent: Place of the limb that it is directly inside; None = none.
    """

    nodes: np.ndarray
    centre: np.ndarray
    joint: np.ndarray
    tip: np.ndarray
    length: float
    width: float
    extent: np.ndarray
    share: float
    low: float
    prominence: float
    slimness: float
    loop: bool
    flat: bool
    children: tuple[int, ...] = ()
    parent: int | None = None


def find_limbs(points: np.ndarray, lattice: Lattice) -> list[Limb]:
    """The limbs of a cloud, smaller ones before those that they are part of.

    Args:
        points: Positions of its particles [m], shape (n, 3).
        lattice: Its solid.
    """
    thin = [measure(lattice, nodes) for nodes in find_thin_parts(lattice)]
    distant = [measure(lattice, nodes) for nodes in _find_distant(points, lattice)]
    caps = [measure(lattice, nodes) for nodes in find_caps(lattice)]
    told = [(limb, limb.prominence) for limb in thin if limb.prominence >= _THIN and limb.share >= _LEAST]
    told += [
        (limb, _COARSE * limb.prominence)
        for limb in distant
        if limb.prominence >= (_PLATE if limb.flat else _DISTANT)
    ]
    told += [(limb, 0.0) for limb in caps]
    chosen: list[Limb] = []
    for limb, _ in sorted(told, key=lambda each: -each[1]):
        if limb.length >= _SMALLEST and all(_fits(limb, each, chosen) for each in chosen):
            chosen.append(limb)
    return _nest(chosen)


def add_blunt(limbs: list[Limb], lattice: Lattice, least: float = _BLUNT) -> list[Limb]:
    """The limbs with those that stick out little, but see little of the rest, as of `find_limbs`.

    Args:
        limbs: Those that are found.
        lattice: The object's solid.
        least: Least prominence of the others.
    """
    chosen = list(limbs)
    blunt = [measure(lattice, nodes) for nodes in find_convex_parts(lattice)]
    for limb in sorted(blunt, key=lambda each: -each.prominence):
        stands_out = limb.prominence >= least and _SMALLEST <= limb.length and limb.share <= LARGEST
        if stands_out and all(_fits(limb, each, chosen) for each in chosen):
            chosen.append(limb)
    return _nest(chosen)


def _nest(limbs: list[Limb]) -> list[Limb]:
    """The limbs with their places in each other, smaller ones first."""
    chosen = sorted(limbs, key=lambda limb: limb.share)
    parents = [
        next((j for j in range(i + 1, len(chosen)) if _share(limb.nodes, chosen[j].nodes) > _WITHIN), None)
        for i, limb in enumerate(chosen)
    ]
    return [
        dataclasses.replace(
            limb, parent=parents[i], children=tuple(k for k, parent in enumerate(parents) if parent == i)
        )
        for i, limb in enumerate(chosen)
    ]


def list_inner(limbs: list[Limb], index: int) -> list[int]:
    """Places of all limbs inside a limb."""
    children = limbs[index].children
    return [*children, *(k for child in children for k in list_inner(limbs, child))]


def list_outer(limbs: list[Limb], index: int) -> list[int]:
    """Places of all limbs that a limb is inside, nearest first."""
    parent = limbs[index].parent
    return [] if parent is None else [parent, *list_outer(limbs, parent)]


def _find_distant(points: np.ndarray, lattice: Lattice) -> list[np.ndarray]:
    """The protrusions of distance as nodes of the lattice, smaller ones first."""
    graph = make_graph(points)
    nearest = KDTree(graph.places).query(lattice.places)[1]
    found = []
    for each in find_protrusions(graph):
        inside = np.zeros(len(graph.places), bool)
        inside[each] = True
        found.append(np.flatnonzero(inside[nearest]))
    return sorted((nodes for nodes in found if len(nodes)), key=len)


def _share(one: np.ndarray, other: np.ndarray) -> float:
    return len(np.intersect1d(one, other, assume_unique=True)) / len(one)


def _fits(one: Limb, other: Limb, chosen: list[Limb]) -> bool:
    """Return whether two limbs are apart, or one is well inside the other."""
    small, large = sorted((one, other), key=lambda limb: len(limb.nodes))
    inside = _share(small.nodes, large.nodes)
    if inside < _APART or inside <= _WITHIN:
        return inside < _APART
    shared = inside * len(small.nodes)
    same = shared / (len(small.nodes) + len(large.nodes) - shared)
    return (
        same < _SAME
        or same < _MOST
        and any(
            _share(each.nodes, large.nodes) > _WITHIN and _share(each.nodes, small.nodes) < _APART
            for each in chosen
            if each.share < large.share
        )
    )


def measure(lattice: Lattice, nodes: np.ndarray) -> Limb:
    """A limb with its measures, on its own."""
    nodes = lattice.complete(nodes)
    places = lattice.places[nodes]
    size = float(np.ptp(lattice.places, axis=0).max())
    necks = [lattice.places[each] for each in lattice.find_necks(nodes)]
    necks = [each for each in necks if len(each) >= _NECK * len(necks[0])] or [places]
    joints = np.array([each.mean(0) for each in necks])
    widths = np.array([_find_radius(each) for each in necks])
    joint = joints.mean(0)
    tip = places[np.linalg.norm(places - joint, axis=1).argmax()]
    loop = (
        len(necks) > 1 and _is_even(lattice, nodes) and not lattice.is_solid(joint + _INNER * (tip - joint))
    )
    width = float(widths.mean()) if loop else _find_radius(np.concatenate(necks))
    if not loop:
        joint = np.concatenate(necks).mean(0)
    way = places.mean(0) - joint
    way /= max(float(np.linalg.norm(way)), 1e-12)
    tip = joint + way * float(((places - joint) @ way).max())
    spread = np.sqrt(np.linalg.eigvalsh(np.cov(places.T) if len(places) > 3 else np.eye(3)).clip(0))
    flat = spread[0] < _FLAT * spread[1] and spread[2] < _LONG * spread[1]
    length = float(np.linalg.norm(tip - joint))
    return Limb(
        nodes,
        places.mean(0),
        joint,
        tip,
        length=length / size,
        width=width / size,
        extent=np.ptp(places, axis=0),
        share=len(nodes) / len(lattice.places),
        low=float(np.percentile(places[:, 2], _LOWEST)),
        prominence=_find_prominence(lattice, nodes, np.concatenate(necks), width),
        slimness=length**1.5 / (len(nodes) * lattice.spacing**3) ** 0.5,
        loop=bool(loop),
        flat=bool(flat),
    )


def _find_prominence(lattice: Lattice, nodes: np.ndarray, neck: np.ndarray, width: float) -> float:
    beside, tree = max(2 * lattice.spacing, 0.7 * width), KDTree(neck)
    outside = np.ones(len(lattice.places), bool)
    outside[nodes] = False
    distance = np.asarray(tree.query(lattice.places[nodes])[0])
    others = np.asarray(tree.query(lattice.places[outside], distance_upper_bound=beside * (1 + 1e-9))[0])
    rest = np.isfinite(others).sum() / (distance <= beside).sum()
    return float(distance.max() / max(width, lattice.spacing) / max(rest, 1e-3))


def _find_radius(places: np.ndarray) -> float:
    return float(np.sqrt(((places - places.mean(0)) ** 2).sum(1).mean()))


def _is_even(lattice: Lattice, nodes: np.ndarray) -> bool:
    """Return whether a part has about the same cross-section wherever it is cut, seen by how much of it lies near."""
    places = lattice.places[nodes]
    chosen = places[:: -(-len(places) // _SAMPLES)]
    near = KDTree(places).query_ball_point(chosen, 4 * lattice.spacing, return_length=True)
    return float(np.percentile(near, 95)) < _EVEN * float(np.median(near))
