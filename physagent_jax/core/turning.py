"""Turning points of a path."""

from __future__ import annotations

from collections.abc import Sequence


def find_turning_points(path: Sequence[float], threshold: float, first: float | None = None) -> list[int]:
    """Indices of the extremes that are followed by a way back of more than ``threshold``, in order.

    Args:
        path: Position per frame.
        threshold: Hysteresis, in the path's unit.
        first: The same of the way to the first extreme, which is half a swing of what begins at rest; None = as the
            others.
    """
    first = threshold if first is None else first
    turns, extreme, heading = [], 0, 0
    for t in range(1, len(path)):
        step = path[t] - path[extreme]
        if heading == 0:
            if abs(step) > first:
                heading, extreme = (1 if step > 0 else -1), t
        elif heading * step >= 0:
            extreme = t
        elif abs(step) > threshold:
            turns.append(extreme)
            heading, extreme = -heading, t
    return turns


def find_returns(path: Sequence[float], threshold: float, rest: float) -> list[int]:
    """Indices of the turning points from which the way leads back to a place, or past it, in order.

    Args:
        path: Position per frame.
        threshold: Hysteresis, in the path's unit; half of it is near enough.
        rest: The place.
    """
    near = 0.5 * threshold
    turns = find_turning_points(path, threshold, first=near)
    ways = [(at, path[at : end + 1]) for at, end in zip(turns, [*turns[1:], len(path)])]
    return [at for at, way in ways if min(way) - rest <= near and max(way) - rest >= -near]
