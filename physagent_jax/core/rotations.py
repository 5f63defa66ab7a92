"""Rotations of a few bodies, frame by frame, on the host."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

MOST_ACROSS = np.radians(45.0)
"""Largest part of a rotation across the axis of the whole turns before it [rad]."""
_ONES, _MIRROR = np.ones(3), np.array([1.0, 1.0, -1.0])


def polar(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split ``matrix`` = R S into a rotation and a symmetric stretch, both (3, 3)."""
    u, s, vt = np.linalg.svd(matrix)
    flip = _find_flip(u @ vt)
    return (u * flip) @ vt, (vt.T * (s * flip)) @ vt


def find_rotation(matrix: np.ndarray) -> np.ndarray:
    """The rotation R of ``matrix`` = R S (`polar`), shape (3, 3)."""
    u, _, vt = np.linalg.svd(matrix)
    return (u * _find_flip(u @ vt)) @ vt


def _find_flip(turn: np.ndarray) -> np.ndarray:
    """Signs of the singular values with which an orthogonal matrix becomes a rotation, shape (3,)."""
    (a, b, c), (d, e, f), (g, h, i) = turn.tolist()
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)  # 1 or -1
    return _MIRROR if determinant < 0 else _ONES


def unwrap(rotations: list[np.ndarray | None]) -> list[np.ndarray | None]:
    """Rotation vectors of a sequence of rotation matrices, whose angle may grow beyond 180 degrees.

    Each is the rotation's own vector of at most 180 degrees, added to the whole turns until then. Near a whole turn
    that vector is short, and its direction says nothing of what the object turned about. So a whole turn keeps the
    axis about which it was half done. What leans far out of that axis is another turn: of all vectors that stand for
    the same rotation, the one nearest to the previous frame's is taken.

    Args:
        rotations: Rotation matrices (3, 3), or None where unknown.

    Returns:
        Rotation vectors [rad], shape (3,), None where unknown.
    """
    previous, whole, vectors = np.zeros(3), np.zeros(3), []
    known = [matrix for matrix in rotations if matrix is not None]
    given = iter(Rotation.from_matrix(np.stack(known)).as_rotvec() if known else ())
    for matrix in rotations:
        if matrix is None:
            vectors.append(None)
            continue
        vector = next(given)
        angle = float(np.linalg.norm(vector))
        axis = vector / angle if angle > 1e-9 else _normalise(previous)
        turns = np.round(((previous - whole) @ axis - angle) / (2 * np.pi))
        whole = whole + 2 * np.pi * turns * axis
        if _measure_across(vector, whole) > MOST_ACROSS:
            turns = np.round((previous @ axis - angle) / (2 * np.pi))
            whole = 2 * np.pi * turns * axis
        previous = whole + vector
        vectors.append(previous)
    return vectors


def _measure_across(vector: np.ndarray, line: np.ndarray) -> float:
    """Length of a vector's part across a line; 0 for no line."""
    length = float(np.linalg.norm(line))
    return float(np.linalg.norm(np.cross(vector, line / length))) if length > 1e-9 else 0.0


def _normalise(vector: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])
