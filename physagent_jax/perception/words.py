"""The report in sentences: numbers first, the viewer's words and world axes beside them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physagent_jax.perception.schema import MotionReport, WindowMotion
from physagent_jax.perception.timing import FEWEST_KNOWN
from physagent_jax.render.camera import Camera

Vectorlike = Sequence[float] | np.ndarray

STILL = 0.015
"""Displacements below are told as none [body lengths]."""
SLIGHT_TURN, PLAIN_TURN = 2.0, 15.0
"""Rotations below are told as none, or as minor [deg]."""


class ViewerWords:
    """The viewer's directions as world vectors, and world vectors in the viewer's words.

    Args:
        camera: The reference camera.
        up: World up, shape (3,).
    """

    def __init__(self, camera: Camera, up: Vectorlike):
        self.up = np.asarray(up, float) / np.linalg.norm(up)
        right = camera.right - (camera.right @ self.up) * self.up
        if np.linalg.norm(right) < 1e-6:  # a camera lying on its side: its vertical axis is level
            right = np.asarray(camera.viewmat, float)[1, :3]
        self.right = right / np.linalg.norm(right)
        self.away = np.cross(self.up, self.right)

    def components(self, vector: Vectorlike) -> list[tuple[float, str]]:
        """Parts of ``vector`` along the viewer's axes, largest first, without the minor ones."""
        pairs = (
            (self.right, "right", "left"),
            (self.up, "up", "down"),
            (self.away, "away from the camera", "towards the camera"),
        )
        v = np.asarray(vector, float)
        parts = [(abs(float(v @ axis)), plus if v @ axis > 0 else minus) for axis, plus, minus in pairs]
        return sorted((p for p in parts if p[0] >= max(0.25 * np.linalg.norm(v), 0.005)), reverse=True)

    def where(self, vector: Vectorlike) -> str:
        """Direction like "to the left (world -x)"; with the lengths of its parts where it has several."""
        parts = self.components(vector)
        if len(parts) > 1:
            return f"({', '.join(f'{size:.2f} {name}' for size, name in parts)}; {name_world_axis(vector)})"
        name = parts[0][1] if parts else "nowhere"
        return f"{'to the ' if name in ('left', 'right') else ''}{name} ({name_world_axis(vector)})"

    def turn(self, axis: Vectorlike) -> str:
        """Sense of a rotation about ``axis`` (right-hand rule) as the viewer sees it."""
        a = np.asarray(axis, float)
        senses = (
            (self.up, "counter-clockwise seen from above", "clockwise seen from above"),
            (self.away, "clockwise for the viewer", "counter-clockwise for the viewer"),
            (self.right, "tipping its top towards the camera", "tipping its top away from the camera"),
        )
        along, plus, minus = max(senses, key=lambda s: abs(float(a @ s[0])))
        return f"{plus if a @ along > 0 else minus}, about {name_world_axis(axis)}"

    def axes(self) -> tuple[tuple[str, np.ndarray], ...]:
        """Names of the three directions along which stretch is told, with their unit vectors."""
        return ("left-right", self.right), ("up-down", self.up), ("towards-away", self.away)


def name_world_axis(vector: Vectorlike) -> str:
    """Says "world -x" if ``vector`` lies within 18 degrees of an axis, else its numbers."""
    v = np.asarray(vector, float)
    k = int(np.argmax(np.abs(v)))
    if abs(v[k]) >= 0.95 * np.linalg.norm(v):
        return f"world {'-' if v[k] < 0 else '+'}{'xyz'[k]}"
    return "world (" + ", ".join(f"{x:.2f}" for x in v) + ")"


def describe_motion(report: MotionReport, words: ViewerWords) -> str:
    """The whole report as one paragraph."""
    windows = [_keep_seen(w, report.unmeasured_direction) for w in report.windows]
    whole, quarters, asked = windows[0], windows[1:5], windows[5:]
    parts = [_describe_whole(whole, words), _describe_swing(report, words), _format_times(report, whole)]
    if report.onset_frame is not None:
        parts.append(
            "By quarters: " + "; ".join(_summarise(w, words) for w in quarters if w.last > w.first) + "."
        )
    parts += [f"Window asked for: {_summarise(w, words)}." for w in asked]
    parts += [f"Note: {note}" for note in report.quality.notes]
    return " ".join(p for p in parts if p)


def _keep_seen(w: WindowMotion, sight: Vectorlike | None) -> WindowMotion:
    """A window's motion without what lies along a line of sight ``sight`` and is a guess there."""
    if sight is None:
        return w
    seen, along = {}, np.asarray(sight, float)
    if not w.displacement_view_axis_observable:
        for name in ("displacement", "peak_displacement"):
            if (vector := getattr(w, name)) is not None:
                seen[name] = tuple((np.asarray(vector) - along * (along @ np.asarray(vector))).tolist())
    if w.rotation_axis is not None and w.rotation_degrees is not None:
        turn = float(along @ np.asarray(w.rotation_axis)) * w.rotation_degrees
        axis = along if turn >= 0 else -along
        seen |= {"rotation_axis": tuple(axis.tolist()), "rotation_degrees": abs(turn)}
    return w.model_copy(update=seen)


