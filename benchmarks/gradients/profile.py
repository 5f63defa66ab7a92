"""Profile of a substep and its reverse, beside the least that the machine must do for them.

Each stage of `mpm.step` and its derivative is jitted alone on the cube's state. The floor is counted, not timed: bytes
are the arrays that a stage must read and write once, operations those that XLA counts in the stage of the reference
path; they are divided by the bandwidth of a copy and by the operations per second of a matrix product, both measured
here with the same cores, the copy on arrays as large as what a stage moves: 20,000 particles fit into caches. The floor
is the larger of the two: no code can be faster, and one that gathers and scatters cannot reach it.
"""

from __future__ import annotations

import dataclasses
import importlib
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks import harness
from benchmarks.gradients.cube import make_cube
from benchmarks.harness import Row
from benchmarks.peers.gradient import draw_weight
from benchmarks.peers.ours_gradient import find_loss, make_schedule
from physagent_jax.mpm import Model, Schedule, State, simulate
from physagent_jax.mpm.grid_update import update_grid

DT = 1e-4  # [s]
PROFILED = ((20_000, 200), (200_000, 50))  # particles, substeps of the whole that stages are held against


@dataclasses.dataclass(frozen=True)
class Machine:
    """Best rates of this machine.

    Attributes:
        bandwidth: Bandwidth of a copy, read and write together [bytes/s].
        operations: Rate of a matrix product in single precision [1/s].
    """

    bandwidth: float
    operations: float

    def find_floor(self, size: float, operations: float) -> float:
        """Least milliseconds for so many bytes and operations."""
        return 1e3 * max(size / self.bandwidth, operations / self.operations)


def measure_machine(size: float, repeats: int, side: int = 2048) -> Machine:
    """Copy half of ``size`` bytes into the other half, and multiply matrices of ``side`` rows."""
    values = jnp.arange(int(size / 8), dtype=jnp.float32)
    copy = jax.jit(lambda a: a + 1)
    matrix = jnp.ones((side, side), jnp.float32)
    product = jax.jit(lambda a: a @ a)
    copied = min(_list_times(copy, (values,), 10 * repeats))
    multiplied = min(_list_times(product, (matrix,), repeats))
    return Machine(8 * len(values) / copied, 2 * side**3 / multiplied)


def measure_profile(particles: int, steps: int, repeats: int) -> list[Row]:
    """A row per stage, one for what is between them, and one for all."""
    model, state = make_cube(particles, np.float32)
    schedule = make_schedule(model, state, 1, steps, DT)
    model = model.replace(grid=schedule.frames[0].grid, dt=jnp.float32(DT))
    stages, references = (list_stages(each, state) for each in (model, model.replace(kernels="reference")))
    most = max(count_bytes(*reverse(stage, arguments)) for _, stage, arguments in stages)
    machine, rows = measure_machine(most, repeats), []
    for (name, stage, arguments), (_, reference, _) in zip(stages, references):
        row: Row = {"stage": name, "particles": particles}
        for way, make in (("forward", _keep), ("reverse", reverse)):
            size, operations = (
                count_bytes(*make(stage, arguments)),
                count_operations(*make(reference, arguments)),
            )
            function, given = make(stage, arguments)
            row |= {
                f"{way}_ms": 1e3 * _time_call(jax.jit(function), given, repeats),
                f"{way}_bytes": size,
                f"{way}_operations": operations,
                f"{way}_floor_ms": machine.find_floor(size, operations),
            }
        rows.append(row)
    forward, both = _time_all(particles, steps, schedule, repeats)
    counted = ("forward_floor_ms", "reverse_floor_ms", "forward_ms", "reverse_ms")
    sums: dict[str, float] = {key: sum(row[key] for row in rows) for key in counted}
    rows.append({"stage": "sum of the stages", "particles": particles, **sums})
    rows.append(
        {
            "stage": "substep, as it runs",
            "particles": particles,
            "forward_ms": forward,
            "reverse_ms": both - forward,
            "forward_floor_ms": sums["forward_floor_ms"],
            "reverse_floor_ms": sums["reverse_floor_ms"],
        }
    )
    for row in rows:
        row |= {"bandwidth": machine.bandwidth, "operations_per_second": machine.operations}
        harness.say(str(row))
    return rows


