"""One scale for the depth of a clip: what a depth model says of each frame, fitted to frame 0 over what stands still.

A model that sees one picture at a time gives each its own scale, and a relative one its own shift too.
"""

from __future__ import annotations

import cv2
import numpy as np

from physagent_jax.render.camera import Camera

_STILL = 6
"""Largest change of a colour that stands still [8-bit levels]."""
_LEAST = 0.01
"""Share of the picture that must stand still for a fit."""
_LEAST_SPREAD = 0.02
"""Spread of the fitted values [share of their median] below which they tell a scale, but no shift."""
_WRONG = 0.1
"""Median error of a fitted ground [share of the inverse depth] above which it is none."""
_SAMPLE, _PAIRS = 4000, 500  # pixels, and pairs of them, that a fit looks at


def find_still(frames: np.ndarray) -> np.ndarray:
    """The pixels that look as in frame 0, with their neighbours, bool, shape (T, H, W).

    Args:
        frames: Pictures, uint8, shape (T, H, W, 3).
    """
    kernel = np.ones((5, 5), np.uint8)
    same = [(cv2.absdiff(frame, frames[0]).max(-1) <= _STILL).astype(np.uint8) for frame in frames]
    return np.stack([cv2.erode(each, kernel) for each in same]) > 0


def anchor_depth(z: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Depth of which each frame is multiplied so that still pixels keep that of frame 0.

    Args:
        z: z-depth, nan where unknown, shape (T, H, W).
        frames: Pictures, uint8, shape (T, H, W, 3).

    Returns:
        The depth, and what weakens it.
    """
    anchored, loose = z.astype(np.float32), 0
    for t, still in enumerate(find_still(frames)):
        both = still & np.isfinite(z[0]) & np.isfinite(z[t]) & (z[t] > 0)
        if both.mean() < _LEAST:
            loose += 1
            continue
        anchored[t] *= np.median(z[0][both] / z[t][both])
    return anchored, _tell(loose)


def anchor_inverse(w: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Inverse depth of unknown scale and shift per frame, on the scale and shift of frame 0; arguments as above."""
    anchored, loose = w.astype(np.float32), 0
    for t, still in enumerate(find_still(frames)):
        both = still & np.isfinite(w[0]) & np.isfinite(w[t])
        if both.mean() < _LEAST:
            loose += 1
            continue
        scale, shift = fit_line(w[t][both], w[0][both])
        anchored[t] = scale * anchored[t] + shift
    return anchored, _tell(loose)


def fit_ground(w: np.ndarray, camera: Camera, height: float) -> tuple[float, float] | None:
    """Scale and shift that turn the inverse depth of a picture into that of the ground which it shows [1/m].

    Args:
        w: Inverse depth up to scale and shift, shape (H, W).
        camera: The camera.
        height: Height of the ground, a plane across the world's z axis [m].

    Returns:
        Scale and shift; None if most of what lies below the horizon is not that ground.
    """
    y, x = np.mgrid[: w.shape[0], : w.shape[1]] + 0.5
    rays = np.stack([x, y, np.ones_like(x)], -1) @ np.linalg.inv(np.asarray(camera.K, float)).T
    down = rays @ np.asarray(camera.viewmat, float)[:3, 2]
    inverse = down / (height - camera.center[2])
    seen = (inverse > 1e-6) & np.isfinite(w)
    if seen.mean() < _LEAST:
        return None
    scale, shift = fit_line(w[seen], inverse[seen])
    error = np.median(np.abs(scale * w[seen] + shift - inverse[seen]) / inverse[seen])
    return (scale, shift) if scale > 0 and error <= _WRONG else None


def fit_line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Scale and shift of the line from x to y that most points lie on (least median of squares, then least squares).

    Where x hardly varies, the shift is 0.
    """
    rng = np.random.default_rng(0)
    if len(x) > _SAMPLE:
        chosen = rng.choice(len(x), _SAMPLE, replace=False)
        x, y = x[chosen], y[chosen]
    x, y = x.astype(float), y.astype(float)
    middle = float(np.median(x))
    if np.subtract(*np.percentile(x, [95, 5])) < _LEAST_SPREAD * abs(middle) or len(x) < 3:
        return (float(np.median(y) / middle) if middle else 1.0), 0.0
    first, second = rng.integers(len(x), size=(2, _PAIRS))
    apart = np.abs(x[first] - x[second]) > 1e-9 * abs(middle)
    first, second = first[apart], second[apart]
    scales = (y[first] - y[second]) / (x[first] - x[second])
    shifts = y[first] - scales * x[first]
    errors = np.abs(scales[:, None] * x[::8] + shifts[:, None] - y[::8])
    best = int(np.median(errors, axis=1).argmin())
    off = np.abs(scales[best] * x + shifts[best] - y)
    near = off <= 3 * np.median(off) + 1e-12
    scale, shift = np.polyfit(x[near], y[near], 1)
    return float(scale), float(shift)


def _tell(loose: int) -> tuple[str, ...]:
    if not loose:
        return ()
    return (f"In {loose} frames too little stood still: their estimated depth has a scale of its own.",)
