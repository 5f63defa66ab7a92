"""The particles that a region selects."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.scene import config as c

DTYPE = np.float32


def to_array(value) -> jnp.ndarray:
    """``value`` as an array of the particles' dtype."""
    return to_device(value, DTYPE)


def select_box(rest: np.ndarray, box, place: str) -> np.ndarray:
    """Particles that rest in a box, shape (n,).

    Raises:
        UserError: There is none; ``place`` names the box.
    """
    inside = np.all(np.abs(rest - np.asarray(box.point)) <= np.asarray(box.half_size), axis=1)
    return check_not_empty(inside, rest, place)


def select_cylinder(rest: np.ndarray, cylinder: c.ParticleRotation, place: str) -> np.ndarray:
    """Particles that rest in a cylinder, shape (n,); raises as `select_box`."""
    arm = rest - np.asarray(cylinder.point)
    height = arm @ np.asarray(cylinder.normal)
    radius = np.linalg.norm(arm - height[:, None] * np.asarray(cylinder.normal), axis=1)
    return check_not_empty(
        (np.abs(height) <= cylinder.half_height) & (radius <= cylinder.radius), rest, place
    )


def check_not_empty(inside: np.ndarray, rest: np.ndarray, place: str) -> np.ndarray:
    """``inside`` itself, if it selects anything; raises as `select_box`."""
    if not inside.any():
        low, high = np.round(rest.min(0), 3).tolist(), np.round(rest.max(0), 3).tolist()
        raise UserError(
            f"`{place}` selects no particle; the object spans {low} to {high} m", do="Move it there"
        )
    return inside
