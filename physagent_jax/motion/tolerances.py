"""The amount of motion that a viewer expects of a sentence's words: ranges per kind of motion and of holding.

They say what people call slight, plain and strong when they watch a clip of a few seconds; how a force field is scaled
does not enter. The yardstick is the object itself (its longest extent L), which viewers compare motion with:

- Motion below `LEAST` is not noticed: some 2 % of an object that fills a third of a 720p picture are 5 pixels.
- Going somewhere: "slightly" is well below the object's own size, up to a third of it; a plain "push" brings it to
  another place, a quarter of its size up to little more than its size; "violently" is about its own size or more. Four
  sizes away it has left any picture that shows the object properly.
- Bending of what is held: its centre moves by about half of what its end does, so a third of the above; beyond 0.8 it
  cannot be held any more.
- Turning: under 30 degrees is slight (the broad face stays in sight); a plain turn shows another side, 20 degrees up to
  two thirds of a turn; "violent" spinning goes on to three eighths of a turn or more.
- Length: a tenth is about the least change of proportions that is seen without a ruler, a half is plain, twice is
  violent. Squeezing ends at 1.
- Tipping over: from half of a quarter turn on something lies, on its rim or on what sticks out of it; however it was
  pushed, it lies then. What is pushed violently may roll on.

Ranges of neighbouring words overlap by a factor of at most `LARGEST_OVERLAP`, because words do not have sharper edges
(turns by `LARGEST_OVERLAP_OF_TURNS`: a plain "spin" goes farther than a plain "turn", and is the same kind of motion);
between the words' strengths (0.4, 1.0, 1.6) limits go geometrically.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from physagent_jax.motion.matching import AXIAL
from physagent_jax.motion.schema import Amount, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import clamp

VISIBLE = 0.02  # [body lengths] less is not seen as motion
VISIBLE_DEGREES = 3.0
VISIBLE_STRAIN = 0.03
LEAST = 0.03  # [body lengths] that something asked for has to move at least
STILL = 0.05  # [body lengths] more is not seen as stillness
STILL_DEGREES = 5.0
STILL_STRAIN = 0.08
LARGEST_OVERLAP = 1.6
LARGEST_OVERLAP_OF_TURNS = 2.0
_LARGEST_GAIN = 10.0  # beyond it the response is not proportional anyway
_SETTLE = 1 / 3  # of a later stillness that may still show what came before it
_PART = 0.3  # how much less the whole shows if only a part is acted on
REACHED = 0.8  # of the way to an obstacle, from where on it counts as met
_TOLD_STRAIN = 0.04  # [1] within which perception tells nine strains of ten
_TOLD_TURN = 60.0  # [degrees] off an angle that the sentence names, however large
_LOST_TURN = 0.12  # of a turn that is lost in following it all around, again and again
_FALLEN = 0.4  # of a height that the sentence names, that a fall may differ by: nothing beside it shows where it was
_LIES = 0.5  # [L] by which the middle of what fell sinks at most as it tips over, or lies in pieces
_WRUNG = 0.85  # of the largest angle of its word that a free end turns by: it lessens towards the held one
_SPUN_LEAST = 60.0  # [degrees] less is a turn, and no spin
_BLADES_LEAST = 15.0  # [degrees] the same of a part
SPIN = 360.0  # [degrees] that what spins turns by, unless the sentence says
_GENTLE = 0.27  # [body lengths / s] at which what goes on and on is still slow, however far it comes
_SLOW_TURN = 30.0  # [degrees / s] the same of a turn
_UNHURRIED = 1.0  # [s] what lasts for less time may do less
_STRENGTHS = (0.4, 1.0, 1.6)
_MANNER = 2.0  # times as fast as the strength, the upper limit rises from a slight word's to a plain one's

Limits = tuple[float, float, float]
Bands = tuple[Limits, Limits, Limits]
"""(low, target, high) of slight, plain and strong."""

MOVE: Bands = ((0.06, 0.15, 0.35), (0.25, 0.6, 1.3), (0.9, 1.4, 4.0))
MOVE_HELD: Bands = ((0.015, 0.04, 0.08), (0.055, 0.15, 0.3), (0.2, 0.3, 0.8))
MOVE_HELD_END: Bands = ((0.03, 0.08, 0.2), (0.13, 0.3, 0.7), (0.45, 0.7, 1.6))
SWAY: Bands = ((0.02, 0.045, 0.07), (0.045, 0.12, 0.35), (0.23, 0.35, 1.0))
SWAY_HELD: Bands = ((0.01, 0.03, 0.065), (0.041, 0.09, 0.2), (0.13, 0.2, 0.5))
TURN: Bands = ((5.0, 14.0, 30.0), (20.0, 85.0, 260.0), (135.0, 240.0, 1100.0))
TOPPLE: Bands = ((45.0, 90.0, 260.0), (45.0, 90.0, 260.0), (45.0, 90.0, 1100.0))
TURN_HELD: Bands = ((4.0, 10.0, 24.0), (15.0, 35.0, 75.0), (48.0, 75.0, 180.0))
STRETCH: Bands = ((0.1, 0.15, 0.22), (0.15, 0.25, 0.55), (0.35, 0.6, 2.0))
SQUEEZE: Bands = ((0.1, 0.13, 0.19), (0.13, 0.28, 0.42), (0.28, 0.45, 0.92))
SWELL: Bands = ((0.06, 0.1, 0.14), (0.09, 0.18, 0.35), (0.23, 0.4, 1.5))
MOST_OF_PART = 0.92  # of its length that a part may get shorter or longer by, however gently
SHRINK: Bands = (SWELL[0], SWELL[1], (0.2, 0.3, 0.8))


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

    def margin(self, value: float) -> float:
        """Signed distance from the nearer limit, in tolerances: 1 at the target, 0 at a limit, negative outside."""
        if value <= self.target:
            return (value - self.low) / (self.target - self.low)
        return (self.high - value) / (self.high - self.target)

    def distance(self, value: float) -> float:
        """Distance from the nearer limit, in the value's unit."""
        return min(abs(value - self.low), abs(value - self.high))

    def gain(self, value: float) -> float:
        """Factor on the cause that would bring ``value`` to the target, if the response is proportional.

        What cannot be told from nothing is taken as just visible, so that the step stays finite.
        """
        floor = 0.1 * max(self.low, 1e-3)
        gain = self.target / (value if abs(value) > floor else floor)
        return clamp(gain, -_LARGEST_GAIN, _LARGEST_GAIN)

    def text(self) -> str:
        """The range in words."""
        if self.low <= 0:
            return f"at most {self.high:.2g} {self.unit}"
        return f"{self.low:.3g} to {self.high:.3g} {self.unit}"

    def limited(self, most: float) -> Tolerance:
        """The same where something stands in the way at the distance ``most``."""
        most = max(most, LEAST)
        return dataclasses.replace(self, low=min(self.low, REACHED * most), target=min(self.target, most))

    def widened(self, least: float) -> Tolerance:
        """The same with at least so much on either side of the target."""
        low, high = min(self.low, self.target - least), max(self.high, self.target + least)
        return dataclasses.replace(self, low=low, high=high)

    def scaled(self, share: float, least: float) -> Tolerance:
        """The same with the lower limit and the target multiplied, but the limit not below ``least``."""
        lower = min(max(share * self.low, least), 0.5 * self.high)
        aim = max(share * self.target, 1.3 * lower)
        return Tolerance(lower, min(aim, 0.9 * self.high), self.high, self.unit)


