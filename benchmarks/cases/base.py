"""Cases, and their runs on our simulator or on a peer.

A case makes a `Problem` (particles, model, step, what to watch), any simulator that can move particles turns it
into a `Signal` (what was watched, over time, with the wall time it took), and the case judges the signal against
its exact answer.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from typing import Literal, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from scipy.optimize import curve_fit

from physagent_jax.mpm import Lumped, Model, Sharpened, State, stable_dt, step

AGGREGATED = Lumped(aggregation=0.5)
"""Lumped masses of which light ones follow their neighbours, at the strength that is studied."""


@dataclasses.dataclass(frozen=True)
class Numerics:
    """Numerics of a case, which a work-precision study varies.

    Attributes:
        resolution: Cells along the case's own length (each case says which); None = the case's default.
        step: ("courant", c): dt = c dx / c_p; ("bound", s): s times the closed-form bound; ("fixed", dt) [s].
        transfer, inertia, rpic_damping, stress_form: As `Model` has them.
        dtype: np.float32 or np.float64 (which needs x64 enabled).
        per_axis: Particles per cell and axis.
    """

    resolution: int | None = None
    step: tuple[Literal["courant", "bound", "fixed"], float] = ("courant", 0.3)
    transfer: Literal["apic", "pic"] = "apic"
    inertia: Lumped | Sharpened = Lumped()
    rpic_damping: float = 0.0
    stress_form: Literal["mls", "gradient"] = "mls"
    dtype: type = np.float32
    per_axis: int = 2

    def finish(self, model: Model, state: State, sound_speed: float) -> Model:
        """``model`` with these transfers, and the substep of this rule; ``sound_speed`` is c_p [m/s]."""
        model = model.replace(
            transfer=self.transfer,
            inertia=self.inertia,
            rpic_damping=self.rpic_damping,
            stress_form=self.stress_form,
        )
        rule, value = self.step
        if rule == "courant":
            dt = value * model.grid.dx / sound_speed
        elif rule == "bound":
            dt = value * float(stable_dt(model, state))
        else:
            dt = value
        return model.replace(dt=jnp.asarray(dt, self.dtype))


@dataclasses.dataclass(frozen=True)
class Problem:
    """A case ready to run.

    Attributes:
        model, state: With ``model.dt`` set and a grid window that covers the whole motion.
        steps: Substeps in all; a multiple of ``every``.
        every: Substeps between samples.
        observe: (x, v, C, F) -> a vector of what is watched, shape (k,). Arrays are jax's or numpy's.
        exact: Whatever `Case.judge` needs of the problem.
    """

    model: Model
    state: State
    steps: int
    every: int
    observe: Callable[..., jax.Array]
    exact: dict

    @property
    def dt(self) -> float:
        """Substep [s]."""
        return float(self.model.dt)


@dataclasses.dataclass(frozen=True)
class Signal:
    """Watched values: ``t`` [s] of shape (s,), ``values`` of shape (s, k), without the initial state.

    Attributes:
        walls: Wall time of each run, compilation excluded [s].
        compile: Wall time of compilation [s].
        final: The last x, v, C, F.
    """

    t: np.ndarray
    values: np.ndarray
    walls: tuple[float, ...]
    compile: float
    final: tuple


class Case(Protocol):
    """A problem with a known answer.

    Attributes:
        name: For tables and file names.
        title: One line: what moves, and what is measured.
        source: Where the exact answer comes from.
        resolutions: Cells along the case's length worth trying, coarse to fine.
    """

    @property
    def name(self) -> str: ...  # noqa: D102  (see Attributes)

    @property
    def title(self) -> str: ...  # noqa: D102

    @property
    def source(self) -> str: ...  # noqa: D102

    @property
    def resolutions(self) -> tuple[int, ...]: ...  # noqa: D102

    def problem(self, numerics: Numerics) -> Problem:
        """Particles and model."""
        ...

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Errors by name, relative unless the name says otherwise, signed where the sign means something."""
        ...

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """The largest acceptable size of each error."""
        ...


def run(problem: Problem, repeats: int = 1, seconds: float = 0.0) -> Signal:
    """Run a problem on our simulator; the first run is compiled beforehand.

    ``repeats`` of them are timed, or as many as take ``seconds`` together, but 25 at most.
    """

    def sample(state, _):
        state = jax.lax.fori_loop(0, problem.every, lambda _, s: step(problem.model, s), state)
        return state, problem.observe(state.x, state.v, state.C, state.F)

    def roll(state):
        return jax.lax.scan(sample, state, None, length=problem.steps // problem.every)

    begun = time.perf_counter()
    compiled = jax.jit(roll).lower(problem.state).compile()
    compile_seconds, walls = time.perf_counter() - begun, []
    while len(walls) < repeats or sum(walls) < seconds and len(walls) < 25:
        begun = time.perf_counter()
        state, values = jax.block_until_ready(compiled(problem.state))
        walls.append(time.perf_counter() - begun)
    values = np.asarray(values, np.float64)
    t = problem.dt * problem.every * (1 + np.arange(len(values)))
    final = tuple(np.asarray(leaf) for leaf in (state.x, state.v, state.C, state.F))
    return Signal(t, values.reshape(len(values), -1), tuple(walls), compile_seconds, final)


def check(case: Case, numerics: Numerics) -> dict[str, float]:
    """Run ``case`` and raise AssertionError if an error exceeds its bar; return the errors."""
    problem = case.problem(numerics)
    errors = case.judge(problem, run(problem))
    for name, bar in case.bars(numerics).items():
        assert abs(errors[name]) <= bar, f"{case.name}: |{name}| = {abs(errors[name]):.4g} exceeds {bar:.4g}"
    return errors


def lattice(cells, dx: float, low, per_axis: int = 2) -> np.ndarray:
    """``per_axis``**3 particles per cell in a box of ``cells`` cells with low corner ``low`` [m], shape (n, 3)."""
    axes = [(np.arange(count * per_axis) + 0.5) * dx / per_axis for count in cells]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3) + np.asarray(low)


def observed_steps(duration: float, dt: float, samples: int) -> tuple[int, int]:
    """(steps, every): about ``samples`` evenly spaced samples that cover ``duration`` [s]."""
    every = max(1, int(duration / dt / samples))
    return max(1, int(np.ceil(duration / dt / every))) * every, every


def fit_damped_cosine(t: np.ndarray, y: np.ndarray, frequency: float) -> tuple[float, float]:
    """Frequency [Hz] and decay rate [1/s] of a e^(-d t) cos(2 pi f t + phase), fitted from a first guess."""

    def model(t, amplitude, f, decay, phase):
        return amplitude * np.exp(-decay * t) * np.cos(2 * np.pi * f * t + phase)

    scale = np.abs(y).max()
    fitted, _ = curve_fit(model, t, y / scale, p0=[1.0, frequency, 0.01 * frequency, 0.0], maxfev=20_000)
    return float(fitted[1]), float(fitted[2])


def cosine_deviation(
    t: np.ndarray, y: np.ndarray, start: float, frequency: float, periods: float = 2.0
) -> float:
    """RMS of y from start cos(2 pi f t) over the first periods, relative to the cosine's own RMS.

    Unlike the fitted frequency it counts damping too: what an observer of the motion would call its error. Velocities
    belong to half a substep before the end of a step: shift ``t`` accordingly.
    """
    seen = t <= periods / frequency
    exact = start * np.cos(2 * np.pi * frequency * t[seen])
    return float(np.sqrt(np.mean((y[seen] - exact) ** 2) / np.mean(exact**2)))
