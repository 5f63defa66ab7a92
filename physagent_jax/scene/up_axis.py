"""The up axis of an object that nobody has stated, guessed from its shape where the shape tells it.

What was captured or modelled upright stands on something flat. A side is a base if the object would stand on it
firmly, and if it is flat: its outline hardly grows from the lowest points upwards, as that of rounded sides does.
Ground that was captured with the object is a base as well. The guess is made only if one of the six sides is a base
by far: a table stands as firmly on its top, and a floating object on nothing.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from physagent_jax.core.strict import Vector
from physagent_jax.scene.config.common import SignedAxis
from physagent_jax.scene.world import measure_overhang

AXES: tuple[SignedAxis, ...] = ("+x", "-x", "+y", "-y", "+z", "-z")
STRAYS = 2e-3  # share of the points on each side that may be floaters
FEWEST_POINTS = 100
FEWEST_CELLS, MOST_CELLS = 8, 32  # along the longest side, in which points are counted
FEWEST_IN_CELL = 2  # a cell with fewer points holds floaters, where cells hold more on average
SKIN, SOLE, RISE = 0.015, 0.03, 0.06  # [L] of height: what is flat lies in the first, feet in the second
LEAST_SCORE = 4e-3  # of what counts as a base; a cube scores 0.2, a pot with a tree 0.006
CLEARLY = 5.0  # times the score of every other side
FLAT, FIRM = 0.8, 5e-3  # from which flatness and work [L] on a second side is a base too
MIRRORED, UNLIKE = 0.7, 0.15  # overlap with its mirror image from which on it is one, and less of the others
MIRROR_CELLS = 24  # along the longest side, in which that is told
GROUND = 0.97  # share of the outline seen from above that a base takes if it is a ground


@dataclasses.dataclass(frozen=True)
class UpGuess:
    """An up axis and the reason for it.

    Attributes:
        axis: The file's up axis; None = the shape does not tell it.
        reason: A sentence without its full stop.
    """

    axis: SignedAxis | None
    reason: str


@dataclasses.dataclass(frozen=True)
class Side:
    """A side of an object as a base to stand on.

    Attributes:
        up: The axis that points up when the object stands on this side.
        work: Height by which the mass centre has to be raised to tip the object over [L]; 0 = it does not stand.
        angle: Angle by which it has to be tipped for that [degrees].
        flatness: Area of the outline of the lowest `SKIN` over that of the lowest `RISE`, 1 = flat.
        share: Area of the outline of the lowest `SOLE` over that of the whole object, both from above.
    """

    up: SignedAxis
    work: float
    angle: float
    flatness: float
    share: float

    @property
    def score(self) -> float:
        """The work [L], counted only as far as the side is flat."""
        return self.work * self.flatness**4


def guess_up(points: np.ndarray) -> UpGuess:
    """The up axis that an object's shape tells.

    Args:
        points: Points on the object's surface [any unit], in the file's frame, shape (n, 3).
    """
    sides = measure_sides(points)
    if not sides:
        return UpGuess(None, "there are too few points to tell from the shape")
    best, *others = sorted(sides, key=lambda side: -side.score)
    if best.score < LEAST_SCORE:
        return UpGuess(None, "the shape does not tell: on none of its sides would it stand flat and firm")
    rivals: list[SignedAxis] = [
        side.up
        for side in others
        if side.score > best.score / CLEARLY or (side.flatness >= FLAT and side.work >= FIRM)
    ]
    if rivals:
        listed = ", ".join(map(find_opposite, [best.up, *rivals]))
        return UpGuess(None, f"the shape does not tell: it would stand on several of its sides ({listed})")
    side = find_opposite(best.up)
    what = "is flat and as broad as the whole, as ground is," if best.share >= GROUND else "is flat"
    return UpGuess(
        best.up,
        f"its {side} side {what} and it stands there until it is tipped by {best.angle:.0f} degrees; "
        "no other side is such a base",
    )


def find_mirrored(points: np.ndarray) -> int | None:
    """The axis (0 to 2) across which alone an object is its own mirror image: left and right, and so never up.

    Args:
        points: As of `guess_up`.
    """
    points = np.asarray(points, np.float64)
    low, high = np.quantile(points, [STRAYS, 1 - STRAYS], axis=0)
    extent = float((high - low).max())
    if len(points) < FEWEST_POINTS or not extent > 0:
        return None
    middle = 0.5 * (low + high)
    points = (points[((points >= low) & (points <= high)).all(axis=1)] - middle) * (MIRROR_CELLS / extent)
    own = {*map(tuple, np.floor(points).astype(int))}
    overlaps = []
    for axis in range(3):
        image = {*map(tuple, np.floor(points * np.where(np.arange(3) == axis, -1, 1)).astype(int))}
        overlaps.append(len(own & image) / len(own | image))
    best = int(np.argmax(overlaps))
    others = max(overlaps[:best] + overlaps[best + 1 :])
    return best if overlaps[best] > MIRRORED and others < overlaps[best] - UNLIKE else None


def find_opposite(axis: SignedAxis) -> SignedAxis:
    """The opposite direction."""
    return AXES[AXES.index(axis) ^ 1]


def measure_sides(points: np.ndarray) -> list[Side]:
    """The six sides of an object as bases; none if it has too few points or no extent."""
    points = np.asarray(points, np.float64)
    low, high = np.quantile(points, [STRAYS, 1 - STRAYS], axis=0)
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    extent = float((high - low).max())
    if len(points) < FEWEST_POINTS or not extent > 0:
        return []
    points = (points - low) / extent
    centre = _find_centre(points)
    found = [_measure_side(points, centre, up) for up in AXES]
    return [side for side in found if side is not None]


def _find_centre(points: np.ndarray) -> Vector:
    """The mean of the cells' means, shape (3,): some parts of a surface may be sampled more densely than others."""
    cells = int(np.clip(np.sqrt(len(points)) / 4, FEWEST_CELLS, MOST_CELLS))
    _, mine, counts = np.unique(
        np.floor(points * cells).astype(np.int64), axis=0, return_inverse=True, return_counts=True
    )
    whole = (counts >= FEWEST_IN_CELL) | (counts.mean() < FEWEST_IN_CELL)
    means = [np.bincount(mine.reshape(-1), column) / counts for column in points.T]
    x, y, z = (float(each[whole].mean()) for each in means)
    return x, y, z


