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
