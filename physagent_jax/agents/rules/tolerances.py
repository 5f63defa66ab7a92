"""Commonsense ranges: how much motion a viewer expects for a kind, a strength and a window.

Units are body lengths, degrees and strain. A plain push (strength 1) of a free object over the whole clip is
expected to do what M = 1 is calibrated to do (`forces.calibration`), and so is a blow; from rest the distance goes
with the square of the window, after a blow with its length.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from physagent_jax.agents.schema import ExpectedMotion, MotionKind
from physagent_jax.agents.vectors import clamp
from physagent_jax.forces import calibration

VISIBLE = 0.02  # [body lengths] less is not seen as motion
VISIBLE_DEGREES = 3.0
STILL = 0.05  # [body lengths] more is not seen as stillness
STILL_DEGREES = 5.0
STILL_STRAIN = 0.08
_BRAKED = 0.7  # between a push that goes on (1) and one that is braked half-way (1/2)
_LARGEST_GAIN = 10.0  # beyond it the response is not proportional anyway
_SETTLE = 1 / 3  # of a later stillness that may still show what came before it
_PART = 0.3  # how much less the whole shows if only a part is acted on


@dataclass(frozen=True)
class Tolerance:
    """An acceptable range and the value to aim at.

    Attributes:
        low, high: Inclusive limits.
        target: What a correction aims at.
        unit: For people.
    """

    low: float
    target: float
    high: float
    unit: str

    def score(self, value: float) -> float:
        """1 inside, falling with the ratio outside, 0 for the contrary sign."""
        if self.low <= value <= self.high:
            return 1.0
        ratio = value / self.low if value < self.low else self.high / value
        return 0.9 * max(ratio, 0.0)

    def gain(self, value: float) -> float:
        """Factor on the cause that would bring ``value`` to the target, if the response is proportional.

        What cannot be told from nothing is taken as just visible, so that the step stays finite.
        """
        floor = 0.1 * self.low
        gain = self.target / (value if abs(value) > floor else floor)
        return clamp(gain, -_LARGEST_GAIN, _LARGEST_GAIN)

    def text(self) -> str:
        """The range in words."""
        if self.high == float("inf"):
            return f"at least {self.low:.2g} {self.unit}"
        return f"{self.low:.2g} to {self.high:.2g} {self.unit}"


def list_windows(expectations: Sequence[ExpectedMotion], frame_count: int) -> list[tuple[int, int]]:
    """Windows that the planner needs in the motion report: one per expectation, in whole frames, without repeats."""
    windows: list[tuple[int, int]] = []
    for expectation in expectations:
        window = round_window(expectation, frame_count)
        if window not in windows:
            windows.append(window)
    return windows


def round_window(expectation: ExpectedMotion, frame_count: int) -> tuple[int, int]:
    """The expectation's window rounded to frames, at least one frame long if the clip has two.

    Stillness after motion is looked for once the motion has had time to settle.
    """
    last = max(frame_count - 1, 0)
    begin, finish = expectation.window
    if expectation.kind is MotionKind.STILL and begin > 0.5:
        begin += _SETTLE * (finish - begin)
    end = min(max(round(finish), 1), last)
    first = min(max(round(begin), 0), max(end - 1, 0))
    return first, end


def _fraction(expectation: ExpectedMotion, frame_count: int) -> float:
    first, last = round_window(expectation, frame_count)
    return (last - first) / max(frame_count - 1, 1)


def expect_move(
    expectation: ExpectedMotion, frame_count: int, anchored: bool, speed: float = 0.0, rises: bool = False
) -> Tolerance:
    """Distance along the direction [body lengths].

    Args:
        expectation: The motion.
        frame_count: Frames of the clip.
        anchored: Whether the object is held.
        speed: Of a free object along the direction when the window begins [body lengths per clip].
        rises: Whether it is thrown up and comes down again, which halves the way.
    """
    strength, part = expectation.strength, _PART if expectation.partial else 1.0
    if anchored:
        low, high = 0.05 * strength, 0.5 * strength
        return Tolerance(
            part * low,
            part * calibration.EXPECTED_HELD_SHIFT * strength + (1 - part) * low,
            high,
            "body lengths",
        )
    fraction = _fraction(expectation, frame_count)
    steady = fraction**2 * (1.0 if fraction > 0.99 else _BRAKED)
    impulses = (
        0.5 * (expectation.repeats + 1) * fraction
    )  # evenly spaced: the later ones act for a shorter time
    target = (
        calibration.TRAVEL * strength * (impulses if expectation.sudden else steady) * (0.5 if rises else 1.0)
    )
    low = max(0.5 * part * target, VISIBLE)
    drift = max(speed, 0.0) * fraction
    return Tolerance(
        low, max(target, 1.5 * low) + drift, max(2.0 * target, 3.0 * low) + 2.0 * drift, "body lengths"
    )


def expect_rotation(expectation: ExpectedMotion, frame_count: int, anchored: bool) -> Tolerance:
    """Angle about the axis [degrees]: `calibration.TURN` for a plain torque over the whole clip."""
    part = _PART if expectation.partial else 1.0
    if anchored:
        return Tolerance(
            5.0 * part * expectation.strength,
            calibration.EXPECTED_HELD_TURN * expectation.strength,
            150.0,
            "degrees",
        )
    fraction = _fraction(expectation, frame_count)
    turn = math.degrees(calibration.TURN)
    target = turn * expectation.strength * fraction**2 * (1.0 if fraction > 0.99 else _BRAKED)
    low = max(0.5 * part * target, VISIBLE_DEGREES)
    return Tolerance(low, max(target, 1.5 * low), max(2.5 * target, 3.0 * low), "degrees")


def expect_strain(expectation: ExpectedMotion, squeeze: bool) -> Tolerance:
    """Relative change of length along the direction; what M = 1 gives (`calibration.STRAIN`) lies in its lower half."""
    strength, part = expectation.strength, _PART if expectation.partial else 1.0
    high = min(0.45 * strength + 0.15, 0.85) if squeeze else 0.75 * strength + 0.1
    return Tolerance(0.1 * part * strength, calibration.EXPECTED_STRAIN * strength, high, "of its length")


def expect_sway(expectation: ExpectedMotion) -> Tolerance:
    """Half of the peak-to-peak excursion [body lengths]."""
    strength, part = expectation.strength, _PART if expectation.partial else 1.0
    low = max(VISIBLE * strength * part, 0.008)
    return Tolerance(
        low,
        max(calibration.EXPECTED_SWAY * strength * part, 1.5 * low),
        0.6 * max(strength, 0.7),
        "body lengths to either side",
    )


def expect_fall(expectation: ExpectedMotion, frame_count: int) -> Tolerance:
    """Distance downwards [body lengths]; how far depends on the height of the ground, so there is no upper limit."""
    low = 0.1 * min(1.0, 2.0 * _fraction(expectation, frame_count)) + VISIBLE
    return Tolerance(low, 5.0 * low, float("inf"), "body lengths")
