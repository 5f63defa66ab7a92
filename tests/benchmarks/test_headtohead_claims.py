"""Figures of fits, and sentences about two methods."""

import pytest

from baselines import fits
from benchmarks.headtohead import claims


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


def refuse(task, family="drop", seed=0):
    return {"task": task, "family": family, "seed": seed, "marks": []}


def test_a_refusal_is_neither_a_miss_nor_a_success():
    """One of two tasks is refused, the other solved: 1 of 1, and the refusal is named."""
    rows = [*make_rows([(True, 0.5)]), refuse("drop-1")]
    assert fits.list_successes(rows, 10.0) == [1.0] and fits.find_refused(rows) == {"drop-1"}
    assert fits.find_last_mark(rows) == 10.0 and fits.find_last_mark([refuse("a")]) == 0.0
    (far,) = make_rows([(False, float("inf"))])
    assert fits.read_mark(far, 10.0) == (0.0, fits.CAP)
    with pytest.raises(ValueError, match="not judged"):
        fits.read_mark(far, 30.0)


def test_pairs_are_of_the_tasks_that_both_have_done():
    """Eight tasks that one alone solves; the other refuses them all but two."""
    one = make_rows([(True, 0.5)] * 8)
    other = [*make_rows([(False, 2.0)] * 2), *(refuse(f"drop-{i}") for i in range(2, 8))]
    pair = fits.compare(one, other)
    assert (pair.tasks, pair.first, pair.second) == (2, 2, 0) and pair.successes == pytest.approx(0.5)
    assert fits.compare(one, [refuse(f"drop-{i}") for i in range(8)]) is None


def test_a_method_with_a_small_budget_leaves_the_last_mark_of_others_alone():
    """Two methods are compared at the last mark that both have."""
    long, short = make_rows([(True, 0.5)] * 3, mark=30.0), make_rows([(False, 2.0)] * 3)
    for row in long:
        row["marks"].insert(0, {"mark": 10.0, "success": False, "error": 3.0})
    assert fits.find_last_mark(long) == 30.0 and fits.find_last_mark(short) == 10.0
    assert fits.compare(long, short).mark == 10.0 and fits.compare(long, short).first == 0
    short[0]["marks"] += [{"mark": 20.0, "success": True, "error": 0.5}]
    assert fits.find_last_mark(short) == 10.0 and fits.average_tasks(long, 20.0) == {}


def test_only_fits_that_had_the_budget_count_at_its_mark():
    """Seed 0 was given 30, seed 1 only 10: at 30 the second says nothing; a refusal says the same at both."""
    short, long = make_rows([(False, 2.0)]), make_rows([(True, 0.5)])
    long[0]["marks"].append({"mark": 30.0, "success": True, "error": 0.2})
    long[0]["seed"] = 1
    rows = short + long
    assert fits.average_tasks(rows, 10.0)["drop-0"][1:] == (0.5, 1.25)
    assert fits.average_tasks(rows, 30.0)["drop-0"][1:] == (1.0, 0.2)
    refused = refuse("drop-1")
    assert fits.is_measured([*rows, refused], 30.0) and not fits.is_measured(short, 30.0)
    assert not fits.is_measured([*rows, refused], 100.0)
    assert fits.find_solved([*rows, refused], 10.0) == {"drop-0"}
    assert fits.find_solved([*rows, refused], 100.0) == set()


def test_a_mark_is_read_off_the_fit_with_the_least_budget_that_reaches_it():
    """One seed, three budgets: what was planned for 100 says nothing at 10, and what was planned for 10 none at 30."""
    rows = make_rows([(False, 2.0)]) + make_rows([(True, 0.5)])
    rows[1]["marks"] += [{"mark": mark, "success": True, "error": mark / 100} for mark in (30.0, 100.0)]
    for order in (rows, rows[::-1]):
        errors = [fits.average_tasks(order, mark)["drop-0"][2] for mark in (10.0, 30.0, 100.0)]
        assert errors == [2.0, 0.3, 1.0]


