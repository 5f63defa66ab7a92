"""Run time and memory of a gradient beside those of the plain simulation."""

from __future__ import annotations

import time

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks import harness
from benchmarks.gradients.cube import NEO_HOOKEAN, make_cube
from benchmarks.harness import Row
from benchmarks.peers.gradient import draw_weight, read_memory, reset_peak
from benchmarks.peers.ours_gradient import find_loss
from physagent_jax.mpm import Schedule, simulate

CASES = (  # particles, frames, substeps of a frame, memory of the reverse pass [bytes], aim: times the forward
    (20_000, 1, 200, 2e9, 5.0),
    (20_000, 50, 200, 2e9, 6.0),
    (200_000, 1, 100, 4e9, None),
)


def measure_cost(
    n: int, frames: int, steps: int, memory: float, aim: float | None, repeats: int,
    material: str = NEO_HOOKEAN,
) -> list[Row]:  # fmt: skip
    """The row of a case; arguments as in `CASES`."""
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


def _time(function) -> float:
    """Seconds of one call."""
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun
