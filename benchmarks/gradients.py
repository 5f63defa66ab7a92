"""`python -m benchmarks.gradients --json OUT [--markdown OUT] [--quick]`: what the gradient of a simulation costs.

The elastic cube that is dropped on a floor (`benchmarks.peers.drop`), eight particles per cell. "forward" is what the
product runs: `simulate`, with its window and kernels. "value and gradient" is `jax.value_and_grad` through `replay` of
its schedule, of a loss over the last frame, by gravity, the initial velocity and the stiffness. Both are timed in turn,
warm; first calls compile. Memory is what the process takes more at its peak. "precision" compares the gradient by the
kernels in single precision with that of the reference path in double precision. "peers" sets the same gradient by
Warp's tape and by Taichi's automatic differentiation beside it, each in a process of its own with as many cores; they
are looked for in the interpreter that the environment variable PEER_PYTHON names. "materials" and "growth" are cost and
precision of the other laws, return mappings and viscosity among them.
"""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
import tempfile
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
from benchmarks.peers.base import PYTHON_VARIABLE
from benchmarks.peers.drop import SIDE, SIZE, drop
from benchmarks.peers.gradient import CODES, draw_weight, read_memory, reset_peak
from benchmarks.peers.ours import build
from benchmarks.peers.ours_gradient import find_loss
from benchmarks.peers.scene import Material, PeerScene
from physagent_jax.mpm import Model, Schedule, State, cell_order, simulate

CASES = (  # particles, frames, substeps of a frame, memory of the reverse pass [bytes], aim: times the forward
    (20_000, 1, 200, 2e9, 5.0),
    (20_000, 50, 200, 2e9, 6.0),
    (200_000, 1, 100, 4e9, None),
)
HORIZONS = (10, 100, 1000)  # substeps
NEO_HOOKEAN = "neo-Hookean"
MATERIALS = {  # law, viscosity [Pa s]; E = 1e5 Pa, a fluid's K likewise
    "fixed corotated": (Material.JELLY, 0.0),
    "von Mises": (Material.METAL, 0.0),
    "Drucker-Prager": (Material.SAND, 0.0),
    "fluid": (Material.FLUID, 0.0),
    "viscous fluid": (Material.FLUID, 20.0),
    "Kelvin-Voigt": (Material.NEO_HOOKEAN, 20.0),
}
ROOT = Path(__file__).resolve().parents[1]
_MEANING = """What the gradient of a simulation costs, by `python -m benchmarks.gradients`. The elastic cube that the
codes are timed on, dropped on a floor, with eight particles per cell. *Forward* is what the product runs (`simulate`,
with its window and kernels); *value and gradient* is `jax.value_and_grad` through `replay` of its schedule, by gravity,
initial velocity and stiffness. Both in turn, warm; median and range of the ratio. *Memory* is what the process takes
more at its peak; *allowed* is what `replay` was given. *Precision*: the gradient by the kernels in single precision
against that of the reference path in double precision, of 1,000 particles, and that one against central differences.
*Peers*: the same scene, loss and unknowns by the automatic differentiation of Warp (kernels of the classical substep,
every substep's arrays on the tape) and of Taichi (as in DiffTaichi: nodes are filled again in reverse), each in
a process of its own with as many cores; Warp has one thread on a CPU. *Cosine* is between the gradients: the classical
stress form and MLS-MPM differ at this resolution. *Materials* and *growth* are cost and precision for the other laws:
the impact makes metal and sand yield, so that their gradients go through the return mapping.
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
MATERIAL_COLUMNS = {"material": lambda row: row["material"]} | COLUMNS
GROWTH = {"material": lambda row: row["material"]} | PRECISION
PEERS = {
    "code": lambda row: f"{row['code']}: {row['version']}",
    "cores": lambda row: str(row["cores"]),
    "particles": lambda row: f"{row['particles']:,}",
    "substeps": lambda row: str(row["substeps"]),
    "value and gradient [s]": lambda row: (
        f"{number(row['seconds'])} ({' to '.join(map(number, row['range']))})"
    ),
    "times ours": lambda row: number(row["ratio"]),
    "first call [s]": lambda row: number(row["first_seconds"]),
    "memory [GB]": lambda row: number(row["memory_gb"]),
    "cosine with ours": lambda row: f"{row['cosine']:.4f}",
}

TABLES = {
    "cost": COLUMNS,
    "precision": PRECISION,
    "peers": PEERS,
    "materials": MATERIAL_COLUMNS,
    "growth": GROWTH,
}
PARTS = ("cost", "precision", "peers", "materials", "growth")


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure what gradients cost, and how exact they are."""

    parts: tuple[Literal["cost", "precision", "peers", "materials", "growth"], ...] = PARTS
    """Which to measure."""
    repeats: int = 3
    """Timed pairs; quick: one."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    parts = {
        "cost": lambda: _list_costs(command),
        "precision": lambda: _list_precisions(command),
        "peers": lambda: _list_peers(command),
        "materials": lambda: _list_materials(command),
        "growth": lambda: _list_growth(command),
    }
    return harness.main(command, parts, document)


def document(result: dict, json_path: Path, target: Path) -> str:
    """The tables as Markdown."""
    text = f"# Gradients\n\n{_MEANING}\nEvery row is in [{json_path.name}]({link(json_path, target)}).\n"
    text += provenance(result, PARTS)
    for part, columns in TABLES.items():
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


def _list_materials(command: Command) -> list[Job]:
    n, steps, repeats = (2_000, 20, 1) if command.quick else (20_000, 200, command.repeats)
    return [Job(f"{name}, {n} x {steps}", partial(_measure_cost, n, 1, steps, 2e9, None, repeats, name))
            for name in MATERIALS]  # fmt: skip


def _list_growth(command: Command) -> list[Job]:
    horizons = HORIZONS[:1] if command.quick else HORIZONS
    return [
        Job(f"{name}, {count} substeps", partial(_measure_precision, count, name))
        for name in MATERIALS
        for count in horizons
    ]


def _list_peers(command: Command) -> list[Job]:
    """One job, so that ratios are within a run."""
    particles, steps, cores = (500, 10, (1,)) if command.quick else (20_000, 200, (2, 1))
    repeats = 1 if command.quick else command.repeats
    return [Job(f"{n} core(s)", partial(_measure_peers, particles, steps, n, repeats)) for n in cores]


def _measure_peers(particles: int, steps: int, cores: int, repeats: int) -> list[Row]:
    """Ours and the peers' that are there, one after another."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        stored = Path(folder) / "scene.npz"
        make_scene(particles).save(stored)
        for code in CODES:
            python = sys.executable if code == "ours" else os.environ.get(PYTHON_VARIABLE, sys.executable)
            command = [
                python,
                "-m",
                "benchmarks.peers.gradient",
                "--code",
                code,
                "--scene",
                str(stored),
                "--dt",
                "1e-4",
            ]
            command += ["--steps", str(steps), "--repeats", str(repeats), "--threads", str(cores)]
            done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
            if done.returncode != 0:
                harness.say(f"{code} is left out: {(done.stderr or done.stdout).strip().splitlines()[-1]}")
                continue
            rows.append(json.loads(done.stdout.strip().splitlines()[-1]))
    ours = rows[0]
    for row in rows:
        seconds = row.pop("seconds")
        row |= {"seconds": float(np.median(seconds)), "range": [min(seconds), max(seconds)], "cores": cores}
        row |= {"particles": particles, "substeps": steps, "ratio": row["seconds"] / ours["seconds"]}
        a, b = np.asarray(row["gradient"]), np.asarray(ours["gradient"])
        row["cosine"] = float(a @ b / np.sqrt((a @ a) * (b @ b)))
        harness.say(str(row))
    return rows


