"""The motion report as perfect perception would fill it: from the particles' true trajectories.

For judging and measuring only. In a run, agents read what perception saw, never this.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.rotations import polar, unwrap
from physagent_jax.metrics.pieces import count_pieces
from physagent_jax.perception import timing
from physagent_jax.perception.ends import DIRECTIONS
from physagent_jax.perception.extents import describe_extents, measure_breadths
from physagent_jax.perception.fit import Affine
from physagent_jax.perception.schema import (
    Box,
    Extent,
    Matrix,
    MotionReport,
    PartMotion,
    Quality,
    Uncertainty,
)
from physagent_jax.perception.windows import Frames, measure_window
from physagent_jax.perception.words import ViewerWords, describe_motion
from physagent_jax.render.camera import Camera

VISIBLE = 0.01
"""Least motion that counts as seen, as in perception [body lengths]."""
THINNEST = 0.03
"""Box edges are taken as at least this long in ratios, as in perception [body lengths]."""
STRAY = 0.5
"""Particles beyond this percentile on either side of an axis do not count for a box [%]."""


def report_true_motion(
    positions: np.ndarray,
    *,
    frame_dt: float,
    camera: Camera | None = None,
    up: Sequence[float] = (0.0, 0.0, 1.0),
    windows: Sequence[tuple[int, int]] = (),
    parts: Mapping[int, np.ndarray] | None = None,
) -> MotionReport:
    """Fill a motion report from true trajectories, all fields, without uncertainty.

    Args:
        positions: Particle or Gaussian centres per frame [m], shape (T, n, 3).
        frame_dt: Seconds per frame [s].
        camera: The reference camera, for the words and for when the object leaves the picture; None = no text,
            never out of the picture.
        up: World up, for the words.
        windows: Further windows of interest as (first, last) frames, inclusive.
        parts: Particles of parts that are followed by themselves, by the part's number; bool, shape (n,) each.

    Returns:
        The report.

    Raises:
        UserError: ``positions`` is not of that shape, not finite, or a window lies outside of the clip.
    """
    x = np.asarray(positions, np.float64)
    if x.ndim != 3 or x.shape[-1] != 3 or not x.size or not np.isfinite(x).all():
        raise UserError("`positions` must be finite numbers of shape (T, n, 3)", got=x.shape)
    count = len(x)
    for first, last in windows:
        if not 0 <= first <= last < count:
            raise UserError(
                f"window ({first}, {last}) is outside of the clip", do=f"stay within 0..{count - 1}"
            )
    size = float(np.ptp(x[0], axis=0).max()) or 1.0
    center = x[0].mean(axis=0)
    poses = _fit(x)
    low, high = np.percentile(x, [STRAY, 100 - STRAY], axis=1)
    frames = Frames(
        size=size,
        center=center,
        centroid=(x.mean(axis=1) - center) / size,
        poses=list(poses),
        chain=np.zeros(count, int),
        box=np.maximum((high - low) / size, THINNEST),
        depth_shown=np.ones(count, bool),
        reasons={topic: [""] * count for topic in ("centroid", "rotation", "box")},
    )
    turns = frames.rotation_from(0, count - 1)
    turn = _to_degrees(turns)
    report = MotionReport(
        frame_count=count,
        frame_dt=frame_dt,
        object_size=size,
        object_center=_to_vector(center),
        windows=tuple(measure_window(frames, *span) for span in list_spans(count, windows)),
        centroid=_to_vectors(frames.centroid),
        rotation_degrees=tuple(np.linalg.norm(turn, axis=1).tolist()),
        volume_ratio=tuple(frames.volume(t) for t in range(count)),
        rotation=_to_vectors(turn),
        stretch=tuple(_to_matrix(polar(pose.matrix)[1]) for pose in poses),
        box=tuple(
            Box(low=_to_vector(a), high=_to_vector(b))
            for a, b in zip((low - center) / size, (high - center) / size)
        ),
        extents=_measure_extents(x, turns, size, camera, up),
        parts=(*_measure_ends(x, turns, size, camera, up), *_measure_parts(x, size, parts or {})),
        pieces=tuple(count_pieces(x, np.stack([pose.matrix for pose in poses]), size)),
        uncertainty=Uncertainty(displacement=0.0, rotation=0.0, axis=0.0, stretch=0.0, frequency=0.0),
        oscillation=timing.find_oscillation(frames.centroid, frame_dt, VISIBLE),
        onset_frame=timing.find_onset(_measure_distances(x, 0) / size, VISIBLE),
        settle_frame=timing.find_settling(_measure_distances(x, -1) / size, VISIBLE),
        quality=Quality(
            tracks_kept=1.0,
            fit_residual=max(pose.residual for pose in poses) / size,
            depth_noise=0.0,
            mask_fraction=1.0 if camera is None else _measure_share_of_picture(x[0], camera),
            leaves_frame=None if camera is None else _find_leaving(x, camera),
        ),
        text="",
    )
    if camera is None:
        return report
    return report.model_copy(update={"text": describe_motion(report, ViewerWords(camera, up))})


def list_spans(count: int, windows: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Whole clip, its quarters (neighbours share a frame, so that displacements add up), windows asked for."""
    marks = [round(k * (count - 1) / 4) for k in range(5)]
    spans = [(0, count - 1), *zip(marks, marks[1:])]
    return spans + [w for w in dict.fromkeys((int(a), int(b)) for a, b in windows) if w not in spans]


