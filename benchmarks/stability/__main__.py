"""`python -m benchmarks.stability [--quick] [--json OUT] [--markdown MD]`: attempts to break the simulator.

Parts, each a section of the JSON (those not asked for are kept, so that parts can be run one by one):

- critical: the measured critical step of every material over the closed-form bound.
- matrix: every material x force x magnitude with the automatic step.
- pairwise: every pair of values of the remaining axes (stiffness, step rule, particles per cell, walls, ...).
- stiffness: E from 1e3 to 1e9 Pa with the automatic step.
- degenerate: inputs that should not be, and runs that must agree.
- sharpened-critical and so on: the same with sharpened increments (`mpm.inertia`).

Every run passes, is refused in words, or fails; a wrong result without a word is a failure.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Literal

import jax
import tyro

from benchmarks import harness
from benchmarks.harness import RAW, Job
from benchmarks.stability import matrix
from benchmarks.stability.criteria import Result, examine
from benchmarks.stability.dt_crit import CONFIGURATIONS, FORMS, SUBJECTS, measure
from benchmarks.stability.markdown import KINDS, PAGE, PARTS, SHARPENED
from benchmarks.stability.scenario import Scenario
from physagent_jax.kernels import programs
from physagent_jax.mpm import Lumped, Sharpened

Part = Literal[
    "critical",
    "matrix",
    "pairwise",
    "stiffness",
    "degenerate",
    "sharpened-critical",
    "sharpened-matrix",
    "sharpened-pairwise",
    "sharpened-stiffness",
    "sharpened-degenerate",
]
Inertia = Lumped | Sharpened
_QUICK = {"critical": 2, "matrix": 12, "pairwise": 6, "stiffness": 3, "degenerate": 8}  # rows of a quick look


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Try to break the simulator, and write down what happened."""

    json: Path = RAW / "stability.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Part, ...] = PARTS  # type: ignore[assignment]
    """Parts to run."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    parts = {kind: partial(_list_jobs, kind, Lumped(), command.quick) for kind in KINDS}
    parts |= {SHARPENED + kind: partial(_list_jobs, kind, Sharpened(), command.quick) for kind in KINDS}
    return harness.main(command, parts, PAGE)


def _list_jobs(kind: str, inertia: Inertia, quick: bool) -> list[Job]:
    """All jobs of a kind, or an even spread of them."""
    jobs = list(_list_critical(inertia) if kind == "critical" else _list_runs(kind, inertia))
    if not quick or len(jobs) <= _QUICK[kind]:
        return jobs
    stride = len(jobs) / _QUICK[kind]
    return [jobs[int(i * stride)] for i in range(_QUICK[kind])]


def _list_critical(inertia: Inertia) -> Iterator[Job]:
    for subject in SUBJECTS:
        for form in FORMS:
            for place in CONFIGURATIONS:
                yield Job(f"{subject}, {form}, {place}", partial(_measure_row, subject, form, place, inertia))


def _measure_row(subject: str, form: str, place: str, inertia: Inertia) -> list[dict]:
    with jax.enable_x64(True):
        found = measure(subject, place, form, inertia)
    verdict = "pass" if found.good else "FAIL"
    limit = "at least " if found.unlimited else ""
    harness.say(f"{verdict:>8}  {subject}, {place}, {form}: {limit}{found.ratio:.3f} of the bound")
    return [dataclasses.asdict(found) | {"verdict": verdict, "good": found.good}]


def _list_runs(kind: str, inertia: Inertia) -> Iterator[Job]:
    if kind == "degenerate":
        for name, run in matrix.degenerate(inertia):
            yield Job(name, partial(_make_row, run))
        return
    scenarios = {"matrix": matrix.matrix, "pairwise": matrix.pairwise, "stiffness": matrix.stiffness}[kind]()
    for scenario in scenarios:
        scenario = dataclasses.replace(scenario, inertia=inertia)
        yield Job(scenario.name, partial(_make_row, partial(_examine, scenario)))


def _examine(scenario: Scenario) -> Result:
    with jax.enable_x64(scenario.dtype == "float64"):
        return examine(scenario)


def _make_row(run: Callable[[], Result]) -> list[dict]:
    row = _to_plain(run())
    programs.release_programs()
    harness.say(f"{row['verdict']:>8}  {row['name']}{': ' if row['message'] else ''}{row['message']}")
    return [row]


def _to_plain(result: Result) -> dict:
    row = dataclasses.asdict(result)
    row["good"] = result.verdict != "FAIL"
    row["figures"] = {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in result.figures.items()
    }
    return row


if __name__ == "__main__":
    sys.exit(main())
