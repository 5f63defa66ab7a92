"""Perception against the particles' own motion: a check for people, never seen by an agent."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from physagent_jax.metrics.motion import ALIGNED_DEGREES, TrueMotion
from physagent_jax.perception.schema import MotionReport
from physagent_jax.report.formats import UNKNOWN, format_fixed
from physagent_jax.report.layout import make_table
from physagent_jax.report.markup import Markup, div, tag

NOTE = "The truth is for your eyes only; no agent saw it. Agents judge by the pictures alone."
DECIMALS = 3


def make_truth_table(report: MotionReport, truth: TrueMotion) -> Markup:
    """The table of perceived and true motion, at the end of the clip and over it."""
    head = ["measure", "perceived", "true", "difference", "unit"]
    rows = make_table(head, _list_rows(report, truth), numeric=(1, 2, 3))
    return div("truth", tag("p", NOTE, class_="truth-note"), rows)


def measure_centroid_error(report: MotionReport, truth: TrueMotion) -> tuple[float, float] | None:
    """Root mean square and largest distance of the two centres over the clip [body lengths]."""
    pairs = zip(report.centroid, truth.centroid)
    distances = [math.dist(seen, true) for seen, true in pairs if seen is not None]
    if not distances:
        return None
    return math.sqrt(sum(d * d for d in distances) / len(distances)), max(distances)


def _list_rows(report: MotionReport, truth: TrueMotion) -> Iterator[list[str]]:
    last = min(len(report.centroid), len(truth.centroid)) - 1
    yield _make_row("Longest extent in frame 0", report.object_size, truth.object_size, "m")
    if last < 0:
        return
    end = report.centroid[last]
    for axis, name in enumerate("xyz"):
        seen = None if end is None else end[axis]
        title = f"Displacement along {name} in frame {last}"
        yield _make_row(title, seen, truth.centroid[last][axis], "body lengths")
    farthest = _find_farthest(report.centroid), _find_farthest(truth.centroid)
    yield _make_row("Farthest from the start", *farthest, "body lengths")
    rotation = _get_at(report.rotation_degrees, last), _get_at(truth.rotation_degrees, last)
    yield _make_row(f"Rotation in frame {last}", *rotation, "degrees")
    volume = _get_at(report.volume_ratio, last), _get_at(truth.volume_ratio, last)
    yield _make_row(f"Volume in frame {last}", *volume, "of frame 0")
    yield from _list_stretch_rows(report, truth)
    error = measure_centroid_error(report, truth)
    if error is not None:
        mean, largest = error
        yield ["Distance between the two centres, RMS", "", "", format_fixed(mean, DECIMALS), "body lengths"]
        yield [
            "Distance between the two centres, largest",
            "",
            "",
            format_fixed(largest, DECIMALS),
            "body lengths",
        ]
    yield from _list_stated_rows(report)


def _list_stated_rows(report: MotionReport) -> Iterator[list[str]]:
    """The rows of perception's stated uncertainty: the differences above should be smaller in nine of ten runs."""
    stated = report.uncertainty
    for name, value, unit in (
        ("displacement", stated.displacement, "body lengths"),
        ("displacement along the line of sight", stated.along, "body lengths"),
        ("rotation", stated.rotation, "degrees"),
        ("stretch across the view", stated.stretch, "of frame 0"),
    ):
        if value is not None:
            yield [f"Half width stated by perception: {name}", "", "", format_fixed(value, DECIMALS), unit]


def _list_stretch_rows(report: MotionReport, truth: TrueMotion) -> Iterator[list[str]]:
    """Stretch over the longest window that begins at frame 0, along the world axes.

    Perception's tensor describes the object before its turn, the true extents after it: past `ALIGNED_DEGREES` the
    two are not the same quantity, and no difference is given.
    """
    whole = max((w for w in report.windows if w.first == 0), key=lambda w: w.last, default=None)
    if whole is None or whole.last >= len(truth.stretch):
        return
    aligned = (whole.rotation_degrees or 0.0) <= ALIGNED_DEGREES
    for axis, name in enumerate("xyz"):
        seen = None if whole.stretch is None else whole.stretch[axis][axis]
        row = _make_row(
            f"Stretch along {name} in frame {whole.last}", seen, truth.stretch[whole.last][axis], "of frame 0"
        )
        if seen is not None and not aligned:
            row[3] = "not comparable after a turn"
        yield row


def _make_row(name: str, seen: float | None, true: float | None, unit: str) -> list[str]:
    if seen is None or true is None:
        shown = "not observable" if seen is None else format_fixed(seen, DECIMALS)
        return [name, shown, format_fixed(true, DECIMALS), UNKNOWN, unit]
    return [name, format_fixed(seen, DECIMALS), format_fixed(true, DECIMALS), _sign(seen - true), unit]


def _sign(value: float) -> str:
    text = format_fixed(value, DECIMALS)
    return text if value <= 0 or float(text) == 0 else f"+{text}"


def _get_at(values: Sequence[float | None], index: int) -> float | None:
    return values[index] if index < len(values) else None


def _find_farthest(path: Sequence[Sequence[float] | None]) -> float | None:
    return max((math.hypot(*point) for point in path if point is not None), default=None)
