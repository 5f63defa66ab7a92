"""The judge of a task: verdicts from particles, and the same as residuals for methods that minimise.

Both read `metrics.measures`, so that they cannot disagree: where all residuals are zero, the judge says success.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.clips import Clip
from physagent_jax.metrics.measures import Measure, measure_clause
from physagent_jax.metrics.targets import Target

ROOM = 0.5
"""Residuals are zero up to this miss [tolerances]: what is met with this margin needs nothing more."""


@dataclasses.dataclass(frozen=True)
class ClauseJudgement:
    """One number of a clause.

    Attributes:
        name: What was measured.
        seen: On the clip; NaN where the clip's positions are not finite.
        wanted: By the clause.
        tolerance: By how much it may differ.
        unit: Unit of these three.
        margin: 1 at the target, 0 at the tolerance's edge, negative outside.
    """

    name: str
    seen: float
    wanted: float
    tolerance: float
    unit: str
    margin: float


@dataclasses.dataclass(frozen=True)
class TaskJudgement:
    """The judge's verdict.

    Attributes:
        success: Whether all clauses are met.
        error: The largest miss [tolerances]: 0 where all targets are hit, up to 1 for a success; infinite for
            positions that are not finite.
        clauses: Each number.
    """

    success: bool
    error: float
    clauses: tuple[ClauseJudgement, ...]


def judge(target: Target, x, mass, frame_dt: float) -> TaskJudgement:
    """Judge true trajectories.

    Args:
        target: What is asked for.
        x: Particle positions [m], shape (T, n, 3); frame 0 is the rest pose.
        mass: [kg], shape (n,).
        frame_dt: Seconds per frame [s].

    Raises:
        UserError: The clip is too short for the target, or a shape does not fit.
    """
    finite = bool(np.isfinite(x).all())
    clauses = []
    for measure in _measure(target, x, mass, frame_dt):
        seen = float(measure.seen) if finite else float("nan")
        margin = 1.0 - abs(seen - measure.wanted) / measure.tolerance if finite else -float("inf")
        clauses.append(
            ClauseJudgement(measure.name, seen, measure.wanted, measure.tolerance, measure.unit, margin)
        )
    error = max(1.0 - clause.margin for clause in clauses)
    return TaskJudgement(error <= 1.0, error, tuple(clauses))


def compute_residuals(target: Target, x, mass, frame_dt: float) -> jax.Array:
    """The shortfall as residuals, for methods that minimise half of its square, shape (m,).

    The misses in tolerances, less `ROOM` towards zero; for stored paths, the misses of all coordinates, without room,
    divided so that their norm is the root mean square distance in tolerances. Half the square is continuously
    differentiable but where a greatest value changes its frame.

    Args:
        target: What is asked for.
        x: Particle positions [m], shape (T, n, 3); may be traced.
        mass: [kg], shape (n,).
        frame_dt: Seconds per frame [s].

    Raises:
        UserError: As for `judge`.
    """
    residuals = []
    for measure in _measure(target, x, mass, frame_dt):
        if measure.parts is not None:
            residuals.append(measure.parts)
            continue
        miss = measure.miss
        residuals.append(jnp.sign(miss) * jnp.maximum(jnp.abs(miss) - ROOM, 0.0))
    return jnp.concatenate([jnp.atleast_1d(each) for each in residuals])


def _measure(target: Target, x, mass, frame_dt: float) -> list[Measure]:
    clip = Clip(x, mass, frame_dt)
    if target.last_frame >= clip.frame_count:
        raise UserError(
            f"the target looks at frame {target.last_frame}, the clip ends with frame {clip.frame_count - 1}",
            do="Judge a clip of the task's length",
        )
    return [measure for clause in target.clauses for measure in measure_clause(clause, clip)]
