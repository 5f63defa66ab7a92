"""The precision of stored positions: the point to take off before float32, and the lattice that they lie on."""

from __future__ import annotations

import numpy as np

_LOSS = 2.0**-21  # of the extent; a larger rounding error in float32 is avoided by taking an origin off
_TRIMMED = 0.01  # share of the Gaussians on each side that may be floaters
_FEWEST = 64  # Gaussians from which a lattice can be told
_MOST_VALUES = 128  # distinct values along an axis from which a lattice is fine enough
_PER_VALUE = 8  # Gaussians per distinct value from which the values are few
_FLAT = 1e-3  # of the extent; coarser steps of float32 can have flattened an axis
_SAME_STEP = 0.01


def find_origin(means: np.ndarray) -> np.ndarray:
    """The point to take off the positions so that float32 holds the rest, shape (3,); zero where it need not.

    Args:
        means: Finite positions in the file's own precision [file units], float64, shape (n, 3).
    """
    low, high = np.quantile(means, [_TRIMMED, 1 - _TRIMMED], axis=0)
    extent = float((high - low).max()) or float(np.ptp(means, axis=0).max())
    inside = ((means >= low) & (means <= high)).all(axis=1)
    lost = np.abs(means - means.astype(np.float32))[inside if inside.any() else slice(None)].max()
    if not extent > 0 or lost <= _LOSS * extent:
        return np.zeros(3)
    step = 2.0 ** np.floor(np.log2(extent))  # a short binary fraction is taken off without rounding
    return np.round(0.5 * (low + high) / step) * step


def describe_lattice(means: np.ndarray) -> str | None:
    """A coarse lattice that the stored positions lie on, in words; None if there is none.

    Positions that were rounded before they were stored have few distinct values along an axis. A grid that somebody
    made, with one step along all axes and one Gaussian per node, is none.

    Args:
        means: Finite positions in the file's own precision [file units], float64, shape (n, 3).
    """
    if len(means) < _FEWEST:
        return None
    values = [np.unique(column) for column in means.T]
    counts = np.array([len(each) for each in values])
    extent = max(np.ptp(each) for each in values)
    few = (counts < _MOST_VALUES) & (counts * _PER_VALUE <= len(means)) & (counts > 1)
    # A single value says nothing by itself, unless single precision could not have told it from its neighbours.
    few |= (counts == 1) & np.array([np.spacing(np.float32(abs(v[0]))) > _FLAT * extent for v in values])
    if not few.any() or extent == 0 or _is_made_grid(means, values):
        return None
    found = " and ".join(
        f"{count} distinct value{'s' if count > 1 else ''} along {axis}"
        for axis, count, coarse in zip("xyz", counts, few)
        if coarse
    )
    return (
        f"its {len(means):,} stored positions are a coarse lattice, with only {found}: they were rounded before they "
        "were saved; export the scene near the origin or in double precision"
    )


def _is_made_grid(means: np.ndarray, values: list[np.ndarray]) -> bool:
    """Return whether all axes have one step, and no two Gaussians share a place."""
    steps = [np.diff(each).min() for each in values if len(each) > 1]
    even = max(steps) <= (1 + _SAME_STEP) * min(steps)
    return even and len(np.unique(means, axis=0)) == len(means)
