"""Small line plots as inline SVG: axes with units, readable ticks, shaded windows, gaps for missing data.

The script of the page moves a cursor through every plot of a clip as its video plays, and writes the values
at the cursor into the legend; without the script the plots are complete all the same.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from functools import cached_property

from physagent_jax.report.formats import format_fixed, format_number, format_power_of_ten
from physagent_jax.report.markup import Markup, div, join, span, tag

WIDTH, HEIGHT = 520, 232
RIGHT, TOP, BOTTOM = 12, 12, 40


@dataclasses.dataclass(frozen=True)
class Series:
    """One line.

    Attributes:
        name: For the legend.
        values: y values; None leaves a gap.
        color: Palette index, 0..3.
        dashed: Dashed instead of solid.
        xs: x values; None = 0, 1, 2, ...
        shape: "line", "step" (a value holds over the interval that ends at its x) or "points".
    """

    name: str
    values: Sequence[float | None]
    color: int = 0
    dashed: bool = False
    xs: Sequence[float] | None = None
    shape: str = "line"

    @property
    def points(self) -> list[tuple[float, float | None]]:
        """(x, y) pairs."""
        return list(zip(range(len(self.values)) if self.xs is None else self.xs, self.values))


@dataclasses.dataclass(frozen=True)
class Plot:
    """A plot over frames.

    Attributes:
        title: Above the plot.
        unit: Unit of the y axis, in words.
        last_frame: Right end of the x axis.
        series: What is drawn.
        bands: Shaded (first, last) windows in frames.
        level: A horizontal reference line (value, name).
        marks: Vertical marks: frame -> explanation.
        least_span: The y axis covers at least this much, so that noise does not fill the plot.
        clip: Which clip's videos the cursor follows.
    """

    title: str
    unit: str
    last_frame: int
    series: Sequence[Series]
    bands: Sequence[tuple[float, float]] = ()
    level: tuple[float, str] | None = None
    marks: Mapping[int, str] = dataclasses.field(default_factory=dict)
    least_span: float = 0.0
    clip: str = ""


_LARGEST = 1e300  # that an axis reaches
_SHORT = 1e-2, 1e5  # between these, the numbers at an axis have few digits


def choose_step(low: float, high: float, most: int = 7) -> float:
    """1, 2 or 5 times a power of ten, so that [low, high] holds at most ``most`` steps."""
    rough = (high - low) / most
    power = 10.0 ** math.floor(math.log10(rough))
    return next(m * power for m in (1, 2, 5, 10) if m * power >= rough * 0.999)


def place_ticks(low: float, high: float, step: float) -> list[float]:
    """The multiples of ``step`` within [low, high]."""
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [round(i * step, 12) for i in range(first, last + 1)]


def draw(plot: Plot) -> Markup:
    """A plot as a ``figure`` with its legend."""
    plot = _shorten_numbers(plot)
    frame = _Frame(*_choose_range(plot), max(1, plot.last_frame))
    picture = tag(
        "svg",
        _draw_bands(plot, frame),
        _draw_grid(frame),
        _draw_axes(frame),
        _draw_level(plot, frame),
        [_draw_mark(at, why, frame) for at, why in plot.marks.items()],
        [_draw_curve(series, frame) for series in plot.series],
        tag("line", class_="cursor", x1=frame.left, x2=frame.left, y1=TOP, y2=HEIGHT - BOTTOM),
        viewBox=f"0 0 {WIDTH} {HEIGHT}",
        role="img",
        aria_label=f"{plot.title}, {plot.unit}, over frames",
    )
    caption = tag("figcaption", tag("strong", plot.title), " ", span("unit", f"[{plot.unit}]"))
    return tag(
        "figure",
        caption,
        _make_legend(plot, frame.decimals + 1),
        picture,
        class_="plot",
        data_clip=plot.clip,
        data_last=plot.last_frame,
        data_left=frame.left,
        data_right=WIDTH - RIGHT,
        data_width=WIDTH,
    )


@dataclasses.dataclass(frozen=True)
class _Frame:
    low: float
    high: float
    last: int

    @cached_property
    def step(self) -> float:
        return choose_step(self.low, self.high)

    @cached_property
    def decimals(self) -> int:
        """Decimals that tell two ticks apart."""
        return max(0, -math.floor(math.log10(self.step) + 1e-9))

    @cached_property
    def left(self) -> int:
        """The left end of the axis: right of the widest label, in the larger type of narrow screens too."""
        labels = [format_fixed(t, self.decimals) for t in place_ticks(self.low, self.high, self.step)]
        return 14 + 10 * max((len(label) for label in labels), default=0)

    def x(self, value: float) -> float:
        return round(self.left + (WIDTH - self.left - RIGHT) * value / self.last, 1)

    def y(self, value: float) -> float:
        share = (value - self.low) / (self.high - self.low)
        return round(HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * share, 1)


def _choose_range(plot: Plot) -> tuple[float, float]:
    values = [y for series in plot.series for y in series.values if y is not None]
    if plot.level is not None:
        values.append(plot.level[0])
    low, high = (min(values), max(values)) if values else (0.0, 1.0)
    # Only a damaged record holds more; the difference of two such numbers would be infinite.
    low, high = max(low, -_LARGEST), min(high, _LARGEST)
    span_ = max(high - low, plot.least_span, 1e-9, 1e-6 * max(abs(low), abs(high)))
    # Quantities that are never negative (energies, time steps) keep their zero at the bottom.
    middle, half = (low + high) / 2, 0.54 * span_
    bottom, top = middle - half, middle + half
    return (0.0, max(top, span_)) if low >= 0 > bottom else (bottom, top)


def _shorten_numbers(plot: Plot) -> Plot:
    """The plot in a unit with a power of ten, if its numbers would need many digits otherwise."""
    largest = max(map(abs, _choose_range(plot)))
    power = math.floor(math.log10(largest))
    if _SHORT[0] <= largest < _SHORT[1]:
        return plot

    def scaled(value: float | None) -> float | None:
        return None if value is None else min(max(value, -_LARGEST), _LARGEST) * 10.0**-power

    return dataclasses.replace(
        plot,
        unit=f"{format_power_of_ten(power)} {plot.unit}",
        series=[dataclasses.replace(s, values=[scaled(y) for y in s.values]) for s in plot.series],
        level=plot.level and (plot.level[0] * 10.0**-power, plot.level[1]),
        least_span=plot.least_span * 10.0**-power,
    )


def _draw_grid(frame: _Frame) -> Markup:
    lines = [
        tag("line", x1=frame.left, x2=WIDTH - RIGHT, y1=frame.y(t), y2=frame.y(t))
        for t in place_ticks(frame.low, frame.high, frame.step)
    ]
    return tag("g", *lines, class_="grid")


def _draw_axes(frame: _Frame) -> Markup:
    vertical = [
        tag("text", format_fixed(t, frame.decimals), x=frame.left - 7, y=frame.y(t) + 4, text_anchor="end")
        for t in place_ticks(frame.low, frame.high, frame.step)
    ]
    horizontal = [
        tag("text", format_fixed(t, 0), x=frame.x(t), y=HEIGHT - BOTTOM + 17, text_anchor="middle")
        for t in place_ticks(0, frame.last, max(1.0, choose_step(0, frame.last, 10)))
    ]
    name = tag("text", "frame", x=(frame.left + WIDTH - RIGHT) / 2, y=HEIGHT - 5, text_anchor="middle")
    base = tag("line", x1=frame.left, x2=WIDTH - RIGHT, y1=HEIGHT - BOTTOM, y2=HEIGHT - BOTTOM, class_="axis")
    return tag("g", base, *vertical, *horizontal, name, class_="ticks")


def _draw_bands(plot: Plot, frame: _Frame) -> Markup:
    shapes = []
    for first, last in plot.bands:
        left, right = frame.x(max(0, first)), frame.x(min(frame.last, last))
        if right > left:
            shapes.append(
                tag("rect", x=left, y=TOP, width=round(right - left, 1), height=HEIGHT - TOP - BOTTOM)
            )
    return tag("g", *shapes, class_="bands")


def _draw_level(plot: Plot, frame: _Frame) -> Markup | None:
    if plot.level is None:
        return None
    y = frame.y(plot.level[0])
    return tag("line", class_="level", x1=frame.left, x2=WIDTH - RIGHT, y1=y, y2=y)


def _draw_mark(at: int, why: str, frame: _Frame) -> Markup:
    x = frame.x(at)
    return tag(
        "g",
        tag("title", f"frame {at}: {why}"),
        tag("line", x1=x, x2=x, y1=TOP, y2=HEIGHT - BOTTOM),
        tag("path", d=f"M{x - 4} {TOP}h8l-4 7z"),
        class_="mark",
    )


def _draw_curve(series: Series, frame: _Frame) -> Markup:
    name = f"c{series.color}"
    if series.shape == "points":
        dots = [tag("circle", cx=frame.x(x), cy=frame.y(y), r=4) for x, y in series.points if y is not None]
        return tag("g", *dots, class_=f"dots {name}")
    commands, pen_down = [], False
    for x, y in series.points:
        if y is None:
            pen_down = False
            continue
        if series.shape == "step":
            commands.append(f"{'L' if pen_down else 'M'}{frame.x(x - 1)} {frame.y(y)}H{frame.x(x)}")
        else:
            commands.append(f"{'L' if pen_down else 'M'}{frame.x(x)} {frame.y(y)}")
        pen_down = True
    return tag("path", d="".join(commands), class_=f"curve {name}{' dashed' if series.dashed else ''}")


def _make_legend(plot: Plot, decimals: int) -> Markup:
    entries = []
    for _, twins in itertools.groupby(plot.series, key=lambda series: series.color):
        # What is seen and what is true stay together when the legend wraps.
        entries.append(
            span("pair", *[_make_legend_entry(series, plot.last_frame, decimals) for series in twins])
        )
    if plot.level is not None:
        entries.append(span("key", span("swatch level"), f"{plot.level[1]} {format_number(plot.level[0])}"))
    if plot.bands:
        entries.append(span("key", span("swatch band"), "force active"))
    if plot.marks:
        entries.append(span("key", span("swatch mark"), "frame redone"))
    return div("legend", join(entries))


def _make_legend_entry(series: Series, last: int, decimals: int) -> Markup:
    style = "dot" if series.shape == "points" else "dashed" if series.dashed else "line"
    values = None
    if series.shape != "points":
        at = {x: y for x, y in series.points if y is not None}
        values = ";".join(format_fixed(at[x], decimals) if x in at else "" for x in range(last + 1))
    return span(
        "key",
        span(f"swatch {style} c{series.color}"),
        series.name,
        tag("output", data_values=values) if values else None,
    )
