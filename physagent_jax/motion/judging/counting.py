"""The confidence of a count or a time: its distance from another verdict, against the noise of its series."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import median

from physagent_jax.core.turning import find_returns, find_turning_points
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.comparing import find_confidence
from physagent_jax.motion.schema import Check
from physagent_jax.motion.vectors import clamp

_STEPS = 40  # thresholds tried between nothing and the whole span
_NORMAL = 0.6745  # median of a standard normal variable's size
_FOURTH = math.sqrt(70.0)  # deviation of the fourth difference of unit noise: 1, 4, 6, 4, 1 squared and added
_ROUNDED = 1 / math.sqrt(12.0)  # [frames] standard deviation of a time that is read off to whole frames
_SMALLEST = 1e-9
_SOME, _MANY = (
    2,
    16,
)  # turns of what goes to and fro again and again: to one side, and to the other; and what is still followed
_CLEAR = 4.0  # times its noise, by which a swing stands out
_FAINT = 0.5  # of the hysteresis: from there on a swing may be counted, as its neighbours tower above it


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
    would: the verdict is as sure as the nearest threshold with another verdict is far. None larger than ``span`` makes
    sense; ``noise`` is the standard deviation of what is compared with the threshold.
    """
    verdict = passes(count(threshold))
    tried = [span * (k + 0.5) / _STEPS for k in range(_STEPS)]
    away = [abs(other - threshold) for other in tried if passes(count(other)) is not verdict]
    return find_confidence(min(away, default=max(span, _SMALLEST)), max(noise, _SMALLEST))


def check_count(
    asked: Asked,
    question: str,
    count: Callable[[float], int],
    *,
    least: int,
    most: int,
    aim: float,
    threshold: float,
    span: float,
    noise: float,
    noun: str,
    fix: str,
) -> Check:
    """The number of what exceeds a threshold against what is asked; see `find_count_confidence`.

    ``aim`` is the number in [least, most] with the largest margin, ``noun`` names what is counted.
    """
    seen = count(threshold)
    passed, half = least <= seen <= most, 0.5 + most - aim
    return Check(
        expectation=asked.index,
        question=question,
        aspect="repeats",
        expected=f"{least} times" if least == most else f"{least} to {most} times",
        observed=f"{seen} {noun}",
        passed=passed,
        score=1.0 if passed else round(0.9 * min(seen / least, most / max(seen, 1)), 6),
        margin=round(clamp((half - abs(seen - aim)) / half, -10.0, 1.0), 6),
        confidence=find_count_confidence(count, lambda n: least <= n <= most, threshold, span, noise),
        remedy="" if passed else fix,
    )


def count_turns(asked: Asked, path: list[float], hysteresis: float, rest: float | None = None) -> Check:
    """To and fro ``repeats`` times is ``2 repeats - 1`` turns, and some more while it comes to rest.

    Without a count, any number that can be followed is a sway. Ways back shorter than ``hysteresis`` do not
    count but where the number needs them, as the last ones of what comes to rest; nor do those that end before the
    place of rest: what is held in place and bent to one side rings there.

    Args:
        asked: What is asked.
        path: Position per frame.
        hysteresis: Least way back, in the path's unit.
        rest: Position at rest; None for what has no place of its own.
    """
    count = asked.motion.repeats

    noise = math.sqrt(2.0) * estimate_jitter(path)

    def count_those(threshold: float) -> int:
        if rest is None:
            return len(find_turning_points(path, threshold, first=0.5 * threshold))
        return len(find_returns(path, threshold, rest))

    def count_needed(threshold: float) -> int:
        faint = min(max(_FAINT * threshold, _CLEAR * noise), threshold)
        return max(count_those(threshold), min(count_those(faint), least))

    least, most = 2 * count - 1, (2 * count + 2 if count > 1 else 7)
    if not asked.motion.counted and count > 1:  # a viewer does not count what no number is told of
        least, most = _SOME, max(most, _MANY)
    return check_count(
        asked,
        "how often does it turn back?",
        count_needed,
        least=least,
        most=most,
        aim=0.5 * (least + most),
        threshold=hysteresis,
        span=max(path) - min(path),
        noise=noise,
        noun="turns",
        fix=f"alternate {asked.causes or 'pushes'} {count} times to and fro",
    )


def estimate_crossing(series: Sequence[tuple[int, float]], frame: int, noise: float) -> float:
    """Standard deviation of when a series crossed a level [frames]: noise over slope, and the frames' own width."""
    at = next((k for k, (t, _) in enumerate(series) if t >= frame), len(series) - 1)
    low, high = max(at - 1, 0), min(at + 1, len(series) - 1)
    slope = abs(series[high][1] - series[low][1]) / max(series[high][0] - series[low][0], 1)
    return math.hypot(_ROUNDED, min(noise / max(slope, _SMALLEST), float(len(series))))
