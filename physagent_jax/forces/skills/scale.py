"""The skill `scale`: a stretch or a squeeze along an axis."""

from __future__ import annotations

from physagent_jax.forces.calibration import STRAIN, STRETCH_RAMP
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import draw_double_arrow


class Scale(Skill):
    """The acceleration a = k M sgn(d) v, d = (x - x_c) . v, with k = 4 E e / (rho L) and e = `STRAIN`.

    x_c is the present mass centre; e is the linear mean strain of a uniform bar of length L. k is divided by the
    shape's stress concentration along the axis where that exceeds 1. M = 1 then strains no section more than the
    middle of the bar. From a mean strain of `STRETCH_FADES` on the pull fades. On a part, or on what is held, k is
    measured (`scene.response`).
    """

    name = "scale"
    meaning = "a stretch along the axis `vector` (a squeeze with a negative magnitude), held while it acts"
    one_means = f"a linear strain of {STRAIN:g}"
    quantity, unit = "scale", "m/s\u00b2"
    effect, reverse_effect = "stretches along {axis}", "squeezes along {axis}"
    causes = ("stretch", "squeeze")
    is_two_sided = True
    is_memoryless = False  # it grows with its window
    prescribed_by = "enforce_particle_translation"

    def make_forces(self, bound):
        """A pull on the two sides."""
        from physagent_jax.forces.terms import Stretch

        start, end = bound.window
        k = self.find_k(bound.scaling, bound.values.vector)
        spared = 1.0 if bound.scaling.measured else bound.stress_concentration()
        strength = bound.leaf(k * bound.values.magnitude / spared)
        axis = bound.leaf(bound.values.vector)
        ramp, reach = STRETCH_RAMP * (end - start), bound.leaf(bound.reach())
        return [Stretch(axis, strength, start, end, ramp, bound.weight, reach=reach)]

    def draw_icon(self, reverse):
        """A double arrow."""
        return draw_double_arrow(inwards=reverse)
