"""Closest points of triangles, many pairs at once."""

from __future__ import annotations

import numpy as np


class Surface:
    """Triangles with what their distances need.

    Args:
        triangles: Corners, shape (m, 3, 3).
    """

    def __init__(self, triangles: np.ndarray):
        self.triangles = triangles
        self.origin = triangles[:, 0]
        self.edges = np.roll(triangles, -1, axis=1) - triangles
        first, second = triangles[:, 1] - self.origin, triangles[:, 2] - self.origin
        self.normal = np.cross(first, second)
        squared = (self.normal**2).sum(1, keepdims=True)
        # Without area, edges are all there is.
        self.flat = squared[:, 0] <= 1e-24 * (self.edges**2).sum(2).max(1) ** 2
        safe = np.where(self.flat[:, None], 1.0, squared)
        self.unit = self.normal / np.sqrt(safe)
        # (p - a) . gradients = the barycentric coordinates of the projection of p for b and c.
        self.gradients = (
            np.stack([np.cross(second, self.normal), np.cross(self.normal, first)], axis=1) / safe[:, None]
        )
        length = (self.edges**2).sum(2)
        self.inverse_length = 1 / np.where(length > 0, length, 1.0)

    def find_closest(self, t: np.ndarray, points: np.ndarray) -> np.ndarray:
        """The points of the triangles ``t``, shape (k,), that are closest to points, shape (k, 3)."""
        offset = points - self.origin[t]
        result = points - _dot(offset, self.unit[t])[:, None] * self.unit[t]
        b, c = (_dot(offset, self.gradients[t, side]) for side in range(2))
        beside = np.flatnonzero((b < 0) | (c < 0) | (b + c > 1) | self.flat[t])
        t, points = t[beside], points[beside]
        least, closest = np.full(len(t), np.inf), np.empty((len(t), 3))
        for side in range(3):
            offset, edge = points - self.triangles[t, side], self.edges[t, side]
            share = np.clip(_dot(offset, edge) * self.inverse_length[t, side], 0, 1)
            at = self.triangles[t, side] + share[:, None] * edge
            squared = ((points - at) ** 2).sum(1)
            nearer = squared < least
            least[nearer], closest[nearer] = squared[nearer], at[nearer]
        result[beside] = closest
        return result


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", a, b)
