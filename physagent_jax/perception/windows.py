"""Measurements within a window of frames."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.core.rotations import polar, unwrap
from physagent_jax.perception.bridging import Bridged
from physagent_jax.perception.fit import Affine
from physagent_jax.perception.reasons import BY_SIZE, CUT, GONE, NO_DEPTH, TURNED
from physagent_jax.perception.schema import WindowMotion
from physagent_jax.perception.uncertainty import NINETY

PATH_STEP = 0.005
"""Steps below are noise and do not lengthen a path [body lengths]."""

MOST_DRIFT = 0.12
"""Half width of the displacement along the line of sight from which it is not observable [body lengths]."""


@dataclasses.dataclass(frozen=True)
class Frames:
    """All that was measured, frame by frame; nan or None where not observable.

    Attributes:
        size: Longest visible extent in frame 0: the body length [m].
        center: Likely centre in frame 0 [m], shape (3,).
        centroid: Displacement from frame 0 [body lengths], shape (T, 3).
        poses: Map from the chain's first frame [m].
        chain: Which chain a pose belongs to, shape (T,).
        box: Edge lengths of the world-axis box around the visible surface [body lengths], shape (T, 3).
        depth_shown: Whether the visible surface has enough relief to show stretch along the view, shape (T,).
        reasons: Why a frame is not observable, keyed by "centroid", "rotation", "box"; each of length T.
        corners: Lowest and highest corner of the world-axis box around the visible surface, relative to ``center``
            [body lengths], shape (T, 2, 3); None if not measured.
        lengths: Lengths of the visible surface along further directions [body lengths], shape (T, k); None if
            not measured.
        breadths: Mean breadths of the six ends along these directions [body lengths], shape (T, 6, k); None if not
            measured.
        drift: Standard deviation of the object's distance against that in frame 0 [body lengths], shape (T,); None = as
            small as that of a measured depth is.
        relief_known: Whether the form of the visible surface is measured.
        tilt: Largest angle by which a fit turned out of the picture plane, believed or not [deg].
        turned: Rotations from frame 0, across gaps between chains; None = within each chain alone.
    """

    size: float
    center: np.ndarray
    centroid: np.ndarray
    poses: list[Affine | None]
    chain: np.ndarray
    box: np.ndarray
    depth_shown: np.ndarray
    reasons: dict[str, list[str]]
    corners: np.ndarray | None = None
    lengths: np.ndarray | None = None
    breadths: np.ndarray | None = None
    drift: np.ndarray | None = None
    relief_known: bool = True
    tilt: float = 0.0
    turned: Bridged | None = None

    def volume(self, frame: int, first: int = 0) -> float:
        """Volume of the box over that in frame ``first``."""
        return float(np.prod(self.box[frame] / self.box[first]))

    def rotation_from(self, first: int, last: int) -> list[np.ndarray | None]:
        """Unwrapped rotation vectors of frames first..last relative to ``first`` [rad]."""
        return unwrap([self._turn(first, t) for t in range(first, last + 1)])

    def stretch_from(self, first: int, t: int) -> np.ndarray | None:
        """Symmetric stretch of the affine map from frame ``first`` to ``t``, shape (3, 3); None where unknown."""
        a, b = self.poses[first], self.poses[t]
        if a is None or b is None or self.chain[first] != self.chain[t] or np.linalg.cond(a.matrix) > 100:
            return None
        return polar(b.matrix @ np.linalg.inv(a.matrix))[1]

    def _turn(self, first: int, t: int) -> np.ndarray | None:
        if self.turned is not None:
            start, end = self.turned.rotations[first], self.turned.rotations[t]
            if start is not None and end is not None:
                return end @ start.T
        a, b = self.poses[first], self.poses[t]
        if a is None or b is None or self.chain[first] != self.chain[t]:
            return None
        return b.rotation @ a.rotation.T

    def find_drift(self, first: int, last: int) -> float:
        """Half width of the displacement along the line of sight over frames first..last [body lengths]."""
        if self.drift is None:
            return 0.0
        return float(NINETY * np.nanmax(self.drift[first : last + 1], initial=0.0))

    def shows_approach(self, first: int, last: int) -> bool:
        """Return whether the displacement along the line of sight is observable over frames first..last."""
        return self.find_drift(first, last) <= MOST_DRIFT

    def weaknesses(self, in_view: np.ndarray) -> list[str]:
        """Plain sentences about what weakened the measurement; ``in_view`` says where the object shows, (T,)."""
        notes = []
        if self.turned is not None and self.turned.guessed:
            notes.append(
                f"It is seen from an edge for a while, and is taken to turn on there, by "
                f"{np.degrees(self.turned.guessed):.0f} degrees: it turns alike before and after."
            )
        why = self.reasons["rotation"]
        lost = [t for t, pose in enumerate(self.poses) if pose is None and in_view[t] and why[t] != TURNED]
        if lost:
            notes.append(
                f"Rotation and shape are unknown in {len(lost)} frames (first: {lost[0]}), because "
                f"{why[lost[0]]}; the centroid there is the visible surface's."
            )
        out = [t for t, reason in enumerate(self.reasons["box"]) if reason in (CUT, GONE)]
        if out:
            notes.append(
                "The object touches the picture's border or is out of it in "
                f"{len(out)} frames (first: {out[0]})."
            )
        blind = [t for t, reason in enumerate(self.reasons["centroid"]) if reason == NO_DEPTH]
        if blind:
            notes.append(f"Nothing is known in {len(blind)} frames (first: {blind[0]}), because {NO_DEPTH}.")
        if not self.relief_known:
            notes.append(
                "The form of the surface is not measured: turns out of the picture plane, and what moves or deforms "
                "along the line of sight at one place, are not observable."
            )
            if TURNED in why:
                notes.append(f"Rotation and shape are unknown in {why.count(TURNED)} frames: {TURNED}.")
            if not self.shows_approach(0, len(self.poses) - 1):
                notes.append(f"How far it moves along the line of sight is not observable: {BY_SIZE}.")
        elif not self.depth_shown[0]:
            notes.append(
                "The visible side has too little relief to show stretch along the viewing direction."
            )
        return notes


def measure_window(frames: Frames, first: int, last: int) -> WindowMotion:
    """Motion over frames first..last, relative to ``first``."""
    found, missing, along = {}, {}, True
    for measure, fields, topic in (
        (_measure_travel, ("displacement", "path_length"), "centroid"),
        (_find_peak, ("peak_displacement", "peak_frame"), "centroid"),
        (_turn, ("rotation_axis", "rotation_degrees"), "rotation"),
        (_measure_stretch, ("stretch",), "rotation"),
        (_measure_volume, ("volume_ratio",), "box"),
    ):
        values = measure(frames, first, last) if last > first else None
        if values is None:
            reason = (
                "the window has one frame only" if last == first else _explain(frames, topic, first, last)
            )
            missing |= dict.fromkeys(fields, reason)
            values = (None,) * len(fields)
        found |= dict(zip(fields, values))
    if found["displacement"] is not None and not (along := frames.shows_approach(first, last)):
        missing["displacement along the line of sight"] = BY_SIZE
    shown = bool(found["stretch"] is not None and frames.depth_shown[first])
    return WindowMotion(
        first=first,
        last=last,
        displacement_view_axis_observable=along,
        stretch_view_axis_observable=shown,
        unobservable=missing,
        **found,
    )


def _explain(frames: Frames, topic: str, first: int, last: int) -> str:
    """The reason at the later end of the window, else at its start, else between."""
    why = frames.reasons[topic]
    between = next((why[t] for t in range(first, last + 1) if why[t]), "")
    return why[last] or why[first] or between or "the points were lost in between"


def _measure_travel(frames: Frames, first: int, last: int):
    c = frames.centroid[first : last + 1]
    if not np.isfinite(c[[0, -1]]).all():
        return None
    length, here = 0.0, c[0]
    for there in c[np.isfinite(c[:, 0])]:
        step = np.linalg.norm(there - here)
        if step > PATH_STEP:
            length, here = length + step, there
    return tuple((c[-1] - c[0]).tolist()), float(length)


def _find_peak(frames: Frames, first: int, last: int):
    away = frames.centroid[first : last + 1] - frames.centroid[first]
    if not np.isfinite(away[:, 0]).any():
        return None
    k = int(np.nanargmax(np.linalg.norm(away, axis=1)))
    return tuple(away[k].tolist()), first + k


def _turn(frames: Frames, first: int, last: int):
    vector = frames.rotation_from(first, last)[-1]
    if vector is None:
        return None
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle > 1e-6 else np.array([0.0, 0.0, 1.0])
    return tuple(axis.tolist()), float(np.degrees(angle))


def _measure_stretch(frames: Frames, first: int, last: int):
    S = frames.stretch_from(first, last)
    return None if S is None else (tuple(map(tuple, S.tolist())),)


def _measure_volume(frames: Frames, first: int, last: int):
    ratio = frames.volume(last, first)
    return (ratio,) if np.isfinite(ratio) else None
