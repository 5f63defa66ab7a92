"""The timing of the object's motion: onset, settling, reversals, frequency."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.turning import find_turning_points
from physagent_jax.perception.schema import Oscillation

FEWEST_KNOWN = 5
"""Frames with a known place below which nothing is said about swinging."""
LEAST_REVERSALS = 2
"""Out, back beyond, and out again: fewer reversals are a single excursion."""


def find_onset(distance: np.ndarray, threshold: float) -> int | None:
    """First frame from which the object is visibly away from frame 0 for two frames in a row.

    Args:
        distance: Per frame, distance from frame 0 (nan where unknown), shape (T,).
        threshold: What counts as visible, in the same unit.
    """
    away = np.nan_to_num(distance, nan=np.inf) > threshold
    away[:-1] &= away[1:]
    known = np.isfinite(distance)
    frames = np.flatnonzero(away & known)
    return int(frames[0]) if len(frames) else None


def find_settling(distance_to_end: np.ndarray, threshold: float) -> int | None:
    """Frame from which the object stays where it ends, None if it moves until the end.

    Args:
        distance_to_end: Per frame, distance from the last frame (nan where unknown), shape (T,).
        threshold: What counts as visible, in the same unit.
    """
    count = len(distance_to_end)
    away = ~(distance_to_end <= threshold)
    if away[-1]:
        return None
    first = int(np.flatnonzero(away)[-1]) + 1 if away.any() else 0
    rest = count - 1 - first
    return first if rest >= max(3, count // 10) else None


def find_oscillation(centroid: np.ndarray, frame_dt: float, threshold: float) -> Oscillation | None:
    """Swinging of the centroid along one of its principal directions, the widest that reverses.

    The directions come from the path less its straight trend; the reversals from the path itself, so that
    a fall with a bounce counts and a curved one does not. The frequency is half the inverse of the mean
    time between turning points.

    Args:
        centroid: Displacement per frame [body lengths], nan where unknown, shape (T, 3).
        frame_dt: [s].
        threshold: What counts as a motion [body lengths].

    Returns:
        The oscillation, None if there are fewer than two reversals.
    """
    known = np.isfinite(centroid[:, 0])
    if known.sum() < FEWEST_KNOWN:
        return None
    t = np.arange(len(centroid))
    path = np.stack([np.interp(t, t[known], c[known]) for c in centroid.T], 1)
    trend = np.stack([np.polyval(np.polyfit(t, c, 1), t) for c in path.T], 1)
    _, spread, axes = np.linalg.svd(path - trend - (path - trend).mean(0), full_matrices=False)
    for axis, width in zip(axes, spread):
        signal = path @ axis
        turns = [t + _find_vertex(signal, t) for t in find_turning_points(signal, threshold)]
        if len(turns) >= LEAST_REVERSALS and width > 0:
            period = 2 * (turns[-1] - turns[0]) / (len(turns) - 1)
            first = signal[int(round(turns[0]))] - signal[0]
            return Oscillation(
                direction=tuple((axis * (np.sign(first) or 1)).tolist()),
                frequency_hz=1 / (period * frame_dt),
                amplitude=float(np.ptp(signal) / 2),
                reversals=len(turns),
            )
    return None


def _find_vertex(signal: np.ndarray, t: int) -> float:
    """The offset of the turning point from frame t: the vertex of a parabola through three frames."""
    if t in (0, len(signal) - 1):
        return 0.0
    before, at, after = signal[t - 1 : t + 2]
    curvature = before - 2 * at + after
    return float(np.clip(0.5 * (before - after) / curvature, -0.5, 0.5)) if curvature else 0.0
