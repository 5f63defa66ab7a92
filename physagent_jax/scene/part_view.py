"""The camera from which the motion of a part is seen: across the line of sight, and with nothing before it.

What left and right mean is settled before, so that the camera turns by less than a right angle.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import Part
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.broad_side import find_seen
from physagent_jax.scene.camera import find_view_direction, find_viewer_directions
from physagent_jax.scene.config import CameraConfig

TURNS = tuple(sign * turn for turn in range(0, 76, 15) for sign in (-1, 1))
"""Turns of the camera that are tried [degrees], smallest first: baked light comes from the left."""

ENOUGH = 0.6  # of the most that is seen of the motion from anywhere, from which on the camera stays
AS_GOOD = 0.85  # of the most, from which on the smallest turn is taken
SIDEWAYS = 0.3  # share of a motion that goes to the left or right, from which on it must stay so
REACH = 0.7  # of the part's length, that its tip goes
MOST_POINTS, CELLS = 8000, 40  # of the object; across it, for what hides what


@dataclasses.dataclass(frozen=True)
class PartMotion:
    """A part and where it goes.

    Attributes:
        mask: Which points it has, shape (n,).
        joint: What it turns about [m], shape (3,).
        way: Where its tip goes, or the axis that it turns about; a unit vector, shape (3,).
        turns: Whether ``way`` is an axis.
    """

    mask: np.ndarray
    joint: np.ndarray
    way: np.ndarray
    turns: bool

    def displace(self, points: np.ndarray) -> np.ndarray:
        """The way that each point goes, where the farthest goes `REACH` of the part's length [m], shape (n, 3)."""
        arms = (points - self.joint) * self.mask[:, None]
        far = np.linalg.norm(arms, axis=1)
        moved = np.cross(self.way, arms) if self.turns else far[:, None] * self.way
        return REACH * far.max() * moved / max(float(np.linalg.norm(moved, axis=1).max()), 1e-12)


def find_part_motion(part: Part, points: np.ndarray, way: Vector, *, turns: bool) -> PartMotion:
    """A part and where it goes.

    Args:
        part: The part.
        points: Points of the object at rest [m], shape (n, 3).
        way: Where its tip goes, or the axis that it turns about; a unit vector.
        turns: Whether it is an axis.
    """
    mask = make_region_mask(part.moved, points)
    joint = points.min(0) + np.asarray(part.joint) * np.ptp(points, axis=0)
    return PartMotion(mask, points[mask].mean(0) if part.seated else joint, np.asarray(way), turns)


def turn_to_parts(camera: CameraConfig, points: np.ndarray, motions: Sequence[PartMotion]) -> CameraConfig:
    """The camera turned about the vertical until what moves is seen, or as it is if that is seen already.

    Args:
        camera: Where it looks from.
        points: Points of the object at rest [m], shape (n, 3).
        motions: The parts that move, each with one point or more.
    """
    chosen = slice(None, None, -(-len(points) // MOST_POINTS))
    thinned = [dataclasses.replace(each, mask=each.mask[chosen]) for each in motions]
    points, shown = points[chosen], [each for each in thinned if each.mask.any()]
    moved = [each.displace(points) for each in shown]
    if not moved:
        return camera
    right = np.asarray(find_viewer_directions(camera)["right"])

    def look(turn: float) -> CameraConfig:
        azimuth = 180 - (180 - camera.azimuth_degrees - turn) % 360
        return camera.model_copy(update=dict(azimuth_degrees=azimuth))

    def keeps_sides(turned: CameraConfig) -> bool:
        aside = np.asarray(find_viewer_directions(turned)["right"])
        sideways = [each.way @ right for each in shown if not each.turns]
        there = [each.way @ aside for each in shown if not each.turns]
        return all(abs(here) < SIDEWAYS or here * other > 0 for here, other in zip(sideways, there))

    tried = [turned for turned in map(look, TURNS) if keeps_sides(turned)]
    shares = [measure_seen(each, points, moved) for each in tried]
    if shares[0] >= ENOUGH * max(shares):
        return camera
    return next(each for each, share in zip(tried, shares) if share >= AS_GOOD * max(shares))


def measure_seen(camera: CameraConfig, points: np.ndarray, moved: Sequence[np.ndarray]) -> float:
    """The displacements that are seen in the picture, over all of them, halfway and at their end [1].

    Args:
        camera: Where it looks from.
        points: Points of the object at rest [m], shape (n, 3).
        moved: Displacements of the points, one array for each part [m], shape (n, 3).
    """
    sight, total = find_view_direction(camera), sum(moved)
    across = [np.linalg.norm(each - np.outer(each @ sight, sight), axis=1) for each in moved]
    cell = float(np.ptp(points, axis=0).max()) / CELLS
    seen = 0.0
    for share in (0.0, 1.0):
        front = find_seen(points + share * total, camera.azimuth_degrees, cell)
        seen += sum(float(each[front].sum()) for each in across)
    return seen / max(sum(float(np.linalg.norm(each, axis=1).sum()) for each in moved), 1e-12)
