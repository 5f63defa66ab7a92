"""The meaning of a quantity for a motion: a distance, an angle, a share of the size.

A target for whoever judges, and the magnitude that reaches it where nothing opposes (`forces.calibration`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_jax.agents.rules.language.modifiers import Names
from physagent_jax.agents.grammar.measures import Quantity
from physagent_jax.agents.rules.language.verbs import Effect, Verb
from physagent_jax.agents.rules.tolerances import MOVE, TURN, pick_band
from physagent_jax.agents.schema import Amount, SceneBrief
from physagent_jax.agents.vectors import clamp
from physagent_jax.forces import calibration
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN

MOST = 1e5  # of any unit, as in `agents.schema.Amount`: more is no target
_AXES: dict[str, Names] = {"height": ("up",), "width": ("right",), "depth": ("toward",)}
_TRAVELS = (Effect.PUSH, Effect.STRIKE, Effect.ROLL, Effect.SWAY, Effect.LEAN, Effect.JUMP)
_TURNS = (Effect.TURN, Effect.LEAN, Effect.SWAY, Effect.TOPPLE, Effect.ROLL)
_SCALES = (Effect.SCALE, Effect.SWELL)
_SAME_HEIGHT = 0.1
"""[body lengths] by which a height may differ from the one that everything is dropped from."""

_STRAIN_PER_M = 0.2
"""[1] that a stretch or squeeze shows for M = 1: between the linear 0.15 and what soft solids do at full strength."""


@dataclass(frozen=True)
class Target:
    """The target that a quantity sets for an event.

    Attributes:
        amount: The target; None if the quantity does not fit the motion.
        names: The axis that it names; empty = none.
        everywhere: Whether all dimensions change.
        sign: Sign of a stretch (+1) or squeeze (-1) that the quantity alone tells.
        usual: Whether the quantity is what the motion has by itself: there is nothing to aim at.
    """

    amount: Amount | None
    names: Names = ()
    everywhere: bool = False
    sign: int = 0
    usual: bool = False


def find_target(quantity: Quantity, verb: Verb, before: Amount | None) -> Target:
    """The target that ``quantity`` sets for ``verb``; ``before`` is the target of the event before."""
    value, unit, effect = quantity.value, quantity.unit, verb.effect
    if quantity.dimension == "far":
        fits = {"lengths": _TRAVELS, "metres": _TRAVELS, "degrees": _TURNS}
        known = before is not None and effect in fits.get(before.unit, ())
        return Target(before.model_copy(update={"value": before.value * value}) if known and before else None)
    if value > MOST:
        return Target(None)
    if unit == "degrees" and effect in _TURNS:
        return Target(Amount(value=value, unit="degrees"))
    if unit == "lengths" and effect in _TRAVELS:
        return Target(Amount(value=value, unit="lengths"))
    if unit == "metres" and effect in _TRAVELS:
        return Target(Amount(value=value, unit="metres"))
    if effect is Effect.FALL and (unit == "lengths" or unit == "share" and quantity.dimension == "length"):
        return Target(None, usual=abs(value - calibration.DROP_HEIGHT) <= _SAME_HEIGHT)
    becomes = quantity.goal or quantity.acts  # "pull it to twice its length", "until it is half as tall"
    if unit == "share" and effect in _TRAVELS and quantity.dimension and not becomes:
        return Target(Amount(value=value, unit="lengths"))
    if unit == "share" and effect in _SCALES and quantity.dimension != "volume":
        return _find_scale(quantity, verb)
    return Target(None)


def _find_scale(quantity: Quantity, verb: Verb) -> Target:
    """A share as a factor of the extent: "to half", "by half", "by 30 percent"."""
    sign = verb.sign
    factor = 1.0 + sign * quantity.value if quantity.relative else quantity.value
    if (factor - 1.0) * sign <= 0:  # "stretch it to half its length", "squeeze it by 120 percent"
        return Target(None)
    axis = _AXES.get(quantity.dimension, ())
    amount = Amount(value=round(factor, 6), unit="factor") if factor > 0 else None
    return Target(amount, axis, quantity.dimension == "size", sign)


def find_lengths(amount: Amount | None, brief: SceneBrief) -> float | None:
    """A distance in body lengths; None if the amount is none."""
    if amount is None or amount.unit not in ("lengths", "metres"):
        return None
    return amount.value / (brief.size if amount.unit == "metres" else 1.0)


def find_effort(amount: Amount | None, effect: Effect, brief: SceneBrief) -> float | None:
    """The effort for a free object: 1 is what M = 1 does from rest in the reference time; None = no matter."""
    lengths = find_lengths(amount, brief)
    if lengths is not None:
        return lengths / calibration.TRAVEL
    if amount is not None and amount.unit == "degrees" and effect in (Effect.TURN, Effect.LEAN, Effect.ROLL):
        return math.radians(amount.value) / calibration.TURN
    return None


def find_word_effort(strength: float, effect: Effect) -> float | None:
    """The same for what a word promises a viewer, without a quantity; None = no matter."""
    if effect is Effect.PUSH:
        return pick_band(MOVE, strength, "body lengths").target / calibration.TRAVEL
    if effect is Effect.TURN:
        return math.radians(pick_band(TURN, strength, "degrees").target) / calibration.TURN
    return None


def find_reference_seconds(brief: SceneBrief) -> float:
    """T of a free object's skills [s]."""
    return min((brief.frame_count - 1) * brief.frame_dt, calibration.REFERENCE_TIME)


def find_span(effort: float, usual: float, brief: SceneBrief) -> float:
    """The time for which an object is pushed and then braked, so that a magnitude in range brings it there [s].

    Half of the time it is pushed, half braked: it gets M (t / T)^2 / 2 of what M = 1 does in T.
    """
    reference = calibration.REFERENCE_TIME
    shortest, longest = (reference * math.sqrt(2.0 * effort / m) for m in (MAGNITUDE_MAX, MAGNITUDE_MIN))
    return clamp(usual, shortest, max(longest, 4.0 * brief.frame_dt))


def find_magnitude(effort: float, seconds: float, braked: bool, brief: SceneBrief) -> float:
    """M that reaches ``effort`` in ``seconds``, from rest; out of range if it cannot."""
    reference = find_reference_seconds(brief)
    return (2.0 if braked else 1.0) * effort * (reference / max(seconds, brief.frame_dt)) ** 2


def find_held_magnitude(amount: Amount, effect: Effect, brief: SceneBrief) -> float | None:
    """M that bends or turns something held about as far."""
    if effect is Effect.SWAY:
        return find_swing_magnitude(amount, True, brief)
    lengths = find_lengths(amount, brief)
    if lengths is not None:
        return lengths / calibration.EXPECTED_HELD_SHIFT
    return amount.value / calibration.EXPECTED_HELD_TURN if amount.unit == "degrees" else None


def find_swing_magnitude(amount: Amount, held: bool, brief: SceneBrief) -> float | None:
    """M that swings something about as far to either side."""
    lengths = find_lengths(amount, brief)
    if lengths is not None:
        return lengths / (calibration.EXPECTED_SWAY if held else calibration.SWING)
    return amount.value / calibration.EXPECTED_HELD_TURN if held and amount.unit == "degrees" else None


def find_strain_magnitude(amount: Amount) -> float:
    """M whose stretch or squeeze comes near a factor."""
    return abs(amount.value - 1.0) / _STRAIN_PER_M
