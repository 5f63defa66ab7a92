"""Simultaneous magnitudes: their range holds for the sum of what acts at once along one line."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.slabs import do_regions_meet
from physagent_jax.motion.matching import Cause
from physagent_jax.motion.vectors import cosine

_PARALLEL = 0.9


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
    return one.item.object == other.item.object and do_regions_meet(one.item.region, other.item.region)


def _get_span(cause: Cause, last: float) -> tuple[float, float]:
    """First and last frame in which it acts."""
    return cause.item.active_time or (0.0, max(last, 1e-3))


def _project(cause: Cause, other: Cause) -> float:
    """The other's magnitude in the sense of ``cause``; an axis of a stretch has no sense of its own."""
    along = cause.skill.is_two_sided or cosine(cause.item.vector, other.item.vector) > 0
    return other.item.magnitude * (1.0 if (cause.item.magnitude > 0) == along else -1.0)
