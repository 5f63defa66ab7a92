"""Simultaneous magnitudes: their range holds for the sum of what acts at once along one line."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from physagent_jax.agents.matching import Cause
from physagent_jax.agents.vectors import cosine, dot
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import BoxRegion, HalfSpaceRegion, Region

_PARALLEL = 0.9
_SAMPLES = [i / 8 for i in range(9)]


def find_room(cause: Cause, others: Sequence[Cause], last: float) -> tuple[float, list[Cause]]:
    """The magnitude that is left for ``cause`` beside ``others`` that act at the same time.

    Args:
        cause: What is to act too.
        others: What acts already.
        last: Last frame of the clip.

    Returns:
        1.6 less the largest sum, at any instant, of what pulls the same way along the same line on the same matter;
        and what pulls there.
    """
    fellows = [other for other in others if acts_alike(cause, other) and share_window(cause, other, last)]
    first, end = get_span(cause, last)
    instants = [first, *(start for other in fellows if first <= (start := get_span(other, last)[0]) < end)]
    largest = 0.0
    for instant in instants:
        acting = [
            other for other in fellows if get_span(other, last)[0] <= instant < get_span(other, last)[1]
        ]
        largest = max(largest, sum(max(_project(cause, other), 0.0) for other in acting))
    return MAGNITUDE_MAX - largest, [other for other in fellows if _project(cause, other) > 0]


def fits(room: float, magnitude: float) -> bool:
    """Return whether a magnitude stays inside the room that there is."""
    return abs(magnitude) <= room + 1e-6


def has_room(room: float) -> bool:
    """Return whether the weakest action still fits."""
    return room >= MAGNITUDE_MIN - 1e-9


def acts_alike(one: Cause, other: Cause) -> bool:
    """Return whether two entries are of one kind, along one line, and on the same particles."""
    kinds = [cause.skill.stacks_with or cause.skill.name for cause in (one, other)]
    if kinds[0] != kinds[1] or abs(cosine(one.item.vector, other.item.vector)) < _PARALLEL:
        return False
    return one.item.object == other.item.object and do_regions_meet(one.item.region, other.item.region)


def share_window(one: Cause, other: Cause, last: float) -> bool:
    """Return whether there is an instant in which both act."""
    (a, b), (c, d) = get_span(one, last), get_span(other, last)
    return a < d and c < b


def get_span(cause: Cause, last: float) -> tuple[float, float]:
    """First and last frame in which it acts."""
    return cause.item.active_time or (0.0, max(last, 1e-3))


def _project(cause: Cause, other: Cause) -> float:
    """The other's magnitude in the sense of ``cause``; an axis of a stretch has no sense of its own."""
    value = other.item.magnitude * (1.0 if cause.item.magnitude > 0 else -1.0)
    if cause.skill.is_two_sided:
        return value
    return value if cosine(cause.item.vector, other.item.vector) > 0 else -value


def do_regions_meet(one: Region | None, other: Region | None) -> bool:
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
    return sum((c - q) ** 2 for c, q in zip(p, region.center)) <= region.radius**2
