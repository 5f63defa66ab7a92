"""Choices of which both ways are right: precision and the length of the step, with their errors."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.cases.bar import FreeBar
from benchmarks.cases.base import Numerics, cosine_deviation
from benchmarks.skipping.base import Answer, Pair, Sizes, Skip, State, Way
from benchmarks.skipping.scene import cube, rolled
from physagent_jax.mpm import simulate, stable_dt
from physagent_jax.mpm.timestep import SAFETY, divide_frame

PERIODS = 2  # of the bar's first mode
CELLS = 16  # along the bar
FRAME_DT = 0.02  # an eighth of a period [s]
SIGNAL_BAR = 0.1  # largest deviation of the automatic step's signal from the cosine, both as root mean square


def _compare_precision(sizes: Sizes) -> Pair:
    step = float(cube(sizes)[0].dt)  # float32's own, for both

    def way(dtype: Any) -> Way:
        double = partial(jax.enable_x64, dtype is np.float64)
        with double():
            model, state = cube(sizes, dtype=dtype)
            rolling = rolled(model.replace(dt=jnp.asarray(step, dtype)), state, sizes.substeps)

        def run():
            with double():
                return jax.block_until_ready(rolling.run())

        def read(result) -> Answer:
            with double():
                return rolling.read(result)

        return Way(run, read)

    return Pair(way(np.float32), way(np.float64), sizes.particles, sizes.substeps)


def _compare_with_fixed(dt: float) -> Callable[[Sizes], Pair]:
    """The bar with the automatic step, against the same with ``dt`` [s]."""

    def build(sizes: Sizes) -> Pair:
        problem = FreeBar().problem(Numerics(resolution=CELLS, per_axis=sizes.bar_per_axis))
        frequency, start = problem.exact["f"], problem.exact["start"]
        frames = int(np.ceil(PERIODS / frequency / FRAME_DT))

        def way(substep_dt: float | None) -> Way:
            def run() -> list[tuple[float, float]]:
                """Times that velocities belong to, half a substep before those of positions; the signal there."""
                rows = []
                clip = dict(frame_count=frames + 1, frame_dt=FRAME_DT, substep_dt=substep_dt, safety=SAFETY)
                for frame in simulate(problem.model, problem.state, **clip):
                    state = frame.state
                    seen = problem.observe(state.x, state.v, state.C, state.F)
                    rows.append((float(state.time) - frame.dt / 2, float(seen)))
                return rows[1:]

            def read(rows) -> Answer:
                t, seen = np.array(rows).T
                return {"error": cosine_deviation(t, seen, start, frequency, PERIODS)}

            return Way(run, read)

        automatic = divide_frame(FRAME_DT, SAFETY * float(stable_dt(problem.model, problem.state)))
        note = f"{automatic} against {divide_frame(FRAME_DT, dt)} substeps per frame of {FRAME_DT:g} s"
        return Pair(way(None), way(dt), len(problem.state.x), unit="clip", note=note)

    return build


SKIPS = (
    Skip(
        "float32",
        "half of every number's bits",
        "float64 from the same start; the difference is the error of float32",
        _compare_precision,
        State.CHOICE,
        tolerance=2e-5,
        reason="float32 resolves 1e-7, which each substep adds",
    ),
    *(
        Skip(
            f"automatic step against {dt:g} s",
            f"substeps that stability does not need: the step is {SAFETY:g} times the closed-form bound",
            f"a fixed step of {dt:g} s. Free elastic bar, {PERIODS} periods of its first mode by `mpm.simulate`; "
            "errors are the root mean square of the signal's deviation from the exact cosine, over the cosine's own",
            _compare_with_fixed(dt),
            State.CHOICE,
            tolerance=SIGNAL_BAR,
            reason="bar on the error of the automatic step",
            errors=True,
        )
        for dt in (2e-4, 1e-4)
    ),
)
