"""Success and error of a method over tasks, with intervals: the task is the sampling unit.

Seeds of a task are averaged first; fits that were not given a budget do not count at its mark. Intervals are of the
stratified bootstrap (Agarwal et al. 2021, "Deep Reinforcement Learning at the Edge of the Statistical Precipice"):
tasks are drawn with replacement within their family, those that are alone in theirs among each other. Two methods are
compared on the tasks that both have done, by exact McNemar for success and by Wilcoxon's signed ranks for the error,
with Holm's correction over all comparisons of a table.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy import stats

DRAWS = 2000
CAP = 10.0  # [tolerances] at which errors are cut: how far a miss is beyond that says nothing
Rows = Sequence[Mapping[str, Any]]


def read_mark(row: Mapping[str, Any], mark: float) -> tuple[float, float]:
    """Success (0 or 1) and error of a row at a mark; a refusal is a miss."""
    for each in row["marks"]:
        if each["mark"] == mark:
            return float(each["success"]), min(float(each["error"]), CAP)
    return 0.0, CAP


def read_budget(row: Mapping[str, Any]) -> float:
    """Budget of a fit: the last mark of its row; a refusal holds at all marks."""
    return float(row["marks"][-1]["mark"]) if row["marks"] else math.inf


def choose_fits(rows: Rows, mark: float) -> list[Mapping[str, Any]]:
    """Of one method, the fits that say where it stands at a mark: of each task and seed that with the least budget.

    What shares its budget out does other things with a larger one, so that its early marks say less.
    """
    fits: dict[tuple, Mapping[str, Any]] = {}
    for row in sorted((row for row in rows if read_budget(row) >= mark), key=read_budget):
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


def is_measured(rows: Rows, mark: float) -> bool:
    """Return whether every task of these rows has a fit that had the budget."""
    return average_tasks(rows, mark).keys() == {row["task"] for row in rows}


def find_solved(rows: Rows, mark: float) -> set[str]:
    """The tasks of which at least half of the seeds succeed."""
    return {name for name, (_, success, _) in average_tasks(rows, mark).items() if success >= 0.5}


def count_by_seed(rows: Rows, mark: float) -> dict[int, int]:
    """Of one method, how many tasks each seed solves; of the seeds that had the budget on every task."""
    fits, tasks = choose_fits(rows, mark), {row["task"] for row in rows}
    seeds: dict[int, dict[str, float]] = {}
    for row in fits:
        seeds.setdefault(row["seed"], {})[row["task"]] = read_mark(row, mark)[0]
    return {seed: int(sum(found.values())) for seed, found in sorted(seeds.items()) if found.keys() == tasks}


def read_cost(row: Mapping[str, Any], mark: float) -> dict[str, float]:
    """Costs of a fit by a mark: forward-equivalents, seconds and evaluations."""
    if read_budget(row) <= mark or row["spent"] <= mark:
        return {"spent": row["spent"], "seconds": row["seconds"], "evaluations": row["evaluations"]}
    made = [(0.0, 0.0), *((spent, seconds) for spent, seconds, _ in row["trace"] if spent <= mark)]
    return {"spent": made[-1][0], "seconds": made[-1][1], "evaluations": len(made) - 1}


def estimate(
    rows: Rows,
    mark: float,
    pick: int,
    reduce: Callable[[np.ndarray], float] = lambda values: float(np.mean(values)),
) -> tuple[float, float, float]:
    """A figure over the tasks and its 95 % interval.

    Args:
        rows: Rows of one method.
        mark: Mark of the budget.
        pick: 1 = success, 2 = error.
        reduce: Figure that is made of the values per task.

    Raises:
        ValueError: No row had the budget.
    """
    tasks = list(average_tasks(rows, mark).values())
    if not tasks:
        raise ValueError(f"there are no rows at the mark of {mark:g} to estimate from")
    strata: dict[str, list[float]] = {}
    for task in tasks:
        strata.setdefault(task[0], []).append(task[pick])
    alone = [values[0] for values in strata.values() if len(values) == 1]  # one has no spread to draw from
    larger = [values for values in strata.values() if len(values) > 1]
    groups = [np.asarray(values) for values in (*larger, alone) if values]
    rng = np.random.default_rng(0)
    drawn = [
        reduce(np.concatenate([rng.choice(values, len(values)) for values in groups])) for _ in range(DRAWS)
    ]
    low, high = np.percentile(drawn, [2.5, 97.5])
    return reduce(np.concatenate(groups)), float(low), float(high)


def compare(one: Rows, other: Rows, mark: float) -> tuple[int, int, float, float]:
    """Tasks that only ``one`` and only ``other`` solves, and the p values of McNemar and of Wilcoxon."""
    a, b = average_tasks(one, mark), average_tasks(other, mark)
    shared = sorted(a.keys() & b.keys())
    ours, theirs = find_solved(one, mark) & set(shared), find_solved(other, mark) & set(shared)
    first, second = len(ours - theirs), len(theirs - ours)
    exact = stats.binomtest(first, first + second).pvalue if first + second else 1.0
    gap = np.array([a[name][2] - b[name][2] for name in shared])
    ranks = stats.wilcoxon(gap).pvalue if np.any(gap) else 1.0
    return first, second, float(exact), float(ranks)


def correct(p_values: Sequence[float]) -> list[float]:
    """Holm's step-down correction."""
    order, adjusted, largest = np.argsort(p_values), np.empty(len(p_values)), 0.0
    for place, index in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - place) * p_values[index]))
        adjusted[index] = largest
    return adjusted.tolist()
