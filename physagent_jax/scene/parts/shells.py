"""The shells of a mesh: surfaces that share no edge, of which people build what they model: a wheel, a lid, a sign.

A shell has a border that is known, where a limb of the solid ends about there. So a part that is about some shells is
these, and where nothing else tells what a word means, shells are looked through as limbs are.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.parts.cells import fit_part
from physagent_jax.scene.parts.named import find_owners

_FEWEST = 12  # points of a shell, below which it is part of what is nearest
_WITHIN = 0.6  # share of a shell in a part, from which on it is of that
_SAME = 0.45  # overlap (intersection over union) of a part with its shells, from which on it is these
ROUGH = 0.35  # the same of a region that a word tells roughly
_TOUCH = 2.5  # spacings within which shells touch
_MOST_SHELLS = 60  # largest ones; the others are part of what is nearest
_NESTED = 0.04  # of its length, by which a shell may reach out of the box of one that it is set into
_HOST = 0.25  # share of the object that such a one has at most
_CUT = 0.25  # share of a part in shells that it cuts and that are smaller than it, from which on it is none
_MOST = 0.8  # share of the object that a candidate has
_INSIDE, _SMALL = 0.8, 0.15  # share of a tip in its shell, at least; of the object in that, at most
_LIKE = 1.5  # ratio of the sizes of a pair, at most
_AROUND, _OCTANTS = (
    0.12,
    5,
)  # of its length, about a point; octants there with other shells, of what lies outside
_DEEP = 0.05  # of its length, that a joint lies in a shell which bends there
_MOST_OTHERS, _LINKED = 8000, 1.5  # points of those; spacings within which free points hang together


@dataclasses.dataclass(frozen=True)
class Shells:
    """The shells of an object.

    Attributes:
        points: Points of the object at rest, z up [m], shape (n, 3).
        labels: The shell that each belongs to, from 0, shape (n,); zeros if there is but one.
    """

    points: np.ndarray
    labels: np.ndarray

    def snap(self, mask: np.ndarray, least: float = _SAME) -> np.ndarray | None:
        """The points of the shells that a mask is about, shape (n,); None if it is not about any of them.

        Args:
            mask: Points, shape (n,).
            least: Overlap (intersection over union) of the mask with its shells, from which on it is these.
        """
        sizes = np.bincount(self.labels)
        chosen = np.bincount(self.labels[mask], minlength=len(sizes)) > _WITHIN * sizes
        found = chosen[self.labels]
        if chosen.all() or not chosen.any():
            return None
        return found if (found & mask).sum() > least * (found | mask).sum() else None

    def snap_part(self, part: Part) -> Part:
        """A part that the shape shows, with the borders of the shells that it is about."""
        mask = self.snap(~make_region_mask(part.rest, self.points))
        if mask is None or "blade" in part.roles and self._is_inside(part, mask):
            return part
        made = fit_part(self.points, mask, joined=False)
        told = dict(moved=made.moved, rest=made.rest, share=made.share, side=made.side, neck=made.neck)
        return part.model_copy(update=told)

    def snap_parts(self, parts: Sequence[Part]) -> list[Part]:
        """The parts that the shape shows, with the borders of the shells that they are about, or are a pair of tips of.

        Of antlers that branch, the shape shows two tips alone.
        """
        if not self.labels.any():
            return [*parts]
        hosts, found = [self._find_host(part) for part in parts], [self.snap_part(part) for part in parts]
        for role in {part.roles[0] for part in parts if part.roles}:
            pair = [k for k, part in enumerate(parts) if part.roles[:1] == (role,)]
            if len(pair) != 2 or len({hosts[k] for k in pair} - {None}) != 2:
                continue
            masks = [self._find_free(hosts[k], parts[k]) for k in pair]
            sizes = sorted(int(mask.sum()) for mask in masks)
            if _FEWEST <= sizes[0] and sizes[1] < _LIKE * sizes[0]:
                for k, mask in zip(pair, masks):
                    made = fit_part(self.points, mask, joined=True, limb=True)
                    told = dict(roles=parts[k].roles, confidence=parts[k].confidence, origin=parts[k].origin)
                    found[k] = made.model_copy(update=told)
        return found

    def _is_inside(self, part: Part, mask: np.ndarray) -> bool:
        """Return whether a part bends in the midst of its shells, which reach down the shaft; mask of shape (n,)."""
        box = np.ptp(self.points, axis=0)
        tree: Any = KDTree(self.points[~mask])
        return bool(tree.query(self.points.min(0) + np.asarray(part.joint) * box)[0] > _DEEP * box.max())

    def _find_host(self, part: Part) -> int | None:
        """The small shell that a part is the tip of; None if there is none."""
        mask = ~make_region_mask(part.rest, self.points)
        inside, sizes = np.bincount(self.labels[mask]), np.bincount(self.labels)
        host = int(inside.argmax())
        tip = inside[host] > _INSIDE * mask.sum() and sizes[host] > 2 * mask.sum()
        return host if tip and sizes[host] < _SMALL * len(self.points) else None

    def _find_free(self, shell: int | None, tip: Part) -> np.ndarray:
        """The points of a shell beside its tip that lie outside of the others, shape (n,): no antler's root."""
        found, size = self.labels == shell, float(np.ptp(self.points, axis=0).max())
        others, own = self.points[~found], self.points[found]
        tree: Any = KDTree(others[:: -(-len(others) // _MOST_OTHERS)])
        near = zip(tree.query_ball_point(own, _AROUND * size), own)
        free = np.array([len({*map(tuple, tree.data[each] > place)}) <= _OCTANTS for each, place in near])
        if free.any():  # what lies in a hollow of the rest hangs together with nothing outside
            reach = _LINKED * size / max(len(self.points), 8) ** (1 / 3)
            links = KDTree(own[free]).sparse_distance_matrix(KDTree(own[free]), reach)
            groups = connected_components(links, directed=False)[1]
            outer = ~make_region_mask(tip.rest, self.points)[found][free]
            free[free] = groups == np.bincount(groups, outer).argmax()
        found[found] = free
        return found

    def are_cut(self, mask: np.ndarray) -> bool:
        """Return whether the border of a mask is across shells that are smaller than it."""
        sizes = np.bincount(self.labels)
        inside = np.bincount(self.labels[mask], minlength=len(sizes))
        small = sizes < mask.sum()
        return bool(np.minimum(inside, sizes - inside)[small].sum() > _CUT * mask.sum())

    @functools.cached_property
    def candidates(self) -> list[np.ndarray]:
        """The shells, those with what is set into them, and what hangs on the rest by one of them, as masks."""
        if not self.labels.any():
            return []
        own = [self.labels == k for k in range(self.labels.max() + 1)]
        boxes = [(self.points[mask].min(0), self.points[mask].max(0)) for mask in own]
        slack = _NESTED * float(np.ptp(self.points, axis=0).max())
        found: dict[bytes, np.ndarray] = {}
        for mask, (low, high) in zip(own, boxes):
            inner = [
                other
                for other, (a, b) in zip(own, boxes)
                if (a > low - slack).all() and (b < high + slack).all() and other.sum() < mask.sum()
            ]
            hosts = [mask, np.logical_or.reduce([mask, *inner])] if mask.mean() < _HOST else [mask]
            found |= {each.tobytes(): each for each in hosts}
        found |= {each.tobytes(): each for each in self._list_branches()}
        return [mask for mask in found.values() if mask.mean() < _MOST]

    def _list_branches(self) -> list[np.ndarray]:
        """The shells with what hangs on the middle one by each of them, as masks."""
        sizes, links = np.bincount(self.labels).astype(float), self._link()
        groups = [
            _part(links, k) for k in range(len(sizes))
        ]  # an arm is what hangs on the body by its upper half
        most = [np.bincount(group[group >= 0], sizes[group >= 0]).max(initial=0) for group in groups]
        middle = int(np.argmin(most))
        return [(group != group[middle])[self.labels] for k, group in enumerate(groups) if k != middle]

    def _link(self) -> np.ndarray:
        """The pairs of shells that touch; what touches none is linked to the nearest. Bool, shape (k, k)."""
        count = int(self.labels.max()) + 1
        trees: list[Any] = [KDTree(self.points[self.labels == k]) for k in range(count)]
        spacing = float(np.median(KDTree(self.points).query(self.points, k=2)[0][:, 1]))
        apart = np.full((count, count), np.inf)
        for a in range(count):
            for b in range(a):
                apart[a, b] = apart[b, a] = trees[b].query(trees[a].data)[0].min()
        links = apart <= _TOUCH * spacing
        while (groups := connected_components(links, directed=False)[1]).any():
            between = np.where(groups[:, None] == groups[None], np.inf, apart)
            a, b = np.unravel_index(between.argmin(), between.shape)
            links[a, b] = links[b, a] = True
        return links


def _part(links: np.ndarray, shell: int) -> np.ndarray:
    """The connected group of each shell if one is taken away, whose own is -1; shape (k,)."""
    left = links.copy()
    left[shell], left[:, shell] = False, False
    groups = connected_components(left, directed=False)[1].astype(int)
    groups[shell] = -1
    return groups


def find_shells(points: np.ndarray, surfaces: Sequence[MeshPart] = ()) -> Shells:
    """The shells of an object; those of a few points are part of what is nearest.

    Args:
        points: Points of the object at rest, z up [m], shape (n, 3).
        surfaces: Its shells in the same frame; none = there is but one.
    """
    alone = Shells(points, np.zeros(len(points), int))
    if len(surfaces) < 2:
        return alone
    owner = find_owners(points, np.zeros_like(points), surfaces)
    sizes = np.bincount(owner, minlength=len(surfaces))
    large = sizes[owner] >= max(
        _FEWEST, np.sort(sizes)[::-1][: _MOST_SHELLS + 1][-1] + 1 if len(sizes) > _MOST_SHELLS else 0
    )
    if not large.any():
        return alone
    tree: Any = KDTree(points[large])
    labels = np.unique(owner[large], return_inverse=True)[1].ravel()
    return Shells(points, labels[tree.query(points)[1]])
