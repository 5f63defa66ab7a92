"""The meaning of a magnitude of 1: the numbers that skills, camera, agents and report share.

Plain numbers, so that agents read them without arrays. Lengths are in body lengths (L, the object's longest extent)
and times in clips (T) unless a unit is given. A skill at M = 1 does what is said here to a free object on which nothing
else acts; the formulas are in `forces.scaling`.
"""

from __future__ import annotations

import math

# --- the range of the library -----------------------------------------------------------------------------------------

MAGNITUDE_MIN = 0.4
"""Least abs(M): the paper's. Weaker is hardly seen in a clip."""

MAGNITUDE_MAX = 1.6
"""Greatest abs(M): the paper's. Stronger carries the object out of the picture."""

GAIN_MIN, GAIN_MAX = 0.02, 50.0
"""Range of the factor on k that one entry may have (`forces.schema.Action.gain`): beyond it another skill is needed."""

# --- what M = 1 does --------------------------------------------------------------------------------------------------

TRAVEL = 1.0
"""[L] that a push (``translation``) or a blow (``impulse``) at the clip's start moves the object by its end: as far as
can be seen at a glance and still fits into a picture."""

PRESCRIBED_TRAVEL = 0.5
"""[L per T] at which ``enforce_particle_translation`` moves its particles. Nothing slows prescribed particles down, so
half of what a blow gives is enough. A part, or a plate, moves by as much of the object's extent along its way: two
opposed ends then part by one such extent in T."""

TURN = math.pi / 2
"""[rad] that a ``torque`` turns the object in a clip: a quarter turn, the most that leaves no doubt about its sense."""

TIPPED, TIPPING_TIME = math.radians(90), 1.7
"""[rad], [s] that what stands is turned to tip over with a strength of 1, at most: past its balance nothing more is
made up for, and its weight turns it faster than that."""

SWING = 0.16
"""[L] to either side that a free object goes with M = 1 where pushes to and fro follow each other (`forces.swinging`):
M = 0.4 and 1.6 are then just what viewers call slight and strong."""

STRAIN = 0.15
"""[1] linear mean strain of a free bar under ``scale``. Soft solids stretch more than linearly: a neo-Hookean bar shows
0.17 at M = 1, and more than in proportion above (`STRETCH_FADES`)."""

STRETCH_RAMP = 0.4
"""[share of the window] over which a ``scale`` grows to its full strength: the object then follows without ringing."""

STRETCH_FADES = (0.3, 0.5)
"""[1] mean strain from which on the pull of a ``scale`` fades, and at which none is left. No magnitude asks for more;
what strains unevenly, as a head on a neck, would tear off at M = 1.6 with no more than that on average."""

REFERENCE_TIME = 2.0
"""[s] T of a free object, at most; a shorter clip is its own T. A longer clip leaves time for more, it does not make
what happens in it slower."""

QUICK = 0.5
"""[s] that what is over in an instant takes: a flinch, a sudden turn. No force in range starts and stops it so soon."""

BLOW = 0.2
"""[s] in which a blow swings a limb out, or presses what stands."""

RETREAT = 0.4
"""[s] in which a plate that has pressed goes back to where it came from."""

HELD_TIME = 0.7
"""[s] T for what is held somewhere, whatever the clip's length: it cannot leave the picture and has to be bent, which a
field of four tenths of gravity does to a plant of 1 m (2 L / T^2)."""

# --- what M = 1 usually shows of what is held; a quantity in the sentence sets M in proportion ------------------------
# What viewers expect does not follow from these numbers: see `motion.tolerances`.

EXPECTED_HELD_SHIFT = 0.17
"""[L] by which the centre of something held moves when it is pushed."""

HELD_RANGE = 8.0
"""[1] how many times less than 2 L / `HELD_TIME`^2 a push of something held may be: what is soft is not blown away."""

HELD_MOST = 100.0
"""[1] how many times more it may be: what is stiffer is not bent visibly."""

EXPECTED_HELD_TURN = 25.0
"""[degrees] by which something held turns: it twists and springs back."""

EXPECTED_SWAY = 0.1
"""[L] to either side when something held sways."""

