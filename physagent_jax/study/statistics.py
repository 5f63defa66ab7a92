"""Statistics of choices: strengths from choices among several, and agreement between raters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy import optimize, sparse

from physagent_jax.metrics.statistics import DRAWS, LEVEL

FEWEST = 5
"""Participants below which drawing them tells nothing."""


def draw_participants(chosen: np.ndarray, shown: np.ndarray, seed: int = 0) -> tuple[float, float] | None:
    """Percentiles of the bootstrap of a share in which whole participants are drawn.

    Args:
        chosen: Counts of each participant, shape (participants,).
        shown: Number of sets that each participant saw, shape (participants,).
        seed: Seed of the draws.

    Returns:
        The ends of the interval; None with fewer than `FEWEST` participants.
    """
    if len(shown) < FEWEST:
        return None
    drawn = np.random.default_rng(seed).integers(len(shown), size=(DRAWS, len(shown)))
    total = shown[drawn].sum(1)
    shares = chosen[drawn].sum(1)[total > 0] / total[total > 0]
    low, high = np.percentile(shares, [50 * (1 - LEVEL), 50 * (1 + LEVEL)])
    return float(low), float(high)


Choices = Mapping[tuple[tuple[int, ...], int], int]
"""Number of votes by the alternatives shown, and the one that was chosen."""


def is_estimable(choices: Choices, count: int) -> bool:
    """Return whether strengths have a finite estimate (Ford 1957): every group of methods wins somewhere."""
    over = np.zeros((count, count))
    for (shown, chosen), votes in choices.items():
        over[chosen, list(shown)] += votes
    return count > 0 and sparse.csgraph.connected_components(over, connection="strong")[0] == 1


def fit_strengths(choices: Choices, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Maximum-likelihood strengths of Bradley and Terry 1952, for several alternatives those of Luce 1959.

    A method is chosen with probability exp(s) over the sum of exp(s) of all shown. Where there is no finite estimate
    (`is_estimable`), what is returned has no meaning.

    Returns:
        Strengths on the log scale, with mean 0, shape (count,), and their covariance (inverse Fisher information).
    """
    sets = [(np.array(shown), chosen, votes) for (shown, chosen), votes in choices.items()]

    def weigh(strengths: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        loss, slope, curvature = (
            0.5 * strengths.sum() ** 2,
            np.full(count, strengths.sum()),
            np.ones((count, count)),
        )
        for shown, chosen, votes in sets:
            s = strengths[shown] - strengths[shown].max()
            p = np.exp(s) / np.exp(s).sum()
            loss -= votes * np.log(p[shown == chosen][0])
            slope[shown] += votes * (p - (shown == chosen))
            curvature[np.ix_(shown, shown)] += votes * (np.diag(p) - np.outer(p, p))
        return loss, slope, curvature

    found = optimize.minimize(
        lambda s: weigh(s)[:2], np.zeros(count), jac=True, hess=lambda s: weigh(s)[2], method="trust-exact"
    )
    return found.x, np.linalg.pinv(weigh(found.x)[2] - 1)  # less the 1 that holds the mean at 0


def compute_fleiss_kappa(counts: np.ndarray) -> float | None:
    """Fleiss' kappa (1971) of (units, categories) counts.

    None where raters per unit differ or are fewer than two, or only one category was used.
    """
    raters = counts.sum(1)
    if len(counts) == 0 or raters.min() != raters.max() or raters[0] < 2:
        return None
    n = raters[0]
    expected = np.square(counts.sum(0) / counts.sum()).sum()
    observed = ((np.square(counts).sum(1) - n) / (n * (n - 1))).mean()
    return float((observed - expected) / (1 - expected)) if expected < 1 else None


def compute_alpha(counts: np.ndarray) -> float | None:
    """Krippendorff's alpha of names, of (units, categories) counts; raters per unit may differ.

    None where no unit has two raters, or only one category was used.
    """
    paired = counts[counts.sum(1) >= 2].astype(float)
    total = paired.sum()
    if total == 0:
        return None
    observed = 1 - (paired * (paired - 1) / (paired.sum(1, keepdims=True) - 1)).sum() / total
    used = paired.sum(0)
    expected = 1 - (used * (used - 1)).sum() / (total * (total - 1))
    return float(1 - observed / expected) if expected > 0 else None


def compute_agreement(counts: np.ndarray) -> float | None:
    """Share of pairs of raters of one unit that chose the same, of (units, categories) counts; None without pairs."""
    pairs = (counts.sum(1) * (counts.sum(1) - 1)).sum()
    return float((counts * (counts - 1)).sum() / pairs) if pairs else None
