"""Named sets of defaults: what a scene costs against how fine it is."""

from __future__ import annotations

import dataclasses
import enum
import math

from physagent_jax.scene.config import Domain, Filling, Rendering, Timing, Transfer

_PAPER_SUBSTEP = 2e-4  # [s]
_PAPER_DAMPING = 0.9995  # of grid velocities, per substep


class PresetName(enum.StrEnum):
    """FAST: seconds on a laptop's processor. PAPER: the figures of PhysAgent, section 4.1 and appendix C.6."""

    FAST = "fast"
    PAPER = "paper"


@dataclasses.dataclass(frozen=True)
class Preset:
    """Everything of a `SceneConfig` that is a matter of cost, not of the scene."""

    domain: Domain
    filling: Filling
    timing: Timing
    transfer: Transfer
    rendering: Rendering


PRESETS = {
    # The domain is four object lengths wide, so that a pushed object has somewhere to go; the grid window
    # follows the object, so only about 32 to 48 cells a side are computed.
    PresetName.FAST: Preset(
        Domain(size=4.0, cells=96),
        Filling(max_particles=20_000, join=True),
        Timing(frame_count=50, frame_dt=0.04, substep_dt="auto"),
        Transfer(),
        Rendering(width=480, height=360),
    ),
    PresetName.PAPER: Preset(
        Domain(size=4.0, cells=200),  # the paper's cells, and room to go somewhere
        Filling(max_particles=200_000, join=True),
        Timing(frame_count=50, frame_dt=0.04, substep_dt=_PAPER_SUBSTEP),
        Transfer(rpic_damping=0.5, damping_rate=-math.log(_PAPER_DAMPING) / _PAPER_SUBSTEP),
        Rendering(width=512, height=512),
    ),
}
