"""Simultaneous magnitudes: their range holds for the sum of what acts at once along one line."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import BoxRegion, CellsRegion, HalfSpaceRegion, Region
from physagent_jax.motion.matching import Cause
from physagent_jax.motion.vectors import cosine, dot

_PARALLEL = 0.9
_SAMPLES = [i / 8 for i in range(9)]


def find_room(cause: Cause, others: Sequence[Cause], last: float) -> tuple[float, list[Cause]]:
    """The magnitude that is left for ``cause`` beside ``others``, in a clip that ends with frame ``last``.

    Returns:
        1.6 less the largest sum, at any instant, of what pulls the same way along the same line on the same matter;
        and what pulls there.
    """
    first, end = _get_span(cause, last)
    fellows = []
    for other in others:
        begun, ended = _get_span(other, last)
        if begun < end and first < ended and _acts_alike(cause, other):
            fellows.append((other, begun, ended, _project(cause, other)))
    largest = 0.0
    for instant in (first, *(begun for _, begun, _, _ in fellows if first <= begun < end)):
        acting = (max(size, 0.0) for _, begun, ended, size in fellows if begun <= instant < ended)
        largest = max(largest, sum(acting))
    return MAGNITUDE_MAX - largest, [other for other, _, _, size in fellows if size > 0]


def fits(room: float, magnitude: float) -> bool:
    """Return whether a magnitude stays inside the room that there is."""
    return abs(magnitude) <= room + 1e-6


def has_room(room: float) -> bool:
    """Return whether the weakest action still fits."""
    return room >= MAGNITUDE_MIN - 1e-9


def _acts_alike(one: Cause, other: Cause) -> bool:
    """Return whether two entries are of one kind, along one line, and on the same particles."""
    kinds = [cause.skill.stacks_with or cause.skill.name for cause in (one, other)]
    if kinds[0] != kinds[1] or abs(cosine(one.item.vector, other.item.vector)) < _PARALLEL:
        return False
    return one.item.object == other.item.object and _do_regions_meet(one.item.region, other.item.region)


def _get_span(cause: Cause, last: float) -> tuple[float, float]:
    """First and last frame in which it acts."""
    return cause.item.active_time or (0.0, max(last, 1e-3))


def _project(cause: Cause, other: Cause) -> float:
    """The other's magnitude in the sense of ``cause``; an axis of a stretch has no sense of its own."""
    along = cause.skill.is_two_sided or cosine(cause.item.vector, other.item.vector) > 0
    return other.item.magnitude * (1.0 if (cause.item.magnitude > 0) == along else -1.0)


def _do_regions_meet(one: Region | None, other: Region | None) -> bool:
    """Return whether two parts of the object have something in common; looked at on a lattice over its bounding box."""
    if one is None or other is None or one == other:
        return True
    lattice = itertools.product(_SAMPLES, _SAMPLES, _SAMPLES)
    return any(_is_inside(one, p) and _is_inside(other, p) for p in lattice)


def _is_inside(region: Region, p: tuple[float, float, float]) -> bool:
    if isinstance(region, BoxRegion):
        return all(low <= c <= high for low, c, high in zip(region.low, p, region.high))
    if isinstance(region, HalfSpaceRegion):
        x, y, z = (c - q for c, q in zip(p, region.point))
        return dot((x, y, z), region.normal) >= 0
    if isinstance(region, CellsRegion):
        near, far = (min(math.dist(p, seed) for seed in seeds) for seeds in (region.inside, region.outside))
        return near < far
    return sum((c - q) ** 2 for c, q in zip(p, region.center)) <= region.radius**2