# --- what M = 1 shows of a part, and of what is held and turned or stretched (`scene.response`) -----------------------

PART_SHIFT = 0.3
"""[L] by which a part moves when it is pushed or hit."""

PART_BEND = 0.8
"""[1] the same in lengths of the part itself, at most: a short ear cannot go farther."""

PART_TURN = 45.0
"""[degrees] by which a part, or what is held, is turned."""

PART_STRAIN = 0.16
"""[1] linear strain of a part, or of what is held."""

# --- where the object will be (`scene.fuse`) --------------------------------------------------------------------------

GRAVITY = 9.8
"""[m/s^2] of a world with gravity."""

ALOFT = 0.75
"""[share] of its time that each of several leaps is in the air, at most."""

FRICTION = 0.4
"""[1] Coulomb coefficient of the ground, unless it is given: dry wood, plastic or ceramics on a floor have
0.2 to 0.5."""

DROP_HEIGHT = 0.5
"""[L] of clear height under what can fall: it is seen to fall, and lands within a clip."""

HIGH_DROP = 1.2
"""[L] the same of what falls from high up: more than its own height."""

MOST_DROP = 1.3
"""[L] the same at most: the domain of a preset has no more room below an object."""

SWEEP = MAGNITUDE_MAX * TRAVEL
"""[L] that the camera looks ahead of a free object, at most: the travel of the strongest push."""

HELD_SWEEP = 0.35
"""[L] the same for what is held: it bends and comes back."""

ROOM = 0.15
"""[L] that the picture leaves around the object to stretch, turn and sway; sideways."""

ROOM_UPWARD = 0.6
"""[share of ROOM] that it leaves above and below: what sways moves less there."""

FLOOR_ROOM = 0.12
"""[L] that the picture leaves below the floor: the near edge of what lies on it hangs lower."""


def find_reference_time(held: bool, duration: float) -> float:
    """T of the skill table [s]: the clip, but no more than `REFERENCE_TIME`; `HELD_TIME` for what is held somewhere.

    A long clip does not make its actions slower.

    Args:
        held: Whether the object is held somewhere.
        duration: Duration of the clip [s].
    """
    return HELD_TIME if held else min(duration, REFERENCE_TIME)


def find_magnitude(effort: float, seconds: float, duration: float, *, braked: bool) -> float:
    """M that brings a free object so far from rest; out of range if it cannot.

    Args:
        effort: The way or the turn, in those of M = 1.
        seconds: Time that it has [s].
        duration: Duration of the clip [s].
        braked: Whether it is stopped in the second half of that time.
    """
    reference = find_reference_time(False, duration)
    return (2.0 if braked else 1.0) * effort * (reference / seconds) ** 2


def find_tipping(strength: float, longest: float, duration: float) -> tuple[float, float]:
    """M and time [s] of a torque that tips over what stands; the strength says how soon.

    Args:
        strength: 1 is plain.
        longest: Time that there is [s].
        duration: Duration of the clip [s].
    """
    seconds = max(min(TIPPING_TIME / math.sqrt(strength), longest), 1e-3)
    return find_magnitude(TIPPED / TURN, seconds, duration, braked=False), seconds


def find_highest_leap(seconds: float) -> float:
    """Rise [m] of a leap, at most, after which there is time to land and to stand before the next one.

    It is in the air for sqrt(8 h / g).

    Args:
        seconds: Time from one leap to the next [s].
    """
    return GRAVITY * (ALOFT * seconds) ** 2 / 8.0


def find_flight(rise: float) -> float:
    """Time [s] in which what rises by a height [m] is down again."""
    return math.sqrt(8.0 * rise / GRAVITY)


def find_spin_aloft(degrees: float, rise: float, push: float, duration: float) -> float:
    """M of a torque that turns what is thrown up so far until it comes down; out of range if only a gain can.

    Args:
        degrees: Turn until then [degrees].
        rise: Height that it rises by [m].
        push: Time for which the torque acts [s].
        duration: Duration of the clip [s].
    """
    rate = math.radians(degrees) / find_flight(rise)
    return find_magnitude(rate * push / 2.0 / TURN, push, duration, braked=False)
