"""The skill `quiver`: what is soft shakes in its own shape."""

from __future__ import annotations

from physagent_jax.forces.calibration import TRAVEL
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import draw_arrow


class Quiver(Skill):
    """The ends of the object go to and fro at first with k M, less and less, and its middle against them.

    k = s L / T with s = `TRAVEL`, as of a blow. What stands is sheared along the vector; what lies is bent up and down.
    Nothing of it goes elsewhere by that, and its own elasticity is left to it (`forces.terms.Quiver`).
    """

    name = "quiver"
    group = "constraints"
    meaning = "the object quivers like jelly while it acts, less and less: its top along `vector`, its foot against it"
    one_means = f"its ends begin with {TRAVEL:g} body length per clip"
    quantity, unit = "impulse", "m/s"
    effect = "quivers {direction} and back"
    causes = ("sway",)
    is_two_sided = True
    is_memoryless = False  # it fades

    def make_forces(self, bound):
        """The force that shakes it."""
        from physagent_jax.forces.terms import Quiver as Term

        velocity = bound.vector(self.find_k(bound.scaling, bound.values.vector))
        return [Term(velocity, *bound.window)]

    def draw_icon(self, reverse):
        """An arrow."""
        return draw_arrow()
