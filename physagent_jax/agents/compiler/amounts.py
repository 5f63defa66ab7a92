"""The meaning of a quantity for a motion: a distance, an angle, a share of the size.

A target for whoever judges, and the magnitude that reaches it where nothing opposes (`forces.calibration`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from physagent_jax.agents.intent import Quantity
from physagent_jax.agents.lexicon import Effect, Motion, Names
from physagent_jax.forces import calibration
from physagent_jax.motion.efforts import find_lengths
from physagent_jax.motion.schema import Amount, SceneBrief
from physagent_jax.motion.tolerances import MOVE, TURN, pick_band

MOST = 1e5  # of any unit, as in `motion.schema.Amount`: more is no target
_LEAST = 1e-6  # of any unit
_AXES: dict[str, Names] = {"height": ("up",), "width": ("right",), "depth": ("toward",)}
_TRAVELS = (Effect.PUSH, Effect.STRIKE, Effect.ROLL, Effect.SWAY, Effect.LEAN, Effect.JUMP)
_TURNS = (Effect.TURN, Effect.LEAN, Effect.SWAY, Effect.TOPPLE, Effect.ROLL)
_SCALES = (Effect.SCALE, Effect.SWELL)
_WAYS = (*_TRAVELS, Effect.FALL)
_UNITS = {"lengths": _WAYS, "metres": _WAYS, "degrees": _TURNS}
_SPUN = (Effect.TURN, Effect.LEAN, Effect.ROLL)  # turned by a torque


class Target(NamedTuple):
    """The target that a quantity sets; None if it does not fit the motion.

    Attributes:
        amount: The target.
        names: The axis that it names; empty = none.
        everywhere: Whether all dimensions change.
    """

    amount: Amount | None = None
    names: Names = ()
    everywhere: bool = False


def find_target(quantity: Quantity, motion: Motion, before: Amount | None, brief: SceneBrief) -> Target:
    """The target that ``quantity`` sets for ``motion``; ``before`` is the target of the event before."""
    value, effect, unit = quantity.value, motion.effect, quantity.unit
    if quantity.dimension == "far" and before is not None:  # "twice as far"
        value, unit = before.value * value, before.unit
    if not _LEAST <= value <= MOST:
        return Target()
    if effect in _UNITS.get(unit, ()):
        return Target(Amount.model_validate({"value": value, "unit": unit}))
    if unit != "share" or quantity.dimension in ("far", "volume"):
        return Target()
    becomes = quantity.relation in ("to", "is")  # "pull it to twice its length", "until it is half as tall"
    reached = motion.direction == "up" and quantity.relation == "to" or effect is Effect.FALL
    if effect in _WAYS and quantity.dimension and (reached or not becomes):
        sides: dict[str, float] = dict(zip(("width", "height", "depth"), brief.extents))
        return Target(Amount(value=round(value * sides.get(quantity.dimension, 1.0), 6), unit="lengths"))
    return _find_scale(quantity, motion) if effect in _SCALES else Target()


def _find_scale(quantity: Quantity, motion: Motion) -> Target:
    """A share as a factor of the extent: "to half", "by half", "by 30 percent"."""
    factor = 1.0 + motion.sign * quantity.value if quantity.relation == "by" else quantity.value
    if (factor - 1.0) * motion.sign <= 0 or factor < _LEAST:  # "stretch it to half its length"
        return Target()
    amount = Amount(value=round(factor, 6), unit="factor")
    return Target(amount, _AXES.get(quantity.dimension, ()), quantity.dimension == "size")


def find_effort(amount: Amount | None, effect: Effect, brief: SceneBrief) -> float | None:
    """The effort for a free object: 1 is what M = 1 does from rest in the reference time; None = no matter."""
    lengths = find_lengths(amount, brief)
    if lengths is not None and effect is not Effect.FALL:
        return lengths / calibration.TRAVEL
    turned = amount is not None and amount.unit == "degrees" and effect in _SPUN
    return math.radians(amount.value) / calibration.TURN if amount and turned else None


def find_word_effort(strength: float, effect: Effect) -> float | None:
    """The same for what a word promises a viewer, without a quantity; None = no matter."""
    if effect is Effect.PUSH:
        return pick_band(MOVE, strength, "body lengths").target / calibration.TRAVEL
    if effect is Effect.TURN:
        return math.radians(pick_band(TURN, strength, "degrees").target) / calibration.TURN
    return None
