"""The magnitude that brings a free object so far: M = 1 does an effort of 1 from rest in the reference time."""

from __future__ import annotations

from physagent_jax.forces import calibration
from physagent_jax.motion.schema import SceneBrief


def find_reference_seconds(brief: SceneBrief) -> float:
    """T of a free object's skills [s]."""
    return min((brief.frame_count - 1) * brief.frame_dt, calibration.REFERENCE_TIME)


def find_magnitude(effort: float, seconds: float, braked: bool, brief: SceneBrief) -> float:
    """M that reaches ``effort`` in ``seconds``, from rest; out of range if it cannot."""
    reference = find_reference_seconds(brief)
    return (2.0 if braked else 1.0) * effort * (reference / max(seconds, brief.frame_dt)) ** 2
