"""`python -m benchmarks.headtohead --json OUT [--markdown MD] [--data DIR] [--quick]`: methods against each other.

Every method gets the same budget on the same tasks and the same simulator, counted in forward-equivalents; what it is
to be judged by is read from the particles and never shown to it (oracles apart, which are named so). `methods` is the
comparison, `ablation` takes the agents apart, `iterations` counts their rewrites, `neighbourhood` checks that local
methods are not broken. `verify` simulates the force fields of the file again and judges them anew.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Literal

import tyro

import physagent_jax as pa
from baselines.tasks import Task, TaskSpec, load_tasks, load_witnesses, make_task, split_available
from benchmarks import harness
from benchmarks.harness import Job, Row
from benchmarks.headtohead import leaderboard
from benchmarks.headtohead.entrants import ABLATION, ITERATIONS, METHODS, Entrant, list_distillers
from benchmarks.headtohead.markdown import document
from benchmarks.headtohead.measuring import judge_field, measure
from benchmarks.headtohead.neighbourhood import Begin, list_begins, list_entrants, move
from benchmarks.headtohead.plot import plot
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField

MARKS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
ROUNDS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
TASKS = Path(__file__).resolve().parents[1] / "tasks"
_TOLERANCE = 1e-6  # [tolerances] by which a verified error may differ on the machine it was made on
_KEPT = tempfile.TemporaryDirectory()


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Compare the methods, or write the tables of an earlier run."""

    parts: tuple[
        Literal["methods", "ablation", "iterations", "distillation", "neighbourhood", "verify"], ...
    ] = (
        "methods",
        "ablation",
        "iterations",
    )
    """Which to measure."""
    tasks: Path = TASKS
    """Folder of the tasks."""
    data: Path | None = None
    """Folder of captured objects; tasks on those are left out without it."""
    split: Literal["development", "test", "both"] = "both"
    """Which tasks."""
    families: tuple[str, ...] = ()
    """Only these; none = all."""
    smooth: bool = False
    """Only tasks in which nothing comes to touch the ground."""
    every: int = 1
    """Only every so-many-th task of a family."""
    budget: float = 30.0
    """Forward-equivalents of each fit: the last mark."""
    seeds: int = 1
    """Of what is random; the rest is done once."""
    workers: int = 1
    """Fits side by side, each on its share of the cores: for what is counted, not for seconds to quote."""
    prior: Literal["wan", "modelscope", "cogvideox", "toy"] = "toy"
    """Who leads the methods of score distillation."""
    weights: str = "runs/toy_prior/prior"
    """Of the prior."""
    leaderboard: Path | None = None
    """File of JSON lines, one per fit: those of this result are added; `verify` then checks all of its lines."""
    plots: Path | None = None
    """Also draw success against budget here."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    pa.enable_compile_cache()
    try:
        specs, left_out = list_tasks(command)
    except UserError as error:
        print(f"headtohead: {error}", file=sys.stderr)
        return 2
    marks = (*(mark for mark in MARKS if mark < command.budget), command.budget)
    parts: dict[str, Callable[[], list[Job]]] = {
        "methods": lambda: _list_jobs(command, specs, METHODS, marks, command.budget),
        "ablation": lambda: _list_jobs(command, specs, ABLATION, marks, command.budget),
        "iterations": lambda: _list_jobs(command, specs, ITERATIONS, ROUNDS, ROUNDS[-1]),
        "distillation": lambda: _list_jobs(
            command, specs, list_distillers(command.prior, command.weights), marks, command.budget
        ),
        "neighbourhood": lambda: _list_neighbours(command, specs, marks),
        "verify": lambda: _list_checks(command, specs),
    }
    about = {"left_out": left_out, "budget": command.budget}
    code = harness.main(command, parts, document, about, command.workers, pa.enable_compile_cache)
    if command.leaderboard is not None and command.json.is_file():
        leaderboard.merge(command.leaderboard, json.loads(command.json.read_text()))
    if command.plots is not None:
        plot(json.loads(command.json.read_text()), command.plots)
    return code


def list_tasks(command: Command) -> tuple[tuple[TaskSpec, ...], list[str]]:
    """The tasks that are asked for and can be made, and the names of those that cannot.

    Raises:
        UserError: There are none, or a family is unknown.
    """
    split = None if command.split == "both" else command.split
    specs = load_tasks(command.tasks, split=split, families=command.families or None)
    specs, left_out = split_available(
        [spec for spec in specs if spec.smooth or not command.smooth], command.data
    )
    counts: dict[str, int] = {}
    chosen = []
    every = 4 if command.quick else command.every
    for spec in specs:
        place = counts[spec.family] = counts.get(spec.family, -1) + 1
        if place % every == 0:
            chosen.append(spec)
    return tuple(chosen), list(left_out)


def _list_jobs(
    command: Command,
    specs: Sequence[TaskSpec],
    entrants: Sequence[Entrant],
    marks: Sequence[float],
    budget: float,
) -> list[Job]:
    jobs = []
    for spec in specs:
        for entrant in entrants:
            seeds = command.seeds if entrant.make().stochastic else 1
            for seed in range(seeds):
                work = partial(_measure, entrant, spec, command.data, marks, seed, budget)
                jobs.append(Job(f"{spec.name} / {entrant.label} / {seed}", work))
    return jobs


def _measure(
    entrant: Entrant, spec: TaskSpec, data: Path | None, marks, seed: int, budget: float
) -> list[Row]:
    return measure(entrant, _make(spec, data), marks, seed, budget)


def _list_neighbours(command: Command, specs: Sequence[TaskSpec], marks: Sequence[float]) -> list[Job]:
    """Local methods, once each: near the witness, where the task says, and from afar."""
    witnesses, jobs = load_witnesses(command.tasks), []
    for spec in specs:
        for begin in list_begins(spec.begin is not None):
            for entrant in list_entrants(begin):
                witness = witnesses[spec.name] if begin == "near" else None
                work = partial(_measure_from, begin, witness, entrant, spec, command, marks)
                jobs.append(Job(f"{spec.name} / {entrant.label}", work))
    return jobs


def _measure_from(
    begin: Begin, witness: ForceField | None, entrant: Entrant, spec: TaskSpec, command: Command, marks
) -> list[Row]:
    task = _make(spec, command.data)
    if witness is not None:
        task = move(task, witness, seed=0)
    rows = measure(entrant, task, marks, 0, command.budget)
    return [row | {"begin": begin, "smooth": spec.smooth} for row in rows]


def _list_checks(command: Command, specs: Sequence[TaskSpec]) -> list[Job]:
    """The last force field of every row of the file, or of every line of the leaderboard, once more."""
    known = {spec.name: spec for spec in specs}
    if command.leaderboard is not None and command.leaderboard.is_file():
        rows = [leaderboard.as_row(entry) for entry in leaderboard.read(command.leaderboard)]
    else:
        result = json.loads(command.json.read_text()) if command.json.is_file() else {}
        rows = [row for part in leaderboard.PARTS for row in result.get(part, {}).get("rows", [])]
    return [
        Job(row["job"], partial(verify, row, _make(known[row["task"]], command.data)))
        for row in rows
        if row["task"] in known and row["marks"]
    ]


def verify(row: Row, task: Task) -> list[Row]:
    """Whether a stored force field is still judged as its row says, by the target that it was made for."""
    stored = row["marks"][-1]
    again = judge_field(ForceField.model_validate(stored["force_field"]), task)
    same_target = row["target_hash"] == task.spec.target_hash
    near = again["error"] == stored["error"] or abs(again["error"] - stored["error"]) <= _TOLERANCE
    good = same_target and again["success"] == stored["success"] and near
    if not good:
        harness.say(f"{row['job']}: error {stored['error']:.6g} then, {again['error']:.6g} now")
    return [{"good": good, "stored": stored["error"], "again": again["error"], "same_target": same_target}]


@cache
def _make(spec: TaskSpec, data: Path | None) -> Task:
    return make_task(spec, Path(_KEPT.name), data)


if __name__ == "__main__":
    sys.exit(main())
