"""`python -m baselines.record NAME ...`: record the paths of recovery tasks again, from their hidden force fields.

For the day when the library's own sizes change: the same force field then makes another motion. No other target follows
from a simulation, and none is written.
"""

from __future__ import annotations

import dataclasses
import sys
import tempfile
from pathlib import Path
from typing import Annotated

import tyro

import physagent_jax as pa
from baselines.run import TASKS, find_task
from baselines.task_files import record_target, stamp, write_tasks
from baselines.tasks import TaskSpec, load_tasks, make_task
from physagent_jax.core.errors import UserError


@dataclasses.dataclass(frozen=True)
class Command:
    """Record the paths of recovery tasks again."""

    names: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Names of the tasks."""
    tasks: Path = TASKS
    """Folder of tasks."""
    data: Path | None = None
    """Folder of captured objects, for the tasks on these."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    command = tyro.cli(Command, prog="python -m baselines.record", args=arguments)
    pa.enable_compile_cache()
    try:
        found = [find_task(command.tasks, name, changed=True) for name in command.names]
        recorded = {spec.name: record(spec, command.data) for spec in found}
    except UserError as error:
        print(f"baselines: {error}", file=sys.stderr)
        return 2
    specs = load_tasks(command.tasks, families=("recovery",), changed=True)
    write_tasks(command.tasks / "recovery.json", [recorded.get(spec.name, spec) for spec in specs])
    return 0


def record(spec: TaskSpec, data: Path | None) -> TaskSpec:
    """The task with what its hidden force field does now.

    Raises:
        UserError: It has no hidden force field, or its object needs a folder of data that is not given.
    """
    if spec.hidden is None:
        raise UserError(f"`{spec.name}` has no hidden force field", do="Name recovery tasks")
    with tempfile.TemporaryDirectory() as folder:
        task = make_task(spec, Path(folder), data)
        target = record_target(task, spec.hidden, spec.target.clauses[0].tolerance)
    return stamp({**spec.model_dump(), "target": target.model_dump()})


if __name__ == "__main__":
    sys.exit(main())
