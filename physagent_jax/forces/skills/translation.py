"""The skill `translation`: a steady push."""

from __future__ import annotations

from physagent_jax.forces.calibration import SWING, TRAVEL
from physagent_jax.forces.skills.base import Skill


class Translation(Skill):
    """The same acceleration a = k M v at every particle, with k = 2 s L / T^2 and s = `TRAVEL`.

    One of several to and fro has a k of its own (`forces.swinging`), with which M = 1 goes by `SWING` L to either side;
    what is held goes by its compliance (`forces.holding`). Friction and weight are made up for (`forces.opposition`),
    and what stands stays upright.
    """

    name = "translation"
    meaning = (
        "a steady push along `vector`; at magnitude 1, over the whole clip and unopposed, it moves "
        "the object by its own longest extent"
    )
    one_means = f"unopposed, {TRAVEL:g} body length by the clip's end"
    quantity, unit = "translation", "m/s\u00b2"
    effect = "pushes {direction}"
    causes = ("move", "sway", "fall")
    swings = True
    prescribed_by = "enforce_particle_translation"

    def find_k(self, scaling, vector):
        """The k of a push that is none of a swing [m/s^2]."""
        from physagent_jax.forces.holding import find_push_scale

        return find_push_scale(scaling.holding, scaling.translation, vector)

    def explain_one(self, scaling, vector, swing):
        """The k of an entry and its meaning, for the report."""
        if swing is not None and (scaling.measured or scaling.holding is not None):
            return swing, f"to and fro, {scaling.swing:.3g} m to either side"
        if swing is not None:
            return swing, f"to and fro, {SWING:g} body lengths to either side"
        if scaling.holding is not None:
            return (
                float(self.find_k(scaling, vector)),
                f"what is held is to move by {scaling.holding.shift:.3g} m",
            )
        return super().explain_one(scaling, vector, swing)

    def make_forces(self, bound):
        """The push, and the force that overcomes friction."""
        from physagent_jax.forces.opposition import oppose_push, oppose_swing
        from physagent_jax.forces.terms import UniformAcceleration

        stroke = bound.stroke
        if stroke is not None and stroke.swings:
            push = oppose_swing(bound.opposition, stroke.k, *bound.directed)
        else:
            k = self.find_k(bound.scaling, bound.values.vector)
            push = oppose_push(bound.known_opposition, k, *bound.directed)
        k, before = (bound.scaling.translation, None) if stroke is None else (stroke.k, stroke.speed)
        return [
            UniformAcceleration(bound.along(push), *bound.window, bound.weight),
            *bound.overcome_friction(k, before),
            *bound.keep_balance(),
        ]

    def accelerate(self, gained, entry):
        """The velocity gained in each interval."""
        k = entry.scaling.translation if entry.stroke is None else entry.stroke.k
        return gained + entry.direct(k) * entry.frame_dt * entry.frames[:, None]
