"""The skill `wind_gust`: a push that rises and falls within its window."""

from __future__ import annotations

import math

from physagent_jax.forces.calibration import TRAVEL
from physagent_jax.forces.skills.icons import Mark
from physagent_jax.forces.skills.translation import Translation


class WindGust(Translation):
    """The acceleration a = k M (1 - cos(2 pi s)) v, s the part of the window that is over.

    The profile is the discrete gust of aviation (14 CFR 25.341, CS-25.341). Its mean is k M with the k of a push: it
    leaves an unopposed object with the same speed and at the same place as a push of the same window does, and bends
    what is held without the jolt of one.
    """

    name = "wind_gust"
    meaning = (
        "a gust of wind along `vector`: a push that rises smoothly to twice its mean and dies away within "
        "`active_time`; at magnitude 1, over the whole clip and unopposed, it moves the object by its own longest "
        "extent"
    )
    one_means = f"on average over its window as a push: unopposed, {TRAVEL:g} body length by the clip's end"
    effect = "blows {direction}"
    causes = ("move", "sway")
    nouns = ("gust", "gusts", "gust of wind", "gusts of wind", "wind gust", "wind gusts", "squall", "squalls")
    is_brief = True
    is_memoryless = superposes = swings = False
    prescribed_by = None

    def make_forces(self, bound):
        """The gust, and the force that overcomes friction."""
        from physagent_jax.forces.envelope import Envelope
        from physagent_jax.forces.opposition import oppose_push
        from physagent_jax.forces.terms import UniformField

        push = oppose_push(
            bound.known_opposition, self.find_k(bound.scaling, bound.values.vector), *bound.directed
        )
        gust = UniformField(bound.along(2 * push), Envelope.pulse(*bound.window), bound.weight)
        return [gust, *bound.overcome_friction(bound.scaling.translation, pulse=True), *bound.keep_balance()]

    def accelerate(self, gained, entry):
        """The velocity gained in each interval."""
        import numpy as np

        first, last = entry.values.window
        rate = 2 * math.pi / (last - first)
        low, high = (np.clip(at, first, last) - first for at in (entry.begin, entry.begin + 1))
        frames = high - low - (np.sin(rate * high) - np.sin(rate * low)) / rate
        return gained + entry.direct(entry.scaling.translation) * entry.frame_dt * frames[:, None]

    def draw_icon(self, reverse):
        """Three streaks of air, the middle one an arrow."""
        streaks = [((-0.5, side, 0.0), (0.3, side, 0.0)) for side in (0.45, -0.45)]
        return Mark(((-0.9, 0.0, 0.0), (1.0, 0.0, 0.0))), *(Mark(streak, "line") for streak in streaks)
