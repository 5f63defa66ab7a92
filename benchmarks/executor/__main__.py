"""`python -m benchmarks.executor [--quick] [--json OUT] [--markdown MD]`: from wrong force fields to right motions.

`starts` begins with spoilt force fields and lets the offline executor mend them, with perfect perception: planner and
executor read the particles' motion. `kinds` compares body forces with velocity constraints. `rescues` runs sentences
whose first clip fails through the whole loop, with its pictures.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.executor.kinds import COMPARISONS, compare_kind
from benchmarks.executor.markdown import PAGE
from benchmarks.executor.rescues import list_pairs, measure_rescue
from benchmarks.executor.scenes import prepare, run_rounds
from benchmarks.executor.tasks import FAULTS, TASKS, Task
from benchmarks.harness import RAW, Job, Row

ROUNDS = 4  # the wrong start and three rewrites


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure the executor, or write the tables of an earlier run."""

    json: Path = RAW / "executor.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["starts", "kinds", "rescues"], ...] = ("starts", "kinds", "rescues")
    """Parts to measure."""
    data: Path | None = None
    """Folder with spot.obj and bunny.obj, for `rescues`; without them those objects are left out."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)

    def list_starts() -> list[Job]:
        pairs = [(task, fault) for task in TASKS for fault in task.faults]
        if command.quick:
            pairs = pairs[::10]
        return [Job(f"{task.name}: {fault}", partial(measure_start, task, fault)) for task, fault in pairs]

    def list_kinds() -> list[Job]:
        chosen = COMPARISONS[::5] if command.quick else COMPARISONS
        return [Job(each.name, partial(compare_kind, each)) for each in chosen]

    def list_rescues() -> list[Job]:
        pairs = list_pairs(command.data)[:: 5 if command.quick else 1]
        return [Job(f"{p.object}: {p.sentence}", partial(measure_rescue, p, command.data)) for p in pairs]

    parts = {"starts": list_starts, "kinds": list_kinds, "rescues": list_rescues}
    return harness.main(command, parts, PAGE)


def measure_start(task: Task, fault: str) -> list[Row]:
    """One wrong start: its rounds, and in which of them the motion was right."""
    setting = prepare(task.object, task.world)
    right = task.mean(setting.brief)
    wrong = FAULTS[fault](right, setting.brief)
    attempts = run_rounds(setting, task.sentence, task.expect(setting.brief), wrong, ROUNDS)
    verdicts = [attempt.round.judgement.verdict.value for attempt in attempts]
    at = verdicts.index("SUCCESS") if "SUCCESS" in verdicts else None
    harness.say(
        f"{task.name:14s} {fault:15s} {'right after ' + str(at) if at is not None else 'never right'}"
    )
    row: Row = {
        "task": task.name,
        "object": task.object,
        "sentence": task.sentence,
        "fault": fault,
        "rewrites_to_success": at,
        "rounds": len(attempts),
        "scores": [attempt.round.judgement.score for attempt in attempts],
        "stopped_at_walls": [attempt.clip.stopped if attempt.clip else None for attempt in attempts],
        "fields": [a.round.force_field.model_dump(mode="json", exclude_none=True) for a in attempts],
        "changes": [list(a.rewrite.changes) if a.rewrite else [] for a in attempts],
        "failed": [
            [
                f"{check.question} expected {check.expected}, observed {check.observed}"
                for check in attempt.round.judgement.checks
                if check.passed is not True
            ]
            for attempt in attempts
        ],
    }
    return [row]


if __name__ == "__main__":
    sys.exit(main())
