"""Grid, time steps and transfers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from physagent_jax.core.strict import Strict
from physagent_jax.scene.config.common import Rate

MOST_FRAMES = 10_000


class Domain(Strict):
    """The cubic domain [0, size]^3 and its resolution.

    Attributes:
        size: Side [m].
        cells: Cells along a side; dx = size / cells.
    """

    size: float = Field(default=4.0, ge=1e-3, le=1e6)
    cells: int = Field(default=96, ge=8, le=1024)

    @property
    def dx(self) -> float:
        """Grid spacing [m]."""
        return self.size / self.cells


class Timing(Strict):
    """Frames and substeps.

    Attributes:
        frame_count: Pictures in all; frame 0 is the rest pose, so frame_count - 1 intervals are simulated.
        frame_dt: Seconds per frame [s].
        substep_dt: Substep [s], or "auto" = ``safety`` times the stable bound, fitted to the frame.
        safety: Fraction of the bound that "auto" uses.
        force_substep: Run ``substep_dt`` even above the stable bound; a frame that then fails ends the run.
    """

    frame_count: int = Field(default=50, ge=2, le=MOST_FRAMES)
    frame_dt: float = Field(default=0.04, ge=1e-6, le=100)
    substep_dt: Annotated[float, Field(ge=1e-12, le=100)] | Literal["auto"] = "auto"
    safety: float = Field(default=0.9, ge=1e-3, le=1)  # as `mpm.timestep.SAFETY`
    force_substep: bool = False

    @property
    def duration(self) -> float:
        """Of the clip [s]."""
        return (self.frame_count - 1) * self.frame_dt


class Transfer(Strict):
    """Particle-grid transfers and damping.

    Attributes:
        scheme: "apic" or "pic".
        stress_form: "mls" (Hu et al. 2018), or "gradient", the classical form of warp-mpm and PhysGaussian, whose
            stable step is 0.71 times as long.
        sharpening: Strength of sharpened increments of the node velocities (`mpm.Sharpened`), 0.18 for most; 0 = lumped
            masses. Waves and vibrations err a third as much; a substep takes 13 to 29 % longer.
        aggregation: Share of the neighbours' mass below which nodes of a free surface follow them (`mpm.Lumped`), 0.5
            for most; 0 = none does. What is slender bends within 1 %, not 6 % too far; liquids at rest and what lies
            beside slip walls err more (docs/accuracy.md); a substep takes 5 to 30 % longer.
        rpic_damping: 0 = APIC, 1 = only the rotational part of C (RPIC).
        damping_rate: Global velocity damping [1/s]: grid velocities decay by exp(-rate dt) per substep.
    """

    scheme: Literal["apic", "pic"] = "apic"
    stress_form: Literal["mls", "gradient"] = "mls"
    sharpening: float = Field(default=0.0, ge=0, le=0.25)  # as `mpm.inertia.MOST_BETA`
    aggregation: float = Field(default=0.0, ge=0, le=0.8)  # as `mpm.inertia.MOST_AGGREGATION`
    rpic_damping: float = Field(default=0.0, ge=0, le=1)
    damping_rate: Rate = 0.0
