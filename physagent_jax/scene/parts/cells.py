"""Particles of a part as a part: cells that hold them, the joint, and the way the part points."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion

_MOST_POINTS = 30_000  # that seeds are fitted to
_PAIRS, _SPREAD, _AT_ONCE, _MOST_SEEDS = 160, 60, 12, 240  # seeds on either side
_AROUND = 24  # points on either side that tell where the border runs
_TOUCH = 2.0  # spacings between particles that touch
_SLIM = 3.5  # length over the radius of gyration of where it joins, from which on a piece turns about its joint: a
# cube on a cube has 2.4, an arm 5
_OUTER = 0.1  # share of a part that is either end of it
_OFF = 0.2  # of its length, by which the middle of what turns about its joint lies off it
_FLAT, _THICK = 0.6, 0.97  # spread of a disc along its axle over that across, and of what is called a wheel
_ROUND = 0.85  # the lesser spread across the axle over the larger
_RIM = 1.15  # farthest from the axle over that of an even disc of the same spread: the corners of a square are at 1.22
_JOINT = 0.3  # of the way from joint to tip that bends, of what is one skin with the rest


def fit_part(
    points: np.ndarray,
    mask: np.ndarray,
    *,
    joined: bool,
    wheel: bool = False,
    blades: bool = False,
    limb: bool = False,
) -> Part:
    """The part that some of the particles are.

    A piece of its own, whose surface is closed, moves with all its particles; what is of one skin with the rest bends
    beside its joint, as a found limb does (`scene.parts.marking`). A piece that is no longer than it is wide where it
    joins sits on the rest.

    Args:
        points: Particles at rest [m], shape (n, 3).
        mask: Those of the part, shape (n,); neither none nor all.
        joined: Whether it is of one skin with the rest.
        wheel: Whether it is called a wheel: then it may be nearly as thick as it is broad.
        blades: Whether it is called blades that turn together, as a rotor's: they need not fill a disc.
        limb: Whether it is called as what has a joint, however short it is.
    """
    low, high = points.min(0), points.max(0)
    box, size = np.maximum(high - low, 1e-12), float((high - low).max())
    own, rest = points[mask], points[~mask]
    centre = own.mean(0)
    contact = find_contact(own, rest, size)
    joint = contact.mean(0)
    tip = own[np.linalg.norm(own - joint, axis=1).argmax()]
    length = float(np.linalg.norm(tip - joint))
    width = float(np.sqrt(((contact - joint) ** 2).sum(1).mean()))
    off = float(np.linalg.norm(centre - joint))
    axle = _find_axle(own, _THICK if wheel else _FLAT, filled=not blades)
    rolls = axle is not None and not joined
    if (
        limb and not joined and off < _OFF * length
    ):  # it is sunk in the rest: the end at the middle of that is its joint
        joint, tip = _find_ends(own, rest.mean(0))
        length, off = float(np.linalg.norm(tip - joint)), float(np.linalg.norm(centre - joint))
    slim = limb or length >= _SLIM * max(width, 1e-9)
    seated = rolls or not slim or off < _OFF * length
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

    def divide(inside: np.ndarray, rigid: bool = False) -> CellsRegion:
        seeds = _fit_seeds((points - low) / size, inside)
        own, other = (
            tuple((float(x), float(y), float(z)) for x, y, z in np.round(each * size / box, 5))
            for each in seeds
        )
        return CellsRegion(inside=own, outside=other, rigid=rigid)

    moved = divide(free, rigid=not joined)
    if (free == mask).all():
        other = moved.model_copy(update=dict(inside=moved.outside, outside=moved.inside))
    else:
        other = divide(~mask)
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
        axle=axle,
        neck=tuple(np.round(contact.std(0) / size, 4).tolist()) if joined else (0, 0, 0),
    )


def _find_ends(own: np.ndarray, middle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The ends of a long part, the one nearer to a place first, shape (3,) each."""
    centre = own.mean(0)
    along = (own - centre) @ np.linalg.eigh(np.cov(own.T))[1][:, -1]
    low, high = np.quantile(along, [_OUTER, 1 - _OUTER])
    ends = own[along <= low].mean(0), own[along >= high].mean(0)
    near, far = sorted(ends, key=lambda end: float(np.linalg.norm(end - middle)))
    return near, far


def _find_axle(own: np.ndarray, flat: float, filled: bool) -> tuple[float, float, float] | None:
    """The thin axis of what is at most so ``flat``, and ``filled`` like a disc, as a unit vector; None if it is not."""
    spread, axes = np.linalg.eigh(np.cov(own.T) if len(own) > 3 else np.eye(3))
    if spread[0] > flat**2 * spread[1]:
        return None
    away = np.hypot(*((own - own.mean(0)) @ axes[:, 1:]).T)
    ragged = np.quantile(away, 0.98) > _RIM * np.sqrt(2 * spread[1:].sum())
    if filled and (spread[1] < _ROUND**2 * spread[2] or ragged):
        return None
    axle = axes[:, 0] * np.sign(axes[np.abs(axes[:, 0]).argmax(), 0])
    x, y, z = np.round(axle, 4).tolist()
    return x, y, z