def _fit(x: np.ndarray) -> list[Affine]:
    """Least-squares affine maps from frame 0 to every frame."""
    rest, middle = x[0] - x[0].mean(axis=0), x[0].mean(axis=0)
    cov = rest.T @ rest
    floor = (1e-9 * np.trace(cov) + 1e-30) * np.eye(3)  # particles in a plane, on a line, or only one
    inverse = np.linalg.inv(cov + floor)
    poses = []
    for frame in x:
        here = frame.mean(axis=0)
        matrix = ((frame - here).T @ rest + floor) @ inverse
        offset = here - matrix @ middle
        residual = np.sqrt(np.mean(np.sum((x[0] @ matrix.T + offset - frame) ** 2, axis=1)))
        poses.append(Affine(matrix, offset, polar(matrix)[0], float(residual)))
    return poses


def _measure_extents(
    x: np.ndarray, turns: list[np.ndarray | None], size: float, camera: Camera | None, up: Sequence[float]
) -> tuple[Extent, ...]:
    """Along all of the viewer's directions, hidden ones too; world axes without a camera."""
    axes = _list_axes(camera, up)
    low, high = np.percentile(x @ axes.T, [STRAY, 100 - STRAY], axis=1)
    return describe_extents((high - low) / size, axes, turns, 0.0)


def _list_axes(camera: Camera | None, up: Sequence[float]) -> np.ndarray:
    """The viewer's directions, world axes without a camera, shape (3, 3)."""
    return np.eye(3) if camera is None else np.stack([axis for _, axis in ViewerWords(camera, up).axes()])


def _measure_ends(
    x: np.ndarray, turns: list[np.ndarray | None], size: float, camera: Camera | None, up: Sequence[float]
) -> tuple[PartMotion, ...]:
    """The six ends: the third of the particles farthest along +-x, +-y, +-z in frame 0."""
    ends, share = [], max(1, x.shape[1] // 3)
    axes = _list_axes(camera, up)
    breadths = np.moveaxis(measure_breadths(list(x), DIRECTIONS, axes) / size, 1, 0)
    for axis in range(3):
        order = np.argsort(x[0, :, axis], kind="stable")
        for sign, chosen in ((1.0, order[-share:]), (-1.0, order[:share])):
            direction = np.zeros(3)
            direction[axis] = sign
            extents = describe_extents(breadths[len(ends)], axes, turns, 0.0)
            ends.append(_follow(x[:, chosen], direction, size, None, extents))
    return tuple(ends)


def _measure_parts(x: np.ndarray, size: float, parts: Mapping[int, np.ndarray]) -> list[PartMotion]:
    center = x[0].mean(axis=0)
    away = {number: x[0, chosen].mean(axis=0) - center for number, chosen in parts.items()}
    return [
        _follow(x[:, chosen], away[number] / (np.linalg.norm(away[number]) or 1.0), size, number).model_copy(
            update=dict(place=_to_vector(away[number] / size))
        )
        for number, chosen in parts.items()
    ]


def _follow(
    part: np.ndarray,
    direction: np.ndarray,
    size: float,
    number: int | None,
    extents: tuple[Extent, ...] = (),
) -> PartMotion:
    poses = _fit(part)
    turn = _to_degrees(unwrap([pose.rotation for pose in poses]))
    moved = (part.mean(axis=1) - part[0].mean(axis=0)) / size
    return PartMotion(
        direction=_to_vector(direction),
        limb=number,
        centroid=_to_vectors(moved),
        rotation=_to_vectors(turn),
        stretch=tuple(_to_matrix(polar(pose.matrix)[1]) for pose in poses),
        extents=extents,
    )


def _measure_distances(x: np.ndarray, frame: int) -> np.ndarray:
    """RMS distance of the particles from where they are in ``frame`` [m], shape (T,)."""
    return np.sqrt(np.mean(np.sum((x - x[frame]) ** 2, axis=2), axis=1))


def _project(points: np.ndarray, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Pixel coordinates, shape (n, 2), and whether they lie in the picture, shape (n,)."""
    view = np.asarray(camera.viewmat, np.float64)
    local = points @ view[:3, :3].T + view[:3, 3]
    depth = np.maximum(local[:, 2], 1e-9)
    pixels = (local @ np.asarray(camera.K, np.float64).T)[:, :2] / depth[:, None]
    size = np.array([camera.width, camera.height])
    return pixels, (local[:, 2] > 0) & (pixels > 1.0).all(1) & (pixels < size - 1.0).all(1)


def _find_leaving(x: np.ndarray, camera: Camera) -> int | None:
    """First frame in which more than stray particles are at the border or beyond; None if never."""
    for t, frame in enumerate(x):
        if np.mean(~_project(frame, camera)[1]) > STRAY / 100:
            return t
    return None


def _measure_share_of_picture(points: np.ndarray, camera: Camera) -> float:
    """Share of the pixels that the box around the projected points covers; the object itself covers less."""
    pixels, inside = _project(points, camera)
    if not inside.any():
        return 0.0
    return float(np.prod(np.ptp(pixels[inside], axis=0)) / (camera.width * camera.height))


def _to_degrees(vectors: Sequence[np.ndarray | None]) -> np.ndarray:
    return np.degrees(np.stack([v for v in vectors if v is not None]))


def _to_vector(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


def _to_matrix(rows: np.ndarray) -> Matrix:
    a, b, c = map(_to_vector, rows)
    return a, b, c


def _to_vectors(rows: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    return tuple(map(_to_vector, rows))
