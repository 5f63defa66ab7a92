"""Windows of time in frames, and their division into strokes and swings."""

from __future__ import annotations

import itertools

Window = tuple[float, float]
SPRING = 0.28  # [s] of each swing of what springs back
# Swings as it springs back, in parts of the angle: each goes 0.39 as far as the one before.
OVERSHOOT = 0.4  # of the angle, by which it goes too far at first
_BACK = (-1.0 - OVERSHOOT, 0.55, -0.21, 0.06)
IMPULSE_FRAMES = 1.0
_GUST = 0.3  # part of its window during which a gust acts
_MANY = 4  # swings in one window: half a second or less each, in a clip of the usual length


def divide(window: Window, shares: list[float]) -> list[Window]:
    """Consecutive windows in the ratio of ``shares``."""
    first, last = window
    total = sum(shares)
    edges = [first]
    for share in shares[:-1]:
        edges.append(edges[-1] + (last - first) * share / total)
    return list(zip(edges, [*edges[1:], last]))


def divide_swings(window: Window, count: int, held: bool) -> list[Window]:
    """Pushes that swing an object to and fro ``count`` times, each against the one before.

    What is held is pushed for half a period each. What is free is pushed half as long first and last, so that it comes
    back to its place and stops there; in whole frames where there is room, or it would drift. What is held and shakes
    faster than it would swing by itself is as good as free: a whole first push would throw it farther than all others.
    """
    if held and count < _MANY:
        return divide(window, [1.0] * (2 * count))
    shares = [0.5, *[1.0] * (2 * count - 1), 0.5]
    if held:
        return divide(window, shares)
    whole = 2 * int((window[1] - window[0]) / (4 * count))  # frames of half a period
    if whole < 2:
        return divide(window, shares)
    first = float(round(window[0]))
    return divide((first, first + 2.0 * count * whole), shares)


def list_springs(begin: float, end: float, frames: float) -> list[tuple[float, Window]]:
    """Swings of what springs back, of ``frames`` each, as there is time: parts of the angle with their windows."""
    count = int((end - begin) / frames)
    shares = _BACK if count >= len(_BACK) else (-1.0,) * min(count, 1)
    edges = [begin + frames * index for index in range(len(shares) + 1)]
    return list(zip(shares, itertools.pairwise(edges)))


def halve(window: Window) -> tuple[Window, Window]:
    """Two halves of as many whole frames each where there is room: else what is braked would drift on, or go back."""
    first = float(round(window[0]))
    half = int((round(window[1]) - first) / 2)
    if half < 1:
        speed_up, slow_down = divide(window, [1.0, 1.0])
        return speed_up, slow_down
    return (first, first + half), (first + half, first + 2.0 * half)


def shorten(window: Window, last: float) -> Window:
    """The part of a window in which a gust or a burst acts."""
    return (window[0], window[0] + max(_GUST * (window[1] - window[0]), min(1.0, last)))


def make_impulse_window(at: float) -> Window:
    """The shortest window that begins nearest to ``at``."""
    return (float(round(at)), round(at) + IMPULSE_FRAMES)
