"""Rotations of a few bodies, frame by frame, on the host."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def polar(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split ``matrix`` = R S into a rotation and a symmetric stretch, both (3, 3)."""
    u, s, vt = np.linalg.svd(matrix)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return u @ flip @ vt, vt.T @ np.diag(s) @ flip @ vt


def unwrap(rotations: list[np.ndarray | None]) -> list[np.ndarray | None]:
    """Rotation vectors of a sequence of rotation matrices, whose angle may grow beyond 180 degrees.

    Of all vectors that stand for the same rotation, the one nearest to the previous frame's is taken.

    Args:
        rotations: Rotation matrices (3, 3), or None where unknown.

    Returns:
        Rotation vectors [rad], shape (3,), None where unknown.
    """
    previous, vectors = np.zeros(3), []
    for matrix in rotations:
        if matrix is None:
            vectors.append(None)
            continue
        vector = Rotation.from_matrix(matrix).as_rotvec()
        angle = float(np.linalg.norm(vector))
        axis = vector / angle if angle > 1e-9 else _normalise(previous)
        turns = np.round((previous @ axis - angle) / (2 * np.pi))
        previous = (angle + 2 * np.pi * turns) * axis
        vectors.append(previous)
    return vectors


def _normalise(vector: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])
