"""The uncertainty of the report's figures: half widths that should hold the truth in nine of ten clips.

The widths have the form "floor + share of what makes the measurement hard". Turning is the largest part: the hidden
side's middle is a guess, and each new link of tracks adds its own error.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.perception.schema import Oscillation, Uncertainty

NINETY = 1.645
"""Half width of the interval that holds a normal variable in nine of ten cases [standard deviations]."""
OFF_MIDDLE = 0.03
"""Error of the middle across the view, which a turn makes a shift [body lengths]."""
HIDDEN = 0.07
"""Error of the middle along the view, where a side is hidden [body lengths]."""
BRIDGED = 0.25
"""Share of a turn that was not seen by which it may be off [1]."""
ASSUMED_SHIFT, ASSUMED_MIDDLE = 0.06, 0.28
"""Error of a shift by a form that is thicker or thinner than assumed, and of the middle by its turn [body lengths]."""
ASSUMED_TILT, ASSUMED_STRETCH = 8.0, 0.04
"""Turn out of the picture plane that an assumed form may hide [deg], and what it does to lengths [1]."""


@dataclasses.dataclass(frozen=True)
class Difficulty:
    """The difficulty of measuring a clip.

    Attributes:
        pixel: Size of a pixel on the object [body lengths].
        noise: Noise of depth, from pixel to pixel [body lengths].
        residual: Largest RMS residual of the affine fits [body lengths].
        turn: Largest rotation out of the picture plane [deg].
        links: How often points were seeded anew.
        travel: Largest displacement [body lengths].
        disagreement: Disagreement of the affine fits' stretch with the outline's, beyond what a turn explains [1].
        drift: Half width of the displacement along the line of sight, where no depth is measured [body lengths].
        assumed: Whether the form of the surface is assumed.
        bridged: Turn that was not seen, but follows from that before and after [deg].
    """

    pixel: float
    noise: float
    residual: float
    turn: float
    links: int
    travel: float
    disagreement: float = 0.0
    drift: float | None = None
    assumed: bool = False
    bridged: float = 0.0


def estimate_uncertainty(
    hard: Difficulty, turns: list[np.ndarray | None], swing: Oscillation | None, frame_dt: float
) -> Uncertainty:
    """Half widths for the figures that the report has; None for those that it does not have.

    Args:
        hard: What makes the clip hard to measure.
        turns: Rotation vector per frame [rad].
        swing: The oscillation that was found.
        frame_dt: Seconds per frame [s].
    """
    blur = 0.5 * hard.pixel + 0.3 * hard.noise
    tilt = np.sin(np.radians(min(hard.turn, 90.0)))
    known = [v for v in turns if v is not None]
    angle = max((float(np.linalg.norm(v)) for v in known), default=0.0)
    displacement = 0.008 + blur + 0.015 * hard.travel + 0.3 * hard.residual
    displacement += float(np.hypot(OFF_MIDDLE * 2 * np.sin(min(angle, np.pi) / 2), HIDDEN * tilt))
    if hard.assumed:
        displacement += ASSUMED_SHIFT * hard.travel + ASSUMED_MIDDLE * tilt
    along = None if hard.drift is None else float(np.hypot(hard.drift, displacement))
    if not known:
        return Uncertainty(
            displacement=displacement, along=along, frequency=_estimate_frequency(swing, frame_dt)
        )
    rotation = 0.7 + np.degrees(2 * blur + 0.5 * hard.residual) + 0.12 * hard.turn + 0.3 * hard.links
    rotation += BRIDGED * hard.bridged
    if hard.assumed:
        rotation += ASSUMED_TILT
    axis = float(np.degrees(np.arctan2(np.radians(rotation), angle)))
    turning = ASSUMED_STRETCH if hard.assumed else 0.0
    stretch = turning + max(0.02 + 2 * blur + hard.residual + 0.12 * tilt, hard.disagreement)
    return Uncertainty(
        displacement=displacement,
        along=along,
        rotation=rotation,
        axis=min(axis, 90.0),
        stretch=stretch,
        frequency=_estimate_frequency(swing, frame_dt),
    )


def _estimate_frequency(swing: Oscillation | None, frame_dt: float) -> float | None:
    """Turning points are known to a fifth of a frame; the mean time between them, the better the more there are."""
    if swing is None:
        return None
    between = max(swing.reversals - 1, 1)
    return NINETY * swing.frequency_hz**2 * 2 * frame_dt * (0.3 / between) + 0.02 * swing.frequency_hz
