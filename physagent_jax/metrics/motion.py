"""True motion from particle trajectories, in the measures of the motion report, and the report's errors.

For honesty only: how good was perception? No agent sees any of this.
"""

from __future__ import annotations

import numpy as np

from physagent_jax.core.rotations import polar, unwrap
from physagent_jax.core.strict import Strict, Vector
from physagent_jax.perception.schema import MotionReport

_TAIL = 0.5
"""Particles beyond this percentile on either side of an axis do not count for a box [%]."""
ALIGNED_DEGREES = 10.0
"""Rotation up to which perception's stretch tensor compares with extents along the world axes [deg]."""


class TrueMotion(Strict):
    """Motion of the particles themselves, in the same measures as the motion report.

    For the report's honesty only: no agent ever sees it.

    Attributes:
        object_size: Longest extent of the rest particles [m].
        centroid: Per frame displacement of the Gaussians' centroid from frame 0 [body lengths].
        rotation_degrees: Per frame, angle of the best rigid fit [deg].
        volume_ratio: Per frame, bounding-box volume over frame 0's.
        stretch: Per frame, extents (standard deviations) along world x, y, z over frame 0's.
    """

    object_size: float
    centroid: tuple[Vector, ...]
    rotation_degrees: tuple[float, ...]
    volume_ratio: tuple[float, ...]
    stretch: tuple[Vector, ...]


def measure_true_motion(positions: np.ndarray) -> TrueMotion:
    """Motion of the particles themselves.

    Args:
        positions: Particle or Gaussian centres per frame [m], shape (T, n, 3).

    Returns:
        Displacement of the mean, angle of the rotation in the best affine fit (unwrapped), volume ratio of
        the world-axis box, standard deviations along world x, y, z over those of frame 0.
    """
    x = np.asarray(positions, np.float64)
    low, high = np.percentile(x, [_TAIL, 100 - _TAIL], axis=1)
    edges = high - low
    size = float(np.ptp(x[0], axis=0).max()) or 1.0
    spread = x.std(axis=1)
    rest = x[0] - x[0].mean(axis=0)
    turns = unwrap([_fit_rotation(rest, frame - frame.mean(axis=0)) for frame in x])
    floor = 1e-6 * size
    return TrueMotion(
        object_size=size,
        centroid=_to_vectors((x.mean(axis=1) - x[0].mean(axis=0)) / size),
        rotation_degrees=tuple(float(np.degrees(np.linalg.norm(v))) for v in turns if v is not None),
        volume_ratio=tuple(np.prod((edges + floor) / (edges[0] + floor), axis=1).tolist()),
        stretch=_to_vectors((spread + floor) / (spread[0] + floor)),
    )


def compare(report: MotionReport, truth: TrueMotion) -> dict[str, float | int | None]:
    """Errors of the report against the truth; None where the report says "not observable".

    Displacements are compared in true body lengths, so that a misjudged size is not counted twice.

    Args:
        report: What perception said.
        truth: What the particles did, over the same frames.

    Returns:
        `centroid_error_last`, `centroid_error_max` [true body lengths], `rotation_error_last`,
        `rotation_error_max` [deg], `volume_ratio_error_last`, `stretch_error_last` (largest over the world
        axes, as far as the affine stretch compares with standard deviations), `size_ratio` (perceived over
        true), `frames_observed`.

    Raises:
        ValueError: The numbers of frames differ.
    """
    if report.frame_count != len(truth.centroid):
        raise ValueError(
            f"report has {report.frame_count} frames, truth {len(truth.centroid)}; compare the same clip"
        )
    scale = report.object_size / truth.object_size
    centroid = [
        None if a is None else float(np.linalg.norm(np.multiply(a, scale) - b))
        for a, b in zip(report.centroid, truth.centroid)
    ]
    rotation = [
        None if a is None else abs(a - b) for a, b in zip(report.rotation_degrees, truth.rotation_degrees)
    ]
    volume = report.volume_ratio[-1]
    return {
        "centroid_error_last": centroid[-1],
        "centroid_error_max": _find_largest(centroid),
        "rotation_error_last": rotation[-1],
        "rotation_error_max": _find_largest(rotation),
        "volume_ratio_error_last": None if volume is None else abs(volume - truth.volume_ratio[-1]),
        "stretch_error_last": _measure_stretch_error(report, truth),
        "size_ratio": scale,
        "frames_observed": sum(e is not None for e in centroid),
    }


def _fit_rotation(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Rotation in the least-squares linear map a -> b of centred particles, shape (3, 3)."""
    cov = a.T @ a
    cov += (1e-9 * np.trace(cov) + 1e-30) * np.eye(3)  # particles in a plane, on a line, or only one
    return polar(b.T @ a @ np.linalg.inv(cov))[0]


def _measure_stretch_error(report: MotionReport, truth: TrueMotion) -> float | None:
    """Largest difference along the world axes; the tensor is set against the truth only without a turn."""
    whole = report.windows[0]
    if (
        whole.stretch is None
        or (whole.rotation_degrees or 0.0) > ALIGNED_DEGREES
        or not whole.stretch_view_axis_observable
    ):
        return None
    return float(np.abs(np.diag(np.asarray(whole.stretch)) - truth.stretch[-1]).max())


def _find_largest(errors: list[float | None]) -> float | None:
    return max((e for e in errors if e is not None), default=None)


def _to_vectors(rows: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(a), float(b), float(c)) for a, b, c in rows)
