"""The lengths of the object's outline along the viewer's directions: stretch that the followed points may miss."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.perception.schema import Extent

ALONG_SIGHT = 0.7
"""A direction whose cosine with the line of sight is larger lies along it: most of its extent is hidden."""
HIDDEN_END = 0.5
"""Share of a change of length, times the cosine of direction and line of sight, that a hidden end may take away."""
STRAY = 0.3
"""Pixels beyond this percentile on either side do not count [%]."""
ACROSS = 0.3
"""Cosine to an end's direction from which on another one does not go across it."""
SLICES, MOST_POINTS = 12, 4000
"""Slices of an end over which its breadth is averaged, and points of an outline that are enough for it."""
ROUGH = 0.01
"""Half width of a ratio where nothing turns, besides the pixels' [1]."""


def choose_directions(axes: np.ndarray, forward: np.ndarray) -> np.ndarray:
    """Those of the unit vectors ``axes``, shape (k, 3), that lie across the line of sight ``forward``, shape (3,)."""
    return axes[np.abs(axes @ forward) <= ALONG_SIGHT]


def measure_lengths(outlines: list[np.ndarray], directions: np.ndarray) -> np.ndarray:
    """Lengths along directions [m], shape (T, k); nan where there are no points.

    Args:
        outlines: World points of all the mask's pixels per frame [m], each (n, 3).
        directions: Unit vectors, shape (k, 3).
    """
    lengths = np.full((len(outlines), len(directions)), np.nan)
    for t, points in enumerate(outlines):
        if len(points):
            low, high = np.percentile(points @ directions.T, [STRAY, 100 - STRAY], axis=0)
            lengths[t] = high - low
    return lengths


def measure_breadths(outlines: list[np.ndarray], ends: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Mean breadths of ends of the outline [m], shape (T, e, k); nan where there are no points, or not across.

    An end is the outermost third of a frame's outline, wherever that is: what is squeezed there need not be followed.

    Args:
        outlines: World points of all the mask's pixels per frame [m], each (n, 3).
        ends: Unit vectors towards the ends, shape (e, 3).
        directions: Unit vectors across, shape (k, 3).
    """
    breadths = np.full((len(outlines), len(ends), len(directions)), np.nan)
    across = [
        (e, k) for e, k in np.ndindex(len(ends), len(directions)) if abs(ends[e] @ directions[k]) < ACROSS
    ]
    for t, points in enumerate(outlines):
        thin = points[:: max(1, len(points) // MOST_POINTS)]
        if len(thin) < SLICES:
            continue
        along, beside = thin @ ends.T, thin @ directions.T
        low, high = np.percentile(along, [STRAY, 100 - STRAY], axis=0)
        for e, k in across:
            level = (along[:, e] - high[e] + (high[e] - low[e]) / 3) / max((high[e] - low[e]) / 3, 1e-12)
            breadths[t, e, k] = _measure_mean_breadth(level, beside[:, k])
    return breadths


def _measure_mean_breadth(level: np.ndarray, beside: np.ndarray) -> float:
    """Mean over slices of [0, 1] of how far points spread beside; nan if none has two."""
    slices = np.floor(level * SLICES).astype(int)
    spreads = [np.ptp(own) for s in range(SLICES) if len(own := beside[slices == s]) > 1]
    return float(np.mean(spreads)) if spreads else np.nan


def describe_extents(
    lengths: np.ndarray,
    directions: np.ndarray,
    turns: list[np.ndarray | None],
    blur: float,
    forward: np.ndarray | None = None,
) -> tuple[Extent, ...]:
    """The extents for the report.

    Args:
        lengths: Per frame and direction [body lengths], nan where not observable, shape (T, k).
        directions: Unit vectors, shape (k, 3).
        turns: Rotation vector from frame 0 per frame [rad], None where unknown.
        blur: How far an end of the outline may be off [body lengths].
        forward: The viewing direction, shape (3,); None where nothing is hidden.
    """
    seen = np.isfinite(lengths[0]) & (lengths[0] > 2 * blur)
    aslant = np.zeros(len(directions)) if forward is None else np.abs(directions @ forward)
    return tuple(
        _describe(lengths[:, k], directions[k], turns, blur, aslant[k]) for k in np.flatnonzero(seen)
    )


def _describe(length: np.ndarray, direction: np.ndarray, turns, blur: float, aslant: float) -> Extent:
    ratio, rest = length / length[0], float(length[0])
    widths = [
        None
        if turn is None or not np.isfinite(value)
        else ROUGH
        + (1 + float(value)) * blur / rest
        + HIDDEN_END * aslant * abs(1 - float(value))
        + _bound_turned(direction, turn, rest)
        for value, turn in zip(ratio, turns)
    ]
    return Extent(
        direction=tuple(direction.tolist()),
        ratio=tuple(float(v) if np.isfinite(v) else None for v in ratio),
        half_width=tuple(widths),
    )


def _bound_turned(direction: np.ndarray, turn: np.ndarray, rest: float) -> float:
    """The largest relative change of a length ``rest`` by a turn alone.

    Turned by an angle, a length a shows as between a cos and a cos + b sin, b <= 1 being the extent across it.
    """
    cosine = float(np.clip(direction @ Rotation.from_rotvec(turn).apply(direction), 0, 1))
    return max(1 - cosine, np.sqrt(1 - cosine**2) / rest)


def find_disagreement(extents: tuple[Extent, ...], stretch: list[np.ndarray | None]) -> float:
    """The largest distance of the affine fits' stretch from the extents', beyond the half widths of both.

    Args:
        extents: Extents of the outline.
        stretch: Symmetric stretch tensor from frame 0 per frame, shape (3, 3), None where unknown.
    """
    off = [
        abs(np.asarray(e.direction) @ S @ np.asarray(e.direction) - value) - width
        for e in extents
        for S, value, width in zip(stretch, e.ratio, e.half_width)
        if S is not None and value is not None and width is not None
    ]
    return float(max(off, default=0.0))
