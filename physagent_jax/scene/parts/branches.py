"""The branches of an object of pieces that are only numbered: what hangs on the rest by one piece, with that piece.

"grinder 11" says nothing, but arm and grip of a crank hang on a grinder together. They have no name, as limbs that the
shape shows, and a place. Sections that have names make limbs: an upper arm, a lower one and a hand are an arm.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts.cells import fit_part

_NEIGHBOURS, _TOUCH = 12, 2.5  # particles beside one, and spacings within which pieces touch
_LARGEST = 0.4  # share of the object that a branch has at most
_FEWEST = 8  # particles
_NEAREST, _OFF = (
    0.05,
    0.25,
)  # share of a branch that is nearest to the rest; of its length, by which its middle is off
# an end
_CHAINS = {
    "arm": frozenset("arm forearm elbow wrist hand".split()),
    "leg": frozenset("leg thigh shin calf knee ankle foot".split()),
}
"""Words for the sections of a limb, by the word for all of it."""
_STEEP = 0.8  # cosine to the vertical, from which on a branch is on top or at the bottom


def is_numbered(part: Part, own: Sequence[str]) -> bool:
    """Return whether a part is called as the object is, and has but a number of its own."""
    words = split_name(part.name)
    return bool(words) and words[-1].isdigit() and set(own).issuperset(words[:-1])


def branch_numbered(points: np.ndarray, parts: Sequence[Part], name: str) -> tuple[Part, ...]:
    """The parts with branches in place of the pieces that are only numbered.

    Args:
        points: Particles at rest, z up [m], shape (n, 3).
        parts: Parts that the file names.
        name: What the object is called.
    """
    own = split_name(name)
    kept = [part for part in parts if not is_numbered(part, own)]
    if len(parts) - len(kept) < 2:
        return tuple(parts)
    labels = np.zeros(len(points), int)
    for index, part in enumerate((each for each in parts if each not in kept), 1):
        labels[make_region_mask(part.moved, points)] = index
    told: Any = KDTree(points[labels > 0])  # what belongs to none goes with what is nearest
    labels = labels[labels > 0][told.query(points)[1]]
    return (*kept, *(_make(points, mask) for mask in find_branches(points, labels)))


def join_chains(points: np.ndarray, parts: Sequence[Part]) -> tuple[Part, ...]:
    """The parts, and behind them the whole limbs of which the file names but sections: an arm of upper arm and hand.

    Args:
        points: Particles at rest, z up [m], shape (n, 3).
        parts: Parts that the file names.
    """
    names, found = [split_name(part.name) for part in parts], []
    for whole, sections in _CHAINS.items():
        for side in ("left", "right"):
            own = [k for k, name in enumerate(names) if side in name and not sections.isdisjoint(name)]
            if len(own) < 2 or any({*name} == {side, whole} for name in names):
                continue
            mask = np.logical_or.reduce([make_region_mask(parts[k].moved, points) for k in own])
            if mask.any() and not mask.all():
                made = _make(points, mask, joined=not all(parts[k].moved.rigid for k in own))
                found.append(made.model_copy(update=dict(name=f"{side} {whole}", origin="file", roles=())))
    return (*parts, *found)


def find_branches(points: np.ndarray, labels: np.ndarray) -> list[np.ndarray]:
    """The branches as masks of particles, smaller ones first; bool, shape (n,) each.

    Args:
        points: Particles [m], shape (n, 3).
        labels: The piece of each, shape (n,).
    """
    known, labels = np.unique(labels, return_inverse=True)
    tree: Any = KDTree(points)
    distance, near = tree.query(points, k=min(_NEIGHBOURS, len(points)))
    touching = distance <= _TOUCH * np.median(distance[:, 1])
    first, second = np.repeat(labels, touching.sum(1)), labels[near[touching]]
    sizes = np.bincount(labels)
    found: dict[bytes, np.ndarray] = {}
    for piece in range(len(known)):
        if piece == sizes.argmax():
            continue
        stays = (first != piece) & (second != piece)
        edges = coo_matrix((np.ones(stays.sum()), (first[stays], second[stays])), 2 * (len(known),))
        groups = connected_components(edges, directed=False)[1]
        mask = (groups != groups[sizes.argmax()])[labels]
        if _FEWEST <= mask.sum() < _LARGEST * len(points):
            found[mask.tobytes()] = mask
    return sorted(found.values(), key=lambda mask: int(mask.sum()))


def _make(points: np.ndarray, mask: np.ndarray, *, joined: bool = False) -> Part:
    """The part that a branch is. It turns about the end at which it is nearest to the rest, if that is an end."""
    part, own, low = fit_part(points, mask, joined=joined), points[mask], points.min(0)
    role = "top" if part.side[2] > _STEEP else "bottom" if part.side[2] < -_STEEP else "side"
    told: dict[str, Any] = dict(roles=(role,))
    tree: Any = KDTree(points[~mask])
    distance = tree.query(own)[0]
    joint = own[distance <= np.quantile(distance, _NEAREST)].mean(0)
    tip = own[np.linalg.norm(own - joint, axis=1).argmax()]
    if np.linalg.norm(own.mean(0) - joint) > _OFF * np.linalg.norm(tip - joint):
        ends = (
            (joint - low) / np.maximum(np.ptp(points, axis=0), 1e-12),
            (tip - joint) / np.ptp(points, axis=0).max(),
        )
        told |= dict(
            zip(("joint", "arm"), (tuple(np.round(each, 4).tolist()) for each in ends)), seated=False
        )
    return part.model_copy(update=told)
