"""Intervals, figures over runs and tasks, and power: against closed forms, scipy, and published definitions."""

import itertools

import numpy as np
import pytest
from scipy import stats

from physagent_jax.metrics import statistics

RUNS_X = np.array([[1.0, 2.0], [2.0, 2.0], [1.0, 1.0], [2.0, 1.0]])
RUNS_Y = np.array([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]])
"""Example data of rliable's own tests: 4 and 3 runs on two tasks, with the improvement of 1/3 and the means below."""


@pytest.mark.parametrize(("successes", "count"), [(35, 35), (32, 35), (2, 35), (2, 6), (0, 3), (40, 100)])
def test_a_share_has_wilsons_interval(successes, count):
    made = statistics.estimate_share([1.0] * successes + [0.0] * (count - successes))
    known = stats.binomtest(successes, count).proportion_ci(0.95, method="wilson")
    assert made.value == successes / count
    assert (made.low, made.high) == pytest.approx((known.low, known.high), abs=1e-12)


def test_intervals_of_shares_cover_as_often_as_they_say():
    """35 tasks: 95 % on average over shares, and never far below; no interval is a point."""
    count = 35
    ends = [statistics.estimate_share([1.0] * k + [0.0] * (count - k)) for k in range(count + 1)]
    assert all(each.high - each.low > 0.05 for each in ends)
    shares = np.linspace(0.03, 0.97, 95)
    held = [
        sum(stats.binom.pmf(k, count, share) for k, each in enumerate(ends) if each.low <= share <= each.high)
        for share in shares
    ]
    assert np.mean(held) == pytest.approx(0.95, abs=0.01) and min(held) > 0.9


def test_figures_are_those_of_the_library():
    """Of its examples; the probability of improvement is Mann and Whitney's U, as it takes it from scipy."""
    assert (
        statistics.find_interquartile_mean(RUNS_X) == 1.5
        and statistics.find_interquartile_mean(RUNS_Y) == 2.0
    )
    assert statistics.find_improvement(RUNS_X, RUNS_Y) == pytest.approx(1 / 3)
    by_task = [stats.mannwhitneyu(x, y, alternative="greater")[0] / 12 for x, y in zip(RUNS_X.T, RUNS_Y.T)]
    assert statistics.find_improvement(RUNS_X, RUNS_Y) == pytest.approx(np.mean(by_task))
    assert statistics.find_improvement(RUNS_X, RUNS_X) == 0.5
    assert statistics.find_profile(RUNS_X, [0.5, 1.0, 1.5, 2.0]) == [1.0, 0.5, 0.5, 0.0]
    many = np.arange(80.0).reshape(5, 16)
    assert statistics.find_interquartile_mean(many) == np.mean(np.arange(20, 60))


@pytest.mark.parametrize("tasks", [False, True])
def test_draws_are_those_of_the_stratified_bootstrap(tasks):
    """Two runs on two tasks: as often as in a list of all samples, runs drawn within tasks, and tasks where asked."""
    scores = np.array([[0.0, 10.0], [1.0, 14.0]])
    columns = list(itertools.product(range(2), repeat=2)) if tasks else [(0, 1)]
    every = [
        np.mean([scores[run, columns_of[place % 2]] for place, run in enumerate(runs)])
        for columns_of in columns
        for runs in itertools.product(range(2), repeat=4)
    ]
    drawn = []

    def find_mean(each):
        drawn.append(each.mean((-2, -1)))
        return drawn[-1]

    made = statistics.draw_again(find_mean, scores, tasks=tasks)
    samples = drawn[0]
    assert samples.shape == (statistics.DRAWS,) and made.value == np.mean(scores)
    for value in set(every):
        assert np.mean(samples == value) == pytest.approx(np.mean(np.array(every) == value), abs=0.04)
    assert set(samples) <= set(every)


def test_methods_are_drawn_on_the_same_tasks():
    """Two methods that differ by 1 everywhere: the improvement is certain whatever tasks are drawn."""
    scores = np.random.default_rng(0).normal(scale=100.0, size=(1, 30))
    made = statistics.draw_again(statistics.find_improvement, scores + 1.0, scores)
    assert (made.value, made.low, made.high) == (1.0, 1.0, 1.0)


def test_holm():
    """Textbook: 0.01, 0.04, 0.03, 0.005 become 0.03, 0.06, 0.06, 0.02."""
    np.testing.assert_allclose(statistics.correct([0.01, 0.04, 0.03, 0.005]), [0.03, 0.06, 0.06, 0.02])


def test_power_is_that_of_simulated_tables():
    """Exact McNemar on 35 tasks, of which the better method alone solves 30 % and the other 5 %."""
    rng = np.random.default_rng(0)
    tables = rng.multinomial(35, [0.30, 0.05, 0.65], size=2000)[:, :2]
    known = {(a, b): statistics.compute_mcnemar(int(a), int(b)) for a, b in np.unique(tables, axis=0)}
    found = np.mean([known[int(a), int(b)] <= 0.05 and a > b for a, b in tables])
    assert statistics.find_power(35, 0.30, 0.05) == pytest.approx(found, abs=0.03)


def test_the_smallest_difference_is_found_with_the_power_that_is_asked_for():
    """35 tasks: 30 points; six: none, for five solved alone against none have p = 0.06."""
    least = statistics.find_smallest_difference(35)
    assert least == pytest.approx(0.30, abs=0.005)
    assert statistics.find_power(35, least + statistics.CONTRARY, statistics.CONTRARY) == pytest.approx(
        0.8, abs=0.01
    )
    assert (
        statistics.find_smallest_difference(6) is None and statistics.find_smallest_difference(5, 0.0) is None
    )
    assert statistics.find_smallest_difference(500) < 0.07
