"""Vector arithmetic on 3-tuples: the agents' layer holds no arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable

from physagent_jax.core.strict import Vector


def add(vectors: Iterable[Vector]) -> Vector:
    """Sum of any number of vectors."""
    x = y = z = 0.0
    for v in vectors:
        x, y, z = x + v[0], y + v[1], z + v[2]
    return (x, y, z)


def subtract(a: Vector, b: Vector) -> Vector:
    """``a - b``."""
    return add([a, scale(b, -1.0)])


def reject(v: Vector, axis: Vector, low: float = -math.inf, high: float = math.inf) -> Vector:
    """``v`` less its part along a unit vector, of which only what lies in [low, high] is taken away."""
    return add([v, scale(axis, -clamp(dot(v, axis), low, high))])


def scale(v: Vector, factor: float) -> Vector:
    """``factor * v``; adding 0.0 turns -0.0 into 0.0, so that equal vectors print alike."""
    return (factor * v[0] + 0.0, factor * v[1] + 0.0, factor * v[2] + 0.0)


def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return (
        a[1] * b[2] - a[2] * b[1] + 0.0,
        a[2] * b[0] - a[0] * b[2] + 0.0,
        a[0] * b[1] - a[1] * b[0] + 0.0,
    )


def norm(v: Vector) -> float:
    """Euclidean length."""
    return math.sqrt(dot(v, v))


def normalise(v: Vector) -> Vector | None:
    """The unit vector along ``v``, or None if ``v`` is (nearly) zero: the summands cancelled."""
    length = norm(v)
    return None if length < 1e-6 else scale(v, 1.0 / length)


def cosine(a: Vector, b: Vector) -> float:
    """Cosine of the angle between two vectors; 0 if either is zero."""
    product = norm(a) * norm(b)
    return 0.0 if product < 1e-12 else dot(a, b) / product


def clamp(value: float, low: float, high: float) -> float:
    """``value`` limited to [low, high]."""
    return min(max(value, low), high)


def rotate(v: Vector, turn: Vector) -> Vector:
    """A vector turned by a rotation vector [deg] (Rodrigues)."""
    axis, angle = normalise(turn), math.radians(norm(turn))
    if axis is None:
        return v
    c, s = math.cos(angle), math.sin(angle)
    return add([scale(v, c), scale(cross(axis, v), s), scale(axis, dot(axis, v) * (1 - c))])
