"""One fit as a row: a method on a task, and the judge's verdict on where it stood at each mark of the budget."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from baselines.protocol import Budget, FitResult, Method, MethodFailedError
from baselines.tasks import Task
from physagent_jax.core.errors import MissingPackageError, UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.effort import measure_effort

Row = dict[str, Any]


def measure_fit(
    method: Method,
    task: Task,
    marks: Sequence[float],
    seed: int,
    budget: float,
    names: Mapping[str, Any],
) -> Row:
    """Fit within ``budget`` forward-equivalents and judge the incumbents at ``marks`` by true particles.

    Args:
        method: What is to find a force field.
        task: What it is to solve.
        marks: Budgets at which it is judged [forward-equivalents]; the last is ``budget``.
        seed: Seed of all that is random.
        budget: What may be spent.
        names: Fields that say whose row it is: ``label``, ``method``, ``options``.

    Returns:
        JSON fields. A task that the method refuses has ``refused`` and no marks.

    Raises:
        MissingPackageError: The method needs a package that is not installed, which says nothing of it.
        MethodFailedError: It has an error of its own.
    """
    row: Row = {
        **names,
        "task": task.spec.name,
        "family": task.spec.family,
        "split": task.spec.split,
        "smooth": task.spec.smooth,
        "seed": seed,
        "oracle": method.oracle,
        "task_hash": task.spec.task_hash,
    }
    try:
        result = method.fit(task, Budget(budget), seed)
    except (MissingPackageError, MethodFailedError):
        raise
    except UserError as error:  # a sentence that the agents refuse, a task without an expert: not solved
        return row | {"refused": " ".join(str(error).split())[:300], "marks": [], "spent": 0.0}
    return row | {
        "spent": result.spent,
        "seconds": result.seconds,
        "evaluations": len(result.evaluations),
        "model_calls": result.model_calls,
        "tokens": result.tokens,
        "trace": [[e.spent, round(e.seconds, 3), e.objective] for e in result.evaluations],
        "marks": judge_marks(result, task, marks),
    }


def judge_marks(result: FitResult, task: Task, marks: Sequence[float]) -> list[dict[str, Any]]:
    """State of the method at each mark, by its own choice, with the verdict of the judge."""
    known: dict[str, dict[str, Any]] = {}
    rows = []
    for mark in marks:
        field = result.incumbent_at(mark)
        key = field.model_dump_json()
        if key not in known:
            known[key] = judge_field(field, task)
        rows.append({"mark": mark, **known[key]})
    return rows


def judge_field(field: ForceField, task: Task) -> dict[str, Any]:
    """Simulate as the product does, and judge the true particles; what cannot be simulated is a miss."""
    said: dict[str, Any] = {"force_field": field.model_dump(mode="json", exclude_none=True)}
    try:
        x = task.simulate(field)
    except UserError as error:
        return said | {"success": False, "error": float("inf"), "refused": str(error)[:200], "effort": None}
    found = task.judge(x)
    margins = {clause.name: float(clause.margin) for clause in found.clauses}
    effort = measure_effort(task.build(field).model, x, task.frame_dt) if np.isfinite(x).all() else None
    return said | {"success": found.success, "error": found.error, "margins": margins, "effort": effort}
