"""Magnitudes and times that bring about an amount where nothing opposes it (`forces.calibration`)."""

from __future__ import annotations

import math

from physagent_jax.core.strict import Vector
from physagent_jax.forces import calibration
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.motion.schema import Amount, ExpectedMotion, MotionKind, SceneBrief, SeenManner
from physagent_jax.motion.tolerances import SPIN, expect_move, expect_strain, find_told
from physagent_jax.motion.vectors import clamp, dot

_STRAIN_PER_M = 0.2
"""[1] that a stretch or squeeze shows for M = 1: between the linear 0.15 and what soft solids do at full strength."""


_UPRIGHT = 0.7  # cosine
_ROOM = 0.95  # of the way to the wall of the space, so that the wall is not felt
_SPIN_TIME = 1.5  # [s] of a whole turn with a strength of 1
_CIRCLE_TIME = 3.0  # [s] the same of a way round a circle, which is some four body lengths
_FAR = 120.0  # [degrees] from which on a turn takes more than the strongest force does in a step

MOVING = 0.6
"""[1] share of its window in which an end or a plate moves; in the rest it is held."""


def find_pace(effort: float, first: float, end: float, share: float = MOVING) -> tuple[float, float]:
    """Magnitude with which an effort [magnitude times frames] takes a share of a window, and its last frame.

    In whole frames, and as long as the largest magnitude needs.
    """
    magnitude = clamp(effort / (share * (end - first)), MAGNITUDE_MIN, MAGNITUDE_MAX)
    until = clamp(float(round(first + effort / magnitude)), first + 1.0, max(end, first + 1.0))
    return magnitude, until


def spread_effort(effort: float, first: float, end: float, share: float = MOVING) -> tuple[float, float]:
    """As `find_pace`, with the magnitude that fits the whole frames."""
    until = find_pace(effort, first, end, share)[1]
    return round(clamp(effort / (until - first), MAGNITUDE_MIN, MAGNITUDE_MAX), 4), until


def find_strain(expectation: ExpectedMotion, brief: SceneBrief) -> float:
    """By how much of its length it is to get longer or shorter [1]."""
    if told := find_told(expectation, brief, "of its length"):
        return told.target
    return expect_strain(expectation, expectation.kind is MotionKind.SQUEEZE).target


def find_wanted_way(expectation: ExpectedMotion, brief: SceneBrief, seconds: float) -> float:
    """The distance that is meant [body lengths], of a motion that lasts so long [s]."""
    told = find_told(expectation, brief, "body lengths")
    return (told or expect_move(expectation, False, seconds=seconds)).target


def find_lengths(amount: Amount | None, brief: SceneBrief) -> float | None:
    """A distance in body lengths; None if the amount is none."""
    if amount is None or amount.unit not in ("lengths", "metres"):
        return None
    return amount.value / (brief.size if amount.unit == "metres" else 1.0)


def keep_in_space(amount: Amount, way: Vector | None, brief: SceneBrief) -> Amount:
    """The amount, or of a distance that is too long for the space that is simulated what there is room for.

    Args:
        amount: Quantity that the sentence tells.
        way: Unit world vector; None = it is not known yet.
        brief: The scene.
    """
    lengths = find_lengths(amount, brief)
    most = 0.0 if way is None else _ROOM * brief.find_room(way)
    if lengths is None or most <= 0.0 or lengths <= most:
        return amount
    return amount.model_copy(update={"value": round(amount.value * most / lengths, 6)})


def find_spin(
    amount: Amount | None, manner: SeenManner, axis: Vector | None, brief: SceneBrief
) -> float | None:
    """The angle of a turn that shows what stands from its far side [degrees]; None if it does not.

    Args:
        amount: Quantity that the sentence tells, or None.
        manner: What spins turns once, unless an angle is told.
        axis: Unit world vector.
        brief: The scene.
    """
    if axis is None or abs(dot(axis, brief.directions.up)) <= _UPRIGHT or brief.anchored is not None:
        return None
    if amount is not None and amount.unit == "degrees":
        return amount.value if amount.value > _FAR else None
    return SPIN if manner == "spin" and brief.world == "ground" else None


def find_spin_time(degrees: float, strength: float, manner: SeenManner = "") -> float:
    """The time that a spin takes, or the same turns along a circle; the strength says how fast it is [s]."""
    turn = _CIRCLE_TIME if manner == "circle" else _SPIN_TIME
    return turn / strength * max(degrees / SPIN, 1.0)


def find_span(
    effort: float, usual: float, brief: SceneBrief, led: bool = False, turning: float | None = None
) -> float:
    """The time for which an object is pushed and then braked, so that a magnitude in range brings it there [s].

    Half of the time it is pushed, half braked: it gets M (t / T)^2 / 2 of what M = 1 does in T. If it is led instead,
    it gets M t / T. What spins is led as fast as it needs: ``turning`` [degrees] takes ``usual`` for each turn.
    """
    if turning is not None:
        return usual * max(turning / 360.0, 1.0)
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
