"""The confidence of a count or a time: its distance from another verdict, against the noise of its series."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import median

from physagent_jax.agents.rules.judging.comparing import find_confidence

_STEPS = 40
"""Thresholds tried between nothing and the whole span."""
_NORMAL = 0.6745
"""Median of a standard normal variable's size."""
_FOURTH = math.sqrt(70.0)
"""Standard deviation of the fourth difference of unit noise: 1, 4, 6, 4, 1 squared and added."""
_ROUNDED = 1 / math.sqrt(12.0)
"""Standard deviation of a time that is read off to whole frames [frames]."""
_SMALLEST = 1e-9


def estimate_jitter(path: Sequence[float]) -> float:
    """Standard deviation of a series' noise from frame to frame.

    From fourth differences, in which a swing of twelve frames a period is less than a hundredth of itself.
    """
    if len(path) < 5:
        return 0.0
    rows = zip(path, path[1:], path[2:], path[3:], path[4:])
    return median(abs(a - 4 * b + 6 * c - 4 * d + e) for a, b, c, d, e in rows) / (_NORMAL * _FOURTH)


def find_count_confidence(
    count: Callable[[float], int], passes: Callable[[int], bool], threshold: float, span: float, noise: float
) -> float:
    """Chance that noise did not decide whether a count passes.

    What is counted is what exceeds a threshold. Noise makes a thing a little larger or smaller, as another threshold
    would: the verdict is as sure as the nearest threshold with another verdict is far.

    Args:
        count: How many exceed a threshold.
        passes: Whether a number of them is what was asked for.
        threshold: The one that was used.
        span: The largest that makes sense, in the same unit.
        noise: Standard deviation of what is compared with the threshold.
    """
    verdict = passes(count(threshold))
    tried = [span * (k + 0.5) / _STEPS for k in range(_STEPS)]
    away = [abs(other - threshold) for other in tried if passes(count(other)) is not verdict]
    return find_confidence(min(away, default=max(span, _SMALLEST)), max(noise, _SMALLEST))


def estimate_crossing(series: Sequence[tuple[int, float]], frame: int, noise: float) -> float:
    """Standard deviation of when a series crossed a level [frames]: noise over slope, and the frames' own width.

    Args:
        series: Frames with a value each.
        frame: At which the level was found to be crossed.
        noise: Standard deviation of a value.
    """
    at = next((k for k, (t, _) in enumerate(series) if t >= frame), len(series) - 1)
    low, high = max(at - 1, 0), min(at + 1, len(series) - 1)
    slope = abs(series[high][1] - series[low][1]) / max(series[high][0] - series[low][0], 1)
    return math.hypot(_ROUNDED, min(noise / max(slope, _SMALLEST), float(len(series))))
