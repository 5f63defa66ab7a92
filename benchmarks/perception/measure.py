"""Errors of perception on clips whose motion is known."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.harness import Row
from benchmarks.perception.motions import LOOK, RIGHT, Motion
from benchmarks.perception.scenes import FRAME_DT, FRAMES, Sight
from physagent_jax.core.rotations import polar
from physagent_jax.perception.measure import Perception, perceive
from physagent_jax.perception.protocols import PerceptionBackends
from physagent_jax.perception.schema import MotionReport
from physagent_jax.perception.uncertainty import NINETY

TOUCHING = 0.02
"""Distance from the floor within which an object touches it [m]."""
SEEN_SHIFT, SEEN_TURN = 0.1, 10.0
"""Directions are compared from these on [body lengths], [deg]."""


def measure(
    sight: Sight,
    motion: Motion,
    rgb: np.ndarray,
    depth: np.ndarray,
    backends: PerceptionBackends,
    grounded: bool,
) -> Row:
    """Errors and stated uncertainties of one clip; a figure that the report does not have is None.

    Args:
        sight: The truth.
        motion: Its motion.
        rgb: Pictures, uint8, shape (T, H, W, 3).
        depth: z-depth [m], shape (T, H, W).
        backends: Backends that see them.
        grounded: Whether there is a floor, which it then touches in frame 0 or not.
    """
    touches = grounded and sight.means[0, :, 2].min() < sight.floor + TOUCHING
    seen = perceive(
        rgb,
        depth,
        sight.camera,
        frame_dt=FRAME_DT,
        backends=backends,
        ground=sight.floor if touches else None,
        length=1.0,
    )
    report = seen.report
    return {
        **_measure_depth(seen, sight),
        **_measure_displacement(report, sight),
        **_measure_rotation(report, motion),
        **_measure_stretch(report, motion),
        **_measure_outline(report, motion),
        **_measure_frequency(report, motion),
        "still": report.onset_frame is None,
        "pieces": max((p for p in report.pieces if p is not None), default=None),
        "notes": [note for note in report.quality.notes if "depth channel" not in note],
        "text": report.text,
    }


def _measure_depth(seen: Perception, sight: Sight) -> Row:
    """Error of an estimated depth that 95 % of the object's pixels stay below [half widths that it states]."""
    z, spread = seen.depth.z, seen.depth.uncertainty
    if spread is None:
        return {}
    known = np.isfinite(z) & (sight.alpha > 0.5) & seen.masks
    if not known.any():
        return {"depth": None, "depth_stated": None}
    off = np.abs(z - sight.depth)[known] / (NINETY * spread[known])
    return {"depth": float(np.quantile(off, 0.95)), "depth_stated": 1.0}


def _measure_displacement(report: MotionReport, sight: Sight) -> Row:
    """Largest error over the clip [true body lengths]; of the direction, in the frame of the largest shift [deg].

    Also that across the line of sight, and that along it; where that part is not observable, nor is the whole.
    """
    true = (sight.means.mean(1) - sight.means[0].mean(0)) / sight.size
    scale = report.object_size / sight.size
    seen = np.array([(np.nan,) * 3 if c is None else c for c in report.centroid]) * scale
    found = {"displacement": None, "direction": None, "frames": int(np.isfinite(seen[:, 0]).sum())}
    found |= {"across": None, "along": None}
    observed = report.windows[0].displacement_view_axis_observable
    stated, beside = report.uncertainty.displacement, report.uncertainty.along
    if np.isfinite(seen[-1]).all():
        off = seen - true
        found["across"] = float(np.nanmax(np.linalg.norm(off - np.outer(off @ LOOK, LOOK), axis=1)))
        if observed:
            found["along"] = float(np.nanmax(np.abs(off @ LOOK)))
            found["displacement"] = float(np.nanmax(np.linalg.norm(off, axis=1)))
    whole = None if stated is None else float(np.hypot(stated, beside or 0.0))
    for name, width in (
        ("displacement", whole),
        ("across", stated),
        ("along", stated if beside is None else beside),
    ):
        found[f"{name}_stated"] = None if width is None else width * scale
    far = int(np.linalg.norm(true, axis=1).argmax())
    if np.linalg.norm(true[far]) < SEEN_SHIFT:
        return found | {"has_direction": False}
    if observed and np.isfinite(seen[far]).all():
        found["direction"] = _measure_angle(seen[far], true[far])
    return found | {"has_direction": True, "size_ratio": scale}


def _measure_rotation(report: MotionReport, motion: Motion) -> Row:
    """At the last frame: of the rotation as a whole, of its angle, and of its axis [deg]."""
    true, seen = np.asarray(motion.turn(1.0)), report.rotation[-1] if report.rotation else None
    turns = bool(np.linalg.norm(true) >= SEEN_TURN)
    row = {"in_plane": motion.in_plane, "turns": turns, "rotation": None, "angle": None, "axis": None}
    row |= {"rotation_stated": report.uncertainty.rotation, "axis_stated": report.uncertainty.axis}
    if seen is None:
        return row
    off = Rotation.from_rotvec(np.radians(seen)).inv() * Rotation.from_rotvec(np.radians(true))
    row["rotation"] = float(np.degrees(off.magnitude()))
    row["angle"] = float(abs(np.linalg.norm(seen) - np.linalg.norm(true)))
    if turns:
        row["axis"] = _measure_angle(np.asarray(seen), true)
    return row


def _measure_stretch(report: MotionReport, motion: Motion) -> Row:
    """At the last frame, along two directions across the line of sight: the largest relative error."""
    row = {"stretch": None, "stretch_stated": report.uncertainty.stretch}
    seen = report.stretch[-1] if report.stretch else None
    if seen is None:
        return row
    true, across = polar(motion.matrix(1.0))[1], np.cross(LOOK, RIGHT)
    errors = [abs(n @ np.asarray(seen) @ n / (n @ true @ n) - 1) for n in (RIGHT, across)]
    return row | {"stretch": float(max(errors))}


def _measure_outline(report: MotionReport, motion: Motion) -> Row:
    """At the last frame, the outline's lengths along right and up: the error that is worst for its half width."""
    true, errors = polar(motion.matrix(1.0))[1], []
    for extent in report.extents:
        n, ratio, stated = np.asarray(extent.direction), extent.ratio[-1], extent.half_width[-1]
        if ratio is not None and stated is not None:
            factor = n @ true @ n
            errors.append((abs(ratio / factor - 1), stated / factor))
    error, stated = max(errors, key=lambda e: e[0] / e[1], default=(None, None))
    return {"outline": error, "outline_stated": stated}


def _measure_frequency(report: MotionReport, motion: Motion) -> Row:
    """Relative error of the frequency; whether a swing was seen where there is none."""
    seen = report.oscillation
    if motion.frequency is None:
        return {"swings": False, "false_swing": seen is not None}
    true = motion.frequency / (FRAME_DT * (FRAMES - 1))
    row = {"swings": True, "frequency": None, "frequency_stated": None}
    if seen is None:
        return row
    stated = report.uncertainty.frequency
    return row | {
        "frequency": abs(seen.frequency_hz / true - 1),
        "frequency_stated": None if stated is None else stated / true,
    }


def _measure_angle(a: np.ndarray, b: np.ndarray) -> float:
    cosine = a @ b / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-9)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
