"""Turning points of a path, and its ways out from a place."""

from __future__ import annotations

from collections.abc import Sequence


def find_turning_points(path: Sequence[float], threshold: float) -> list[int]:
    """Indices of the extremes that are followed by a way back of more than ``threshold``, in order.

    Args:
        path: Position per frame.
        threshold: Hysteresis, in the path's unit.
    """
    turns, extreme, heading = [], 0, 0
    for t in range(1, len(path)):
        step = path[t] - path[extreme]
        if heading == 0:
            if abs(step) > threshold:
                heading, extreme = (1 if step > 0 else -1), t
        elif heading * step >= 0:
            extreme = t
        elif abs(step) > threshold:
            turns.append(extreme)
            heading, extreme = -heading, t
    return turns


def find_excursions(path: Sequence[float], threshold: float) -> list[int]:
    """Indices of the farthest places of the ways out from 0 that lead back there, in order.

    Args:
        path: Position per frame.
        threshold: Distance from 0 at which a way out begins, and ends again, in the path's unit.
    """
    found, farthest, side = [], 0, 0
    for t, place in enumerate(path):
        now = 0 if abs(place) <= threshold else 1 if place > 0 else -1
        if side and now != side:
            found.append(farthest)
        if now and (now != side or abs(place) > abs(path[farthest])):
            farthest = t
        side = now
    return found
