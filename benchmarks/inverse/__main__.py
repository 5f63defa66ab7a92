"""`python -m benchmarks.inverse [--quick] [--json OUT] [--markdown MD] [--images DIR]`: numbers found from tracks.

A hidden scene is simulated, 64 points of its surface are followed over ten frames, and its numbers are sought from a
wrong start by gradients through the simulator: `exact` with the tracks as they are, `noise` with some added, `finer`
with tracks of a simulation at twice the resolution. `unidentifiable` are problems whose tracks do not tell what is
sought, which has to be noticed. `landscape` are slices of the loss with our gradients on them.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

import physagent_jax as pa
from benchmarks import harness
from benchmarks.harness import RAW, Job, Row
from benchmarks.inverse.experiment import EXACT, Data
from benchmarks.inverse.landscape import SLICES, measure_slice
from benchmarks.inverse.markdown import PAGE, PARTS
from benchmarks.inverse.measuring import ADAM, LEVENBERG_MARQUARDT, measure_fit, prepare
from benchmarks.inverse.plot import plot_convergence, plot_landscape
from benchmarks.inverse.problems import HIDDEN, PROBLEMS, SMOOTH, Problem

NOISES = (1e-3, 1e-2)  # of the object's longest side
QUICK = ("initial velocity",)  # problems


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Solve the inverse problems, or write the tables of an earlier run."""

    json: Path = RAW / "inverse.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["exact", "noise", "finer", "unidentifiable", "landscape"], ...] = PARTS
    """Parts to measure."""
    images: Path | None = None
    """Also draw convergence and landscape into this folder."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    if command.images is not None and not harness.can_plot():
        return 2
    pa.enable_compile_cache()
    problems = [each for each in PROBLEMS if not command.quick or each.name in QUICK]
    first = {each.name: next(iter(each.starts)) for each in (*problems, *SMOOTH, *HIDDEN)}

    def list_exact() -> list[Job]:
        jobs = [_plan(each, start) for each in problems for start in each.starts]
        others = [_plan(each, first[each.name], optimiser=ADAM) for each in problems]
        return jobs[:1] if command.quick else jobs + others

    def list_noise() -> list[Job]:
        return [_plan(each, first[each.name], Data(noise=noise)) for each in problems for noise in NOISES]

    def list_finer() -> list[Job]:
        shown = problems if command.quick else [*problems, *SMOOTH]
        return [_plan(each, first[each.name], Data(finer=2)) for each in shown]

    def list_hidden() -> list[Job]:
        return [_plan(each, first[each.name]) for each in (HIDDEN[:1] if command.quick else HIDDEN)]

    def list_slices() -> list[Job]:
        chosen, points = (SLICES[:1], 3) if command.quick else (SLICES, 31)
        return [Job(each.name, partial(measure_slice, each, points)) for each in chosen]

    parts: dict[str, Callable[[], list[Job]]] = dict(
        zip(PARTS, (list_exact, list_noise, list_finer, list_hidden, list_slices))
    )
    code = harness.main(command, parts, PAGE)
    if command.images is not None:
        result = json.loads(command.json.read_text())
        plot_convergence(result, command.images)
        plot_landscape(result, command.images)
    return code


def _plan(problem: Problem, start: str, data: Data = EXACT, optimiser: str = LEVENBERG_MARQUARDT) -> Job:
    name = f"{problem.name}, {start}, {optimiser}"
    name += f", noise {data.noise:g}" * (data.noise > 0) + ", finer" * (data.finer > 1)
    return Job(name, partial(_measure, problem.name, start, optimiser, data))


def _measure(name: str, start: str, optimiser: str, data: Data) -> list[Row]:
    return [measure_fit(prepare(name, data), start, optimiser)]


if __name__ == "__main__":
    sys.exit(main())
