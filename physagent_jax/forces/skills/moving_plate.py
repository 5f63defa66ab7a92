"""The skill `moving_plate`: a plate presses into the object."""

from __future__ import annotations

from physagent_jax.forces.calibration import PRESCRIBED_TRAVEL
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import Mark, draw_arrow


class MovingPlate(Skill):
    """A plate that starts at the object's side, across v, and moves with k M v into it.

    k = s W / T with s = `PRESCRIBED_TRAVEL` and W the object's extent along v. On a region it is of the region's size,
    and W the region's extent.
    """

    name = "moving_plate"
    group = "constraints"
    meaning = "a plate at the object's side moves along `vector` into it; two opposed ones press it"
    one_means = f"{PRESCRIBED_TRAVEL:g} body lengths per clip"
    quantity, unit = "velocity", "m/s"
    effect = "a plate moves {direction}"
    causes = ("squeeze",)
    deforms = "plates"

    def make_constraints(self, bound):
        """The moving plate, the one that stands where it was brought, and the one that goes back."""
        return bound.press(bound.scaling.velocity * bound.width(chosen=True))

    def make_pair(self, bound, other, sign):
        """The plates, and the even squeeze of what lies between them."""
        k = bound.scaling.velocity * bound.width()
        plates = [*bound.press(k), *([] if other is None else other.press(k))]
        return [*plates, *bound.change_length(other, k, sign, retreats=True)]

    def draw_icon(self, reverse):
        """An arrow with the plate behind it."""
        plate = [(-0.8, x, y) for x, y in ((-0.4, -0.4), (-0.4, 0.4), (0.4, 0.4), (0.4, -0.4), (-0.4, -0.4))]
        return (*draw_arrow(), Mark(tuple(plate), "line"))
