"""Parts that turn in place: what lies between them and the rest is twisted, evenly where it is slender enough.

A seat turns on its stem, and a head on its neck. Twisted within a thin layer, matter is wrung until it looks torn and
no step is short enough. So the turn grows along a stretch of the object that is slender and near to the part. Where no
stretch is long and slender enough, the part turns on its narrowest place as a piece of its own.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.forces.regions import grade_part
from physagent_jax.forces.schema import Bend
from physagent_jax.mpm.pieces import label_pieces

TORN = 3.0  # [1] of shear, beyond which matter looks torn
_ALONG = 0.8  # component of an axis along the way out of the rest, from which on a turn about it twists
_OFF = 0.15  # of a part's reach from its joint, that its middle is off the axis where it swings: a tail beside legs
_FOOT = 0.1  # of the way from the object's end to the part, that stays
_FAR = 8.0  # [1] of shear, which is as bad as to turn all of the object but its foot
_CUT = 1.0  # [1] of shear beyond `TORN`, which is as bad as a part that turns as a piece of its own
_BROAD = 3.0  # [1] of shear, which is as bad as to cut where the object is broadest
_SECTIONS = 32  # across the axis
_OUTER = 90  # [%] of a section's matter that lies within its radius
_STEEPEST = 1.5  # of a motion's growth over its depth, over the mean
_LINKED = 2.5  # spacings of particles within which they hang together


@dataclasses.dataclass(frozen=True)
class Twist:
    """A part's turn about an axis along which it twists the object.

    Attributes:
        led: Particles that turn, indices, shape (k,).
        share: Share of the turn of each, shape (k,); None = all turn as one piece.
        pivot: A point of the axis [m], shape (3,).
    """

    led: np.ndarray
    share: np.ndarray | None
    pivot: np.ndarray


def find_twist(bend: Bend, rest: np.ndarray, axis: np.ndarray, angle: float) -> Twist | None:
    """The twist in place of a part's bend; None where the bend does, or the axis is across.

    Args:
        bend: The place beside the part's joint where it bends.
        rest: Rest positions [m], shape (n, 3).
        axis: Unit vector.
        angle: By which it turns [rad].
    """
    part, share, _ = grade_part(bend, rest)
    x = np.asarray(rest, float)
    inside, still = x[part], x[~part]
    bends = share < 1
    if not bends.any():
        return None
    off, nearest = KDTree(still).query(inside[bends])
    out = (inside[bends] - still[nearest]).mean(0) @ axis
    if abs(out) < _ALONG * np.linalg.norm((inside[bends] - still[nearest]).mean(0)):
        return None
    if _swings(bend, x, inside, axis):
        return None
    height = np.copysign(1.0, out) * (x @ axis)
    border = float(np.median(height[~part][nearest]))
    depth = max(float(off.max() - off.min()), 1e-9)
    if _STEEPEST * _find_radius(inside[bends], axis) * angle <= TORN * depth:
        return None
    low, high, shear = _find_stretch(x, axis, height, border, angle)
    between = (height >= low) & (height <= high)
    if shear > TORN:
        low = high = 0.5 * (low + high)
    led = _find_linked(x, height > low, part)
    along = np.clip((height[led] - low) / max(high - low, 1e-9), 0.0, 1.0)
    grown = None if shear > TORN else along**2 * (3 - 2 * along)
    return Twist(led, grown, x[between].mean(0))


def _swings(bend: Bend, x: np.ndarray, inside: np.ndarray, axis: np.ndarray) -> bool:
    """Return whether a part goes around the axis through its joint rather than turns on it."""
    arms = inside - (x.min(0) + np.asarray(bend.joint) * np.ptp(x, axis=0))
    across, along = np.linalg.norm(np.cross(arms.mean(0), axis)), abs(arms.mean(0) @ axis)
    return bool(across > max(_OFF * np.linalg.norm(arms, axis=1).max(), 2 * along))


def _find_radius(x: np.ndarray, axis: np.ndarray) -> float:
    """The radius of matter about its own middle, across the axis [m]."""
    return float(np.percentile(np.linalg.norm(np.cross(x - x.mean(0), axis), axis=1), _OUTER))


def _find_stretch(
    x: np.ndarray, axis: np.ndarray, height: np.ndarray, border: float, angle: float
) -> tuple[float, float, float]:
    """Both ends of the stretch below the border that is to be twisted [m], and its shear [1].

    It is sheared little and lies near the part. Where all are torn, or far, it is where the part is cut off: a narrow
    place near it, with an infinite shear.
    """
    foot = float(height.min()) + _FOOT * (border - float(height.min()))
    edges = np.linspace(foot, border, _SECTIONS + 1)
    place = np.searchsorted(edges, height, side="right") - 1  # -1 is below
    place[height > border] = _SECTIONS
    radius = np.array(
        [
            _find_radius(x[near], axis) if (near := abs(place - k) <= 1).any() else np.inf
            for k in range(_SECTIONS)
        ]
    )
    far = (border - 0.5 * (edges[1:] + edges[:-1])) / (border - foot)
    known = np.isfinite(radius)
    narrow = np.where(known, radius, 0.0) / max(radius[known].max(initial=0.0), 1e-12)
    cuts = np.where(known, TORN + _CUT + _FAR * far + _BROAD * narrow, np.inf)
    cut = int(np.argmin(cuts))
    best, least = (float(edges[cut]), float(edges[cut + 1]), np.inf), float(cuts[cut])
    for top in range(_SECTIONS, 0, -1):
        broadest = np.maximum.accumulate(radius[:top][::-1])[::-1]
        shear = _STEEPEST * broadest * angle / (edges[top] - edges[:top])
        cost = np.where(shear <= TORN, shear + _FAR * (border - edges[:top]) / (border - foot), np.inf)
        low = int(np.argmin(cost))
        if cost[low] < least:
            best, least = (float(edges[low]), float(edges[top]), float(shear[low])), cost[low]
    return best


def _find_linked(x: np.ndarray, above: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Indices of the particles above that hang together with the part's."""
    index = np.flatnonzero(above | part)
    spacing = float(np.median(KDTree(x).query(x[:: max(len(x) // 500, 1)], k=2)[0][:, 1]))
    label = label_pieces(x[index], _LINKED * max(spacing, 1e-9))
    return index[np.isin(label, np.unique(label[part[index]]))]
