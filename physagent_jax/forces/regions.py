"""Particles that a region selects, and terms that act on them alone."""

from __future__ import annotations

import jax
import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import Bend, BoxRegion, CellsRegion, HalfSpaceRegion, Region, SphereRegion

_OUTER = 0.7  # of the way to a part's farthest particle, beyond which it goes along as a whole


def make_region_mask(region: Region, rest: np.ndarray, origin: str = "region") -> np.ndarray:
    """Particles of ``region``.

    Args:
        region: In fractions of the bounding box of ``rest``.
        rest: Rest positions [m], shape (n, 3).
        origin: The region's place in the force field, for the message.

    Returns:
        Bool, shape (n,).

    Raises:
        UserError: No particle lies in the region.
    """
    low, high = rest.min(0), rest.max(0)
    size = np.maximum(high - low, np.finfo(np.float32).tiny)
    fraction = (rest - low) / size
    match region:
        case BoxRegion():
            mask = np.all((fraction >= region.low) & (fraction <= region.high), axis=1)
        case HalfSpaceRegion():
            mask = (fraction - np.asarray(region.point)) @ np.asarray(region.normal) >= 0
        case SphereRegion():
            center = low + np.asarray(region.center) * size
            mask = np.linalg.norm(rest - center, axis=1) <= region.radius * size.max()
        case CellsRegion():
            seeds = low + np.asarray((*region.inside, *region.outside)) * size
            mask = np.asarray(KDTree(seeds).query(rest)[1]) < len(region.inside)
    if not mask.any():
        raise UserError(
            f"`{origin}` selects no particle of the object",
            got=region.model_dump_json(),
            do="Regions are fractions of the bounding box: (0,0,0) is its low corner, (1,1,1) its high corner",
        )
    return mask


def grade_part(bend: Bend, rest: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The particles of a part that bends beside its joint, and how much each goes along.

    Args:
        bend: Where it bends.
        rest: Rest positions [m], shape (n, 3).

    Returns:
        Bool, shape (n,); shares of the motion of these k particles, shape (k,), which grow as u^2 (3 - 2 u) with the
        distance from the rest beside the joint; the middle of where it bends [m], shape (3,).
    """
    still = make_region_mask(bend.rest, rest, "bend.rest")
    size = float(np.ptp(rest, axis=0).max())
    joint = rest.min(0) + np.asarray(bend.joint) * np.ptp(rest, axis=0)
    off = np.linalg.norm(rest[still] - joint, axis=1)
    beside = off <= max(bend.reach * size, 1.2 * float(off.min()))
    distance = np.asarray(KDTree(rest[still][beside]).query(rest[~still])[0])
    distance = distance - distance.min()
    depth = min(bend.depth * size, _OUTER * float(distance.max()))  # what is broad and flat moves as well
    along = np.minimum(distance / max(depth, 1e-9 * size), 1.0)
    bends = along < 1
    middle = rest[~still][bends].mean(0) if bends.any() else joint
    return ~still, along**2 * (3 - 2 * along), middle


def confine(value: jax.Array, weight: jax.Array | None) -> jax.Array:
    """``value`` times the region's weight.

    Args:
        value: One per particle, shape (n, ...).
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """
    return value if weight is None else weight.reshape(-1, *[1] * (value.ndim - 1)) * value
