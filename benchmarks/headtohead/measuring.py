"""One method on one task: the fit, and what the judge says of where it stood at each mark of the budget."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from baselines.protocol import Budget, FitResult
from baselines.simulation import Simulation
from baselines.tasks import Task
from benchmarks import harness
from benchmarks.harness import Row
from benchmarks.headtohead.entrants import Entrant
from benchmarks.peers.gradient import read_memory, reset_peak
from physagent_jax.core.errors import MissingPackageError, UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.effort import measure_effort

_FOLDERS = ("weights", "clip")  # options that say where a model lies on this machine: rows do not


def measure(entrant: Entrant, task: Task, marks: Sequence[float], seed: int, budget: float) -> list[Row]:
    """Fits with ``budget`` forward-equivalents and judges the incumbents at ``marks`` by true particles."""
    method, memory = entrant.make(), reset_peak()
    begun = time.perf_counter()
    row: Row = {
        "label": entrant.label,
        "method": entrant.method,
        "options": {name: value for name, value in entrant.options.items() if name not in _FOLDERS},
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
    except MissingPackageError:  # says nothing of the method
        raise
    except UserError as error:  # a sentence that the agents refuse, a task without an expert: not solved
        return [row | {"refused": " ".join(str(error).split())[:300], "marks": [], "spent": 0.0}]
    peak = read_memory("VmHWM")
    row |= {
        "spent": result.spent,
        "seconds": result.seconds,
        "memory_gb": None if peak is None or memory is None else (peak - memory) / 1e9,
        "evaluations": len(result.evaluations),
        "model_calls": result.model_calls,
        "tokens": result.tokens,
        "trace": [[e.spent, round(e.seconds, 3), e.objective] for e in result.evaluations],
        "marks": judge_marks(result, task, marks),
    }
    last = row["marks"][-1]
    harness.say(
        f"{task.spec.name:32s} {entrant.label:36s} seed {seed} error {last['error']:8.3g} "
        f"{'success' if last['success'] else ''} {time.perf_counter() - begun:.1f} s"
    )
    return [row]


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


def measure_gradient(task: Task, witness: ForceField, repeats: int) -> list[Row]:
    """Seconds of a simulation with its residuals, and of a value with its gradient along it, warm and in turn."""
    simulation = Simulation(task)
    parameters = ForceFieldParameters.of(witness, task.frame_count)

    def measure_pair() -> tuple[float, float]:
        begun = time.perf_counter()
        rollout = simulation.simulate(witness)
        simulation.compute_residuals(rollout)
        simulated = time.perf_counter()
        simulation.differentiate(rollout, parameters)
        return simulated - begun, time.perf_counter() - simulated

    measure_pair()  # compiles
    pairs = [measure_pair() for _ in range(repeats)]
    ratios = sorted(gradient / plain for plain, gradient in pairs)
    plain, gradient = np.median(pairs, axis=0).tolist()
    row = {
        "task": task.spec.name,
        "family": task.spec.family,
        "split": task.spec.split,
        "plain_seconds": plain,
        "gradient_seconds": gradient,
        "ratio": float(np.median(ratios)),
        "ratio_range": [ratios[0], ratios[-1]],
    }
    harness.say(f"{task.spec.name:32s} {plain:.3f} s, with its gradient {gradient:.3f} s: {row['ratio']:.2f}")
    return [row]