CIRCLE = Tolerance(0.5, 1.3, 3.0, "body lengths")
"""Width of a circle that it goes along."""


def pick_band(bands: Bands, strength: float, unit: str) -> Tolerance:
    """The range for a strength, between those of the words geometrically.

    Words between slight and plain ("slowly", "gently") say how it moves rather than how far, so its upper limit soon is
    that of a plain word.
    """
    low, target, high = _pick_limits(bands, strength)
    if _STRENGTHS[0] < strength < _STRENGTHS[1]:
        soon = _STRENGTHS[0] + _MANNER * (strength - _STRENGTHS[0])
        high = max(high, _pick_limits(bands, min(soon, _STRENGTHS[1]))[2])
    return Tolerance(low, target, high, unit)


def _pick_limits(bands: Bands, strength: float) -> Limits:
    s = clamp(strength, _STRENGTHS[0], _STRENGTHS[2])
    k = 0 if s <= _STRENGTHS[1] else 1
    share = (s - _STRENGTHS[k]) / (_STRENGTHS[k + 1] - _STRENGTHS[k])
    low, target, high = (a ** (1 - share) * b**share for a, b in zip(bands[k], bands[k + 1]))
    return low, target, high


def list_windows(expectations: Sequence[ExpectedMotion], frame_count: int) -> list[tuple[int, int]]:
    """Windows that the planner needs in the motion report: one per expectation, in whole frames, without repeats."""
    return list(dict.fromkeys(round_window(each, frame_count) for each in expectations))


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


def expect_move(
    expectation: ExpectedMotion,
    anchored: bool,
    *,
    seconds: float = 2.0,
    drift: float = 0.0,
    end: bool = False,
) -> Tolerance:
    """Distance along the direction [body lengths].

    What is looked at for less than a second may do less. ``drift`` is how far it goes on by itself with the speed that
    it has when the window begins [body lengths]. ``end``: the named end is looked at, not the whole.
    """
    bands = (MOVE_HELD_END if end else MOVE_HELD) if anchored else MOVE
    share = _PART if expectation.partial and not end else 0.6 if end and not anchored else 1.0
    share *= clamp(seconds / _UNHURRIED, 0.3, 1.0)
    band = pick_band(bands, expectation.strength, "body lengths")
    band = band.scaled(share, least=0.5 * LEAST if anchored and not end else LEAST)
    more = 1.0 if anchored else 0.5 * (expectation.repeats + 1)  # each of several blows adds its own way
    high = max(more * band.high, 0.0 if anchored or expectation.sudden else _GENTLE * seconds)
    return Tolerance(band.low, band.target + max(drift, 0.0), high + max(drift, 0.0), band.unit)


