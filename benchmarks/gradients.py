"""`python -m benchmarks.gradients --json OUT [--markdown OUT] [--quick]`: what the gradient of a simulation costs.

The elastic cube that is dropped on a floor (`benchmarks.peers.drop`), eight particles per cell. "forward" is what the
product runs: `simulate`, with its window and kernels. "value and gradient" is `jax.value_and_grad` through `replay` of
its schedule, of a loss over the last frame, by gravity, the initial velocity and the stiffness. Both are timed in turn,
warm; first calls compile. Memory is what the process takes more at its peak. "precision" compares the gradient by the
kernels in single precision with that of the reference path in double precision.
"""

from __future__ import annotations

import dataclasses
import re
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
import tyro

from benchmarks import harness
from benchmarks.harness import Job, Row, link, number, provenance, table
from benchmarks.peers.drop import SIDE, SIZE, drop
from benchmarks.peers.ours import build
from benchmarks.peers.scene import Material
from physagent_jax.mpm import Model, Schedule, State, cell_order, replay, simulate

CASES = (  # particles, frames, substeps of a frame, memory of the reverse pass [bytes], aim: times the forward
    (20_000, 1, 200, 2e9, 5.0),
    (20_000, 50, 200, 2e9, 6.0),
    (200_000, 1, 100, 4e9, None),
)
HORIZONS = (10, 100, 1000)  # substeps
_STATUS, _CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")
_MEANING = """What the gradient of a simulation costs, by `python -m benchmarks.gradients`. The elastic cube that the
codes are timed on, dropped on a floor, with eight particles per cell. *Forward* is what the product runs (`simulate`,
with its window and kernels); *value and gradient* is `jax.value_and_grad` through `replay` of its schedule, by gravity,
initial velocity and stiffness. Both in turn, warm; median and range of the ratio. *Memory* is what the process takes
more at its peak; *allowed* is what `replay` was given. *Precision*: the gradient by the kernels in single precision
against that of the reference path in double precision, of 1,000 particles, and that one against central differences.
"""
COLUMNS = {
    "particles": lambda row: f"{row['particles']:,}",
    "substeps": lambda row: f"{row['substeps']:,}",
    "forward [ms per substep]": lambda row: number(row["forward_ms"]),
    "value and gradient [ms per substep]": lambda row: number(row["gradient_ms"]),
    "times the forward": lambda row: (
        f"{number(row['ratio'])} ({' to '.join(map(number, row['ratio_range']))})"
    ),
    "aim": lambda row: number(row["aim"]),
    "memory [GB]": lambda row: number(row["memory_gb"]),
    "allowed [GB]": lambda row: number(row["allowed_gb"]),
    "first calls [s]": lambda row: ", ".join(map(number, row["first_seconds"])),
}
PRECISION = {
    "substeps": lambda row: f"{row['substeps']:,}",
    "cosine": lambda row: f"{row['cosine']:.7f}",
    "relative error": lambda row: f"{row['error']:.1e}",
    "norm": lambda row: number(row["norm"]),
    "double precision against central differences": lambda row: f"{row['difference_error']:.1e}",
}


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure what gradients cost, and how exact they are."""

    parts: tuple[Literal["cost", "precision"], ...] = ("cost", "precision")
    """Which to measure."""
    repeats: int = 3
    """Timed pairs; quick: one."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    parts = {"cost": lambda: _list_costs(command), "precision": lambda: _list_precisions(command)}
    return harness.main(command, parts, document)


def document(result: dict, json_path: Path, target: Path) -> str:
    """The tables as Markdown."""
    text = f"# Gradients\n\n{_MEANING}\nEvery row is in [{json_path.name}]({link(json_path, target)}).\n"
    text += provenance(result, ("cost", "precision"))
    for part, columns in (("cost", COLUMNS), ("precision", PRECISION)):
        if part in result:
            rows = [[show(row) for show in columns.values()] for row in result[part]["rows"]]
            text += f"\n## {part.capitalize()}\n" + table(tuple(columns), rows)
    return text


def _list_costs(command: Command) -> list[Job]:
    cases = ((2_000, 1, 20, 2e9, None),) if command.quick else CASES
    repeats = 1 if command.quick else command.repeats
    return [Job(f"{n} x {frames * steps}", partial(_measure_cost, n, frames, steps, memory, aim, repeats))
            for n, frames, steps, memory, aim in cases]  # fmt: skip


def _list_precisions(command: Command) -> list[Job]:
    horizons = HORIZONS[:1] if command.quick else HORIZONS
    return [Job(f"{count} substeps", partial(_measure_precision, count)) for count in horizons]


