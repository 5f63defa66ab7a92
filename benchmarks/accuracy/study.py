"""Numerics that are compared, and one row per run."""

from __future__ import annotations

import contextlib
import dataclasses
import gc
from collections.abc import Iterator

import jax
import numpy as np

from benchmarks.cases.base import AGGREGATED, Case, Numerics, Problem, run
from benchmarks.cases.cantilever import Cantilever
from physagent_jax.mpm import Lumped, Sharpened, stable_dt

REFERENCE_DT = 2e-4  # [s]; PhysGaussian's and the paper's usual substep
NEAR_BOUND = ("bound", 0.9)
FIXED = (0.15, 0.18, 0.216)  # strengths of sharpened increments that are tried
DENSITIES = (2, 3, 4)  # particles per cell and axis
AGGREGATIONS = (0.0, 0.3, AGGREGATED.aggregation, 0.7)
SHARPENED = ", sharpened"  # ends the label of runs with `mpm.inertia.Sharpened`
QUADRATURE_CASE, QUADRATURE_ERROR = Cantilever(), "tip drop"


@dataclasses.dataclass(frozen=True)
class Row:
    """One run of one case.

    Attributes:
        case, code: Names.
        label: What distinguishes the numerics, in words.
        resolution: Cells along the case's length.
        particles, steps: Sizes.
        dt, dt_over_bound: Substep [s], and over the MLS bound of the isolated particle.
        wall, compile: Wall time of the run (the median of several) and of compilation [s].
        wall_range: The shortest and the longest run [s]; empty if it failed.
        errors: By name.
        bars: Largest acceptable errors; empty where the numerics are not the ones they hold for.
        reference: Whether this is the fixed step of 2e-4 s.
        failed: Why there is no result; empty if there is.
    """

    case: str
    code: str
    label: str
    resolution: int
    particles: int
    steps: int
    dt: float
    dt_over_bound: float
    wall: float
    wall_range: tuple[float, ...]
    compile: float
    errors: dict[str, float]
    bars: dict[str, float]
    reference: bool = False
    failed: str = ""

    @property
    def within(self) -> bool:
        """Return whether every error that has a bar is within it."""
        return not self.failed and all(abs(self.errors[name]) <= bar for name, bar in self.bars.items())


def work_precision(resolutions: tuple[int, ...], base: Numerics) -> Iterator[tuple[str, Numerics]]:
    """(label, numerics) to compare: dt policies and inertia at every resolution, the rest at the middle one."""
    for resolution in resolutions:
        for rule in (NEAR_BOUND, ("bound", 0.45), ("fixed", REFERENCE_DT)):
            numerics = dataclasses.replace(base, resolution=resolution, step=rule)
            yield rule_words(rule), numerics
            if rule[0] == "bound":
                yield rule_words(rule) + SHARPENED, dataclasses.replace(numerics, inertia=Sharpened())
    middle = resolutions[len(resolutions) // 2]
    base = dataclasses.replace(base, resolution=middle, step=NEAR_BOUND)
    yield "classical stress form", dataclasses.replace(base, stress_form="gradient")
    yield "RPIC 0.5", dataclasses.replace(base, rpic_damping=0.5)
    yield "PIC", dataclasses.replace(base, transfer="pic")
    yield "float64", dataclasses.replace(base, dtype=np.float64)


def strengths(case: Case, base: Numerics) -> Iterator[tuple[str, Numerics]]:
    """(label, numerics) that differ in the strength of sharpened increments, one of which follows the step."""
    for rule in (NEAR_BOUND, ("bound", 0.45)):
        numerics = dataclasses.replace(base, step=rule)
        follows = 0.216 - _find_courant(case.problem(numerics)) ** 2 / 12
        for name, beta in (*((f"{beta:g}", beta) for beta in FIXED), ("follows the step", follows)):
            yield f"{rule_words(rule)}: {name}", dataclasses.replace(numerics, inertia=Sharpened(beta))


def _find_courant(problem: Problem) -> float:
    """The Courant number c_p dt / dx of a problem of one elastic material."""
    model, (law, *_) = problem.model, problem.model.materials
    stiffness, density = np.asarray(law.lam + 2 * law.mu), np.asarray(model.mass / model.volume)
    return float(np.sqrt(stiffness / density).max()) * problem.dt / model.grid.dx


def quadrature(resolutions: tuple[int, ...]) -> Iterator[Numerics]:
    """Numerics that differ in how densely particles lie, for `QUADRATURE_CASE`."""
    for resolution in resolutions:
        for step in (("courant", 0.3), NEAR_BOUND):
            for form in ("mls", "gradient"):
                for inertia in (Lumped(), AGGREGATED):
                    for per_axis in DENSITIES:
                        yield Numerics(resolution, step, inertia=inertia, stress_form=form, per_axis=per_axis)


def aggregations(base: Numerics) -> Iterator[tuple[str, Numerics]]:
    """(label, numerics) that differ in which nodes of a free surface follow their neighbours."""
    for aggregation in AGGREGATIONS:
        yield f"{aggregation:g}", dataclasses.replace(base, inertia=Lumped(aggregation))


def rule_words(rule: tuple[str, float]) -> str:
    """A step rule in words."""
    kind, value = rule
    if kind == "bound":
        return f"{value:g} x bound"
    return f"fixed {value:g} s" if kind == "fixed" else f"Courant {value:g}"


@contextlib.contextmanager
def precision(dtype):
    """Double precision where it is asked for."""
    with jax.enable_x64(dtype is np.float64):
        yield


def ours(case: Case, label: str, numerics: Numerics, *, repeats: int = 1, judged: bool = False) -> Row:
    """One run of our simulator; a run that breaks down gives a row that says so."""
    with precision(numerics.dtype):
        problem = case.problem(numerics)
        signal = run(problem, repeats, seconds=1.0 if repeats > 1 else 0.0)
        finite = bool(np.isfinite(signal.values).all())
        errors, failed = ({}, "not finite")
        if finite:
            errors, failed = judge(case, problem, signal)
        row = row_of(case, "ours", label, problem, numerics, signal.walls, signal.compile, errors, failed)
        if judged and not failed:
            row = dataclasses.replace(row, bars=case.bars(numerics))
    jax.clear_caches()
    gc.collect()
    return row


def judge(case: Case, problem: Problem, signal) -> tuple[dict[str, float], str]:
    """Errors, or why there are none: a wildly wrong signal may not be measurable at all."""
    try:
        return case.judge(problem, signal), ""
    except (RuntimeError, ValueError) as error:
        return {}, f"cannot be measured: {error}"


def row_of(
    case: Case,
    code: str,
    label: str,
    problem: Problem,
    numerics: Numerics,
    walls: tuple[float, ...],
    compile_seconds: float,
    errors: dict[str, float],
    failed: str,
) -> Row:
    """A row, with the figures that the problem itself tells."""
    mls = problem.model.replace(stress_form="mls")
    return Row(
        case=case.name,
        code=code,
        label=label,
        resolution=numerics.resolution or case.resolutions[len(case.resolutions) // 2],
        particles=int(problem.model.mass.shape[0]),
        steps=problem.steps,
        dt=problem.dt,
        dt_over_bound=problem.dt / float(stable_dt(mls, problem.state)),
        wall=float(np.median(walls)) if walls else float("nan"),
        wall_range=(min(walls), max(walls)) if walls else (),
        compile=compile_seconds,
        errors=errors,
        bars={},
        reference=numerics.step == ("fixed", REFERENCE_DT),
        failed=failed,
    )
