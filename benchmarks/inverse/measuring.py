"""A row: one search, what it found, what it cost, and whether its gradient is right."""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from benchmarks import harness
from benchmarks.harness import Row
from benchmarks.inverse.experiment import EXACT, UNIT, Data, Experiment
from benchmarks.inverse.fitting import (
    LM_STEPS,
    Best,
    Failed,
    Fit,
    descend_adam,
    descend_in_stages,
    descend_levenberg_marquardt,
)
from benchmarks.inverse.problems import HIDDEN, PROBLEMS, SMOOTH, Problem
from physagent_jax.metrics.identifiability import LEAST_CHANGE, Identifiability, find_identifiability

GRADIENT_BAR = 0.01  # of a gradient against differences, relative
LEAST_SLOPE = 1.0  # a loss of 1/2 is a single residual as large as a tracker's noise: less is round-off
DIFFERENCES = (0.1, 0.03, 0.01, 0.003)  # of u: steps of these; the best one counts
LEVENBERG_MARQUARDT, ADAM = "Levenberg-Marquardt", "Adam"

FITS = {problem.name: problem for problem in (*PROBLEMS, *SMOOTH, *HIDDEN)}


@cache
def prepare(name: str, data: Data) -> Experiment:
    """A problem's experiment, made once."""
    return Experiment(FITS[name], data)