def make_scene(particles: int, material: Material = Material.NEO_HOOKEAN) -> PeerScene:
    """The cube above the floor, eight particles in a cell."""
    cells = round(SIZE / (SIDE * (8 / particles) ** (1 / 3)))
    scene = drop(particles, Material.NEO_HOOKEAN, cells)
    return dataclasses.replace(scene, material=material, bulk_modulus=scene.youngs_modulus)


def make_cube(
    particles: int, precision: Any, kernels: str = "auto", material: str = NEO_HOOKEAN
) -> tuple[Model, State]:
    """The cube above the floor, its particles sorted, eight in a cell."""
    law, viscosity = MATERIALS.get(material, (Material.NEO_HOOKEAN, 0.0))
    scene = make_scene(particles, law)
    scene = scene.take(cell_order(scene.x, scene.dx))
    scene = dataclasses.replace(scene, x=scene.x.astype(precision), v=scene.v.astype(precision))
    model, state = build(scene, kernels)
    if viscosity:
        model = model.replace(viscosity=jnp.full(particles, viscosity, precision))
    return model, state


def _measure_cost(
    n: int, frames: int, steps: int, memory: float, aim: float | None, repeats: int,
    material: str = NEO_HOOKEAN,
) -> list[Row]:  # fmt: skip
    model, state = make_cube(n, np.float32, material=material)
    frame_dt = steps * 1e-4
    run = dict(frame_count=frames + 1, frame_dt=frame_dt, substep_dt=1e-4)
    made = list(simulate(model, state, **run))
    schedule = Schedule.of(model, made)
    del made
    gradient = jax.value_and_grad(find_loss(model, state, schedule, draw_weight(n), memory))
    at = jnp.ones(3, state.x.dtype)

    def go_forward():
        for frame in simulate(model, state, **run):
            end = frame.state
        jax.block_until_ready(end.x)

    first = [_time(go_forward), _time(lambda: jax.block_until_ready(gradient(at)))]
    before = reset_peak()
    pairs = [(_time(go_forward), _time(lambda: jax.block_until_ready(gradient(at)))) for _ in range(repeats)]
    peak = read_memory("VmHWM")
    ratios = sorted(both / forward for forward, both in pairs)
    count = schedule.substeps
    row = {
        "material": material,
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


def _measure_precision(count: int, material: str = NEO_HOOKEAN) -> list[Row]:
    particles = 1000
    with jax.enable_x64(True):
        model, state = make_cube(particles, np.float64, "reference", material)
        run = dict(frame_count=2, frame_dt=count * 2e-4, substep_dt=2e-4)
        schedule = Schedule.of(model, simulate(model, state, **run))
        loss = find_loss(model, state, schedule, draw_weight(particles), 2e9)
        at, h = jnp.ones(3), 1e-5
        exact = np.asarray(jax.grad(loss)(at))
        step = h * np.eye(3)
        differences = np.array([(loss(at + e) - loss(at - e)) / (2 * h) for e in step])
    single, begun = make_cube(particles, np.float32, material=material)
    got = np.asarray(
        jax.grad(find_loss(single, begun, schedule, draw_weight(particles), 2e9))(jnp.ones(3, jnp.float32)),
        np.float64,
    )
    norm = float(np.linalg.norm(exact))
    row = {
        "material": material,
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


if __name__ == "__main__":
    sys.exit(main())
