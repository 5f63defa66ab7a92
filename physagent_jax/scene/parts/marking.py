"""The parts of an object as data: limbs with their roles, marked by seeds whose Voronoi cells hold their particles."""

from __future__ import annotations

import collections

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part, PartRole
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.scene.parts.cells import spread
from physagent_jax.scene.parts.digits import name_digits
from physagent_jax.scene.parts.ends import find_ends
from physagent_jax.scene.parts.evidence import weigh
from physagent_jax.scene.parts.figures import add_figure
from physagent_jax.scene.parts.heading import find_overhang
from physagent_jax.scene.parts.lattice import Lattice, make_lattice
from physagent_jax.scene.parts.limbs import PLAIN, Limb, add_blunt, find_limbs, measure
from physagent_jax.scene.parts.roles import Roles
from physagent_jax.scene.store import keep

_JOINT, _BEND = 0.3, 0.08  # of the way from neck to tip, and of the object's length, that bends, at most
_SAME = (
    0.5  # overlap (intersection over union) from which on a limb is the section that has a name of its own
)
_UPRIGHT = ("stem", "neck")  # sections of what stands
_FOOT = 0.15  # of a stem, that stays
_GAP = 0.08  # of the object's length, within which what is beside a part has to be told from it
_SEEDS = 64  # that mark a part, or what is beside it, at most: fewer leave patches of a large one out


@keep
def find_parts(points: np.ndarray) -> tuple[Part, ...]:
    """The parts that stick out of an upright object, its ends, and those of a figure on its base.

    Args:
        points: Positions of its particles, z up [m], shape (n, 3).

    Returns:
        Parts with at least one role each; none for an object without limbs.
    """
    front, parts = find_overhang(points), add_figure(points, _find_own(points), _find_own)
    told = dict(front=None if front is None else tuple(front.tolist()))
    return tuple(part.model_copy(update=told) for part in parts)


def _find_own(points: np.ndarray) -> tuple[Part, ...]:
    """As `find_parts`, without those of a figure on its base."""
    lattice = make_lattice(points)
    limbs = find_limbs(points, lattice)
    low, high = points.min(0), points.max(0)
    named = Roles(limbs, lattice)
    if named.head is None:
        fuller = add_blunt(limbs, lattice)
        other = Roles(fuller, lattice)
        if other.head is not None and len(other.legs) >= len(named.legs):
            limbs, named = fuller, other
        elif not named.legs:  # a thing may have more limbs, if those that it has keep their names
            plain = add_blunt(limbs, lattice, PLAIN)
            more = Roles(plain, lattice)
            had, has = (
                collections.Counter(name_digits(own, each.assign(), each.mirrored).values())
                for own, each in ((limbs, named), (plain, more))
            )
            limbs, named = (
                (plain, more) if not had - has and set(has - had) == {("side",)} else (limbs, named)
            )
    roles = name_digits(limbs, named.assign(), named.mirrored)
    told = [(limbs[k], roles[k]) for k in sorted(roles)]
    possible = {id(limbs[k]): named.things.list_possible(k, roles) for k in roles}
    chances = {
        id(limbs[k]): weigh(limbs[k], names[0], named.missed[k], named.mirror.likeness)
        for k, names in roles.items()
    }
    counts = collections.Counter(role for names in roles.values() for role in names)
    known = frozenset(role for role, count in counts.items() if count > 1 or role not in ("arm", "wing"))
    sections: list[tuple[Limb, tuple[PartRole, ...]]] = []
    for nodes, names in find_ends(lattice, known):
        same = next((index for index, each in enumerate(told) if _is_same(each[0].nodes, nodes)), None)
        limb, had = (measure(lattice, nodes), ()) if same is None else told.pop(same)
        if "stern" in names:  # a tail keeps its name
            sections.append((limb, (*had, *names)))
        else:  # a stem may be a leg: its place goes first
            sections.append((measure(lattice, nodes), (*(had if names[0] in _UPRIGHT else ()), *names)))
    told += sections  # the end of a handle is part of it, and no other name for it
    parts = [
        (_make_stem if "stem" in names else _make_part)(lattice, limb, names, low, high)
        for limb, names in told
    ]
    # Ends are named only where the breadth tells them clearly (`ends`).
    return tuple(
        part.model_copy(
            update=dict(
                roles=(*part.roles, *(() if len(part.roles) > 1 else possible.get(id(limb), ()))),
                confidence=chances.get(id(limb), 1.0),
            )
        )
        for part, (limb, _) in zip(parts, told)
    )


