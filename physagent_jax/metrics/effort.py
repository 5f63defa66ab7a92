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
    x = jnp.asarray(x)
    share = np.asarray(model.mass, np.float64) / float(model.mass.sum())
    total = 0.0
    for acceleration in _evaluate(model, x, frame_dt):
        total += float((np.linalg.norm(acceleration, axis=-1) @ share).sum()) * frame_dt
    for constraint in model.constraints:
        speeds = np.linalg.norm(np.asarray(constraint.prescribe(model, x[0]), np.float64), axis=-1)
        total += float(speeds @ share)
    return total


def list_accelerations(model: Any, x, frame_dt: float) -> np.ndarray:
    """All that acts but boundaries and constraints, gravity too, from each frame to the next [m/s^2].

    Args:
        model: `mpm.Model` of the scene.
        x: Its particles' true positions [m], shape (T, n, 3).
        frame_dt: Seconds per frame [s].

    Returns:
        Shape (T - 1, n, 3).
    """
    x = jnp.asarray(x)
    total = np.zeros((len(x) - 1, *x.shape[1:]))
    if model.gravity is not None:
        total += np.asarray(model.gravity, np.float64)
    return sum(_evaluate(model, x, frame_dt), total)


def _evaluate(model: Any, x: jax.Array, frame_dt: float) -> list[np.ndarray]:
    """Acceleration by each force term at each frame but the last [m/s^2], shape (T - 1, n, 3)."""
    mass, dt = jnp.asarray(model.mass), jnp.asarray(frame_dt, x.dtype)
    times = frame_dt * jnp.arange(x.shape[0] - 1, dtype=x.dtype)
    velocities = jnp.diff(x, axis=0) / frame_dt
    pushes = [
        jax.vmap(lambda place, v, time, term=term: term.acceleration(place, v, mass, time, dt))
        for term in model.forces
    ]
    return [np.asarray(push(x[:-1], velocities, times), np.float64) for push in pushes]
