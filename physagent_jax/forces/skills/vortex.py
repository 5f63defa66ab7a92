"""The skill `vortex`: a swirl about an axis, which turns what is near it more than what is far."""

from __future__ import annotations

import math

from physagent_jax.forces.calibration import TURN
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import draw_turn

CORE = 0.25
"""[L] radius of the core, within which the swirl grows with the distance; outside it fades as 1 / distance."""


class Vortex(Skill):
    """The acceleration a = k M w(d) / <w> (v x d), w = 1 / (1 + (d / c)^2), d across the axis, c = `CORE` L.

    This is Kaufmann's smooth form of Rankine's vortex: tangential, solid at the axis, 1 / d far from it. The axis goes
    through the middle at rest and stays there: it is a place in space. <w> is the mean by moments of inertia, so that a
    rigid body turns as by a torque, with k = 2 theta / T^2 and theta = `TURN`. What is soft is twisted. A part,
    and what is held, is turned as by a torque.
    """

    name = "vortex"
    meaning = (
        "a swirl about the axis `vector` (right-hand rule) through the object's middle, strongest a quarter of its "
        "length from the axis and weaker beyond, so that it twists what is soft; at magnitude 1, over the whole clip "
        "and unopposed, it is a quarter turn on average"
    )
    one_means = f"unopposed, {math.degrees(TURN):g} degrees on average by the clip's end"
    quantity, unit = "torque", "rad/s\u00b2"
    effect = "swirls {turn}"
    causes = ("rotate",)
    nouns = ("vortex", "vortices", "whirlpool", "whirlpools", "whirlwind", "whirlwinds")
    verbs = ("swirl around", "swirl ~ around", "swirl about")
    towards = "up"
    is_axis = True

    def make_forces(self, bound):
        """The swirl, and the force that overcomes friction and weight."""
        from physagent_jax.forces import terms
        from physagent_jax.forces.envelope import Envelope

        if bound.scaling.measured:  # a place in space would push what bends about it aside
            k = self.find_k(bound.scaling, bound.values.vector)
            turn = bound.leaf(k * bound.values.magnitude)
            swirl = terms.Torque(bound.leaf(bound.values.vector), turn, *bound.window, bound.weight)
            return [swirl, *bound.overcome_righting(k)]
        core = max(CORE * bound.extent, 1e-12)
        share = bound.average_turn(lambda squared: 1 / (1 + squared / core**2))
        k = self.find_k(bound.scaling, bound.values.vector)
        turn = k * bound.values.magnitude / share  # at the axis
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
        return [swirl, *bound.overcome_righting(k)]

    def draw_icon(self, reverse):
        """A spiral about the axis."""
        return draw_turn(first=0.15, last=0.9, turns=1.75)
