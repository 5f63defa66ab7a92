"""Setting an object upright that would fall over as its file has it, so that it stands on all of its feet.

A capture's up axis is right to within a few degrees: on level ground the object then stands on one foot, or on the edge
of its base, and would fall over. A mesh was drawn without a ground: a skull or a bust rests leant back. The nearest way
for a rigid body to stand is on the facet of its convex hull that its mass centre is over.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from physagent_jax.scene.world import SOLE, measure_overhang

LARGEST_TILT = 15.0  # [degrees]; what needs more was not captured standing
LARGEST_LEAN = 45.0  # [degrees], of what was drawn; what needs more lies down rather than leans
FALLS = 0.08  # [L] of overhang from which on it was drawn leaning; less is an aeroplane without its wheels
CELLS = 32  # along the longest side, in which points are counted
FEWEST_IN_CELL = 2  # a cell with fewer points holds floaters


def find_tilt(points: np.ndarray, largest: float = LARGEST_TILT) -> tuple[float, float] | None:
    """Rotation about the world's x and y axes together (a rotation vector) [degrees]; None if there is nothing to do.

    Args:
        points: On the object's surface, z up, shape (n, 3).
        largest: Angle that it may be turned by [degrees].
    """
    extent = float(np.ptp(points, axis=0).max())
    cells, inverse, count = np.unique(
        np.floor(points * (CELLS / extent)).astype(np.int64), axis=0, return_inverse=True, return_counts=True
    )
    whole = count >= FEWEST_IN_CELL
    points = points[whole[inverse.reshape(-1)]]
    if len(points) < 4:
        return None
    centre = (cells[whole] + 0.5).mean(0) * (extent / CELLS)  # points may be denser on one side
    feet = points[points[:, 2] <= points[:, 2].min() + SOLE * extent, :2]
    overhang = measure_overhang(feet, centre[:2])
    if overhang <= 0:
        return None
    largest = largest if overhang > FALLS * extent else min(largest, LARGEST_TILT)
    try:
        hull = ConvexHull(points)
    except QhullError:
        return None
    best: tuple[float, float] | None = None
    for corners, equation in zip(points[hull.simplices], hull.equations):
        normal = equation[:3]
        angle = float(np.degrees(np.arccos(np.clip(-normal[2], -1, 1))))
        if angle > largest or (best is not None and angle >= np.hypot(*best)):
            continue
        below = centre - (normal @ centre + equation[3]) * normal
        if not _is_inside(below, corners, normal):
            continue
        # Turns the facet's outward normal downwards; the axis is horizontal.
        axis = np.cross(normal, [0.0, 0.0, -1.0])
        vector = axis / max(np.linalg.norm(axis), 1e-12) * angle
        best = round(float(vector[0]), 3), round(float(vector[1]), 3)
    return best


def _is_inside(point: np.ndarray, corners: np.ndarray, normal: np.ndarray) -> bool:
    """Return whether a point of a triangle's plane is in the triangle, corners (3, 3)."""
    sides = [np.cross(corners[(i + 1) % 3] - corners[i], point - corners[i]) @ normal for i in range(3)]
    return bool(min(sides) >= 0 or max(sides) <= 0)