def _measure_side(points: np.ndarray, centre: Vector, up: SignedAxis) -> Side | None:
    """The side below ``up``; None if it is a line or a point, or the object has no thickness there.

    Args:
        points: Over the longest side [L], shape (n, 3).
        centre: The mass centre [L].
        up: Where up would be.
    """
    axis, sign = "xyz".index(up[1]), 1 if up[0] == "+" else -1
    level = [other for other in range(3) if other != axis]
    heights = sign * points[:, axis]
    ground = heights.min()
    heights, raised = heights - ground, sign * centre[axis] - ground
    flat = points[:, level]
    areas = [_measure_outline(flat[heights <= most]) for most in (SKIN, SOLE, RISE, np.inf)]
    if not areas[2] > 0 or not areas[3] > 0:
        return None
    reach = -measure_overhang(flat[heights <= SOLE], np.asarray(centre)[level])
    work = np.hypot(reach, raised) - raised if reach > 0 else 0.0
    angle = np.degrees(np.arctan2(max(reach, 0.0), max(raised, 1e-9)))
    return Side(up, float(work), float(angle), areas[0] / areas[2], areas[1] / areas[3])


def _measure_outline(points: np.ndarray) -> float:
    """The area of the convex hull of points of a plane, shape (n, 2); 0 if they lie on a line."""
    try:
        return float(ConvexHull(points).volume)
    except (QhullError, ValueError):
        return 0.0
