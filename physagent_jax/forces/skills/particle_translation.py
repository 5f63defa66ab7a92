"""The skill `enforce_particle_translation`: particles move at a prescribed velocity."""

from __future__ import annotations

from physagent_jax.forces.calibration import PRESCRIBED_TRAVEL
from physagent_jax.forces.skills.base import Skill


class ParticleTranslation(Skill):
    """The velocity k M v of its particles, with k = s L / T and s = `PRESCRIBED_TRAVEL`.

    For a part, W takes the place of L: the object's extent along v. Two opposed ends then change it by 2 s M t / T of
    it during a time t, however thin the object is there; what lies between them follows in proportion.

    Of the whole, with the least gain that there is and then held, it prescribes nothing: it stands for the landing of
    what has jumped, which gets up the faster the larger M is (`forces.schema.is_stop`, `forces.terms.Touchdown`).
    """

    name = "enforce_particle_translation"
    group = "constraints"
    meaning = (
        "holds the region's particles at a velocity along `vector` while it acts; a "
        "stretch or squeeze is exactly two of them, on opposite ends and opposed"
    )
    one_means = f"{PRESCRIBED_TRAVEL:g} body lengths per clip"
    quantity, unit = "velocity", "m/s"
    effect = "keeps moving {direction}"
    causes = ("move", "sway", "fall", "stretch", "squeeze")
    deforms = "ends"

    def make_forces(self, bound):
        """The force that takes up a landing, where an entry stands for that (`forces.schema.is_stop`)."""
        return bound.limit_rebound() if bound.stops else []

    def make_constraints(self, bound):
        """The particles' prescribed motion; none of what only takes up a rebound."""
        import numpy as np

        if bound.stops:
            return []
        k = bound.scaling.velocity * (1.0 if bound.whole else bound.width())
        return bound.hold(bound.vector(k), bound.leaf(np.zeros(3)))

    def make_pair(self, bound, other, sign):
        """The whole gets longer or shorter evenly."""
        return bound.change_length(other, bound.scaling.velocity * bound.width(), sign)

    def accelerate(self, gained, entry):
        """The velocity of the whole becomes the prescribed one inside the window, and stays it."""
        import numpy as np

        if not entry.whole:
            return gained
        first, last = entry.values.window
        speed = np.cumsum(gained, axis=0)
        inside = (entry.begin + 1 > first) & (entry.begin < last)
        speed[inside] = entry.direct(entry.scaling.velocity)
        return np.diff(speed, axis=0, prepend=0)
