"""Particles of a part as a part: cells that hold them, the joint, and the way the part points."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion

_MOST_POINTS = 30_000  # that seeds are fitted to
_FIRST_SEEDS, _MOST_SEEDS, _AT_ONCE = 16, 120, 12  # on either side
_GOOD = 2e-3  # share of the points that may lie in the wrong cells
_TOUCH = 2.0  # spacings between particles that touch
_SLIM = 3.5  # length over the radius of gyration of where it joins, from which on a piece turns about its joint: a
# cube on a cube has 2.4, an arm 5
_OFF = 0.2  # of its length, by which the middle of what turns about its joint lies off it
_JOINT = 0.3  # of the way from joint to tip that bends, of what is one skin with the rest


def fit_part(points: np.ndarray, mask: np.ndarray, *, joined: bool) -> Part:
    """The part that some of the particles are.

    A piece of its own, whose surface is closed, moves with all its particles; what is of one skin with the rest bends
    beside its joint, as a found limb does (`scene.parts.roles`). A piece that is no longer than it is wide where it
    joins sits on the rest.

    Args:
        points: Particles at rest [m], shape (n, 3).
        mask: Those of the part, shape (n,); neither none nor all.
        joined: Whether it is of one skin with the rest.
    """
    low, high = points.min(0), points.max(0)
    box, size = np.maximum(high - low, 1e-12), float((high - low).max())
    own, rest = points[mask], points[~mask]
    centre = own.mean(0)
    contact = _find_contact(own, rest, size)
    joint = contact.mean(0)
    tip = own[np.linalg.norm(own - joint, axis=1).argmax()]
    length = float(np.linalg.norm(tip - joint))
    width = float(np.sqrt(((contact - joint) ** 2).sum(1).mean()))
    off = float(np.linalg.norm(centre - joint))
    seated = length < _SLIM * max(width, 1e-9) or off < _OFF * length
    arm = tip - joint
    if seated:  # it goes up or out as far as it is long
        out = centre - joint
        out = out if off > 1e-3 * size else centre - 0.5 * (low + high)
        out = out if np.linalg.norm(out) > 1e-9 * size else np.array([0.0, 0.0, 1.0])
        arm = out / np.linalg.norm(out) * float(np.ptp(own, axis=0).max())
    free = mask.copy()
    if joined and not seated:
        beyond = (points - joint) @ arm > _JOINT * float(arm @ arm)
        free &= beyond | ~(mask & beyond).any()
    away = centre - 0.5 * (low + high)

    def divide(inside: np.ndarray) -> CellsRegion:
        seeds = _fit_seeds((points - low) / size, inside)
        scaled = (tuple(tuple(np.round(p * size / box, 5).tolist()) for p in each) for each in seeds)
        return CellsRegion(**dict(zip(("inside", "outside"), scaled)))

    moved = divide(free)
    other = CellsRegion(inside=moved.outside, outside=moved.inside) if (free == mask).all() else divide(~mask)
    return Part(
        seated=bool(seated),
        moved=moved,
        rest=other,
        joint=tuple(np.round(((centre if seated else joint) - low) / box, 4).tolist()),
        arm=tuple(np.round(arm / size, 4).tolist()),
        side=tuple(np.round(away / norm, 4).tolist())
        if (norm := np.linalg.norm(away)) > 1e-9 * size
        else (0, 0, 1),
        share=round(float(mask.mean()), 4),
    )


def _find_contact(own: np.ndarray, rest: np.ndarray, size: float) -> np.ndarray:
    """The particles of a part that touch the rest; the nearest ones if none does. Shape (k, 3)."""
    tree: Any = KDTree(rest)
    distance = tree.query(own)[0]
    spacing = size / max(len(own) + len(rest), 8) ** (1 / 3)
    return own[distance <= max(_TOUCH * spacing, 1.2 * float(distance.min()))]


def _fit_seeds(points: np.ndarray, inside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places among ``points`` whose nearest cells are inside or outside as the points are; shapes (k, 3), (m, 3).

    Begins with seeds spread over both, and adds those points that lie in wrong cells, farthest from each other first.
    """
    step = -(-len(points) // _MOST_POINTS)
    chosen_points = points[::step] if inside[::step].any() and not inside[::step].all() else points
    chosen_inside = inside[::step] if chosen_points is not points else inside
    sides = [chosen_points[chosen_inside], chosen_points[~chosen_inside]]
    seeds = [spread(each, _FIRST_SEEDS) for each in sides]
    while max(map(len, seeds)) < _MOST_SEEDS:
        near = np.asarray(KDTree(np.concatenate(seeds)).query(chosen_points)[1]) < len(seeds[0])
        wrong = near != chosen_inside
        if wrong.mean() <= _GOOD and wrong[chosen_inside].mean() <= 5 * _GOOD:
            break
        for side, here in enumerate((chosen_inside, ~chosen_inside)):
            if (wrong & here).any():
                seeds[side] = np.concatenate([seeds[side], spread(chosen_points[wrong & here], _AT_ONCE)])
    return seeds[0][:_MOST_SEEDS], seeds[1][:_MOST_SEEDS]


def spread(places: np.ndarray, count: int) -> np.ndarray:
    """At most ``count`` of the places, each far from those before (farthest-point sampling)."""
    chosen = [int(np.linalg.norm(places - places.mean(0), axis=1).argmax())]
    distance = np.linalg.norm(places - places[chosen[0]], axis=1)
    while len(chosen) < min(count, len(places)):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return places[chosen]
