"""Skips: the same answer computed two ways, once with work left out and once with it forced in."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Callable, Mapping
from typing import Any

import jax
import numpy as np

Answer = Mapping[str, np.ndarray | bytes | float]
"""Values that are compared, by name: arrays, numbers or files."""

ROUND_OFF = 1e-6  # what float32 may differ by, over the largest value, unless a skip states a reason for more


class State(enum.StrEnum):
    """State of a skip: whether the product leaves the work out."""

    SKIPPED = "skipped"
    MISSING = "not skipped yet"  # the lean way is written by hand, in the benchmark
    KEPT = "kept on purpose"  # likewise: the row shows the price
    CHOICE = "a choice"  # both ways are right, with errors of their own


@dataclasses.dataclass(frozen=True)
class Sizes:
    """Sizes of the scenes.

    Attributes:
        particles: Number of particles of most rows; also Gaussians, where pictures are made.
        cells: Along a side of the domain.
        substeps: Substeps of one run.
        rounds: In which the two ways take turns; fewer if they are slow (`measure.FEWEST`).
        seconds: What the rounds of a row may take [s].
        sample: A turn lasts at least so long, by as many runs as it takes: other work on the machine comes in slices
            of milliseconds [s].
        bar_per_axis: Particles per cell and axis of the elastic bar.
        clip_particles: Most particles of the clip whose files are written.
        clip_frames: Its frames.
        clip_pixels: Side of its pictures [px].
    """

    particles: int = 100_000
    cells: int = 100
    substeps: int = 20
    rounds: int = 15
    seconds: float = 12.0
    sample: float = 0.1
    bar_per_axis: int = 4
    clip_particles: int = 20_000
    clip_frames: int = 25
    clip_pixels: int = 320


QUICK = Sizes(
    particles=8_000,
    cells=48,
    substeps=10,
    rounds=11,
    seconds=3.0,
    sample=0.05,
    bar_per_axis=2,
    clip_particles=2_000,
    clip_frames=8,
    clip_pixels=160,
)


@dataclasses.dataclass(frozen=True)
class Way:
    """One way to an answer.

    Attributes:
        run: Does the work, always from the same start; timed until its results are there.
        read: What is compared, from what ``run`` returned; not timed.
    """

    run: Callable[[], Any]
    read: Callable[[Any], Answer]


@dataclasses.dataclass(frozen=True)
class Pair:
    """Both ways, ready to run.

    Attributes:
        lean: With the skip.
        full: With the work forced in.
        particles: How many are simulated (or Gaussians drawn).
        share: How many units of work one run is.
        unit: Their name: "substep", "frame", ...
        note: What a reader has to know about this size, "" = nothing; it may be made from the lean answer.
    """

    lean: Way
    full: Way
    particles: int
    share: int = 1
    unit: str = "substep"
    note: str | Callable[[Answer], str] = ""


@dataclasses.dataclass(frozen=True)
class Skip:
    """A row of the table.

    Attributes:
        name: Short and unique; ``--only`` takes it.
        left_out: What is not computed, and when.
        forced: How the work is forced in; where the product does it anyway, how the lean way is made.
        pair: Builds both ways.
        state: Whether the product skips it.
        tolerance: Largest relative difference of the two answers; for errors, the largest error of the lean way.
        reason: Why the tolerance is above `ROUND_OFF`.
        errors: Whether answers are errors against a closed form rather than equal.
    """

    name: str
    left_out: str
    forced: str
    pair: Callable[[Sizes], Pair]
    state: State = State.SKIPPED
    tolerance: float = ROUND_OFF
    reason: str = ""
    errors: bool = False


def finished(way: Way) -> Any:
    """Result of a run of ``way``, once it is there."""
    return jax.block_until_ready(way.run())


def disagreement(lean: Answer, full: Answer) -> tuple[float, str]:
    """The largest difference over the largest value, and the name of what differs most.

    What is missing, of another shape, or not finite differs infinitely; so do files with any other byte.
    """
    if lean.keys() != full.keys():
        return float("inf"), ", ".join(sorted(lean.keys() ^ full.keys()))
    worst = max(((_measure_difference(lean[name], full[name]), name) for name in lean), default=(0.0, ""))
    return worst if worst[0] > 0 else (0.0, "")


def _measure_difference(one: np.ndarray | bytes | float, other: np.ndarray | bytes | float) -> float:
    if isinstance(one, bytes) or isinstance(other, bytes):
        return 0.0 if one == other else float("inf")
    one, other = np.asarray(one, np.float64), np.asarray(other, np.float64)
    if one.shape != other.shape or not (np.isfinite(one).all() and np.isfinite(other).all()):
        return float("inf")
    scale = np.abs(other).max(initial=0.0)
    return float(np.abs(one - other).max(initial=0.0) / (scale if scale > 0 else 1.0))
