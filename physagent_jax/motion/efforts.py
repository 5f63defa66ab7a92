"""Magnitudes and times that bring about an amount where nothing opposes it (`forces.calibration`)."""

from __future__ import annotations

import math

from physagent_jax.forces import calibration
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.motion.schema import Amount, SceneBrief
from physagent_jax.motion.vectors import clamp

_STRAIN_PER_M = 0.2
"""[1] that a stretch or squeeze shows for M = 1: between the linear 0.15 and what soft solids do at full strength."""


def find_lengths(amount: Amount | None, brief: SceneBrief) -> float | None:
    """A distance in body lengths; None if the amount is none."""
    if amount is None or amount.unit not in ("lengths", "metres"):
        return None
    return amount.value / (brief.size if amount.unit == "metres" else 1.0)


def find_span(effort: float, usual: float, brief: SceneBrief, led: bool = False) -> float:
    """The time for which an object is pushed and then braked, so that a magnitude in range brings it there [s].

    Half of the time it is pushed, half braked: it gets M (t / T)^2 / 2 of what M = 1 does in T. If it is led instead,
    it gets M t / T.
    """
    reference = calibration.REFERENCE_TIME
    shortest, longest = (reference * math.sqrt(2.0 * effort / m) for m in (MAGNITUDE_MAX, MAGNITUDE_MIN))
    shortest = max(shortest, reference * effort / MAGNITUDE_MAX) if led else shortest
    return clamp(usual, shortest, max(longest, 4.0 * brief.frame_dt))


def find_held_magnitude(amount: Amount, brief: SceneBrief, sways: bool = False) -> float | None:
    """M that bends, turns or (to either side) sways something held about as far."""
    lengths = find_lengths(amount, brief)
    if lengths is not None:
        return lengths / (calibration.EXPECTED_SWAY if sways else calibration.EXPECTED_HELD_SHIFT)
    return amount.value / calibration.EXPECTED_HELD_TURN if amount.unit == "degrees" else None


def find_swing_magnitude(amount: Amount, held: bool, brief: SceneBrief) -> float | None:
    """M that swings something about as far to either side."""
    if held:
        return find_held_magnitude(amount, brief, sways=True)
    lengths = find_lengths(amount, brief)
    return None if lengths is None else lengths / calibration.SWING


def find_strain_magnitude(amount: Amount) -> float:
    """M whose stretch or squeeze comes near a factor."""
    return abs(amount.value - 1.0) / _STRAIN_PER_M
