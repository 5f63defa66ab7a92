"""The skill `enforce_particle_rotation`: particles turn at a prescribed rate."""

from __future__ import annotations

import math

from physagent_jax.forces.calibration import TURN
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import draw_turn


class ParticleRotation(Skill):
    """The angular velocity k M v of its particles about their own centre, with k = theta / T and theta = `TURN`."""

    name = "enforce_particle_rotation"
    group = "constraints"
    meaning = (
        "turns the region's particles about the axis `vector` through their own centre; "
        "a twist is two of them, on opposite ends and opposed"
    )
    one_means = f"{math.degrees(TURN):g} degrees per clip"
    quantity, unit = "rotation", "rad/s"
    effect = "keeps turning {turn}"
    causes = ("rotate",)
    is_axis = True

    def make_forces(self, bound):
        """The force that lets what tips over lie where it falls."""
        return bound.let_land()

    def make_constraints(self, bound):
        """The particles' prescribed motion."""
        import numpy as np

        return bound.hold(bound.leaf(np.zeros(3)), bound.vector(bound.scaling.rotation))

    def make_pair(self, bound, other, sign):
        """The whole is wrung: every section turns in proportion to its distance from the middle, or the held end."""
        return bound.wring(other, bound.scaling.rotation, sign)

    def draw_icon(self, reverse):
        """A turning arrow about the axis."""
        return draw_turn()