def expect_topple(expectation: ExpectedMotion) -> Tolerance:
    """Angle by which what stands tips over [degrees]: how hard it is pushed does not tell how far down it lies."""
    return pick_band(TOPPLE, expectation.strength, "degrees")


def expect_rotation(expectation: ExpectedMotion, anchored: bool, *, seconds: float = 2.0) -> Tolerance:
    """Angle about the axis [degrees]; what spins freely may go on as it likes."""
    if expectation.manner == "spin" and not anchored and not expectation.partial:
        return Tolerance(_SPUN_LEAST, SPIN, 4.0 * SPIN, "degrees")
    if expectation.manner == "spin" and expectation.limb is not None:  # alike blades look as turned by less
        return Tolerance(_BLADES_LEAST, SPIN, 4.0 * SPIN, "degrees")
    band = pick_band(TURN_HELD if anchored else TURN, expectation.strength, "degrees")
    share = _PART if expectation.partial and expectation.part is None else 1.0
    band = band.scaled(share * clamp(seconds / _UNHURRIED, 0.3, 1.0), least=VISIBLE_DEGREES)
    slow = 0.0 if anchored or expectation.partial or expectation.sudden else _SLOW_TURN * seconds
    return dataclasses.replace(band, high=max(band.high, slow))


def expect_wrung(expectation: ExpectedMotion, brief: SceneBrief) -> float:
    """The angle that one end is to turn by against what holds the other [degrees]."""
    told = find_told(expectation, brief, "degrees")
    return told.target if told else _WRUNG * expect_rotation(expectation, True).high


def expect_strain(expectation: ExpectedMotion, squeeze: bool) -> Tolerance:
    """Relative change of length along the direction; in all directions if there is none."""
    bands = SQUEEZE if squeeze else STRETCH
    if expectation.direction is None:
        bands = SHRINK if squeeze else SWELL
    share = _PART if expectation.partial else 1.0
    return pick_band(bands, expectation.strength, "of its length").scaled(share, least=VISIBLE_STRAIN)


def expect_sway(expectation: ExpectedMotion, anchored: bool, *, end: bool = False) -> Tolerance:
    """Half of the peak-to-peak excursion [body lengths]."""
    is_held = anchored and not end
    band = pick_band(SWAY_HELD if is_held else SWAY, expectation.strength, "body lengths to either side")
    return band.scaled(_PART if expectation.partial and not end else 1.0, least=0.008 if is_held else 0.015)


def expect_fall(seconds: float = 2.0) -> Tolerance:
    """Distance downwards [body lengths]: to the ground, wherever that is; the upper limit only says "not for ever"."""
    low = 0.12 * clamp(seconds / 0.5, 0.4, 1.0)
    return Tolerance(low, 4.0 * low, 8.0, "body lengths")


def find_told(expectation: ExpectedMotion, brief: SceneBrief, unit: str) -> Tolerance | None:
    """The range around the quantity that a motion is told; None if it is told none in this unit."""
    told = expectation.amount and expect_quantity(expectation.amount, expectation.kind, brief)
    return told if told and told.unit == unit else None


def expect_quantity(amount: Amount, kind: MotionKind, brief: SceneBrief) -> Tolerance | None:
    """The range around a quantity that the sentence names, in the unit in which its kind of motion is measured.

    A viewer has no ruler: 20 % off a distance, a length or an angle is not noticed without comparison, nor what is less
    than `LEAST` of a way, `STILL_DEGREES` of a turn or 0.04 of a length, as perception tells (`docs/perception.md`).
    However far something turns, the pose in which it ends shows a sixth of a turn.
    How long a cause lasts is read from speeds, which a viewer judges to about 40 %.

    Returns:
        Body lengths for moves, degrees for turns, relative change of length (or depth of a squeeze), seconds; None if
        such a quantity says nothing about such a motion.
    """
    value, axial, least = amount.value, kind in AXIAL, 0.2
    match amount.unit:
        case "seconds":
            name, width, least = "seconds", max(0.4 * value, 0.2), 0.0
        case "degrees":
            width = max(min(0.2 * value, _TOLD_TURN), _LOST_TURN * value, STILL_DEGREES)
            name = "degrees"
        case "factor" if not axial:
            return None
        case unit:
            value = {"metres": value / brief.size, "factor": abs(value - 1.0)}.get(unit, value)
            name = "of its length" if axial else "body lengths"
            share = _FALLEN if kind is MotionKind.FALL else 0.2
            width = max(share * value, _TOLD_STRAIN if axial else LEAST)
    lies = _LIES if kind is MotionKind.FALL and name == "body lengths" else 0.0
    return Tolerance(max(value - width, least * value), value, value + width + lies, name)