def find_contact(own: np.ndarray, rest: np.ndarray, size: float) -> np.ndarray:
    """The particles of a part that touch the rest; the nearest ones if none does. Shape (k, 3)."""
    tree: Any = KDTree(rest)
    distance = tree.query(own)[0]
    spacing = size / max(len(own) + len(rest), 8) ** (1 / 3)
    return own[distance <= max(_TOUCH * spacing, 1.2 * float(distance.min()))]


def _fit_seeds(points: np.ndarray, inside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places whose nearest cells are inside or outside as the points are; shapes (k, 3), (m, 3).

    Pairs of them are each other's image in the border between the two, so that the border of their cells is that
    border; the others are spread over both, away from it. Then points in wrong cells are added while that helps.
    """
    step = -(-len(points) // _MOST_POINTS)
    if step > 1 and inside[::step].any() and not inside[::step].all():
        points, inside = points[::step], inside[::step]
    own, rest = points[inside], points[~inside]
    pairs, gap = _find_pairs(own, rest, float(np.ptp(points, axis=0).max()))
    border: Any = KDTree(pairs.mean(1))
    seeds = []
    for index, side in enumerate((own, rest)):
        away = side[border.query(side)[0] > gap]
        seeds.append(np.concatenate([pairs[:, index], spread(away if len(away) else side, _SPREAD)]))
    wrong = _find_wrong(points, inside, seeds)
    while wrong.any() and max(map(len, seeds)) < _MOST_SEEDS:
        more = [
            np.concatenate([each, spread(points[wrong & here], _AT_ONCE)]) if (wrong & here).any() else each
            for each, here in zip(seeds, (inside, ~inside))
        ]
        found = _find_wrong(points, inside, more)
        if found.sum() >= wrong.sum():
            break
        seeds, wrong = more, found
    return seeds[0], seeds[1]


def _find_wrong(points: np.ndarray, inside: np.ndarray, seeds: list[np.ndarray]) -> np.ndarray:
    near = np.asarray(KDTree(np.concatenate(seeds)).query(points)[1])
    return (near < len(seeds[0])) != inside


def _find_pairs(own: np.ndarray, rest: np.ndarray, size: float) -> tuple[np.ndarray, float]:
    """Pairs of places on either side of where two sets of points touch, and how far apart the pairs lie.

    Returns:
        Places in ``own`` and in ``rest``, shape (k, 2, 3), and a length, of the points' unit.
    """
    spacing = size / max(len(own) + len(rest), 8) ** (1 / 3)
    contact = spread(find_contact(own, rest, size), _PAIRS)
    trees: list[Any] = [KDTree(side) for side in (own, rest)]
    for _ in range(2):  # from particles near the border to places between the nearest of either side
        nearest = [side[tree.query(contact)[1]] for side, tree in zip((own, rest), trees)]
        contact = 0.5 * (nearest[0] + nearest[1])
    near = []
    for side, tree in zip((own, rest), trees):
        near.append(side[tree.query(contact, k=min(_AROUND, len(side)))[1].reshape(len(contact), -1)])
    apart = [each - each.mean(1, keepdims=True) for each in near]
    within = sum(each.transpose(0, 2, 1) @ each for each in apart)
    within = within + 1e-3 * np.trace(within, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    # Fisher's discriminant: the way across the border, however unevenly the points lie along it.
    way = np.linalg.solve(within, (near[0].mean(1) - near[1].mean(1))[..., None])[..., 0]
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    along = [((each - contact[:, None]) * way[:, None]).sum(-1) for each in near]
    level = 0.5 * (np.quantile(along[0], 0.1, axis=1) + np.quantile(along[1], 0.9, axis=1))
    middle = contact + level[:, None] * way
    pairs = np.stack([middle + spacing * way, middle - spacing * way], axis=1)
    tree = KDTree(middle)
    gap = float(np.median(tree.query(middle, k=min(2, len(middle)))[0].reshape(len(middle), -1)[:, -1]))
    return pairs, max(gap, 2 * spacing)


def spread(places: np.ndarray, count: int) -> np.ndarray:
    """At most ``count`` of the places, each far from those before (farthest-point sampling)."""
    axes = np.ascontiguousarray(places.T)  # one axis after the other is several times as fast

    def measure_from(origin: np.ndarray) -> np.ndarray:
        x, y, z = axes - origin[:, None]
        return np.sqrt(x * x + y * y + z * z)

    chosen = [int(measure_from(places.mean(0)).argmax())]
    distance = measure_from(places[chosen[0]])
    while len(chosen) < min(count, len(places)):
        chosen.append(int(distance.argmax()))
        np.minimum(distance, measure_from(places[chosen[-1]]), out=distance)
    return places[chosen]
