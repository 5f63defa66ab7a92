"""The parts of an object as data: limbs with their roles, marked by seeds whose Voronoi cells hold their particles."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part, PartRole
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.scene.parts.cells import spread
from physagent_jax.scene.parts.lattice import Lattice, make_lattice
from physagent_jax.scene.parts.limbs import Limb, find_limbs
from physagent_jax.scene.parts.roles import Roles

_JOINT, _BEND = 0.3, 0.08  # of the way from neck to tip, and of the object's length, that bends, at most
_SEEDS = 64  # that mark a part, or what is beside it, at most: fewer leave patches of a large one out


def find_parts(points: np.ndarray) -> tuple[Part, ...]:
    """The parts that stick out of an upright object.

    Args:
        points: Positions of its particles, z up [m], shape (n, 3).

    Returns:
        Parts with at least one role each; none for an object without limbs.
    """
    lattice = make_lattice(points)
    limbs = find_limbs(points, lattice)
    low, high = points.min(0), points.max(0)
    roles = Roles(limbs, low, high, lattice.places.mean(0)).assign()
    return tuple(_make_part(lattice, limbs[k], roles[k], low, high) for k in sorted(roles))


def _make_part(
    lattice: Lattice, limb: Limb, roles: tuple[PartRole, ...], low: np.ndarray, high: np.ndarray
) -> Part:
    box, size = np.maximum(high - low, 1e-12), float((high - low).max())

    def mark(nodes: np.ndarray) -> tuple[tuple[float, float, float], ...]:
        chosen = spread(lattice.places[nodes], _SEEDS)
        return tuple(tuple(np.round((place - low) / box, 4).tolist()) for place in chosen)

    nodes, way = limb.nodes, limb.tip - limb.joint
    far = _find_far(lattice, limb, 0.0 if "lid" in roles else _BEND)  # a lid lies loose
    rest = np.setdiff1d(np.arange(len(lattice.places)), nodes)
    moved, joint = mark(nodes[far]), mark(nodes[~far])
    still = mark(rest) + mark(_find_near(lattice, nodes))
    away = limb.centre - 0.5 * (low + high)
    return Part(
        roles=roles,
        moved=CellsRegion(inside=moved, outside=(*joint, *still)),
        rest=CellsRegion(inside=still, outside=(*moved, *joint)),
        joint=tuple(np.round((limb.joint - low) / box, 4).tolist()),
        arm=tuple(np.round(way / size, 4).tolist()),
        side=tuple(np.round(away / max(float(np.linalg.norm(away)), 1e-12), 4).tolist()),
        share=round(limb.share, 4),
        neck=tuple(
            np.round(lattice.places[np.concatenate(lattice.find_necks(nodes))].std(0) / size, 4).tolist()
        ),
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


def _find_near(lattice: Lattice, nodes: np.ndarray) -> np.ndarray:
    """The nodes of the rest beside a part: they bound it."""
    rest = np.setdiff1d(np.arange(len(lattice.places)), nodes)
    necks = lattice.find_necks(rest)
    return np.concatenate(necks) if necks else rest
