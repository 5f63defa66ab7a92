"""The skill `shatter`: the object goes to pieces at once."""

from __future__ import annotations

from physagent_jax.forces.calibration import TRAVEL
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import draw_arrow

PIECES = 32
"""Number of pieces."""


class Shatter(Skill):
    """`PIECES` pieces, which fly apart over the ground with about k M when the window begins.

    k = s L / T with s = `TRAVEL`, as of a blow. The vector is the way up, from what it stands on or has hit. Nothing of
    it is cracked before, and nothing holds the pieces together afterwards.
    """

    name = "shatter"
    group = "constraints"
    meaning = (
        "the whole object breaks into pieces when `active_time` begins; they fly apart, away from what lies "
        "below it against `vector`"
    )
    one_means = f"{PIECES} pieces, which go apart by {TRAVEL:g} body length per clip until they are stopped"
    quantity, unit = "impulse", "m/s"
    effect = "breaks into pieces that fly apart and {direction}"
    causes = ("fall",)
    is_sudden = True
    is_memoryless = False  # it happens once

    def make_constraints(self, bound):
        """The fragments."""
        return bound.shatter(self.find_k(bound.scaling, bound.values.vector), PIECES)

    def draw_icon(self, reverse):
        """An arrow that bursts forth."""
        return draw_arrow("burst")
