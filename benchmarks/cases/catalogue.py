"""All cases with the numerics that they are verified with, and those whose error is studied against wall time."""

from __future__ import annotations

import dataclasses

import numpy as np

from benchmarks.cases.axis_aligned import AxisAligned
from benchmarks.cases.ball_drop import BallDrop
from benchmarks.cases.bar import FreeBar
from benchmarks.cases.base import Case, Numerics
from benchmarks.cases.cantilever import Cantilever, CantileverSwing
from benchmarks.cases.dam_break import DamBreak
from benchmarks.cases.disks import Disks
from benchmarks.cases.hydrostatic import Hydrostatic
from benchmarks.cases.incline import Incline
from benchmarks.cases.periodic_bar import PeriodicBar
from benchmarks.cases.projectile import FreeBody, Projectile
from benchmarks.cases.ring import SpinningRing
from benchmarks.cases.sand_column import SandColumn
from benchmarks.cases.slope import Slope
from benchmarks.cases.sphere import Sphere
from benchmarks.cases.spin import FAST, SLOW, Spin, TurnedFluid
from benchmarks.cases.stepped_rod import SteppedRod
from benchmarks.cases.viscous import Swirl
from benchmarks.cases.vortex import Vortex
from benchmarks.cases.wave import WallImpact, WaveFront

_LONG = ("courant", 0.6)  # near the bound: cheaper and less damped, for what takes many steps


@dataclasses.dataclass(frozen=True)
class Verified:
    """A case and how it is verified.

    Attributes:
        case: The problem.
        coarse: Numerics for a quick look.
        fine: Numerics for the record.
        note: What distinguishes it from others of the same name.
    """

    case: Case
    coarse: Numerics
    fine: Numerics
    note: str = ""


def _make_pair(case: Case, coarse: int, fine: int, note: str = "", **options) -> Verified:
    return Verified(case, Numerics(coarse, **options), Numerics(fine, **options), note)


CASES: tuple[Verified, ...] = (
    Verified(Projectile(), Numerics(2), Numerics(2, dtype=np.float64)),
    Verified(FreeBody(), Numerics(3), Numerics(3, dtype=np.float64)),
    Verified(Spin(FAST), Numerics(4), Numerics(8, dtype=np.float64), "388 steps a turn"),
    Verified(Spin(SLOW), Numerics(4), Numerics(8, dtype=np.float64), "1943 steps a turn"),
    Verified(TurnedFluid(), Numerics(4, dtype=np.float64), Numerics(4, dtype=np.float64)),
    _make_pair(FreeBar(), 8, 32),
    _make_pair(Sphere(), 4, 12),
    _make_pair(WaveFront(), 32, 128),
    _make_pair(SteppedRod(), 64, 128),
    _make_pair(SpinningRing(), 2, 3),
    _make_pair(WallImpact(), 16, 64),
    _make_pair(Vortex(), 5, 20, step=("courant", 0.2), per_axis=3),
    _make_pair(PeriodicBar("free"), 16, 32, "free ends"),
    _make_pair(PeriodicBar("walls"), 16, 32, "slip walls"),
    _make_pair(PeriodicBar("mirrors"), 16, 32, "planes of symmetry"),
    _make_pair(AxisAligned(), 8, 16, "planes of symmetry"),
    _make_pair(AxisAligned("slip"), 8, 16, "slip walls"),
    _make_pair(CantileverSwing(), 4, 8, step=_LONG),
    _make_pair(Cantilever(), 4, 8, step=_LONG, per_axis=3),
    _make_pair(Disks(), 20, 40, per_axis=3),
    _make_pair(BallDrop(), 8, 12, step=_LONG),
    _make_pair(Incline(0.3), 4, 8),
    _make_pair(Incline(0.7), 4, 8),
    _make_pair(Hydrostatic(), 10, 20),
    _make_pair(Swirl(), 8, 16),
    _make_pair(DamBreak(), 16, 16, step=("courant", 0.5)),
    _make_pair(Slope(-2.0), 8, 8, step=_LONG),
    _make_pair(Slope(3.0), 16, 16, step=_LONG),
    _make_pair(SandColumn(0.5), 12, 12, step=_LONG),
    _make_pair(SandColumn(1.0), 8, 16, step=_LONG),
    _make_pair(SandColumn(2.0), 6, 6, step=_LONG),
    _make_pair(SandColumn(4.0), 5, 5, step=_LONG),
)

EXPENSIVE = (
    "dam-break",
    "slope-flows",
    "sand-column-0.5",
    "sand-column-1",
    "sand-column-2",
    "sand-column-4",
    "cantilever",
)
"""Names of those that take minutes, and that a quick look leaves out."""


@dataclasses.dataclass(frozen=True)
class Studied:
    """A case whose error is studied against wall time.

    Attributes:
        case: The problem.
        error: The error that the plot shows.
        resolutions: Cells, coarse to fine.
        base: What is not varied.
    """

    case: Case
    error: str
    resolutions: tuple[int, ...]
    base: Numerics = Numerics()


STUDIED: tuple[Studied, ...] = (
    Studied(FreeBar(), "signal (rms)", (8, 16, 32)),
    Studied(Sphere(), "signal (rms)", (4, 6, 8)),
    Studied(Vortex(), "returned [m]", (5, 10, 20), Numerics(per_axis=3)),
)