def test_cost_at_a_mark_is_that_of_what_was_tried_by_then():
    row = {"spent": 31.0, "seconds": 9.0, "evaluations": 3, "marks": [{"mark": 10.0}, {"mark": 30.0}]}
    row["trace"] = [[4.0, 1.5, 1.0], [9.0, 3.0, 0.5], [31.0, 9.0, 0.4]]
    assert fits.read_cost(row, 10.0) == {"spent": 9.0, "seconds": 3.0, "evaluations": 2}
    assert fits.read_cost(row, 30.0) == {"spent": 31.0, "seconds": 9.0, "evaluations": 3}
    assert fits.read_cost(row, 2.0) == {"spent": 0.0, "seconds": 0.0, "evaluations": 0}


def test_success_against_seconds_is_that_of_the_last_mark_by_then():
    """Solved by the mark of 10 after 3 s, lost again by the end after 9 s; the other seed never solves it."""
    row = {"task": "a", "family": "drop", "seed": 0, "spent": 31.0, "seconds": 9.0, "evaluations": 3}
    row["marks"] = [{"mark": m, "success": m == 10.0, "error": 1.0} for m in (1.0, 10.0, 30.0)]
    row["trace"] = [[4.0, 1.5, 1.0], [9.0, 3.0, 0.5], [31.0, 9.0, 0.4]]
    assert fits.count_within([row], [2.0, 3.0, 8.9, 9.0]) == [0.0, 1.0, 1.0, 0.0]
    never = row | {"seed": 1, "marks": [each | {"success": False} for each in row["marks"]]}
    assert fits.count_within([row, never], [5.0]) == [0.5]


def test_runs_and_tasks_are_arranged_of_seeds_that_did_all():
    rows = make_rows([(True, 0.5), (False, 3.0)], seeds=2)
    rows += [make_rows([(True, 0.1)])[0] | {"seed": 2}]
    tasks, solved, errors = fits.arrange(rows, 10.0)
    assert tasks == ["drop-0", "drop-1"] and solved.tolist() == [[1, 0], [1, 0]]
    assert errors.tolist() == [[0.5, 3.0], [0.5, 3.0]]


def test_mcnemar_is_exact():
    """8 tasks that only one solves, none that only the other does: 2 / 2^8."""
    one = make_rows([(True, 0.5)] * 8 + [(True, 0.5)] * 3)
    other = make_rows([(False, 2.0)] * 8 + [(True, 0.5)] * 3)
    pair = fits.compare(one, other)
    assert (pair.first, pair.second, pair.both) == (8, 0, 3) and pair.successes == pytest.approx(2 / 2**8)
    same = fits.compare(one, one)
    assert (same.first, same.second, same.successes, same.errors) == (0, 0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("alone", "told"),
    [
        ((12, 0), "`rules` solves more tasks than `random` (17 and 5 of 35; alone 12 and 0;"),
        ((0, 12), "`random` solves more tasks than `rules` (5 and 17 of 35; alone 0 and 12;"),
        ((4, 2), "no difference between `rules` and `random` is shown (9 and 7 of 35; alone 4 and 2;"),
        (
            (0, 0),
            "no difference between `rules` and `random` is shown (5 and 5 of 35; alone 0 and 0; p = 1; 30 points",
        ),
    ],
)
def test_a_sentence_says_what_the_test_of_its_rows_supports(alone, told):
    """And the contrary of the contrary rows; where nothing is shown, from which difference on it would have been."""
    first, second = alone
    shares = [(True, False)] * first + [(False, True)] * second + [(True, True)] * 5
    shares += [(False, False)] * (35 - len(shares))
    groups = {
        name: make_rows([(each[place], 1.0) for each in shares])
        for place, name in enumerate(("rules", "random"))
    }
    text = claims.answer((claims.Question("rules", "random"),), groups)
    assert text.startswith(f"- 10 simulations: {told}") and text.count("\n") == 1
    assert ("; 30 points would be)" in text) == ("no difference" in text)


def test_sentences_need_their_rows_and_share_a_correction():
    """p = 2 / 2^6 = 0.031 of one question is shown; of two, 0.0625, it is not. Six tasks could not show any."""
    groups = {"a": make_rows([(True, 1.0)] * 6), "b": make_rows([(False, 1.0)] * 6)}
    one, two = claims.Question("a", "b"), claims.Question("b", "a")
    assert "`a` solves more tasks" in claims.answer((one,), groups)
    assert claims.answer((one, two), groups).count("is shown") == 2
    assert "no difference could be" in claims.answer((one, two), groups)
    assert claims.answer((claims.Question("a", "c"), claims.Question("a", "b", 300.0)), groups) == ""
