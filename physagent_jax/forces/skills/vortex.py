"""The skill `vortex`: a swirl about an axis, which turns what is near it more than what is far."""

from __future__ import annotations

import math

from physagent_jax.forces.calibration import TURN
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import draw_turn

CORE = 0.25
"""[L] radius of the core, within which the swirl grows with the distance; outside it fades as 1 / distance."""


class Vortex(Skill):
    """The acceleration a = k M 2 (v x d) / (1 + (d / c)^2), d across the axis through the middle at rest, c = `CORE` L.

    This is Kaufmann's smooth form of Rankine's vortex: tangential, solid at the axis, 1 / d far from it. With
    k = 2 theta / T^2 and theta = `TURN`, what is at the core's edge goes round by theta. A rigid body turns by the mean
    of what acts on it, and a soft one is twisted. The axis is a place in space: it does not move with the object.
    """

    name = "vortex"
    meaning = (
        "a swirl about the axis `vector` (right-hand rule) through the object's middle, strongest a quarter of its "
        "length from the axis and weaker beyond, so that it twists what is soft; at magnitude 1, over the whole clip "
        "and unopposed, what is there goes round by a quarter turn"
    )
    one_means = f"unopposed, {math.degrees(TURN):g} degrees at the core's edge by the clip's end"
    quantity, unit = "torque", "rad/s\u00b2"
    effect = "swirls {turn}"
    causes = ("rotate",)
    nouns = ("vortex", "vortices", "whirlpool", "whirlpools", "whirlwind", "whirlwinds")
    verbs = ("swirl around", "swirl ~ around", "swirl about")
    towards = "up"
    is_axis = True

    def make_forces(self, bound):
        """The swirl, and the force that overcomes friction."""
        from physagent_jax.forces import terms
        from physagent_jax.forces.envelope import Envelope
        from physagent_jax.forces.opposition import oppose_turn

        core = max(CORE * bound.extent, 1e-12)
        share = bound.average_turn(lambda squared: 2 / (1 + squared / core**2))
        k = self.find_k(bound.scaling, bound.values.vector)
        turn = 2 * oppose_turn(bound.opposition, k * share, *bound.directed) / share  # at the axis
        none, one = bound.leaf(0.0), bound.leaf(1.0)
        swirl = terms.Vortex(
            point=bound.leaf(bound.centre),
            axis=bound.leaf(bound.values.vector),
            swirl=bound.leaf(turn * core),
            inward=none,
            axial=none,
            core=bound.leaf(core),
            power=one,
            envelope=Envelope.constant(*bound.window),
            weight=bound.weight,
        )
        return [swirl, *bound.overcome_rubbing(k * share)]

    def draw_icon(self, reverse):
        """A spiral about the axis."""
        return draw_turn(first=0.15, last=0.9, turns=1.75)
