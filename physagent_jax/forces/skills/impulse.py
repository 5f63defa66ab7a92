"""The skill `impulse`: a blow, spread over a short window."""

from __future__ import annotations

from physagent_jax.forces.calibration import TRAVEL
from physagent_jax.forces.skills.base import Skill
from physagent_jax.forces.skills.icons import draw_arrow

PEAK = 3.0
"""[1] speed of the spot that is struck, over that of the whole: soft matter is dented before it follows."""

STEEP = 0.9
"""[1] vertical share of a blow from which on it is a leap, or a throw upwards, after which it lands on its feet."""

DENT_DEPTH, DENT_WIDTH = 0.3, 0.25
"""[1] of its extent along the blow, [L] across: how far the spot reaches."""


class Blow(Skill):
    """The common part of both forms of a blow: a velocity change k M v, with k = s L / T and s = `TRAVEL`.

    What is held goes by its compliance (`forces.holding`); friction and weight are made up for (`forces.opposition`).
    """

    one_means = f"unopposed, {TRAVEL:g} body length from the clip's start to its end"
    quantity, unit = "impulse", "m/s"
    causes = ("move", "sway", "fall")
    is_sudden = True
    is_memoryless = False  # it is spread over its window

    def find_k(self, scaling, vector):
        """The k of a blow [m/s]."""
        from physagent_jax.forces.holding import find_blow_scale

        return find_blow_scale(scaling.holding, scaling.impulse, vector)

    def explain_one(self, scaling, vector, swing):
        """The k of an entry and its meaning, for the report."""
        k, meaning = super().explain_one(scaling, vector, swing)
        held = scaling.holding
        return k, meaning if held is None else f"what is held is to move by {held.shift:.3g} m"

    def find_weight(self, bound):
        """The particles' weights: most for the side that is struck, where it is a side and not what it stands on."""
        from physagent_jax.forces.opposition import RISES

        if not bound.whole or bound.upwards >= RISES:
            return bound.weight
        return bound.concentrate(PEAK, DENT_DEPTH, DENT_WIDTH)

    def find_speed(self, bound):
        """The velocity change along the vector that the entry asks for [m/s]."""
        from physagent_jax.forces.opposition import oppose_blow

        k = self.find_k(bound.scaling, bound.values.vector)
        return oppose_blow(bound.opposition, k, *bound.directed)


class Impulse(Blow):
    """The blow, spread evenly over its window."""

    name = "impulse"
    meaning = (
        "a blow along `vector`, spread over `active_time`; at magnitude 1 and unopposed the object "
        "then travels its own longest extent in a clip's duration"
    )
    effect = "kicks {direction}"
    prescribed_by = "particle_impulse"

    def make_forces(self, bound):
        """The acceleration that makes the velocity change within the window; what it throws up lands upright.

        What is thrown aside tumbles as it lands. A blow upwards after a fall or another such blow does not add its
        speed to what is left of that, but ends with it (`forces.terms.Launch`).
        """
        from physagent_jax.forces.terms import Launch, UniformAcceleration

        (start, end), leaps = bound.window, bound.whole and bound.upwards >= STEEP
        speed = bound.along(self.find_speed(bound))
        if leaps and bound.again:  # it may rebound, or fall, as the next leap begins
            weight = 0.0 if bound.opposition is None else bound.upwards * bound.opposition.weight
            slows = bound.leaf(weight) if weight else None
            return [Launch(speed, start, end, slows), *bound.keep_balance()]
        blow = UniformAcceleration(speed / (end - start), start, end, self.find_weight(bound))
        return [blow, *(bound.keep_balance() if leaps else [])]

    def accelerate(self, gained, entry):
        """The velocity gained in each interval."""
        first, last = entry.values.window
        return gained + entry.direct(entry.scaling.impulse) * (entry.frames / (last - first))[:, None]

    def draw_icon(self, reverse):
        """An arrow that bursts forth."""
        return draw_arrow("burst")
