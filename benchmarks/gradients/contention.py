"""Two threads against one beside other programs that keep all cores busy: they should not be slower.

    python -m benchmarks.gradients.contention [--busy 2] [--rounds 9]

The cube of `benchmarks.gradients` is simulated and differentiated, by turns with kernels of one thread and of several,
each in a process of its own. A round is one of each; the ratio of a round compares what ran within the same second.
"""

from __future__ import annotations

import contextlib
import dataclasses
import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
import tyro

WAYS = ("forward", "gradient")
DT = 1e-4  # [s]
_BUSY = "while True: pass"
_ready: dict[str, Any] = {}  # of a worker


@dataclasses.dataclass(frozen=True)
class Command:
    """Measure two threads against one beside busy programs."""

    busy: int = 2
    """Programs that do nothing but compute."""
    threads: int = 2
    """Threads that are held against one."""
    rounds: int = 9
    """Rounds of each way."""
    particles: int = 20_000
    """Particles of the cube."""
    steps: int = 50
    """Substeps of a timed run."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    with contextlib.ExitStack() as stack:
        workers = {
            count: stack.enter_context(make_worker(command.particles, command.steps, count))
            for count in (1, command.threads)
        }
        stack.enter_context(keep_busy(command.busy))
        for way in WAYS:
            pairs = [
                [workers[count].submit(run, way).result() for count in workers] for _ in range(command.rounds)
            ]
            print(describe(way, command, np.array(pairs)), flush=True)
    return 0


def describe(way: str, command: Command, seconds: np.ndarray) -> str:
    """A line of medians and the range of the ratio; ``seconds`` of one thread and of several, shape (rounds, 2)."""
    one, several = 1e3 * np.median(seconds, axis=0) / command.steps
    ratios = seconds[:, 1] / seconds[:, 0]
    return (
        f"{way}, {command.particles} particles, {command.busy} busy programs: "
        f"{command.threads} threads {several:.2f} ms per substep, one {one:.2f}; "
        f"ratio {np.median(ratios):.2f} ({ratios.min():.2f} to {ratios.max():.2f})"
    )


@contextlib.contextmanager
def keep_busy(count: int) -> Iterator[None]:
    """Let ``count`` programs compute within the ``with`` block."""
    programs = [subprocess.Popen([sys.executable, "-c", _BUSY]) for _ in range(count)]
    try:
        yield
    finally:
        for program in programs:
            program.kill()
            program.wait()


def make_worker(particles: int, steps: int, threads: int) -> ProcessPoolExecutor:
    """A process that has compiled both ways for kernels of ``threads`` threads."""
    context = multiprocessing.get_context("spawn")
    worker = ProcessPoolExecutor(1, context, _prepare, (particles, steps, threads))
    for way in WAYS:
        worker.submit(run, way).result()
    return worker


def run(way: str) -> float:
    """Seconds of one run in this worker."""
    begun = time.perf_counter()
    _ready[way]()
    return time.perf_counter() - begun


def _prepare(particles: int, steps: int, threads: int) -> None:
    os.environ["NUMBA_NUM_THREADS"] = str(threads)
    import jax
    import jax.numpy as jnp

    from benchmarks.gradients.cube import make_cube
    from benchmarks.peers.gradient import draw_weight
    from benchmarks.peers.ours_gradient import find_loss, make_schedule
    from physagent_jax.mpm import simulate

    model, state = make_cube(particles, np.float32)
    schedule = make_schedule(model, state, 1, steps, DT)
    gradient = jax.value_and_grad(find_loss(model, state, schedule, draw_weight(particles), 2e9))

    def go_forward() -> None:
        *_, end = simulate(model, state, frame_count=2, frame_dt=steps * DT, substep_dt=DT)
        jax.block_until_ready(end.state.x)

    _ready["forward"] = go_forward
    _ready["gradient"] = lambda: jax.block_until_ready(gradient(jnp.ones(3, jnp.float32)))


if __name__ == "__main__":
    sys.exit(main())
