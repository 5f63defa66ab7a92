"""The skill `particle_impulse`: a blow that acts at once."""

from __future__ import annotations

from physagent_jax.forces.skills.icons import draw_arrow
from physagent_jax.forces.skills.impulse import Blow


class ParticleImpulse(Blow):
    """The velocity change of a blow in the one substep in which its window begins."""

    name = "particle_impulse"
    group = "constraints"
    meaning = "adds a velocity along `vector` at once, when `active_time` begins"
    effect = "is knocked once {direction}"
    stacks_with = "impulse"

    def make_forces(self, bound):
        """The change of velocity at the window's start."""
        from physagent_jax.forces.terms import VelocityChange

        value = bound.along(self.find_speed(bound))
        return [VelocityChange(value, bound.instant, bound.instant, self.find_weight(bound))]

    def accelerate(self, gained, entry):
        """The velocity gained in the interval in which it strikes."""
        import numpy as np

        at = np.floor(entry.values.window[0]) == entry.begin
        return gained + entry.direct(entry.scaling.impulse) * at[:, None]

    def draw_icon(self, reverse):
        """An arrow that bursts forth."""
        return draw_arrow("burst")