def _describe_whole(w: WindowMotion, words: ViewerWords) -> str:
    """Net motion of the clip in the paper's manner (appendix B.1)."""
    text = [f"At frame {w.last}, {_describe_translation(w, words)} {_describe_rotation(w, words)}."]
    if w.displacement is not None and w.peak_displacement is not None:
        peak, net = np.linalg.norm(w.peak_displacement), np.linalg.norm(w.displacement)
        if peak > max(1.2 * net, 0.03):
            text.append(
                f"Its largest displacement is {peak:.2f} body lengths {words.where(w.peak_displacement)} "
                f"at frame {w.peak_frame}; its path is {w.path_length or 0:.2f} body lengths long."
            )
    elif w.peak_displacement is not None:
        text.append(
            f"While it was seen, it moved up to {np.linalg.norm(w.peak_displacement):.2f} body lengths "
            f"{words.where(w.peak_displacement)}, at frame {w.peak_frame}."
        )
    text += [_describe_stretch(w, words), _describe_volume(w)]
    return " ".join(t for t in text if t)


def _describe_translation(w: WindowMotion, words: ViewerWords) -> str:
    if w.displacement is None:
        return f"the centroid is not observable ({w.unobservable.get('displacement', 'unknown')})"
    size = float(np.linalg.norm(w.displacement))
    if size < STILL:
        return "the centroid is where it was in the initial frame,"
    verb = "translates" if size >= 0.05 else "barely translates"
    return f"the centroid {verb} {size:.2f} body lengths {words.where(w.displacement)}"


def _describe_rotation(w: WindowMotion, words: ViewerWords) -> str:
    if w.rotation_degrees is None or w.rotation_axis is None:
        return f"and its rotation is not observable ({w.unobservable.get('rotation_degrees', 'unknown')})"
    angle = w.rotation_degrees
    if angle < SLIGHT_TURN:
        return "without rotation"
    sense = words.turn(w.rotation_axis)
    return f"with {'minor ' if angle < PLAIN_TURN else 'a '}rotation ({angle:.0f} deg {sense})"


def _format_factors(w: WindowMotion, words: ViewerWords) -> str:
    """Stretch along the viewer's axes, where it differs from 1 by more than it may be wrong."""
    if w.stretch is None:
        return ""
    least = 0.05 if (w.rotation_degrees or 0) < PLAIN_TURN else 0.15  # another side in view: less exact
    S, told = np.asarray(w.stretch), []
    for name, n in words.axes():
        factor = float(n @ S @ n)
        if abs(factor - 1) > least and (name != "towards-away" or w.stretch_view_axis_observable):
            told.append(f"{factor:.2f}x {name} ({name_world_axis(n).replace('+', '').replace('-', '')})")
    return ", ".join(told)


def _describe_stretch(w: WindowMotion, words: ViewerWords) -> str:
    told = _format_factors(w, words)
    return f"Its shape is scaled {told}." if told else ""


def _describe_volume(w: WindowMotion) -> str:
    if w.volume_ratio is None:
        reason = w.unobservable.get("volume_ratio", "unknown")
        return f"The bounding box volume is not observable ({reason})."
    if (w.rotation_degrees or 0) >= PLAIN_TURN:
        return f"The bounding box volume reads {w.volume_ratio:.2f}x of the initial frame; the turn alone alters it."
    if abs(w.volume_ratio - 1) < 0.1:
        return f"The bounding box volume stays at {w.volume_ratio:.2f}x of the initial frame."
    verb = "shrinks" if w.volume_ratio < 1 else "grows"
    return f"The bounding box volume {verb} to {w.volume_ratio:.2f}x of the initial frame."


def _describe_swing(report: MotionReport, words: ViewerWords) -> str:
    o = report.oscillation
    if o is None and sum(c is not None for c in report.centroid) < min(FEWEST_KNOWN, report.frame_count):
        return "Whether the motion is periodic is not observable."
    if o is None:
        return "The motion is not periodic."
    return (
        f"The centroid swings with {o.reversals} reversals at {o.frequency_hz:.2f} Hz and an amplitude of "
        f"{o.amplitude:.2f} body lengths, first {words.where(o.direction)}."
    )


def _format_times(report: MotionReport, whole: WindowMotion) -> str:
    if report.onset_frame is None:
        return "Nothing moves visibly." if whole.displacement is not None else ""
    end = (
        f"comes to rest by frame {report.settle_frame}"
        if report.settle_frame is not None
        else (
            "is still moving at the end" if whole.displacement is not None else "is not seen to come to rest"
        )
    )
    return f"It starts to move at frame {report.onset_frame} and {end}."


def _summarise(w: WindowMotion, words: ViewerWords) -> str:
    """One window in a clause."""
    span = f"frames {w.first}-{w.last}"
    if w.displacement is None:
        return f"{span} not observable ({w.unobservable.get('displacement', 'unknown')})"
    size = float(np.linalg.norm(w.displacement))
    text = (
        f"{span} no net translation" if size < STILL else f"{span} {size:.2f} {words.where(w.displacement)}"
    )
    if w.rotation_degrees is not None and w.rotation_axis is not None and w.rotation_degrees >= SLIGHT_TURN:
        text += f", rotating {w.rotation_degrees:.0f} deg {words.turn(w.rotation_axis)}"
    if factors := _format_factors(w, words):
        text += f", shape {factors}"
    turned = (w.rotation_degrees or 0) >= PLAIN_TURN
    if w.volume_ratio is not None and abs(w.volume_ratio - 1) >= 0.1 and not turned:
        text += f", volume {w.volume_ratio:.2f}x"
    return text
