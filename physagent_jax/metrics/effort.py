"""The effort of a solution: the impulse that its force field gives to each kilogram."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np


def measure_effort(model: Any, x, frame_dt: float) -> float:
    """Sum over the force terms of |acceleration| times duration, averaged over the mass [m/s].

    Terms are evaluated along the clip, a frame at a time; terms that act against each other both count, and gravity,
    which is nobody's effort, does not. What prescribes a velocity counts as that velocity when it begins, for the part
    of the mass that it moves; a plate, as if it moved all.

    Args:
        model: `mpm.Model` of the scene.
        x: Its particles' true positions [m], shape (T, n, 3).
        frame_dt: Seconds per frame [s].
    """
    x, mass = jnp.asarray(x), jnp.asarray(model.mass)
    share = np.asarray(mass, np.float64) / float(mass.sum())
    times = frame_dt * jnp.arange(x.shape[0] - 1, dtype=x.dtype)
    velocities, dt = jnp.diff(x, axis=0) / frame_dt, jnp.asarray(frame_dt, x.dtype)
    total = 0.0
    for term in model.forces:
        push = jax.vmap(lambda place, v, time, term=term: term.acceleration(place, v, mass, time, dt))
        sizes = np.linalg.norm(np.asarray(push(x[:-1], velocities, times), np.float64), axis=-1)
        total += float((sizes @ share).sum()) * frame_dt
    for constraint in model.constraints:
        speeds = np.linalg.norm(np.asarray(constraint.prescribe(model, x[0]), np.float64), axis=-1)
        total += float(speeds @ share)
    return total