def _is_same(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two sets of nodes are one part."""
    return len(np.intersect1d(one, other)) > _SAME * len(np.union1d(one, other))


def _make_part(
    lattice: Lattice, limb: Limb, roles: tuple[PartRole, ...], low: np.ndarray, high: np.ndarray
) -> Part:
    def mark(nodes: np.ndarray) -> tuple[tuple[float, float, float], ...]:
        return _mark(lattice.places[nodes], low, high)

    nodes = limb.nodes
    far = _find_far(lattice, limb, 0.0 if "lid" in roles else _BEND)  # a lid lies loose
    rest = np.setdiff1d(np.arange(len(lattice.places)), nodes)
    moved, joint = mark(nodes[far]), mark(nodes[~far])
    across = _find_across(lattice, nodes, rest)
    still = mark(rest) + mark(_find_near(lattice, nodes)) + (mark(across) if len(across) else ())
    neck = lattice.places[np.concatenate(lattice.find_necks(nodes))].std(0) / float((high - low).max())
    part = _join(roles, (moved, joint, still), limb, (limb.joint, limb.tip), low, high)
    return part.model_copy(update=dict(neck=tuple(np.round(neck, 4).tolist())))


def _make_stem(
    lattice: Lattice, limb: Limb, roles: tuple[PartRole, ...], low: np.ndarray, high: np.ndarray
) -> Part:
    """The part that a stem is: its foot stays, it bends, and what it bears goes along."""
    height, own = lattice.places[:, 2], lattice.places[limb.nodes, 2]
    foot, top = own.min() + _FOOT * np.ptp(own), own.max()
    sides = (height > top, (height >= foot) & (height <= top), height < foot)
    moved, between, still = (_mark(lattice.places[side], low, high) for side in sides)
    around = np.abs(own - own.mean()) <= 2 * lattice.spacing
    middle = lattice.places[limb.nodes][around].mean(0)
    tip = np.array([*middle[:2], height.max()])
    return _join(roles, (moved, between, still), limb, (middle, tip), low, high)


def _mark(places: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    """Seeds among places, as fractions of the object's box."""
    box = np.maximum(high - low, 1e-12)
    return tuple(tuple(np.round((place - low) / box, 4).tolist()) for place in spread(places, _SEEDS))


def _join(
    roles: tuple[PartRole, ...],
    seeds: tuple[tuple[tuple[float, float, float], ...], ...],
    limb: Limb,
    ends: tuple[np.ndarray, np.ndarray],
    low: np.ndarray,
    high: np.ndarray,
) -> Part:
    """The part with seeds of what moves, of what bends and of the rest, and with its joint and its tip [m]."""
    box, size = np.maximum(high - low, 1e-12), float((high - low).max())
    (moved, between, still), (joint, tip) = seeds, ends
    away = limb.centre - 0.5 * (low + high)
    return Part(
        roles=roles,
        moved=CellsRegion(inside=moved, outside=(*between, *still)),
        rest=CellsRegion(inside=still, outside=(*moved, *between)),
        joint=tuple(np.round((joint - low) / box, 4).tolist()),
        arm=tuple(np.round((tip - joint) / size, 4).tolist()),
        side=tuple(np.round(away / max(float(np.linalg.norm(away)), 1e-12), 4).tolist()),
        share=round(limb.share, 4),
    )


def _find_far(lattice: Lattice, limb: Limb, most: float) -> np.ndarray:
    """A mask of the nodes beyond the joint: the neck's radius away, or nearer where the limb is short, shape (k,)."""
    necks = np.concatenate(lattice.find_necks(limb.nodes))
    size = float(np.ptp(lattice.places, axis=0).max())
    depth = size * min(limb.width, _JOINT * limb.length, most)
    distance = np.asarray(KDTree(lattice.places[necks]).query(lattice.places[limb.nodes])[0])
    if (distance > depth).any():
        return distance > depth
    out = np.linalg.norm(lattice.places[limb.nodes] - limb.joint, axis=1)
    return out > np.median(out)


def _find_across(lattice: Lattice, nodes: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """The nodes of the rest that are near a part across a gap, as a stem is beside an upright arm; shape (k,)."""
    reach = _GAP * float(np.ptp(lattice.places, axis=0).max())
    necks = np.concatenate(lattice.find_necks(nodes))

    def find_within(those: np.ndarray, others: np.ndarray, bound: float) -> np.ndarray:
        tree = KDTree(lattice.places[others])
        return np.isfinite(tree.query(lattice.places[those], distance_upper_bound=bound)[0])

    near = rest[find_within(rest, nodes, reach)]
    return near[~find_within(near, necks, 2 * reach)] if len(near) else near


def _find_near(lattice: Lattice, nodes: np.ndarray) -> np.ndarray:
    """The nodes of the rest beside a part: they bound it."""
    rest = np.setdiff1d(np.arange(len(lattice.places)), nodes)
    necks = lattice.find_necks(rest)
    return np.concatenate(necks) if necks else rest
