"""Rotations of a few bodies, frame by frame, on the host."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

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

    Of all vectors that stand for the same rotation, the one nearest to the previous frame's is taken.

    Args:
        rotations: Rotation matrices (3, 3), or None where unknown.

    Returns:
        Rotation vectors [rad], shape (3,), None where unknown.
    """
    previous, vectors = np.zeros(3), []
    known = [matrix for matrix in rotations if matrix is not None]
    given = iter(Rotation.from_matrix(np.stack(known)).as_rotvec() if known else ())
    for matrix in rotations:
        if matrix is None:
            vectors.append(None)
            continue
        vector = next(given)
        angle = float(np.linalg.norm(vector))
        axis = vector / angle if angle > 1e-9 else _normalise(previous)
        turns = np.round((previous @ axis - angle) / (2 * np.pi))
        previous = (angle + 2 * np.pi * turns) * axis
        vectors.append(previous)
    return vectors


def _normalise(vector: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])
