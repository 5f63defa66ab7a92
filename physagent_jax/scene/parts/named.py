"""Parts that the object's file or a person names, as regions of its particles."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.errors import UserError
from physagent_jax.forces.part import ROLLING, Part, PartChoice, list_parts, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.parts.cells import fit_part
from physagent_jax.scene.placement import Placement
from physagent_jax.scene.store import keep

_SAMPLES = 60_000  # on all surfaces
_FEWEST_SAMPLES = 16  # on one
_NEAREST = 12  # samples among which a particle's is chosen
_WRONG = 3.0  # spacings that a sample is farther if the particle lies before it, or faces another way
_WHOLE = 0.98  # share of the object from which on a name is the object's own
_FEWEST = 5  # particles
_SKIN = 4  # edges that a part's surface shares with others, from which on they are one skin
_TOLD = 0.9  # share of the object that named parts cover, from which on the file names all of it
_WITHIN = 0.8  # share of a shape in a named part, from which on it is a part of that
_WHEELS = frozenset("wheel wheels tyre tire tyres tires gear cog pulley roller rotor propeller fan".split())
_UPRIGHT = 0.5  # cosine to the vertical, from which on an axle carries no wheel that bears
_BEARING, _SHORTER = 0.1, 0.95  # of a vehicle's height over its lowest point; its breadth over its length
_BLADES = frozenset(
    "blades rotor propeller airscrew fan turbine".split()
)  # words for what turns about their hub
_JOINTED = frozenset(
    "arm arms forearm leg legs shin foot hand wing wings tail head neck ear horn trunk antenna finger thumb".split()
)  # words for what turns about its joint, however short it is
_FORELEG = re.compile(r"\barm$")
_SAME = 0.5  # overlap (intersection over union) from which on a shape is the part that is named


@dataclasses.dataclass(frozen=True)
class Group:
    """Particles with one name.

    Attributes:
        name: As the file has it, cleaned.
        mask: Which particles, shape (n,).
        joined: Whether its surface goes over into that of the rest.
    """

    name: str
    mask: np.ndarray
    joined: bool


def find_groups(points: np.ndarray, normals: np.ndarray, surfaces: Sequence[MeshPart]) -> list[Group]:
    """The named groups of particles: each particle belongs to the surface that is nearest to it.

    Two surfaces may touch, as a lid's and a pot's do. Between samples that are as near, a particle belongs to the one
    that faces its way, or that it lies behind.

    Args:
        points: Particles in the frame of the surfaces, shape (n, 3).
        normals: Outward unit normals where a particle lies on a surface, else zero, shape (n, 3).
        surfaces: Surfaces with the names that they go by.

    Returns:
        Groups with distinct particles, in the order of the file; none that is all of the object.
    """
    owner, edges = find_owners(points, normals, surfaces), _number_edges(surfaces)
    found: list[Group] = []
    for name in dict.fromkeys(name for each in surfaces for name in each.names):
        mine = np.array([name in each.names for each in surfaces])
        if _is_all(mine[owner]):  # the root of what hangs on it is that alone
            mine = np.array([name == each.names[0] if each.names else False for each in surfaces])
        mask = mine[owner]
        known = any((mask == other.mask).all() for other in found)
        if mask.sum() >= _FEWEST and not _is_all(mask) and not known:
            found.append(Group(name, mask, _is_joined(edges, mine)))
    return found


def _is_all(mask: np.ndarray) -> bool:
    return bool(mask.sum() >= _WHOLE * len(mask))


def find_owners(points: np.ndarray, normals: np.ndarray, surfaces: Sequence[MeshPart]) -> np.ndarray:
    """The surface of each particle, shape (n,)."""
    corners = [each.vertices[each.faces] for each in surfaces]
    doubled = [np.cross(each[:, 1] - each[:, 0], each[:, 2] - each[:, 0]) for each in corners]
    areas = np.array([np.linalg.norm(each, axis=1).sum() / 2 for each in doubled])
    counts = np.maximum(np.round(_SAMPLES * areas / max(areas.sum(), 1e-30)), _FEWEST_SAMPLES).astype(int)
    chance = np.random.default_rng(0)
    places, ways = [], []
    for triangles, normal, count in zip(corners, doubled, counts):
        size = np.linalg.norm(normal, axis=1)
        if not size.sum() > 0:
            size = np.ones_like(size)
        face = np.searchsorted(np.cumsum(size) / size.sum(), chance.random(count)).clip(0, len(size) - 1)
        u, v = np.sqrt(chance.random((count, 1))), chance.random((count, 1))
        a, b, c = (triangles[face, k] for k in range(3))
        places.append((1 - u) * a + u * (1 - v) * b + u * v * c)
        ways.append(normal[face] / np.maximum(size[face], 1e-30)[:, None])
    place, way = np.concatenate(places), np.concatenate(ways)
    owner = np.repeat(np.arange(len(surfaces)), counts)
    tree: Any = KDTree(place)
    distance, near = tree.query(points, k=min(_NEAREST, len(place)))
    distance, near = distance.reshape(len(points), -1), near.reshape(len(points), -1)
    spacing = np.sqrt(areas.sum() / len(place))
    on_surface = (normals**2).sum(1) > 0
    faces = (way[near] * normals[:, None]).sum(-1) > 0.3
    behind = ((points[:, None] - place[near]) * way[near]).sum(-1) <= 0
    right = np.where(on_surface[:, None], faces, behind)
    best = (distance + np.where(right, 0.0, _WRONG * spacing)).argmin(1)
    return owner[np.take_along_axis(near, best[:, None], 1)[:, 0]]


def _is_joined(edges: tuple[np.ndarray, np.ndarray], mine: np.ndarray) -> bool:
    """Return whether open edges of some surfaces are edges of the others too."""
    numbers, owners = edges
    own, other = (
        np.bincount(numbers[mine[owners] == wanted], minlength=len(numbers)) for wanted in (True, False)
    )
    return int(((own == 1) & (other > 0)).sum()) >= _SKIN


def _number_edges(surfaces: Sequence[MeshPart]) -> tuple[np.ndarray, np.ndarray]:
    """A number for each edge of each triangle, alike for equal ones, and the surface that it is of; shapes (m,)."""
    ends = [each.vertices[each.faces][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2, 3) for each in surfaces]
    owners = np.repeat(np.arange(len(ends)), [len(each) for each in ends])
    return np.unique(_order_ends(np.concatenate(ends)), axis=0, return_inverse=True)[1].ravel(), owners


def _order_ends(pairs: np.ndarray) -> np.ndarray:
    """Edges with the lower end first, rounded so that equal ones are equal; (m, 2, 3) to (m, 6)."""
    pairs = pairs.astype(np.float32)
    a, b = pairs[:, 0], pairs[:, 1]
    first = (a != b).argmax(1)[:, None]
    swap = np.take_along_axis(a, first, 1) > np.take_along_axis(b, first, 1)
    return np.concatenate([np.where(swap, b, a), np.where(swap, a, b)], axis=1)


@keep
def make_parts(points: np.ndarray, groups: Sequence[Group]) -> tuple[Part, ...]:
    """The parts that groups of particles are.

    Args:
        points: Particles at rest [m], shape (n, 3).
        groups: Groups with the file's names.
    """
    rolls = [not _WHEELS.isdisjoint(split_name(group.name)) for group in groups]
    fans = [not _BLADES.isdisjoint(split_name(group.name)[-1:]) for group in groups]
    limbs = [not _JOINTED.isdisjoint(split_name(group.name)[-1:]) for group in groups]
    told = [
        fit_part(points, g.mask, joined=g.joined, wheel=wheel, blades=fan, limb=limb)
        for g, wheel, fan, limb in zip(groups, rolls, fans, limbs)
    ]
    told = [_give_axle(part, points, group) for part, group in zip(told, groups)]
    return tuple(
        part.model_copy(update=dict(name=group.name, origin="file")) for part, group in zip(told, groups)
    )


def _give_axle(part: Part, points: np.ndarray, group: Group) -> Part:
    """The part with an axle across a vehicle where it is called a wheel, bears it, and its shape shows no axle.

    What fills a vehicle belongs to its nearest surface, so that a wheel is as thick as it is broad.
    """
    height = float(np.ptp(points[:, 2]))
    bears = float(points[group.mask, 2].min() - points[:, 2].min()) < _BEARING * height
    told = part.axle is not None and abs(part.axle[2]) < _UPRIGHT
    if told or group.joined or not bears or ROLLING.isdisjoint(split_name(group.name)):
        return part
    spread, axes = np.linalg.eigh(np.cov(points[:, :2].T))
    if spread[0] > _SHORTER**2 * spread[1]:
        return part
    own, low = points[group.mask], points.min(0)
    hub = (0.5 * (own.min(0) + own.max(0)) - low) / np.maximum(np.ptp(points, axis=0), 1e-12)
    axle = (*np.round(axes[:, 0], 4).tolist(), 0.0)
    return part.model_copy(update=dict(axle=axle, joint=tuple(np.round(hub, 5).tolist()), seated=True))


def find_pieces(
    points: np.ndarray, parts: Sequence[Part], masks: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """The piece of its own that each particle and each Gaussian belongs to: those in the same rigid parts are one.

    Args:
        points: Particles at rest [m], shape (n, 3).
        parts: Parts that the file names.
        masks: The Gaussians of each part, shape (g,) each; where surfaces touch they tell more than cells.

    Returns:
        Labels of the particles, shape (n,), and of the Gaussians, shape (g,).
    """
    rows = [
        np.concatenate([make_region_mask(part.moved, points), mask])
        for part, mask in zip(parts, masks)
        if part.moved.rigid
    ]
    if not rows:
        return np.zeros(len(points), int), np.zeros(len(masks[0]) if masks else 0, int)
    labels = np.unique(np.stack(rows), axis=1, return_inverse=True)[1].ravel()
    return labels[: len(points)], labels[len(points) :]


def join_parts(points: np.ndarray, named: Sequence[Part], shapes: Sequence[Part]) -> tuple[Part, ...]:
    """The parts that the file names, then those of the shape that are none of them.

    A named part takes the roles of the shape that it is. Where the file names all of the object, a shape that lies
    across the borders of its parts is none. Parts without particles are left out.

    Args:
        points: Particles at rest [m], shape (n, 3).
        named: Parts that the file names.
        shapes: Parts that the shape shows.
    """
    named, shapes = ([part for part in each if _is_shown(part, points)] for each in (named, shapes))
    masks = [~make_region_mask(part.rest, points) for part in shapes]
    own = [~make_region_mask(part.rest, points) for part in named]
    taken, found = set(), []
    for part, mask in zip(named, own):
        overlaps = [_overlap(each, mask) for each in masks]
        same = int(np.argmax(overlaps)) if overlaps and max(overlaps) > _SAME else None
        if same is not None:
            taken.add(same)
            part = part.model_copy(update=dict(roles=shapes[same].roles))  # its name is certain
            if part.roles[:1] == ("leg",):  # rigs of animals have arms in front
                part = part.model_copy(update=dict(name=_FORELEG.sub("front leg", part.name)))
        found.append(part)
    told = sum(own, np.zeros(len(points), bool)).mean() > _TOLD if len(own) > 1 else False
    across = {k for k, mask in enumerate(masks) if told and not any(_holds(each, mask) for each in own)}
    return (*found, *(part for index, part in enumerate(shapes) if index not in taken | across))


def _is_shown(part: Part, points: np.ndarray) -> bool:
    """Return whether a part and the rest beside it both have particles: few of them may leave a small part none."""
    try:
        return all(make_region_mask(each, points).any() for each in (part.moved, part.rest))
    except UserError:
        return False


def _holds(outer: np.ndarray, inner: np.ndarray) -> bool:
    """Return whether a part that the file names holds a shape, and is more than that."""
    return float((outer & inner).sum()) > _WITHIN * inner.sum() and not outer.all()


def _overlap(a: np.ndarray, b: np.ndarray) -> float:
    return float((a & b).sum() / max((a | b).sum(), 1))


def choose_parts(
    points: np.ndarray, parts: tuple[Part, ...], choices: Sequence[PartChoice], placement: Placement
) -> tuple[Part, ...]:
    """The parts with the names that a person gives them; boxes are added behind the others.

    Args:
        points: Particles at rest [m], shape (n, 3).
        parts: Parts that file and shape show.
        choices: What the person names.
        placement: From the file's frame to the world.

    Raises:
        UserError: A box holds none or all of the particles, a number is not in the list, or there is no part to name.
    """
    found, count = list(parts), len(parts)
    for choice in choices:
        told = dict(name=choice.name, origin="option", confidence=1.0)
        if choice.box is not None:
            source = placement.to_source(points)
            mask = np.asarray(((source >= choice.box[:3]) & (source <= choice.box[3:])).all(1))
            if not _FEWEST <= mask.sum() < len(mask):
                low, high = (np.round(each, 4).tolist() for each in (source.min(0), source.max(0)))
                raise UserError(
                    f"the box of the part {choice.name!r} holds {'all' if mask.all() else 'nothing'} of the object",
                    got=f"{list(choice.box)}; the object reaches from {low} to {high}",
                    do="Give --part NAME=X0,Y0,Z0,X1,Y1,Z1 in the file's units and axes (`physagent inspect`)",
                )
            found.append(fit_part(points, mask, joined=True).model_copy(update=told))
            continue
        if not parts or (choice.number or 1) > count:
            raise UserError(
                f"there is no such part to be called {choice.name!r}",
                got="no part was found"
                if not parts
                else f"number {choice.number} of {count}: {list_parts(parts)}",
                do="Mark it with a box, --part NAME=X0,Y0,Z0,X1,Y1,Z1, in the file's units and axes",
            )
        index = (choice.number or _find_nearest(points, parts, choice, placement) + 1) - 1
        found[index] = found[index].model_copy(update=told)
    return tuple(found)


def _find_nearest(points: np.ndarray, parts: Sequence[Part], choice: PartChoice, placement: Placement) -> int:
    """The part with the particle nearest to a point; of parts within each other the smaller one."""
    place = placement.to_world(np.array(choice.point))
    distances = np.linalg.norm(points - place, axis=1)
    near = [float(distances[make_region_mask(part.moved, points)].min()) for part in parts]
    slack = 1e-3 * float(np.ptp(points, axis=0).max())
    close = [index for index, each in enumerate(near) if each <= min(near) + slack]
    return min(close, key=lambda index: parts[index].share)
