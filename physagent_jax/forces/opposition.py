"""Compensation for pushes, blows and turns against which friction and weight work.

The way s that M asks for is what counts: M = 1 means the same visible motion on the ground as in empty space. A push
overcomes what opposes it and moves the object by what is left; when it ends, friction stops it. Friction, the weight of
what is lifted from the ground, and that which holds the object upright, are made up for while they act
(`forces.terms.friction`), because what it takes is seen only then. Other weight is made up for here. A blow gives the
speed whose way is M s: with a deceleration c, v = sqrt(2 c M s), or v = M s / T + c T / 2 if it is still moving after
T. So a throw rises by M s and comes down. Closed forms; what a part alone is given is not changed, since it moves
against the rest of the object rather than over the ground.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.forces.schema import Opposition

RISES = 0.3  # vertical share of a direction from which on the object leaves the ground: nothing rubs then
_FARTHEST, _FALLEN = (
    np.radians(120),
    0.01,
)  # turn that is looked at; [L] by which the mass centre has sunk again
_FIRST = 6  # of the turns that are looked at tell the edge that it is turned over
_TINY = 1e-12


def find_deceleration(opposition: Opposition, direction):
    """Deceleration of what moves along ``direction``, unit vector, shape (3,) [m/s^2]."""
    xp = _to_numpy(direction)
    return opposition.weight * xp.maximum(direction[2], 0.0) + find_friction(opposition, direction)


def find_friction(opposition: Opposition, direction):
    """Deceleration by friction alone of what moves along ``direction``, unit vector, shape (3,) [m/s^2]."""
    xp = _to_numpy(direction)
    up = direction[2]
    flat = xp.sqrt(xp.maximum(1 - up**2, 0.0))
    return xp.where(up < RISES, opposition.friction * flat, 0.0)


def find_resistance(opposition: Opposition, direction):
    """Deceleration that is made up for while a push along ``direction`` acts, unit vector, shape (3,) [m/s^2].

    It is friction of what slides, and weight of what is lifted from the ground.
    """
    xp = _to_numpy(direction)
    return find_friction(opposition, direction) + xp.where(
        direction[2] < RISES, 0.0, opposition.weight * direction[2]
    )


def oppose_push(opposition: Opposition | None, k, magnitude, direction):
    """Acceleration along ``direction`` of a push of ``magnitude`` but for friction [m/s^2]."""
    if opposition is None:
        return k * magnitude
    xp = _to_numpy(magnitude)
    sign = xp.sign(magnitude)
    return k * magnitude + sign * opposition.weight * xp.maximum(sign * direction[2], 0.0)


def oppose_swing(opposition: Opposition | None, k, magnitude, direction):
    """The same of a push of a train to and fro, which is borne both ways: it is to stop where the next one begins."""
    if opposition is None:
        return k * magnitude
    return k * magnitude + opposition.weight * direction[2]


def oppose_blow(opposition: Opposition | None, k, magnitude, direction):
    """Velocity change along ``direction`` of a blow of ``magnitude`` [m/s]; k M where nothing opposes it."""
    if opposition is None:
        return k * magnitude
    xp = _to_numpy(magnitude)
    sign, size = xp.sign(magnitude), xp.abs(magnitude)
    c = xp.maximum(find_deceleration(opposition, sign * direction), _TINY)
    way, time = size * opposition.travel, opposition.time
    drag = 2 / 3 * opposition.damping_rate * way  # first order in the damping
    stopped = xp.sqrt(2 * c * way) + drag
    passing = k * size + 0.5 * c * time
    return sign * xp.where(way < 0.5 * c * time**2, stopped, passing)


def find_righting(opposition: Opposition, axis):
    """Angular deceleration of what turns about ``axis``, unit vector, shape (3,): by friction, by weight [rad/s^2]."""
    return opposition.turning * axis[2] ** 2 + opposition.tipping * (1 - axis[2] ** 2)


def find_balance(x: np.ndarray, mass: np.ndarray, axis: np.ndarray) -> tuple[float, float]:
    """The balance of what stands and is turned over an edge of its foot, as weight holds it upright until then.

    Args:
        x: Its particles [m], shape (n, 3).
        mass: Their masses, of any scale, shape (n,).
        axis: Unit vector.

    Returns:
        The turn at which the mass centre is highest over what it rests on [rad], and b / R^2: how far inside its foot
        the mass centre is, over the squared radius of gyration about the axis [1/m].
    """
    r = x - np.average(x, axis=0, weights=mass)
    side, along = np.cross(axis, r)[:, 2], axis[2] * (r @ axis)
    angles = np.linspace(0, _FARTHEST, 61)
    c, s = np.cos(angles), np.sin(angles)
    heights = np.array([-(u * r[:, 2] + v * side + (1 - u) * along).min() for u, v in zip(c, s)])
    falls = heights < np.maximum.accumulate(heights) - _FALLEN * np.ptp(x, axis=0).max()
    balance = angles[heights[: np.argmax(falls) if falls.any() else None].argmax()]
    inside = ((heights - heights[0] * c)[1:_FIRST] / s[1:_FIRST]).max()
    squared = np.average((r**2).sum(1) - (r @ axis) ** 2, weights=mass)
    return float(balance), float(inside / max(squared, _TINY))


def describe_opposition(opposition: Opposition) -> str:
    """Describe the compensated opposition in words."""
    parts = []
    if opposition.friction:
        parts.append(f"friction of {opposition.friction:.3g} m/s^2 (for pushes while they act)")
    if opposition.weight:
        parts.append(f"weight of {opposition.weight:.3g} m/s^2")
    if opposition.turning:
        parts.append(f"friction of a spin of {opposition.turning:.3g} rad/s^2")
    if opposition.tipping:
        parts.append(f"standing upright with {opposition.tipping:.3g} rad/s^2")
    return "made up for: " + ", ".join(parts) if parts else "nothing opposes it"


def _to_numpy(value):
    return jnp if isinstance(value, Tracer) else np
