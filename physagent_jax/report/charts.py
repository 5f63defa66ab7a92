"""The curves of the report: the seen and the true motion, and the simulator's own figures."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.motion import TrueMotion
from physagent_jax.perception.schema import MotionReport
from physagent_jax.report.directions import label_world_axes, make_direction_table
from physagent_jax.report.formats import find_prefix
from physagent_jax.report.markup import Markup, div
from physagent_jax.report.plot import Plot, Series, draw
from physagent_jax.run.finished import FinishedRound
from physagent_jax.scene.config import SceneConfig
from physagent_jax.simulation.record import SimulationRecord

AXIS_NAMES = ("x", "y", "z")


def draw_motion_charts(round_: FinishedRound) -> Markup | None:
    """Displacement, rotation, volume and stretch: perceived (solid) against true (dashed)."""
    report = round_.motion
    truth = round_.simulation.truth if round_.simulation else None
    if report is None and truth is None:
        return None
    plots = [
        _plot_displacement(report, truth, round_.scene),
        _plot_rotation(report, truth),
        _plot_volume(report, truth),
        _plot_stretch(report, truth),
    ]
    return _arrange_plots(plots, round_)


def draw_physics_charts(round_: FinishedRound) -> Markup | None:
    """Energy, momentum, substep and volume change of the particles."""
    record = round_.simulation
    if record is None:
        return None
    plots = [
        _plot_energy(record),
        _plot_momentum(record),
        _plot_angular_momentum(record),
        _plot_substep(record),
        _plot_det_f(record),
    ]
    return _arrange_plots([*plots, *_plot_ledger(record)], round_)


_NOTICEABLE = 1e-4  # share of the largest flow of energy below which a curve would only be round-off


def find_active_windows(force_field: ForceField | None, last_frame: int) -> list[tuple[float, float]]:
    """Find the frames in which forces act; overlapping windows are merged."""
    if force_field is None:
        return []
    timed = (*force_field.actions, *force_field.constraints)
    spans = sorted(item.active_time or (0.0, float(last_frame)) for item in timed)
    merged: list[tuple[float, float]] = []
    for first, last in spans:
        if merged and first <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(last, merged[-1][1]))
        else:
            merged.append((first, last))
    return merged


def _arrange_plots(plots: Sequence[tuple[str, str, list[Series], dict]], round_: FinishedRound) -> Markup:
    last = max((len(s.values) - 1 for _, _, series, _ in plots for s in series if s.xs is None), default=0)
    bands = find_active_windows(round_.force_field, last)
    figures = [
        draw(Plot(title, unit, last, series, bands=bands, clip=round_.clip, **options))
        for title, unit, series, options in plots
        if series
    ]
    return div("plots", *figures)


def _make_series(seen, true, color: int, name: str = "") -> list[Series]:
    series = []
    if seen is not None:
        series.append(Series(name or "perceived", seen, color))
    if true is not None:
        # Beside its perceived twin a bare "true" says enough, and keeps the legend short.
        series.append(Series("true" if series else f"{name} true".strip(), true, color, dashed=True))
    return series


def _take_axis(rows: Sequence[Sequence[float] | None], axis: int) -> list[float | None]:
    return [None if row is None else row[axis] for row in rows]


def _plot_displacement(report: MotionReport | None, truth: TrueMotion | None, scene: SceneConfig | None):
    labels = label_world_axes(make_direction_table(scene.camera)) if scene else AXIS_NAMES
    series = []
    for axis, label in enumerate(labels):
        seen = _take_axis(report.centroid, axis) if report else None
        true = _take_axis(truth.centroid, axis) if truth else None
        series += _make_series(seen, true, axis, label)
    return "Displacement of the centre", "body lengths", series, {"least_span": 0.05}


def _plot_rotation(report: MotionReport | None, truth: TrueMotion | None):
    series = _make_series(
        report.rotation_degrees if report else None, truth.rotation_degrees if truth else None, 2
    )
    return "Rotation", "degrees", series, {"least_span": 5.0}


def _plot_volume(report: MotionReport | None, truth: TrueMotion | None):
    series = _make_series(report.volume_ratio if report else None, truth.volume_ratio if truth else None, 1)
    return "Bounding-box volume", "ratio to frame 0", series, {"least_span": 0.1}


def _plot_stretch(report: MotionReport | None, truth: TrueMotion | None):
    series = []
    # Perception fits a stretch per window; those that begin at frame 0 compare with the true curve.
    from_start = [(w.last, w.stretch) for w in report.windows if w.first == 0 and w.stretch] if report else []
    ends = [last for last, _ in from_start]
    for axis, name in enumerate(AXIS_NAMES):
        if from_start:
            seen = [stretch[axis][axis] for _, stretch in from_start]
            series.append(Series(name, seen, axis, xs=ends, shape="points"))
        if truth:
            label = "true" if from_start else f"{name} true"
            series.append(Series(label, _take_axis(truth.stretch, axis), axis, dashed=True))
    return "Stretch along the world axes", "ratio to frame 0", series, {"least_span": 0.1}


def _plot_energy(record: SimulationRecord):
    gravitational = record.gravitational_energy if any(record.gravitational_energy) else ()
    factor, letter = find_prefix(_find_largest(record.kinetic_energy, record.elastic_energy, gravitational))
    series = [
        Series("kinetic", [e * factor for e in record.kinetic_energy], 0),
        Series("elastic", [e * factor for e in record.elastic_energy], 2),
    ]
    if gravitational:
        series.append(Series("gravitational", [e * factor for e in gravitational], 1))
    return "Energy", f"{letter}J", series, {}


def _find_largest(*columns: Sequence[float]) -> float:
    return max((abs(value) for column in columns for value in column), default=0.0)


def _plot_momentum(record: SimulationRecord):
    series = [Series(name, _take_axis(record.momentum, axis), axis) for axis, name in enumerate(AXIS_NAMES)]
    return "Momentum", "kg m/s", series, {}


def _plot_angular_momentum(record: SimulationRecord):
    series = [
        Series(name, _take_axis(record.angular_momentum, axis), axis)
        for axis, name in enumerate(AXIS_NAMES)
        if record.angular_momentum
    ]
    return "Angular momentum about the first mass centre", "kg m\u00b2/s", series, {}


def _plot_ledger(record: SimulationRecord):
    """Plot the exchange of energy and momentum; nothing if it was not recorded."""
    ledger = record.ledger
    if ledger is None:
        return []
    flows = {
        "work of forces": ledger.force_work,
        "work of walls and grips": ledger.boundary_work,
        "plastic dissipation": ledger.plastic_dissipation,
        "viscous dissipation": ledger.viscous_dissipation,
        "numerical loss": ledger.numerical_loss,
    }
    largest = _find_largest(*flows.values())
    flows = {name: values for name, values in flows.items() if _find_largest(values) > _NOTICEABLE * largest}
    factor, letter = find_prefix(largest)
    energy = [
        Series(name, [e * factor for e in values], color)
        for color, (name, values) in enumerate(flows.items())
    ]
    impulse = [
        Series(f"{who} {name}", _take_axis(rows, axis), axis, dashed=who == "walls")
        for who, rows in (("forces", ledger.force_impulse), ("walls", ledger.boundary_impulse))
        for axis, name in enumerate(AXIS_NAMES)
        if any(row[axis] for row in rows)
    ]
    return [
        ("Energy put in and taken out since frame 0", f"{letter}J", energy, {}),
        ("Impulse since frame 0", "N s", impulse, {}),
    ]


def _plot_substep(record: SimulationRecord):
    bound = record.stable_dt
    factor, letter = find_prefix(max((bound or 0.0, *record.substep_dt)))
    # The k-th interval leads to frame k + 1.
    ends = [k + 1 for k in range(len(record.substep_dt))]
    series = [Series("substep", [dt * factor for dt in record.substep_dt], 0, xs=ends, shape="step")]
    level = None if bound is None else (bound * factor, "bound at the start")
    options = {"level": level, "marks": record.redone_frames}
    return "Time step", f"{letter}s", series, options


def _plot_det_f(record: SimulationRecord):
    series = [
        Series("largest", record.max_volume_ratio, 0),
        Series("smallest", record.min_volume_ratio, 2),
    ]
    return (
        "Volume of particles",
        "ratio",
        series,
        {"level": (1.0, "unchanged"), "least_span": 0.1},
    )
