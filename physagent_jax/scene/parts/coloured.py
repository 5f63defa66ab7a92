"""Parts that a sentence tells by their colour alone: "the green box" of a truck.

Light is often painted into colours, so that dark and bright tell little: black, grey and white tell no part.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part
from physagent_jax.scene.parts.cells import fit_part

HUES = dict(
    red=(342.0, 15.0), orange=(15.0, 45.0), brown=(8.0, 48.0), yellow=(42.0, 70.0), green=(70.0, 175.0),
    blue=(175.0, 260.0), purple=(255.0, 315.0), pink=(290.0, 355.0),
)  # fmt: skip
"""Lowest and highest hue of each colour [degrees]."""
COLOURED = 0.15
"""Saturation from which on a colour has a hue."""
_SAME = dict(gold="yellow", golden="yellow", violet="purple", turquoise="blue")
_FEWEST = 40  # points
_MOST = 0.85  # share of the object, from which on it is all of it
_AROUND, _ROUNDS = 40, 4  # points about each that tell whether it is of it, and how often they are asked
_CELLS = 40  # along the longest side, for what lies between


def list_hues() -> tuple[str, ...]:
    """The words for colours that tell a part."""
    return (*HUES, *_SAME)


def find_coloured(
    points: np.ndarray, colours: np.ndarray, phrases: Iterable[tuple[str, str]]
) -> tuple[Part, ...]:
    """The parts of a colour, with all that lies between what is seen of it; none that is about all of the object.

    Args:
        points: Points of the object at rest, z up [m], shape (n, 3).
        colours: Their colours, 0 .. 1, shape (n, 3).
        phrases: The colour and the noun of each: ("green", "box").
    """
    found = []
    for colour, noun in phrases:
        mask = find_hue(colours, _SAME.get(colour, colour))
        mask = smooth(points, mask | find_between(points, mask))
        if _FEWEST <= mask.sum() < _MOST * len(points):
            part = fit_part(points, mask, joined=False)
            told = dict(name=f"{colour} {noun}", stands_for=f"the {colour} part", origin="place")
            if part.seated:  # it stands on the rest, whatever else it touches
                told |= dict(
                    arm=(0.0, 0.0, round(float(np.ptp(points[mask, 2]) / np.ptp(points, axis=0).max()), 4))
                )
            found.append(part.model_copy(update=told))
    return tuple(found)


def find_hue(colours: np.ndarray, colour: str) -> np.ndarray:
    """The points of a colour, shape (n,)."""
    red, green, blue = colours.T
    most, least = colours.max(1), colours.min(1)
    hue = np.degrees(np.arctan2(np.sqrt(3) * (green - blue), 2 * red - green - blue)) % 360
    has, (low, high) = most - least > COLOURED * most, HUES[colour]
    return has & ((low < hue) & (hue < high) if low < high else (low < hue) | (hue < high))


def find_between(points: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The points that have some of a mask on either side of them along one of the axes, shape (n,)."""
    low, size = points.min(0), float(np.ptp(points, axis=0).max())
    cells = ((points - low) / size * (_CELLS - 1)).astype(int)
    held = np.zeros((_CELLS,) * 3, bool)
    held[tuple(cells[mask].T)] = True
    between = np.zeros_like(held)
    for axis in range(3):
        before = np.logical_or.accumulate(held, axis)
        after = np.flip(np.logical_or.accumulate(np.flip(held, axis), axis), axis)
        between |= before & after
    return between[tuple(cells.T)]


def smooth(points: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The mask without holes and ragged borders, shape (n,): each point goes with those around it; small ones stay."""
    near, made = KDTree(points).query(points, k=min(_AROUND, len(points)))[1], mask
    for _ in range(_ROUNDS):
        made = made[near].mean(1) > 0.5
    return made if 2 * made.sum() > mask.sum() else mask
