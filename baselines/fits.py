"""Rows of fits as figures per task: success, error and cost at a mark of the budget.

A task that a method refuses is not applicable to it: it is counted apart, and is neither a miss nor a success. Two
methods are compared on the tasks that both have done. Fits that were not given a budget do not count at its mark.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from physagent_jax.metrics.statistics import compute_mcnemar, compute_wilcoxon

CAP = 10.0  # [tolerances] at which errors are cut: how far a miss is beyond that says nothing
Row = Mapping[str, Any]
Rows = Sequence[Row]


def read_mark(row: Row, mark: float) -> tuple[float, float]:
    """Success (0 or 1) and error of a fit at a mark.

    Raises:
        ValueError: It was not judged there.
    """
    for each in row["marks"]:
        if each["mark"] == mark:
            return float(each["success"]), min(float(each["error"]), CAP)
    raise ValueError(f"the fit {row['task']} was not judged at the mark of {mark:g}")


def is_refused(row: Row) -> bool:
    """Return whether the method refused the task."""
    return not row["marks"]


def find_refused(rows: Rows) -> set[str]:
    """The tasks that one method refuses."""
    return {row["task"] for row in rows if is_refused(row)}


def find_done(rows: Rows) -> set[str]:
    """The tasks that one method does."""
    return {row["task"] for row in rows if not is_refused(row)}


def read_budget(row: Row) -> float:
    """Budget of a fit: the last mark of its row."""
    return float(row["marks"][-1]["mark"])


def list_budgets(rows: Rows) -> list[float]:
    """The budgets that were given, from least to greatest."""
    return sorted({read_budget(row) for row in rows if not is_refused(row)})


def list_marks(rows: Rows) -> list[float]:
    """The marks at which fits were judged, from least to greatest."""
    return sorted({mark["mark"] for row in rows for mark in row["marks"]})


def find_last_mark(*methods: Rows) -> float:
    """The largest mark at which each method was judged on every task that it did; 0 where there is none."""
    marks = list_marks(methods[0])
    return max((mark for mark in marks if all(is_measured(rows, mark) for rows in methods)), default=0.0)


def choose_fits(rows: Rows, mark: float) -> list[Row]:
    """Of one method, the fits that say where it stands at a mark: of each task and seed that with the least budget.

    What shares its budget out does other things with a larger one, so that its early marks say less.
    """
    fits: dict[tuple, Row] = {}
    given = [row for row in rows if any(each["mark"] == mark for each in row["marks"])]
    for row in sorted(given, key=read_budget):
        fits.setdefault((row["task"], row["seed"]), row)
    return list(fits.values())


def average_tasks(rows: Rows, mark: float) -> dict[str, tuple[str, float, float]]:
    """Per task its family, and success and error averaged over the seeds that had the budget."""
    tasks: dict[str, list] = {}
    for row in choose_fits(rows, mark):
        tasks.setdefault(row["task"], []).append((row["family"], *read_mark(row, mark)))
    return {
        name: (each[0][0], float(np.mean([s for _, s, _ in each])), float(np.mean([e for _, _, e in each])))
        for name, each in tasks.items()
    }


def list_successes(rows: Rows, mark: float) -> list[float]:
    """Success of every task that the method did, from 0 to 1."""
    return [success for _, success, _ in average_tasks(rows, mark).values()]


def is_measured(rows: Rows, mark: float) -> bool:
    """Return whether every task that the method did has a fit that had the budget."""
    done = find_done(rows)
    return bool(done) and average_tasks(rows, mark).keys() == done


def find_solved(rows: Rows, mark: float) -> set[str]:
    """The tasks of which at least half of the seeds succeed."""
    return {name for name, (_, success, _) in average_tasks(rows, mark).items() if success >= 0.5}


def arrange(rows: Rows, mark: float) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Tasks, and success and error of shape (runs, tasks), of the seeds that did every task that any seed did."""
    fits = {(row["seed"], row["task"]): read_mark(row, mark) for row in choose_fits(rows, mark)}
    tasks = sorted({task for _, task in fits})
    seeds = [
        seed for seed in sorted({seed for seed, _ in fits}) if all((seed, task) in fits for task in tasks)
    ]
    table = np.array([[fits[seed, task] for task in tasks] for seed in seeds])
    return tasks, table[..., 0], table[..., 1]


def read_cost(row: Row, mark: float) -> dict[str, float]:
    """Costs of a fit by a mark: forward-equivalents, seconds and evaluations."""
    if read_budget(row) <= mark or row["spent"] <= mark:
        return {"spent": row["spent"], "seconds": row["seconds"], "evaluations": row["evaluations"]}
    made = [(0.0, 0.0), *((spent, seconds) for spent, seconds, _ in row["trace"] if spent <= mark)]
    return {"spent": made[-1][0], "seconds": made[-1][1], "evaluations": len(made) - 1}


def count_within(rows: Rows, seconds: Sequence[float]) -> list[float]:
    """Number of tasks that a method holds a solution of after so many seconds each, of its fits with the most budget.

    A fit stands where its last mark by then stood; seeds are averaged.
    """
    fits = choose_fits(rows, find_last_mark(rows))
    seeds = Counter(row["task"] for row in fits)
    counts = [0.0] * len(seconds)
    for row in fits:
        reached = [(read_cost(row, each["mark"])["seconds"], each["success"]) for each in row["marks"]]
        for place, limit in enumerate(seconds):
            held = [success for taken, success in reached if taken <= limit]
            counts[place] += float(bool(held) and held[-1]) / seeds[row["task"]]
    return counts


@dataclasses.dataclass(frozen=True)
class Pair:
    """Two methods on the tasks that both have done.

    Attributes:
        tasks: Number of these tasks.
        mark: Budget of both [forward-equivalents].
        first, second: Tasks that one alone solves, and that the other alone does.
        both: Tasks that both solve.
        successes: The p value of exact McNemar.
        errors: The p value of Wilcoxon's signed ranks of the errors.
    """

    tasks: int
    mark: float
    first: int
    second: int
    both: int
    successes: float
    errors: float


def compare(one: Rows, other: Rows, mark: float | None = None) -> Pair | None:
    """Two methods at a mark, else at the last that both have; None where they have no task in common there."""
    mark = find_last_mark(one, other) if mark is None else mark
    a, b = average_tasks(one, mark), average_tasks(other, mark)
    shared = sorted(a.keys() & b.keys())
    if not shared:
        return None
    ours, theirs = find_solved(one, mark) & set(shared), find_solved(other, mark) & set(shared)
    first, second, both = len(ours - theirs), len(theirs - ours), len(ours & theirs)
    gaps = np.array([a[name][2] - b[name][2] for name in shared])
    exact = compute_mcnemar(first, second)
    return Pair(len(shared), mark, first, second, both, exact, compute_wilcoxon(gaps))


def group(rows: Rows) -> dict[str, list[Row]]:
    """Rows by their label, in the order in which they first appear."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row["label"], []).append(row)
    return groups