def make_cube(particles: int, precision: Any, kernels: str = "auto") -> tuple[Model, State]:
    """The cube above the floor, its particles sorted, eight in a cell."""
    cells = round(SIZE / (SIDE * (8 / particles) ** (1 / 3)))
    scene = drop(particles, Material.NEO_HOOKEAN, cells)
    scene = scene.take(cell_order(scene.x, scene.dx))
    scene = dataclasses.replace(scene, x=scene.x.astype(precision), v=scene.v.astype(precision))
    return build(scene, kernels)


def find_loss(model: Model, state: State, schedule: Schedule, memory: float):
    """A smooth function of the last frame, by three scales: of gravity, initial velocity and stiffness."""
    weight = jnp.asarray(np.random.default_rng(1).normal(size=state.x.shape), state.x.dtype)
    law = model.materials[0]

    def loss(scales):
        stiff = dataclasses.replace(law, mu=scales[2] * law.mu, lam=scales[2] * law.lam)
        changed = model.replace(gravity=scales[0] * model.gravity, materials=(stiff,))
        begun = dataclasses.replace(state, v=scales[1] * state.v)
        end = replay(changed, begun, schedule, memory=memory)[-1]
        return (end.x[:, 2] ** 2).mean() + 0.1 * (weight * end.x).mean() + 0.01 * (end.F[:, 0, 2] ** 2).mean()

    return loss


def _measure_cost(
    n: int, frames: int, steps: int, memory: float, aim: float | None, repeats: int
) -> list[Row]:
    model, state = make_cube(n, np.float32)
    frame_dt = steps * 1e-4
    run = dict(frame_count=frames + 1, frame_dt=frame_dt, substep_dt=1e-4)
    made = list(simulate(model, state, **run))
    schedule = Schedule.of(model, made)
    del made
    gradient = jax.value_and_grad(find_loss(model, state, schedule, memory))
    at = jnp.ones(3, state.x.dtype)

    def go_forward():
        for frame in simulate(model, state, **run):
            end = frame.state
        jax.block_until_ready(end.x)

    first = [_time(go_forward), _time(lambda: jax.block_until_ready(gradient(at)))]
    before = _reset_peak()
    pairs = [(_time(go_forward), _time(lambda: jax.block_until_ready(gradient(at)))) for _ in range(repeats)]
    peak = _read_memory("VmHWM")
    ratios = sorted(both / forward for forward, both in pairs)
    count = schedule.substeps
    row = {
        "particles": n,
        "substeps": count,
        "forward_ms": 1e3 * float(np.median([pair[0] for pair in pairs])) / count,
        "gradient_ms": 1e3 * float(np.median([pair[1] for pair in pairs])) / count,
        "ratio": float(np.median(ratios)),
        "ratio_range": [ratios[0], ratios[-1]],
        "aim": aim,
        "memory_gb": None if peak is None or before is None else (peak - before) / 1e9,
        "allowed_gb": memory / 1e9,
        "first_seconds": first,
    }
    harness.say(str(row))
    return [row]


def _measure_precision(count: int) -> list[Row]:
    particles = 1000
    with jax.enable_x64(True):
        model, state = make_cube(particles, np.float64, "reference")
        run = dict(frame_count=2, frame_dt=count * 2e-4, substep_dt=2e-4)
        schedule = Schedule.of(model, simulate(model, state, **run))
        loss = find_loss(model, state, schedule, 2e9)
        at, h = jnp.ones(3), 1e-5
        exact = np.asarray(jax.grad(loss)(at))
        step = h * np.eye(3)
        differences = np.array([(loss(at + e) - loss(at - e)) / (2 * h) for e in step])
    single, begun = make_cube(particles, np.float32)
    got = np.asarray(jax.grad(find_loss(single, begun, schedule, 2e9))(jnp.ones(3, jnp.float32)), np.float64)
    norm = float(np.linalg.norm(exact))
    row = {
        "particles": particles,
        "substeps": schedule.substeps,
        "cosine": float(got @ exact / (np.linalg.norm(got) * norm)),
        "error": float(np.linalg.norm(got - exact) / norm),
        "norm": norm,
        "difference_error": float(np.linalg.norm(differences - exact) / norm),
    }
    harness.say(str(row))
    return [row]


def _time(function) -> float:
    """Seconds of one call."""
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


def _reset_peak() -> float | None:
    """Memory of this process now, from which on its peak is counted [bytes]; None where the system does not tell."""
    try:
        _CLEAR.write_text("5")
    except OSError:
        return None
    return _read_memory("VmRSS")


def _read_memory(name: str) -> float | None:
    if not _STATUS.is_file():
        return None
    found = re.search(rf"{name}:\s+(\d+) kB", _STATUS.read_text())
    return 1024.0 * int(found[1]) if found else None


if __name__ == "__main__":
    sys.exit(main())
