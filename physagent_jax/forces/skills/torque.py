"""The skill `torque`: a steady turn of a rigid body."""

from __future__ import annotations

import math

from physagent_jax.forces.calibration import TURN
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import draw_turn


class Torque(Skill):
    """The acceleration a = k M (v x r), r = x - x_c, with k = 2 theta / T^2 and theta = `TURN`.

    x_c is the present mass centre. Friction and what holds it upright are made up for (`forces.opposition`).
    """

    name = "torque"
    meaning = (
        "a steady turn about the axis `vector` (right-hand rule) through the mass centre; at "
        "magnitude 1, over the whole clip and unopposed, it is a quarter turn"
    )
    one_means = f"unopposed, {math.degrees(TURN):g} degrees by the clip's end"
    quantity, unit = "torque", "rad/s\u00b2"
    effect = "turns {turn}"
    causes = ("rotate",)
    is_axis = True
    prescribed_by = "enforce_particle_rotation"

    def make_forces(self, bound):
        """The turn, what overcomes friction and weight, keeps up what rolls on its edge, and lets what rolled rest."""
        from physagent_jax.forces import terms

        k = self.find_k(bound.scaling, bound.values.vector)
        turn, axis = bound.leaf(k * bound.values.magnitude), bound.leaf(bound.values.vector)
        made = [terms.Torque(axis, turn, *bound.window, bound.weight), *bound.overcome_righting(k)]
        return [*made, *bound.keep_axle(), *bound.let_settle()]

    def draw_icon(self, reverse):
        """A turning arrow about the axis."""
        return draw_turn()
