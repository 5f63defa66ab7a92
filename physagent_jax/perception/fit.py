"""Rigid and affine motions fitted to pairs of 3D points, and angles that do not wrap."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.rotations import find_rotation
from physagent_jax.perception.schema import Matrix

NEIGHBOURS = 6
"""Points that a point is compared with."""
LEAST_PULL = 1e-200
"""Least pull, and least limit of a residual, so that points that coincide give a map too: they tell where they go."""
ENOUGH = 40
"""With fewer points there are no neighbours to speak of."""


@dataclasses.dataclass(frozen=True)
class Affine:
    """The map x -> matrix @ x + offset, with its rotation beside it.

    Attributes:
        matrix: Shape (3, 3).
        offset: [m], shape (3,).
        rotation: R of matrix = R S, multiplied on along a chain of maps, shape (3, 3).
        residual: RMS distance of the fitted from the given points [m].
    """

    matrix: np.ndarray
    offset: np.ndarray
    rotation: np.ndarray
    residual: float = 0.0

    @classmethod
    def identity(cls) -> Affine:
        """The map that leaves all as it is."""
        return cls(np.eye(3), np.zeros(3), np.eye(3))

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Maps points, shape (..., 3)."""
        return x @ self.matrix.T + self.offset

    def after(self, first: Affine) -> Affine:
        """This map after ``first``; the residual is the larger one."""
        return Affine(
            self.matrix @ first.matrix,
            self(first.offset),
            self.rotation @ first.rotation,
            max(self.residual, first.residual),
        )


def fit_affine(
    a: np.ndarray,
    b: np.ndarray,
    trust: np.ndarray | None = None,
    *,
    prior: float = 0.015,
    iterations: int = 10,
) -> Affine:
    """Robust affine map a -> b that falls back to the rigid one where the points cannot tell.

    Huber weights, reweighted least squares: of the residual at first, then of how far it differs from its neighbours'.
    What moves apart from the rest together, as the end that is squashed, is motion and counts in full; a point that
    leaves its neighbours was followed wrongly. A visible surface that is nearly flat says nothing about
    stretch along its normal, so the matrix is pulled towards its own rotation with the strength of points
    spread over ``prior`` times the extent. The rotation comes from the polar decomposition: Kabsch's, which
    starts the iteration, reads a squash of a lopsided visible side as a turn (by 20 degrees at half height).

    Args:
        a: Points before [m], shape (n, 3), n >= 4.
        b: The same points after [m], shape (n, 3).
        trust: Weight of each point, shape (n,); equal by default.
        prior: Strength of the pull [extents].
        iterations: Iterations of reweighting.

    Returns:
        The map.
    """
    extent = np.linalg.norm(np.ptp(a, axis=0))
    trust = np.ones(len(a)) if trust is None else trust
    w, matrix = trust, None
    beside = _find_neighbours(a.tobytes(), a.dtype.str) if len(a) >= ENOUGH else None
    for k in range(iterations):
        total = w.sum()
        a0, b0 = w @ a / total, w @ b / total
        x, y = a - a0, b - b0
        pull = max(total * (prior * extent) ** 2, LEAST_PULL)
        cross, square = (w[:, None] * y).T @ x, (w[:, None] * x).T @ x
        rotation = find_rotation(cross if matrix is None else matrix)  # of the cross covariance: Kabsch's
        matrix = (cross + pull * rotation) @ np.linalg.inv(square + pull * np.eye(3))
        off = x @ matrix.T - y
        distance = _measure_lengths(off)
        fitted = Affine(matrix, b0 - matrix @ a0, rotation, float(np.sqrt(trust @ distance**2 / trust.sum())))
        if beside is not None and k >= iterations // 2:
            distance = _measure_lengths(off - _find_median(off[beside]))
        before, w = w, trust * huber(distance, floor=0.003 * float(extent))
        if k >= iterations // 2 and np.abs(w - before).max() < 1e-2:
            break
    return fitted


def to_matrix(S: np.ndarray) -> Matrix:
    """The rows of a matrix, shape (3, 3), as the report holds them."""
    first, second, third = (tuple(row) for row in S.tolist())
    return first, second, third


@functools.lru_cache(maxsize=256)  # the same points are fitted in frame after frame
def _find_neighbours(points: bytes, dtype: str) -> np.ndarray:
    """Indices of the points nearest to each, shape (n, NEIGHBOURS), of points (n, 3) in bytes."""
    a = np.frombuffer(points, dtype).reshape(-1, 3)
    tree: Any = KDTree(a)  # scipy annotates `query` for a single neighbour only
    return tree.query(a, k=NEIGHBOURS + 1)[1][:, 1:]


def _measure_lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors, shape (n, 3) -> (n,)."""
    return np.sqrt((vectors * vectors).sum(axis=1))


def _find_median(values: np.ndarray) -> np.ndarray:
    """Over the second axis, whose length is even; a sort is faster than `numpy.median` for so few."""
    middle = values.shape[1] // 2
    return np.sort(values, axis=1)[:, middle - 1 : middle + 1].sum(1) * 0.5


def huber(distance: np.ndarray, *, floor: float) -> np.ndarray:
    """Huber weights for residuals, full up to two robust standard deviations, at least ``floor``."""
    half = len(distance) // 2  # `numpy.median` takes as long as the rest of a fit to so few points
    ordered = np.sort(distance)
    middle = ordered[half] if len(ordered) % 2 else 0.5 * (ordered[half - 1] + ordered[half])
    limit = max(2 * 1.4826 * float(middle), floor, LEAST_PULL)
    return limit / np.maximum(distance, limit)


def estimate_hidden_spread(points: np.ndarray, direction: np.ndarray) -> float:
    """Standard deviation of points along ``direction`` that the other two directions do not explain [m]."""
    cov = np.cov(points.T)
    cov += (1e-12 * np.trace(cov) + 1e-30) * np.eye(3)
    return float(1 / np.sqrt(direction @ np.linalg.inv(cov) @ direction))
