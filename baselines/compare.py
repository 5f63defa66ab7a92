"""`python -m baselines.compare METHOD ...`: methods on the same tasks within the same budget, as tables and a plot.

Methods, tasks and objects may be one's own: nothing here has to be edited for them. Each fit is kept as it ends, and
the same command goes on where it was stopped.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import tempfile
from pathlib import Path
from typing import Annotated, Any

import tyro
from pydantic import ValidationError

import physagent_jax as pa
from baselines.measuring import Row, measure_fit
from baselines.methods import METHODS, make_method
from baselines.objects import add_object
from baselines.plot import plot
from baselines.protocol import Budget, Method
from baselines.run import TASKS, list_names, read_options
from baselines.tables import format_markdown, read_rows, summarise_methods, write_tables
from baselines.task_files import stamp
from baselines.tasks import TaskSpec, check_spec, load_tasks, make_task, split_available
from physagent_jax.core.errors import MissingPackageError, UserError
from physagent_jax.core.files import make_folders, write_text
from physagent_jax.core.reading import format_validation_error, read_json

MARKS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
"""Budgets at which every fit with more is judged as well [forward-equivalents]."""


@dataclasses.dataclass(frozen=True)
class Command:
    """Compare methods on benchmark tasks: tables (Markdown, CSV, LaTeX) and a vector plot."""

    methods: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Names of methods; module:Class or file.py:Class is one of your own. A name that there is not lists them. Options
    follow behind commas: adam,types=enumerated,numbers=random."""
    task: tuple[str, ...] = ()
    """Names of tasks, or files of your own tasks (.json). Default: the tasks of the split whose objects there are."""
    split: str = "development"
    """Split of the published tasks: development or test. Choose and tune on development."""
    object: tuple[str, ...] = ()
    """Objects of your own, for your tasks: NAME=FILE, or NAME=FILE,kind=vessel,up=+y,youngs_modulus=5e4."""
    budget: float = 30.0
    """Simulations that each fit may spend; a gradient counts as 4.3."""
    seeds: int = 1
    """Seeds of methods that draw; others run once."""
    tasks: Path = TASKS
    """Folder of the published tasks."""
    data: Path | None = None
    """Folder of captured objects, for the tasks on these."""
    out: Path = Path("runs/compare")
    """Folder of fits.jsonl, methods.md, methods.csv, methods.tex, fits.csv and success.svg."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    command = tyro.cli(Command, prog="python -m baselines.compare", args=arguments)
    pa.enable_compile_cache()
    try:
        compare_methods(command)
    except UserError as error:
        print(f"baselines: {error}", file=sys.stderr)
        return 2
    return 0


def compare_methods(command: Command) -> list[Row]:
    """Do the fits that the folder has not, and write the tables of all that were asked for.

    Raises:
        UserError: A method, a task, an object or an option is not known or not valid; nothing is measured then.
    """
    if command.seeds < 1:
        raise UserError("there must be at least one seed", got=command.seeds)
    budget = Budget(command.budget).forward_equivalents
    hidden = [command.tasks, command.out, *(Path(text) for text in command.task if text.endswith(".json"))]
    methods = {_name_method(text): _make_known(text, hidden) for text in command.methods}
    for text in command.object:
        add_object(text)
    specs = list_specs(command)
    marks = (*(mark for mark in MARKS if mark < budget), budget)
    path = command.out / "fits.jsonl"
    make_folders(command.out)
    kept = {_identify(row): row for row in read_rows(path)}
    write_text(path, "".join(json.dumps(row) + "\n" for row in kept.values()))  # a line that was cut off goes
    wanted = [
        (spec, label, method, seed)
        for spec in specs  # a task's programs are compiled once
        for label, method in methods.items()
        for seed in range(command.seeds if method.stochastic else 1)
    ]
    rows = []
    with tempfile.TemporaryDirectory() as folder, path.open("a", encoding="utf-8") as file:
        made = None
        for number, (spec, label, method, seed) in enumerate(wanted, 1):
            options = method.list_options()
            names = {"label": label, "method": method.name, "options": options, "budget": budget}
            key = _identify(names | {"task_hash": spec.task_hash, "seed": seed})
            if key not in kept:
                if made is None or made.spec is not spec:
                    made = make_task(spec, Path(folder), command.data)
                kept[key] = measure_fit(method, made, marks, seed, budget, names)
                file.write(json.dumps(kept[key]) + "\n")
                file.flush()
            rows.append(kept[key])
            print(f"{number}/{len(wanted)}  {spec.name:32s} {label:28s} {_tell(kept[key])}", flush=True)
    written = write_tables(rows, command.out)
    try:
        plot(rows, command.out / "success.svg")
        written.append(command.out / "success.svg")
    except MissingPackageError as error:
        print(f"no plot: {error}")
    print(f"\n{format_markdown(summarise_methods(rows))}\n{', '.join(map(str, written))}")
    return rows


def list_specs(command: Command) -> list[TaskSpec]:
    """The tasks that a command names: published ones by name, one's own by file.

    Raises:
        UserError: A name is not known, a file is no task, or an object's file is not there.
    """
    if command.split not in ("development", "test"):
        raise UserError("there is no such split", got=command.split, do="Choose development or test")
    if not command.task:
        kept, left_out = split_available(load_tasks(command.tasks, split=command.split), command.data)
        if left_out:
            print(f"left out, as their objects need `--data`: {', '.join(left_out)}")
        return list(kept)
    specs: list[TaskSpec] = []
    known: dict[str, TaskSpec] = {}
    for text in command.task:
        if text.endswith(".json"):
            specs += read_own_tasks(Path(text))
            continue
        known = known or {spec.name: spec for spec in load_tasks(command.tasks)}
        if text not in known:
            raise list_names("`--task`", text, known)
        specs.append(known[text])
    return specs


def read_own_tasks(path: Path) -> list[TaskSpec]:
    """The task or the list of tasks of a file; one without ``task_hash`` gets its own, of the family "other".

    Raises:
        UserError: It cannot be read, or is no task; a hash that is there and differs is refused, as everywhere.
    """
    content = read_json(path, what="a task of your own")
    specs = []
    for fields in content if isinstance(content, list) else [content]:
        own = {"family": "other", "task_hash": "", **fields} if isinstance(fields, dict) else fields
        try:
            spec = TaskSpec.model_validate(own)
            check_spec(spec, str(path), changed=not spec.task_hash)  # its object is known: it can be hashed
            specs.append(spec if spec.task_hash else stamp(spec.model_dump()))
        except ValidationError as error:
            raise format_validation_error(error, str(path), TaskSpec) from None
    return specs


def _make_known(text: str, hidden: list[Path]) -> Method:
    name, *options = text.split(",")
    if ":" not in name and name not in METHODS.entries:
        raise list_names("a method", name, METHODS.entries)
    return make_method(name, read_options(tuple(options)), hidden)


def _name_method(text: str) -> str:
    """Label of a row: the name, or the class of a file or module of one's own, with the options."""
    name, *options = text.split(",")
    return ", ".join((name.rpartition(":")[2], *options))


def _identify(row: dict[str, Any]) -> str:
    """Key under which a fit is kept: what it is of, whatever came of it."""
    return json.dumps(
        [row[name] for name in ("label", "options", "task_hash", "seed", "budget")], sort_keys=True
    )


def _tell(row: Row) -> str:
    if not row["marks"]:
        return f"refused: {row['refused']}"
    last = row["marks"][-1]
    told = "solved" if last["success"] else "not solved"
    return f"{told}, error {last['error']:.2f}, {row['spent']:.1f} simulations, {row['seconds']:.1f} s"


if __name__ == "__main__":
    sys.exit(main())
