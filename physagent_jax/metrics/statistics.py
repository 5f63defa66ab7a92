"""Statistics of benchmarks: intervals, figures over runs and tasks, paired tests, and the power of a sample.

Scores have the shape (runs, tasks). Figures over both, and how runs and tasks are drawn again, are those of Agarwal
et al. 2021, "Deep Reinforcement Learning at the Edge of the Statistical Precipice", and of its library rliable: runs
are drawn within each task, and tasks too where the tasks stand for others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from scipy import stats

DRAWS = 2000
LEVEL = 0.95
"""Coverage of all intervals; tests reject below 1 - `LEVEL`."""


@dataclasses.dataclass(frozen=True)
class Estimate:
    """A figure with the ends of its interval."""

    value: float
    low: float
    high: float


def estimate_share(values: Sequence[float] | np.ndarray) -> Estimate:
    """Wilson's interval of a share.

    Args:
        values: Success of each task, from 0 to 1, shape (tasks,). Where it is the mean of several runs, the interval is
            wider than it had to be: no mean of such values varies more than a count.
    """
    count, share = len(values), float(np.mean(values))
    z2 = stats.norm.ppf(0.5 + 0.5 * LEVEL) ** 2
    middle = (share + 0.5 * z2 / count) / (1 + z2 / count)
    half = np.sqrt(z2 * (share * (1 - share) / count + 0.25 * z2 / count**2)) / (1 + z2 / count)
    return Estimate(share, max(0.0, float(middle - half)), min(1.0, float(middle + half)))


def find_interquartile_mean(scores: np.ndarray) -> np.ndarray:
    """Mean of the middle half of all scores of (..., runs, tasks), shape (...)."""
    flat = scores.reshape(*scores.shape[:-2], -1)
    return np.asarray(stats.trim_mean(flat, 0.25, axis=-1))


def find_profile(scores: np.ndarray, levels: Sequence[float]) -> list[float]:
    """Performance profile: the share of all runs and tasks whose score is above each level."""
    return [float(np.mean(scores > level)) for level in levels]


def find_improvement(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Probability of improvement of (..., runs, tasks) over (..., other runs, tasks), shape (...).

    A run of ``one`` has a higher score than a run of ``other`` on the same task, averaged over tasks; equal ones count
    half. Per task this is Mann and Whitney's U over the number of pairs.
    """
    gap = np.sign(one[..., :, None, :] - other[..., None, :, :])
    return np.mean(0.5 + 0.5 * gap, axis=(-3, -2, -1))


def draw_again(
    figure: Callable[..., np.ndarray], *scores: np.ndarray, tasks: bool = True, seed: int = 0
) -> Estimate:
    """A figure with the percentiles of its stratified bootstrap.

    Args:
        figure: Maker of the figure, of arrays (..., runs, tasks).
        scores: Scores of each method, shape (runs, tasks); all on the same tasks.
        tasks: Whether tasks are drawn as well, the same for all methods; else runs alone, within each task.
        seed: Seed of the draws.
    """
    rng, count = np.random.default_rng(seed), scores[0].shape[1]
    which = rng.integers(count, size=(DRAWS, 1, count)) if tasks else np.arange(count)[None, None]
    drawn = [each[rng.integers(len(each), size=(DRAWS, *each.shape)), which] for each in scores]
    tail = 50 * (1 - LEVEL)
    low, high = np.percentile(figure(*drawn), [tail, 100 - tail])
    return Estimate(float(figure(*scores)), float(low), float(high))


def compute_mcnemar(first: int, second: int) -> float:
    """Exact p value of McNemar: ``first`` tasks that one method alone solves, ``second`` that the other does."""
    return float(stats.binomtest(first, first + second).pvalue) if first + second else 1.0


def compute_wilcoxon(gaps: np.ndarray) -> float:
    """The p value of Wilcoxon's signed ranks, of differences per task."""
    return float(np.asarray(stats.wilcoxon(gaps))[1]) if np.any(gaps) else 1.0


def correct(p_values: Sequence[float]) -> list[float]:
    """Holm's step-down correction."""
    order, adjusted, largest = np.argsort(p_values), np.empty(len(p_values)), 0.0
    for place, index in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - place) * p_values[index]))
        adjusted[index] = largest
    return adjusted.tolist()


CONTRARY = 0.05
"""Tasks that the worse of two methods alone solves, where a sample's power is told: an assumption, as a share."""


def find_power(count: int, gained: float, lost: float) -> float:
    """Chance that exact McNemar finds the better of two methods.

    Args:
        count: Number of tasks.
        gained: Probability that the better one alone solves a task.
        lost: Probability that the other alone does.
    """
    power = 0.0
    for apart in range(1, count + 1):
        wins = np.arange(apart + 1)
        found = (2 * stats.binom.cdf(apart - wins, apart, 0.5) <= 1 - LEVEL) & (2 * wins > apart)
        chances = stats.binom.pmf(wins, apart, gained / (gained + lost))
        power += float(stats.binom.pmf(apart, count, gained + lost) * chances[found].sum())
    return power


@cache
def find_smallest_difference(count: int, lost: float = CONTRARY, power: float = 0.8) -> float | None:
    """The least difference of two shares that exact McNemar finds with this power; None where there is none.

    Args:
        count: Number of tasks that both methods have done.
        lost: Probability that the worse one alone solves a task: the difference is the other's less this one.
        power: Chance to find it.
    """
    low, high = lost, 1 - lost
    if high <= lost or find_power(count, high, lost) < power:
        return None
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if find_power(count, middle, lost) >= power else (middle, high)
    return high - lost
