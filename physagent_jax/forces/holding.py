"""Compensation for pushes and blows of an object that is held and bends.

With C the mean displacement per uniform acceleration (`scene.compliance`), a steady push a along v moves the centre by
a v.C v, and a sudden one swings to up to twice that, less what damping takes. A blow dv sets the lowest mode going,
w^2 = 1 / (v.C v): it swings to dv / w.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.forces.schema import Holding

OVERSHOOT = 1.6  # of a sudden push, over where it would come to rest; between 1 (slow or damped) and 2


def find_push_scale(holding: Holding | None, k: float, direction):
    """k of a push along ``direction``, unit vector, shape (3,) [m/s^2]; ``k`` where nothing is known of the holding."""
    if holding is None:
        return k
    xp = jnp if isinstance(direction, Tracer) else np
    wanted = holding.shift / (OVERSHOOT * find_way(holding, direction))
    return xp.clip(wanted, holding.least, holding.most)


def find_blow_scale(holding: Holding | None, k: float, direction):
    """k of a blow along ``direction`` [m/s]; as `find_push_scale`, whose limits hold for it in proportion."""
    if holding is None:
        return k
    xp = jnp if isinstance(direction, Tracer) else np
    way = find_way(holding, direction)
    limited = xp.clip(
        holding.shift / way, holding.least, holding.most
    )  # [m/s^2], as of a push that is no longer sudden
    return xp.sqrt(holding.shift * limited)


def find_way(holding: Holding, direction):
    """The way per steady acceleration along a direction, v.C v [s^2]; unit vector, shape (3,)."""
    xp = jnp if isinstance(direction, Tracer) else np
    matrix, v = xp.asarray(holding.compliance), xp.asarray(direction)
    return xp.maximum(v @ matrix @ v, 1e-9)  # what is stiffer than that is at the limit anyway


def find_frequency(holding: Holding, direction):
    """The angular frequency with which it swings along a direction [1/s], by Rayleigh's quotient; 0 = not known."""
    if holding.square is None:
        return 0.0
    xp = jnp if isinstance(direction, Tracer) else np
    matrix, v = xp.asarray(holding.square), xp.asarray(direction)
    return xp.sqrt(find_way(holding, direction) / xp.maximum(v @ matrix @ v, 1e-30))