def list_stages(model: Model, state: State) -> list[tuple[str, Callable, tuple]]:
    """Name, function and arguments of each stage, on this state and what the stages before make of it."""
    step: Any = importlib.import_module("physagent_jax.mpm.step")  # its name in the package is the function's

    def p2g(x, v, C, F, mass):
        moved = dataclasses.replace(state, x=x, v=v, C=C, F=F)
        heavy = model.replace(mass=mass)
        return step.scatter(heavy, moved, moved, step.kirchhoff_stress(heavy, moved))[0]

    def update_nodes(nodes):
        return update_grid(model, state, nodes)[-1]

    def g2p(x, F, velocity):
        moved = step.gather(model, dataclasses.replace(state, x=x, F=F), velocity)
        return moved.x, moved.v, moved.C, moved.F

    particles = state.x, state.v, state.C, state.F, model.mass
    nodes = jax.jit(p2g)(*particles)
    velocity = jax.jit(update_nodes)(nodes)
    return [
        ("p2g with the stress", p2g, particles),
        ("grid update", update_nodes, (nodes,)),
        ("g2p", g2p, (state.x, state.F, velocity)),
    ]


def reverse(function: Callable, arguments: tuple) -> tuple[Callable, tuple]:
    """The derivative by ``arguments``, and its own arguments: those, and a derivative by all that comes out."""

    def pull(bars, *arguments):
        return jax.vjp(function, *arguments)[1](bars)

    bars = jax.tree.map(lambda leaf: jnp.ones(leaf.shape, leaf.dtype), jax.eval_shape(function, *arguments))
    return pull, (bars, *arguments)


def _keep(function: Callable, arguments: tuple) -> tuple[Callable, tuple]:
    return function, arguments


def count_bytes(function: Callable, arguments: tuple) -> float:
    """Of what goes in and what comes out, each once."""
    leaves = jax.tree.leaves((arguments, jax.eval_shape(function, *arguments)))
    return float(sum(leaf.size * leaf.dtype.itemsize for leaf in leaves))


def count_operations(function: Callable, arguments: tuple) -> float:
    """As XLA counts them; what nobody reads is not computed."""
    counted: Any = jax.jit(function).lower(*arguments).compile().cost_analysis()
    return float(counted["flops"])


def _time_all(particles: int, steps: int, schedule: Schedule, repeats: int) -> tuple[float, float]:
    """Milliseconds per substep of the plain simulation, and of the value with its gradient."""
    model, state = make_cube(particles, np.float32)
    gradient = jax.value_and_grad(find_loss(model, state, schedule, draw_weight(particles), 2e9))

    def go_forward():
        made = simulate(model, state, frame_count=2, frame_dt=steps * DT, substep_dt=DT)
        return [frame.state.x for frame in made]

    at = (jnp.ones(3, jnp.float32),)
    return (
        1e3 * _time_call(go_forward, (), repeats) / steps,
        1e3 * _time_call(gradient, at, repeats) / steps,
    )


def _time_call(function: Callable, arguments: tuple, repeats: int) -> float:
    """Median seconds of a warm call."""
    return float(np.median(_list_times(function, arguments, repeats)))


def _list_times(function: Callable, arguments: tuple, repeats: int) -> list[float]:
    jax.block_until_ready(function(*arguments))
    seconds = []
    for _ in range(repeats):
        begun = time.perf_counter()
        jax.block_until_ready(function(*arguments))
        seconds.append(time.perf_counter() - begun)
    return seconds
