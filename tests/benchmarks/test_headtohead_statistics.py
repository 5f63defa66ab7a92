"""Figures over tasks: against what is known in closed form."""

import math

import numpy as np
import pytest

from benchmarks.headtohead import statistics


def make_rows(values, family="drop", seeds=1, mark=10.0):
    """Rows of tasks whose success and error are ``values``."""
    return [
        {
            "task": f"{family}-{index}",
            "family": family,
            "seed": seed,
            "marks": [{"mark": mark, "success": bool(success), "error": error}],
        }
        for index, (success, error) in enumerate(values)
        for seed in range(seeds)
    ]


def test_interval_of_a_share_is_the_binomials():
    """40 of 100 tasks: 0.4 with 1.96 sqrt(p q / n) to either side, however many seeds each has."""
    for seeds in (1, 5):
        rows = make_rows([(index < 40, 1.0) for index in range(100)], seeds=seeds)
        value, low, high = statistics.estimate(rows, 10.0, 1)
        half = 1.96 * math.sqrt(0.4 * 0.6 / 100)
        assert value == pytest.approx(0.4)
        assert (low, high) == pytest.approx((0.4 - half, 0.4 + half), abs=0.02)


def test_strata_keep_what_differs_between_families():
    """One family always solved, the other never: drawn within families, the share does not vary at all."""
    rows = make_rows([(True, 0.0)] * 10, "drop") + make_rows([(False, 5.0)] * 10, "sway")
    assert statistics.estimate(rows, 10.0, 1) == (0.5, 0.5, 0.5)


def test_tasks_alone_in_their_families_are_drawn_among_each_other():
    """As if they were of one family: else the interval would be a point."""
    solved = [True, False, True, False, False, False, False, False]
    apart = [make_rows([(each, 1.0)], f"family{i}")[0] for i, each in enumerate(solved)]
    together = make_rows([(each, 1.0) for each in solved])
    assert statistics.estimate(apart, 10.0, 1) == statistics.estimate(together, 10.0, 1)
    value, low, high = statistics.estimate(apart, 10.0, 1)
    assert (value, low) == (0.25, 0.0) and high >= 0.5


def test_a_refusal_is_a_miss():
    row = {"task": "a", "family": "drop", "seed": 0, "marks": []}
    assert statistics.read_mark(row, 10.0) == (0.0, statistics.CAP)
    (far,) = make_rows([(False, float("inf"))])
    assert statistics.read_mark(far, 10.0) == (0.0, statistics.CAP)


def test_only_fits_that_had_the_budget_count_at_its_mark():
    """Seed 0 was given 30, seed 1 only 10: at 30 the second says nothing; a refusal says the same at both."""
    short, long = make_rows([(False, 2.0)]), make_rows([(True, 0.5)])
    long[0]["marks"].append({"mark": 30.0, "success": True, "error": 0.2})
    long[0]["seed"] = 1
    rows = short + long
    assert statistics.average_tasks(rows, 10.0)["drop-0"][1:] == (0.5, 1.25)
    assert statistics.average_tasks(rows, 30.0)["drop-0"][1:] == (1.0, 0.2)
    refused = {"task": "drop-1", "family": "drop", "seed": 0, "marks": []}
    assert statistics.is_measured([*rows, refused], 30.0) and not statistics.is_measured(short, 30.0)
    assert not statistics.is_measured([*rows, refused], 100.0)
    assert statistics.find_solved([*rows, refused], 10.0) == {"drop-0"}
    assert statistics.find_solved([*rows, refused], 100.0) == set()


def test_a_mark_is_read_off_the_fit_with_the_least_budget_that_reaches_it():
    """One seed, three budgets: what was planned for 100 says nothing at 10, and what was planned for 10 none at 30."""
    rows = make_rows([(False, 2.0)]) + make_rows([(True, 0.5)])
    rows[1]["marks"] += [{"mark": mark, "success": True, "error": mark / 100} for mark in (30.0, 100.0)]
    for order in (rows, rows[::-1]):
        errors = [statistics.average_tasks(order, mark)["drop-0"][2] for mark in (10.0, 30.0, 100.0)]
        assert errors == [2.0, 0.3, 1.0]


def test_seeds_are_counted_that_did_every_task():
    rows = make_rows([(True, 0.5), (False, 3.0), (True, 0.2)], seeds=3)
    rows[1]["marks"][0]["success"] = False  # the first task with seed 1
    del rows[-1]  # the last task with seed 2
    rows += make_rows([(True, 0.5)] * 3, mark=100.0)  # a larger budget says nothing of a smaller one
    assert statistics.count_by_seed(rows, 10.0) == {0: 2, 1: 1}
    assert statistics.count_by_seed(rows, 100.0) == {0: 3}


def test_cost_at_a_mark_is_that_of_what_was_tried_by_then():
    row = {"spent": 31.0, "seconds": 9.0, "evaluations": 3, "marks": [{"mark": 10.0}, {"mark": 30.0}]}
    row["trace"] = [[4.0, 1.5, 1.0], [9.0, 3.0, 0.5], [31.0, 9.0, 0.4]]
    assert statistics.read_cost(row, 10.0) == {"spent": 9.0, "seconds": 3.0, "evaluations": 2}
    assert statistics.read_cost(row, 30.0) == {"spent": 31.0, "seconds": 9.0, "evaluations": 3}
    assert statistics.read_cost(row, 2.0) == {"spent": 0.0, "seconds": 0.0, "evaluations": 0}


def test_mcnemar_is_exact():
    """8 tasks that only one solves, none that only the other does: 2 / 2^8."""
    one = make_rows([(True, 0.5)] * 8 + [(True, 0.5)] * 3)
    other = make_rows([(False, 2.0)] * 8 + [(True, 0.5)] * 3)
    first, second, exact, _ = statistics.compare(one, other, 10.0)
    assert (first, second) == (8, 0) and exact == pytest.approx(2 / 2**8)
    assert statistics.compare(one, one, 10.0) == (0, 0, 1.0, 1.0)


def test_holm():
    """Textbook: 0.01, 0.04, 0.03, 0.005 become 0.03, 0.06, 0.06, 0.02."""
    np.testing.assert_allclose(statistics.correct([0.01, 0.04, 0.03, 0.005]), [0.03, 0.06, 0.06, 0.02])