def measure_fit(experiment: Experiment, start: str, optimiser: str) -> Row:
    """Searches, unless the tracks do not tell all that is sought.

    Args:
        experiment: What is sought, by which tracks.
        start: One of the problem's.
        optimiser: LEVENBERG_MARQUARDT or ADAM.
    """
    problem, data, name = experiment.problem, experiment.data, experiment.problem.name
    numbers = problem.starts[start]
    u = problem.encode(numbers)
    row: Row = {
        "problem": name,
        "start": start,
        "optimiser": optimiser,
        "finer": data.finer,
        "noise": data.noise,
        "unknowns": list(problem.truth),
        "truth": _list(problem.truth),
        "begun": _list(numbers),
        "particles": experiment.particle_count,
        "substeps": experiment.substeps,
    }
    observed = experiment.observed
    row["gradient_error"] = compare_gradient(experiment, u)
    before, least = find_identified(experiment, u)
    row |= describe(before, least)
    if before.identified < len(u):
        row |= {"fitted": False, "good": not problem.identified and row["gradient_error"] <= GRADIENT_BAR}
        harness.say(f"{name}: not fitted, {', '.join(before.unidentified)} cannot be told")
        return row
    experiment.spent, begun = 0.0, time.perf_counter()
    stages = problem.stages

    def search(fit: Fit, start: np.ndarray, sought: np.ndarray) -> Iterator[Best]:
        if optimiser == ADAM:
            return descend_adam(fit, start, observed.size)
        return descend_levenberg_marquardt(fit, start, problem.scale[sought], LM_STEPS // len(stages))

    row |= follow(experiment, descend_in_stages(experiment, u, stages, search)) | {
        "seconds": time.perf_counter() - begun,
        "fitted": True,
    }
    found = np.array(row.pop("u"))
    row["found"] = _list(problem.decode(found))
    try:
        row |= describe(*find_identified(experiment, found)) | spread(experiment, found, data)
    except Failed as error:  # it ended at the border of what can be simulated
        row |= {"failed": str(error), "condition": None, "standard_errors": None}
    row["met"] = all(row["errors"][each.name] <= each.tolerance for each in problem.unknowns)
    exact = data == EXACT
    row["good"] = problem.identified and row["gradient_error"] <= GRADIENT_BAR and (row["met"] or not exact)
    said = ", ".join(f"{key} {value:.3g}" for key, value in row["errors"].items())
    harness.say(
        f"{name}, {start}, {optimiser}, {data}: {said}; {'met' if row['met'] else 'missed'} after "
        f"{row['steps_to_tolerance']} of {row['steps']} steps, {row['seconds']:.0f} s, gradient off by "
        f"{row['gradient_error']:.2g}"
    )
    return row


def follow(experiment: Experiment, search: Iterator[Best]) -> Row:
    """Run a search to its end, and note how near it was after every step."""
    problem, history = experiment.problem, []
    steps, reached, best = 0, None, None
    failed = None
    try:
        for count, best in enumerate(search):
            errors = find_errors(problem, best.u)
            ratio = max(errors[each.name] / each.tolerance for each in problem.unknowns)
            reached = count if reached is None and ratio <= 1 else reached
            steps = count
            history.append([experiment.spent, ratio, best.loss])
    except Failed as error:
        failed = str(error)
    if best is None:
        raise Failed(f"{problem.name}: the start cannot be simulated: {failed}")
    return {
        "u": best.u.tolist(),
        "errors": find_errors(problem, best.u),
        "steps": steps,
        "steps_to_tolerance": reached,
        "forward_equivalents": experiment.spent,
        "residual": float(np.sqrt(2 * best.loss / experiment.observed.size)),
        "history": history,
        "failed": failed,
    }


def find_errors(problem: Problem, u: np.ndarray) -> dict[str, float]:
    """Of every unknown, by its measure."""
    found = problem.decode(u)
    return {
        each.name: each.find_error(found[each.name], problem.truth[each.name]) for each in problem.unknowns
    }


def compare_gradient(experiment: Experiment, u: np.ndarray) -> float:
    """The gradient against central differences of the loss, relative to these, or to `LEAST_SLOPE` if that is more.

    The best of several steps counts: single precision spoils short ones, contact long ones.
    """
    _, gradient = experiment.compute_gradient(u)
    errors = []
    for h in DIFFERENCES:
        sides = [[experiment.compute_loss(u + s * h * e) for s in (1, -1)] for e in np.eye(len(u))]
        difference = np.array([(above - below) / (2 * h) for above, below in sides])
        size = max(float(np.linalg.norm(difference)), LEAST_SLOPE)
        errors.append(float(np.linalg.norm(gradient - difference)) / size)
    return min(errors)


def find_identified(experiment: Experiment, u: np.ndarray) -> tuple[Identifiability, float]:
    """J^T J in the scales of the starts, with residuals in a tracker's noise; and what a direction must move them by.

    That is a tracker's noise of all of them together, or what two Jacobians by steps of different lengths are apart if
    that is more: no singular value is off by more than J is (Weyl).
    """
    problem = experiment.problem
    coarse, fine = (experiment.compute_central_jacobian(u, factor) for factor in (2.0, 1.0))
    doubt = float(np.linalg.norm((fine - coarse) * problem.scale, 2))
    least = max(LEAST_CHANGE, doubt)
    return find_identifiability(fine, problem.labels, problem.scale, least=least), least


def describe(found: Identifiability, least: float) -> Row:
    """Part of a fit that a row keeps."""
    return {
        "least": least,
        "condition": found.condition,
        "identified": found.identified,
        "unidentified": list(found.unidentified),
        "eigenvalues": list(found.eigenvalues),
        "directions": [list(each) for each in found.directions],
        "labels": list(found.names),
    }


def spread(experiment: Experiment, u: np.ndarray, data: Data) -> Row:
    """Standard errors that no unbiased estimate from such tracks can beat (Cramer and Rao), by name.

    Of exact tracks for the noise of `UNIT`.
    """
    problem = experiment.problem
    jacobian = experiment.compute_central_jacobian(u)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * ((data.noise or UNIT) / UNIT) ** 2
    found, at = {}, 0
    for each in problem.unknowns:
        part = slice(at, at + each.size)
        found[each.name] = each.spread(u[part], covariance[part, part])
        at += each.size
    return {"standard_errors": found}


def _list(numbers: Any) -> dict[str, Any]:
    return {name: np.asarray(value, float).tolist() for name, value in numbers.items()}
