"""`python -m baselines.recordings FILE.npz --task NAME`: judge a recording by a task, and rate its physical fidelity.

A recording may come from another simulator, or from a video whose points were lifted into the scene. The file holds
``x``, positions in the task's scene [m], shape (frames, particles, 3), a frame for each of the task's, the rest pose
first. It may hold ``mass`` [kg], ``held`` (which particles are held) and ``acceleration`` (all that acts, gravity too
[m/s^2], from each frame to the next); what it lacks is not rated. `make_task(...).loaded` has the rest pose.
"""

from __future__ import annotations

import dataclasses
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Annotated

import jax.numpy as jnp
import numpy as np
import tyro

from baselines.run import TASKS, find_task
from baselines.tasks import Task, make_task
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.effort import list_accelerations
from physagent_jax.metrics.fidelity import BARS, UNITS, Fidelity, Surroundings, rate_fidelity
from physagent_jax.metrics.task_judge import judge
from physagent_jax.mpm import DomainBox, HalfSpace, PrescribedMotion
from physagent_jax.scene.compile import CompiledScene


@dataclasses.dataclass(frozen=True)
class Command:
    """Judge a recording by a benchmark task, and rate its physical fidelity."""

    file: Annotated[Path, tyro.conf.Positional]
    """The recording, .npz."""
    task: str
    """Name of the task."""
    tasks: Path = TASKS
    """Folder of tasks."""
    data: Path | None = None
    """Folder of captured objects, for the tasks on these."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    command = tyro.cli(Command, prog="python -m baselines.recordings", args=arguments)
    try:
        spec, arrays = find_task(command.tasks, command.task), read(command.file)
        with tempfile.TemporaryDirectory() as folder:
            show(make_task(spec, Path(folder), command.data), arrays)
    except UserError as error:
        print(f"baselines: {error}", file=sys.stderr)
        return 2
    return 0


def read(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a recording.

    Raises:
        UserError: There is no such file, or no positions in it.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in ("x", "mass", "held", "acceleration") if name in file}
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise UserError("the recording cannot be read", got=path, do="Give an .npz file") from error
    if "x" not in arrays:
        raise UserError("the recording has no `x`", got=path, do="Store the positions as `x`")
    return arrays


def show(task: Task, arrays: dict[str, np.ndarray]) -> None:
    """Print the clauses and the terms of a recording."""
    x = np.asarray(arrays["x"], np.float64)
    if x.ndim != 3 or len(x) != task.frame_count:
        raise UserError(f"`x` must have {task.frame_count} frames of shape (particles, 3)", got=x.shape)
    mass = arrays.get("mass", np.ones(x.shape[1]))
    judged = judge(task.target, x, mass, task.frame_dt)
    for clause in judged.clauses:
        print(
            f"{clause.name}: {clause.seen:.3g} {clause.unit}, wanted {clause.wanted:.3g}, margin {clause.margin:.2f}"
        )
    print(f"{'success' if judged.success else 'no success'}, error {judged.error:.2f} tolerances")
    around = dataclasses.replace(
        survey(task.build(ForceField()), x),
        held=arrays.get("held"),
        acceleration=arrays.get("acceleration"),
        driven=False,
    )
    found = rate_fidelity(x, mass, task.frame_dt, around)
    for name, bar in BARS.items():
        value = getattr(found, name)
        told = "not rated" if value is None else f"{value:.3g} {UNITS[name]}, clean up to {bar:g}"
        print(f"{name}: {told}")
    print(f"fidelity {found.score:.2f}" + (f": {', '.join(found.faults)}" if found.faults else ", clean"))


def rate(task: Task, force_field: ForceField, x: np.ndarray) -> Fidelity:
    """Fidelity of a simulation of a task [m], shape (T, n, 3): what acts and holds is known."""
    return rate_fidelity(x, task.mass, task.frame_dt, survey(task.build(force_field), x))


def survey(scene: CompiledScene, x: np.ndarray) -> Surroundings:
    """The surroundings that a scene of a task has along the paths ``x`` [m], shape (T, n, 3).

    Raises:
        UserError: It has an obstacle that tasks do not have.
    """
    model, config = scene.model, scene.config
    solids = []
    for boundary in model.boundaries:
        if isinstance(boundary, HalfSpace):
            point, normal = np.asarray(boundary.point), np.asarray(boundary.normal)
            solids.append(lambda places, point=point, normal=normal: (places - point) @ normal)
        elif isinstance(boundary, DomainBox):
            low = boundary.padding * config.domain.size / config.domain.cells
            high = config.domain.size - low
            solids.append(lambda places, low=low, high=high: np.minimum(places - low, high - places).min(-1))
        else:
            raise UserError("no distance is known from an obstacle", got=type(boundary).__name__)
    held = np.zeros(x.shape[1], bool)
    driven = False
    for constraint in model.constraints:
        fixed = isinstance(constraint, PrescribedMotion) and bool(np.all(np.isinf(constraint.end)))
        if fixed and not np.any(constraint.prescribe(model, jnp.asarray(x[0]))):
            indices = np.asarray(constraint.particles)
            held[indices[indices < len(held)]] = True
        else:
            driven = True
    acts = None if x.shape[1] != len(model.mass) else list_accelerations(model, x, config.timing.frame_dt)
    return Surroundings(tuple(solids), held, acts, resting=True, driven=driven)


if __name__ == "__main__":
    sys.exit(main())
