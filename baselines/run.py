"""`python -m baselines.run --method NAME --task NAME`: solve a task within a budget and leave a run folder."""

from __future__ import annotations

import dataclasses
import json
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import tyro

import physagent_jax as pa
from baselines.materials import OWN
from baselines.methods import METHODS, make_method
from baselines.protocol import Budget, Evaluation, FitResult, Method
from baselines.tasks import Task, TaskSpec, load_tasks, make_task
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.core.names import find_nearest
from physagent_jax.metrics.task_judge import TaskJudgement
from physagent_jax.report.html import write_report
from physagent_jax.run.artifacts import write_best, write_rollout
from physagent_jax.run.manifest import Stages
from physagent_jax.run.provenance import hash_settings, make_manifest
from physagent_jax.run.spec import SaveChoice
from physagent_jax.run.store import RunStore
from physagent_jax.simulation.stopwatch import Stopwatch

_HERE = Path(__file__).resolve().parent
_BUNDLED = _HERE / "task_set"  # of an installed package
TASKS = _BUNDLED if _BUNDLED.is_dir() else _HERE.parent / "benchmarks" / "tasks"


@dataclasses.dataclass(frozen=True)
class Command:
    """Solve a benchmark task with a baseline method."""

    method: str
    """Name of the method; a name that there is not lists them. module:Class or file.py:Class is one of your own."""
    task: str
    """Name of the task; a name that there is not lists them."""
    budget: float = 100.0
    """Simulations that may be spent; a gradient counts as 4.3."""
    seconds: float | None = None
    """Wall time that may be spent [s]."""
    seed: int = 0
    """Seed of everything random."""
    options: tuple[str, ...] = ()
    """Options of the method, as name=value."""
    tasks: Path = TASKS
    """Folder of tasks."""
    data: Path | None = None
    """Folder of captured objects, for the tasks on these."""
    material: str = OWN
    """Material of the object: own, implied (by its kind), softer, stiffer, omniphysgs, a named material, a
    constitutive model, or a JSON object of fields."""
    out: Path | None = None
    """Run folder; default: runs/METHOD_TASK."""
    overwrite: bool = False
    """Replace another run in the folder."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    command = tyro.cli(Command, prog="python -m baselines.run", args=arguments)
    pa.enable_compile_cache()
    try:
        solve(command)
    except UserError as error:
        print(f"baselines: {error}", file=sys.stderr)
        return 2
    return 0


def solve(command: Command) -> RunStore:
    """Let the method spend its budget, print what it tries, and play what it found into a run folder."""
    budget = Budget(command.budget, command.seconds)
    if ":" not in command.method and command.method not in METHODS.entries:
        raise list_names("`--method`", command.method, METHODS.entries)
    hidden = [command.tasks] if command.out is None else [command.tasks, command.out]
    method = make_method(command.method, read_options(command.options), hidden)
    spec = find_task(command.tasks, command.task)
    out = command.out or Path("runs") / f"{method.name}_{command.task}"
    settings = dict(
        method=command.method,
        options=method.list_options(),
        task=spec.model_dump(mode="json"),
        budget=dataclasses.asdict(budget),
        seed=command.seed,
        material=command.material,
    )
    manifest = make_manifest(
        command=f"python -m baselines.run --method {command.method} --task {command.task}",
        prompt=spec.sentence,
        seed=command.seed,
        inputs={"settings": hash_settings(settings)},
    )
    with RunStore.open(out, manifest, overwrite=command.overwrite) as store:
        if store.manifest.complete:
            print(f"{out} is complete; pass --overwrite to make it again")
        else:
            _solve(store, method, spec, budget, command)
    return store


def read_options(pairs: tuple[str, ...]) -> dict[str, Any]:
    """Options of a method from texts like ``starts=4``; values are JSON, else text.

    Raises:
        UserError: A text has no name or no value.
    """
    options = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        if not name or not equals:
            raise UserError("an option of a method is name=value", got=pair)
        try:
            options[name] = json.loads(value)
        except json.JSONDecodeError:
            options[name] = value
    return options


def find_task(folder: Path, name: str, changed: bool = False) -> TaskSpec:
    """The task of this name; ``changed`` as in `load_tasks`.

    Raises:
        UserError: There is none.
    """
    specs = {spec.name: spec for spec in load_tasks(folder, changed=changed)}
    if name not in specs:
        raise list_names("`--task`", name, specs)
    return specs[name]


def list_names(what: str, name: str, known: Iterable[str]) -> UserError:
    """The error for a name that there is not: it lists all that there are."""
    near = [f"`{each}`" for each in find_nearest(name, known)]
    hint = f"Did you mean {' or '.join(near)}? " if near else ""
    return UserError(f"{what} is not known", got=repr(name), do=f"{hint}There are: {', '.join(known)}")


def _solve(store: RunStore, method: Method, spec: TaskSpec, budget: Budget, command: Command) -> None:
    store.begin()
    watch = Stopwatch()
    with tempfile.TemporaryDirectory() as folder:
        with watch("prepare"):
            task = make_task(spec, Path(folder), command.data, command.material)
        print(f"{'spent':>7}  {'seconds':>7}  {'objective':>11}  what for")
        with watch("simulate"):
            result = method.fit(task, budget, command.seed, on_evaluation=_print)
        judgement = _write(store, task, result, watch)
    best = result.find_incumbent()
    objective = "-" if best is None or best.objective is None else f"{best.objective:.3g}"
    print(
        f"{'success' if judgement.success else 'no success'}, error {judgement.error:.2f} tolerances, "
        f"own objective {objective}; report: {write_report(store.path)}"
    )


def _print(evaluation: Evaluation) -> None:
    objective = "-" if evaluation.objective is None else f"{evaluation.objective:.4e}"
    print(
        f"{evaluation.spent:7.1f}  {evaluation.seconds:7.1f}  {objective:>11}  {evaluation.note}", flush=True
    )


def _write(store: RunStore, task: Task, result: FitResult, watch: Stopwatch) -> TaskJudgement:
    """Leave the files of a run with one iteration: the solution, played as any force field is, and judged."""
    scene = task.build(result.incumbent_at())
    recording = pa.simulate_scene(scene, watch=watch)
    judgement = task.judge(recording.x)
    with watch("write"):
        write_rollout(store, 0, scene, recording)
        write_best(store, 0, scene.config, scene.body, SaveChoice())
        report = describe(result) | dict(judgement=dataclasses.asdict(judgement))
        write_text(store.claimed("fit.json"), json.dumps(report, indent=2) + "\n")
    store.finish(stages=Stages(**watch.seconds()), iterations=1, best_iteration=0)
    return judgement


def describe(result: FitResult) -> dict[str, Any]:
    """All of a result as JSON."""
    fields = {field.name: getattr(result, field.name) for field in dataclasses.fields(result)}
    fields["start"] = result.start.model_dump(mode="json")
    fields["evaluations"] = [
        {**dataclasses.asdict(each), "force_field": each.force_field.model_dump(mode="json")}
        for each in result.evaluations
    ]
    for each in fields["evaluations"]:
        if each["objective"] == float("inf"):
            each["objective"] = "failed"  # JSON has no infinity
    return fields


if __name__ == "__main__":
    sys.exit(main())
