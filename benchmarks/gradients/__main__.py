"""`python -m benchmarks.gradients [--json OUT] [--markdown OUT] [--quick]`: what the gradient of a simulation costs.

The elastic cube that is dropped on a floor (`benchmarks.peers.drop`), eight particles per cell. "forward" is what the
product runs: `simulate`, with its window and kernels. "value and gradient" is `jax.value_and_grad` through `replay` of
its schedule, of a loss over the last frame, by gravity, the initial velocity and the stiffness. Both are timed in turn,
warm; first calls compile. Memory is what the process takes more at its peak. "precision" compares the gradient by the
kernels in single precision with that of the reference path in double precision. "peers" sets the same gradient by
Warp's tape and by Taichi's automatic differentiation beside it, each in a process of its own with as many cores; they
are looked for in the interpreter that the environment variable PEER_PYTHON names. "materials" and "growth" are cost
and precision of the other laws, return mappings and viscosity among them. "profile" times the stages of a substep and
of its reverse, beside a counted floor.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.gradients.cost import CASES, measure_cost
from benchmarks.gradients.cube import MATERIALS
from benchmarks.gradients.markdown import PAGE, PARTS
from benchmarks.gradients.peers import ORDERS, ROUNDS, measure_peers
from benchmarks.gradients.precision import HORIZONS, measure_precision
from benchmarks.gradients.profile import PROFILED, measure_profile
from benchmarks.harness import RAW, Job


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure what gradients cost, and how exact they are."""

    json: Path = RAW / "gradients.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["cost", "precision", "peers", "materials", "growth", "profile"], ...] = PARTS
    """Parts to measure."""
    repeats: int = 3
    """Timed pairs; quick: one."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    parts = {
        "cost": lambda: _list_costs(command),
        "precision": lambda: _list_precisions(command),
        "peers": lambda: _list_peers(command),
        "materials": lambda: _list_materials(command),
        "growth": lambda: _list_growth(command),
        "profile": lambda: _list_profiles(command),
    }
    return harness.main(command, parts, PAGE)


def _list_costs(command: Command) -> list[Job]:
    cases = ((2_000, 1, 20, 2e9, None),) if command.quick else CASES
    repeats = 1 if command.quick else command.repeats
    return [Job(f"{n} x {frames * steps}", partial(measure_cost, n, frames, steps, memory, aim, repeats))
            for n, frames, steps, memory, aim in cases]  # fmt: skip


def _list_precisions(command: Command) -> list[Job]:
    horizons = HORIZONS[:1] if command.quick else HORIZONS
    return [Job(f"{count} substeps", partial(measure_precision, count)) for count in horizons]


def _list_materials(command: Command) -> list[Job]:
    n, steps, repeats = (2_000, 20, 1) if command.quick else (20_000, 200, command.repeats)
    return [Job(f"{name}, {n} x {steps}", partial(measure_cost, n, 1, steps, 2e9, None, repeats, name))
            for name in MATERIALS]  # fmt: skip


def _list_growth(command: Command) -> list[Job]:
    horizons = HORIZONS[:1] if command.quick else HORIZONS
    return [
        Job(f"{name}, {count} substeps", partial(measure_precision, count, name))
        for name in MATERIALS
        for count in horizons
    ]


def _list_peers(command: Command) -> list[Job]:
    """All codes in one job, so that ratios are within a run."""
    particles, steps, cores = (500, 10, (1,)) if command.quick else (20_000, 200, (2, 1))
    repeats, rounds = (1, 1) if command.quick else (command.repeats, ROUNDS)
    return [Job(f"{n} core(s), {order}", partial(measure_peers, particles, steps, n, order, repeats, rounds))
            for order in ORDERS for n in cores]  # fmt: skip


def _list_profiles(command: Command) -> list[Job]:
    cases = ((2_000, 20),) if command.quick else PROFILED
    repeats = 3 if command.quick else 10 * command.repeats
    return [Job(f"{n} particles", partial(measure_profile, n, steps, repeats)) for n, steps in cases]


if __name__ == "__main__":
    sys.exit(main())
