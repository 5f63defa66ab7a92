"""`python -m baselines.run --method oracle_gradient --task push`: solve a task and leave a run folder."""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path
from typing import Literal

import tyro

import physagent_jax as pa
from baselines.oracle_gradient import Step, optimise
from baselines.path_tasks import TASKS, Parameters, Task, make_task
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.report.html import write_report
from physagent_jax.run.artifacts import write_best, write_rollout
from physagent_jax.run.manifest import Stages
from physagent_jax.run.provenance import hash_settings, make_manifest
from physagent_jax.run.spec import VIDEO_SIZE
from physagent_jax.run.store import RunStore
from physagent_jax.simulation.stopwatch import Stopwatch


@dataclasses.dataclass(frozen=True)
class Command:
    """Solve a benchmark task with a baseline method."""

    task: Literal["push", "drop"]
    """Which task."""
    method: Literal["oracle_gradient"] = "oracle_gradient"
    """Which method."""
    out: Path | None = None
    """Run folder; default: runs/<method>_<task>."""
    iterations: int = 40
    """Gradients at most."""
    learning_rate: float = 0.1
    """Of Adam."""
    frames: int = 26
    """Frames of the clip."""
    particles: int = 1500
    """Particles at most."""
    overwrite: bool = False
    """Replace another run in the folder."""


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line; returns the exit code."""
    command = tyro.cli(Command, prog="python -m baselines.run", args=arguments)
    pa.enable_compile_cache()
    try:
        solve(command)
    except UserError as error:
        print(f"baselines: {error}", file=sys.stderr)
        return 2
    return 0


def solve(command: Command) -> RunStore:
    """Optimises, prints every iteration, and plays the solution into a run folder."""
    if command.iterations < 1:
        raise UserError("`--iterations` must be at least 1", got=command.iterations)
    if not 0 < command.learning_rate <= 100:
        raise UserError("`--learning-rate` must be above 0 and at most 100", got=command.learning_rate)
    out = command.out or Path("runs") / f"{command.method}_{command.task}"
    settings: dict = {"method": command.method, "task": command.task, "lr": command.learning_rate}
    settings.update(iterations=command.iterations, frames=command.frames, particles=command.particles)
    manifest = make_manifest(
        command=f"python -m baselines.run --method {command.method} --task {command.task}",
        prompt=TASKS[command.task].prompt,
        seed=0,
        inputs={"settings": hash_settings(settings)},
    )
    with RunStore.open(out, manifest, overwrite=command.overwrite) as store:
        if store.manifest.complete:
            print(f"{out} is complete; pass --overwrite to make it again")
        else:
            _solve(command, store)
    return store


def _solve(command: Command, store: RunStore) -> None:
    out = store.path
    store.begin()
    watch = Stopwatch()
    with watch("prepare"):
        task = make_task(TASKS[command.task], out, frame_count=command.frames, particles=command.particles)
    print(
        f"{'iteration':>9}  {'loss [L^2]':>11}  {'|gradient|':>10}  {'M':>5}  direction              seconds"
    )
    with watch("simulate"):
        parameters, history = optimise(
            task, iterations=command.iterations, learning_rate=command.learning_rate, on_step=_print
        )
    _write(store, task, parameters, history, watch)
    print(f"best loss {min(step.loss for step in history):.3g} body lengths^2; report: {write_report(out)}")


def _print(step: Step) -> None:
    x, y, z = step.vector
    print(
        f"{step.iteration:9d}  {step.loss:11.4e}  {step.gradient_norm:10.3e}  {step.magnitude:5.2f}  "
        f"({x:+.3f} {y:+.3f} {z:+.3f})  {step.seconds:7.2f}",
        flush=True,
    )


def _write(
    store: RunStore, task: Task, parameters: Parameters, history: list[Step], watch: Stopwatch
) -> None:
    """Leaves the files of a run with one iteration: the solution, played with the adaptive driver."""
    scene = task.solution(parameters)
    print("simulating the solution")
    recording = pa.simulate_scene(scene, watch=watch)
    with watch("write"):
        write_rollout(store, 0, scene, recording)
        write_best(
            store, 0, scene.config, scene.body, save_frames=False, save_splats=False, video_size=VIDEO_SIZE
        )
        steps = [dataclasses.asdict(step) for step in history]
        write_text(store.claimed("optimisation.json"), json.dumps(steps, indent=2) + "\n")
    store.finish(stages=Stages(**watch.seconds()), iterations=1, best_iteration=0)


if __name__ == "__main__":
    sys.exit(main())
