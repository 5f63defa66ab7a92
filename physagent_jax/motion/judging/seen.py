"""The planner's view: the report's motion as courses of frames, from its series or else its windows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion import tolerances
from physagent_jax.motion.matching import share_time
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, ObstacleRequest, SceneBrief
from physagent_jax.motion.tolerances import Tolerance
from physagent_jax.motion.vectors import (
    add,
    clamp,
    cosine,
    cross,
    dot,
    norm,
    normalise,
    reject,
    rotate,
    scale,
    subtract,
)
from physagent_jax.perception.schema import Matrix, MotionReport, PartMotion, Uncertainty, WindowMotion

Course = list[tuple[int, Vector]]
"""Frames with a vector each, relative to the first."""
Signal = list[tuple[int, float]]
"""Frames with a number each."""

# from the half width of an interval that holds the truth in nine of ten clips to a standard deviation
TO_SIGMA = 1 / 1.645
_UNKNOWN = Uncertainty(displacement=0.04, along=0.2, rotation=8.0, axis=12.0, stretch=0.08, frequency=0.2)
ALONG_END = 0.65  # cosine: the end nearest to a direction that lies between two of them is taken
SAME_LINE = 0.97  # cosine
_TURNS = 20.0  # [degrees] from which on a limb is seen to turn
_ON_ITS_SIDE = 0.12  # [1] of its height, by which its outline changes as it turns over
_BACK = 0.75  # of that, below which it is as it was
_IN_THE_AIR = 0.35  # of how far its centre rises, above which it is in the air
_TOPPLES = 0.5  # sine of an axis to the vertical
_LANDED = 0.1  # of its way down that may be left when it has landed
_ZERO = (0.0, 0.0, 0.0)

Value = TypeVar("Value")
Result = TypeVar("Result")


@dataclass(frozen=True)
class View:
    """The measured motion as the checks use it.

    Attributes:
        report, brief, expectations: What was seen, where, and what was asked.
        force_field: Names what to change, and whether the object was let fall from above; else no yardstick.
        gravity: Whether things that are let go fall.
        obstacles: What the sentence puts in the way.
        sentence: The sentence itself, for what it rules out.
        keeps_dents: Whether it is said to be of matter that keeps the shape which a blow gives it.
        ending: What was seen of the frames after the planned ones, from the last of those on; None = nothing.
        soft: Whether it is said to be of soft matter, which is pressed together where it lands.
    """

    report: MotionReport
    brief: SceneBrief
    expectations: tuple[ExpectedMotion, ...]
    force_field: ForceField
    gravity: bool = False
    obstacles: tuple[ObstacleRequest, ...] = ()
    sentence: str = ""
    keeps_dents: bool = False
    ending: MotionReport | None = None
    soft: bool = False

    @property
    def anchored(self) -> bool:
        """Return whether the object is held."""
        return self.brief.anchored is not None

    @property
    def last(self) -> int:
        """The clip's last frame."""
        return self.report.frame_count - 1

    @property
    def grounded(self) -> bool:
        """Return whether the object stands on something."""
        return self.brief.world == "ground"

    @property
    def visible(self) -> float:
        """Smallest displacement that is not noise [body lengths]."""
        return clamp(1.5 * self.uncertainty("displacement"), tolerances.VISIBLE, 0.08)

    @property
    def visible_axes(self) -> list[Vector]:
        """Those of the viewer's three axes along which a stretch can be seen."""
        table = self.brief.directions
        return [axis for axis in (table.right, table.up, table.toward) if not self.hides(axis)]

    def span(self, expectation: ExpectedMotion) -> tuple[int, int]:
        """First and last frame in which a motion should be seen."""
        return tolerances.round_window(expectation, self.report.frame_count)

    def seconds(self, first: int, last: int) -> float:
        """Duration of frames first..last [s]."""
        return (last - first) * self.report.frame_dt

    def uncertainty(self, name: str) -> float:
        """Half width of the report's interval for a figure; a cautious one where the report says none."""
        told = getattr(self.report.uncertainty, name)
        return getattr(_UNKNOWN, name) if told is None else told

    def sigma(self, name: str) -> float:
        """Standard deviation of a figure."""
        return max(self.uncertainty(name) * TO_SIGMA, 1e-9)

    @property
    def motionless(self) -> bool:
        """Return whether nothing is seen to move, turn or deform in the whole clip, beyond what is noise."""
        course, turns = self.course(0, self.last), self.turns(0, self.last)
        moved = [norm(p) for _, p in course]
        for end in self.report.parts:
            moved += [norm(p) / 1.5 for _, p in self.course(0, self.last, end)]
            if end.limb is not None and self.turns_limb(end, 0, self.last):
                return False
        lost = any(end.limb is not None and None in end.centroid for end in self.report.parts)
        if not course or lost or max(moved) >= self.visible or not self.shows_approach(0, self.last):
            return False
        if max((norm(v) for _, v in turns), default=0.0) >= max(
            tolerances.VISIBLE_DEGREES, self.uncertainty("rotation")
        ):
            return False
        strains = [abs(v) for axis in self.visible_axes for _, v in self.strains(axis, 0, self.last)]
        return max(strains, default=0.0) < max(tolerances.VISIBLE_STRAIN, self.uncertainty("stretch"))

    def turns_limb(self, limb: PartMotion, first: int, last: int) -> bool:
        """Return whether a limb is seen to turn in some frames."""
        turns = [norm(v) for _, v in self.turns(first, last, limb)]
        return max(turns, default=0.0) >= max(_TURNS, 2.0 * self.sigma("rotation"))

    def topples(self, turn: ExpectedMotion) -> bool:
        """Return whether a turn tips over what stands: it ends in a fall, and is about no upright axis."""
        if not self.grounded or self.anchored or self.force_field.default_drop:
            return False
        if turn.kind is not MotionKind.ROTATE or turn.part is not None or turn.limb is not None:
            return False
        level = turn.direction is None or norm(cross(turn.direction, self.brief.directions.up)) > _TOPPLES
        if self.is_aloft(turn):
            return False
        return level and any(e.kind is MotionKind.FALL and share_time(e, turn) for e in self.expectations)

    def is_aloft(self, turn: ExpectedMotion) -> bool:
        """Return whether a turn is that of what leaps or is thrown up as it begins: it comes down as it stood."""
        up = self.brief.directions.up
        leaps = [e for e in self.expectations if e.kind is MotionKind.MOVE and e.sudden and e.direction]
        rises = (e for e in leaps if not e.part and cosine(e.direction or up, up) > _TOPPLES)
        return turn.kind is MotionKind.ROTATE and any(e.window[0] == turn.window[0] for e in rises)

    def count_half_turns(self) -> int:
        """Half turns of what turns over in the air: how often its outline changes its height there and has it again.

        So fast a turn loses the points by which others are measured. They have to show that it begins to turn; and what
        lands may be squashed and spring back, which is no turn.
        """
        turned = max((norm(v) for _, v in self.turns(0, self.last)), default=0.0)
        if turned < _TURNS:
            return 0
        up = self.brief.directions.up
        heights = {t: dot(p, up) for t, p in self.course(0, self.last)}
        least = _IN_THE_AIR * max(heights.values(), default=0.0)
        changes = self.lengths(up, 0, self.last)
        aloft = [change for t, change in changes if heights.get(t, 0.0) > least]
        ends = [change for _, change in changes[-1:]]  # the last turn is done as it lands
        return count_excursions([*aloft, *ends], _ON_ITS_SIDE)

    def find_topples(self) -> list[Vector]:
        """Ways that the top of what stands goes as it tips over."""
        topples, up = [e for e in self.expectations if self.topples(e)], self.brief.directions.up
        ways = [cross(e.direction, up) for e in topples if e.direction]
        for each in (e for e in topples if e.direction is None):  # no way is told: where it went from then on
            course = self.course(self.span(each)[0], self.last)
            gone = subtract(course[-1][1], course[0][1]) if course else up
            ways += [way] if (way := normalise(reject(gone, up))) else []
        return [normalise(way) or way for way in ways]

    def fit_to_limb(self, tolerance: Tolerance, motion: ExpectedMotion) -> Tolerance:
        """A way's tolerance in lengths of the limb that is asked about; unchanged where none is.

        What is followed is the middle of it, which goes half as far as its tip.
        """
        if motion.limb is None:
            return tolerance
        return tolerance.scaled(norm(self.brief.parts[motion.limb].arm), least=0.75 * tolerances.VISIBLE)

    def find_end(self, direction: Vector) -> PartMotion | None:
        """The end towards a direction; None if the report tells no ends apart."""
        whole = [p for p in self.report.parts if p.limb is None]
        ends = [p for p in whole if cosine(p.direction, direction) >= ALONG_END]
        return max(ends, key=lambda p: cosine(p.direction, direction), default=None)

    def window(self, first: int, last: int) -> WindowMotion | None:
        """The report's window of these frames, or the shortest that holds them from the same frame on."""
        fitting = [w for w in self.report.windows if w.first == first and w.last >= last]
        return min(fitting, key=lambda w: w.last, default=None)

    def explain(self, figure: str, first: int, last: int, otherwise: str) -> str:
        """The reason that a figure is not known in these frames."""
        window = self.window(first, last)
        return window.unobservable.get(figure, otherwise) if window else otherwise

    def course(self, first: int, last: int, end: PartMotion | None = None) -> Course:
        """Displacements from frame ``first`` on; empty if that frame or all others are not observable.

        Across the line of sight alone, where what happens along it is not observable.
        """
        course, sight = _compare(self.get_places(end), first, last, subtract), self.sight
        if sight is None or (end is None and self.shows_approach(first, last)):
            return course
        return [(t, reject(p, sight)) for t, p in course]

    @property
    def sight(self) -> Vector | None:
        """The line of sight, if what lies along it is not measured; None if depth is."""
        return self.report.unmeasured_direction

    def shows_approach(self, first: int, last: int) -> bool:
        """Return whether the whole's displacement along the line of sight is observable in these frames."""
        window = self.window(first, last) or self.report.windows[0]
        return window.displacement_view_axis_observable

    def get_places(self, end: PartMotion | None) -> tuple[Vector | None, ...]:
        """Places of an end, or of the whole, frame by frame."""
        return self.report.centroid if end is None else end.centroid

    def speed_before(self, first: int, end: PartMotion | None = None) -> Vector:
        """Velocity when a window begins [body lengths per frame]; zero if not observable."""
        before, places = max(first - 3, 0), self.get_places(end)
        here, there = places[first], places[before]
        if here is None or there is None or before == first:
            return _ZERO
        return scale(subtract(here, there), 1.0 / (first - before))

    def turns(self, first: int, last: int, end: PartMotion | None = None) -> Course:
        """Rotation vectors from frame ``first`` on [deg]; without a series, the window's alone."""
        series = self.report.rotation if end is None else end.rotation
        if series:
            return self._keep_in_plane(_compare(series, first, last, measure_turn))
        window = self.window(first, last)
        if end is not None or window is None or window.rotation_degrees is None:
            return []
        turn = scale(window.rotation_axis or _ZERO, window.rotation_degrees)
        return self._keep_in_plane([(window.first, _ZERO), (window.last, turn)])

    def _keep_in_plane(self, turns: Course) -> Course:
        """The parts of turns that are in the picture plane, where those out of it are not observable."""
        sight = self.sight
        return turns if sight is None else [(t, scale(sight, dot(v, sight))) for t, v in turns]

    def strains(self, direction: Vector, first: int, last: int, end: PartMotion | None = None) -> Signal:
        """Relative change of the length that lies along a direction in frame ``first``, frame by frame.

        Of the whole, or of an end or a part of it.
        """
        report = self.report if end is None else end
        if report.stretch:
            turned = report.rotation[first] if report.rotation else None
            body = direction if turned is None else rotate(direction, scale(turned, -1.0))

            def compare(tensor: Matrix, start: Matrix) -> float:
                return _project(tensor, body) / max(_project(start, body), 1e-6) - 1.0

            return _compare(report.stretch, first, last, compare)
        window = None if end else self.window(first, last)
        if window is None or window.stretch is None:
            return []
        return [(window.first, 0.0), (window.last, _project(window.stretch, direction) - 1.0)]

    def outline(
        self, direction: Vector, first: int, last: int, end: PartMotion | None = None
    ) -> list[tuple[int, float, float]]:
        """Relative change of the outline's length along a direction since frame ``first``, with its half width.

        Of the whole, or of an end of it. Empty where the direction is none of the report's, or not seen in that
        frame or in any other.
        """
        along = (e for e in (end or self.report).extents if abs(cosine(e.direction, direction)) > SAME_LINE)
        extent = next(along, None)
        start = extent and extent.ratio[first]
        if not extent or not start:
            return []
        points = [(t, extent.ratio[t], extent.half_width[t]) for t in range(first, last + 1)]
        found = [(t, v / start - 1.0, w / start) for t, v, w in points if v is not None and w is not None]
        return found if len(found) > 1 else []

    def lengths(self, direction: Vector, first: int, last: int) -> Signal:
        """The same of the whole in all frames in which it is seen, however well its length is known in them."""
        along = (e.ratio for e in self.report.extents if abs(cosine(e.direction, direction)) > SAME_LINE)
        return _compare(next(along, (None,)), first, last, lambda value, start: value / start - 1.0)

    def hides(self, direction: Vector) -> bool:
        """Return whether a stretch along a direction cannot be seen, because it is along the line of sight."""
        shown = any(w.stretch_view_axis_observable for w in self.report.windows)
        return not shown and abs(dot(direction, self.brief.directions.toward)) > 0.7

    def volumes(self, first: int, last: int) -> Signal:
        """Volume ratios of the box, frame by frame, relative to ``first``."""
        ratios = self.report.volume_ratio
        return _compare(ratios, first, last, lambda value, start: value / start) if ratios[first] else []


def count_excursions(values: Iterable[float], least: float) -> int:
    """Count how often values leave zero by ``least`` and more, and come back."""
    count, away = 0, False
    for value in map(abs, values):
        count += away and value < _BACK * least
        away = value >= (_BACK if away else 1.0) * least
    return count


def has_gravity(
    told: str | None, brief: SceneBrief, expectations: Sequence[ExpectedMotion], field: ForceField
) -> bool:
    """Return whether what is let go falls: a fact about the world, from the sentence (``told``) or the scene."""
    if told is not None:
        return told == "down"
    falls = any(e.kind is MotionKind.FALL for e in expectations)
    return brief.world == "ground" or falls or field.default_drop


def find_farthest(course: Course) -> tuple[int, Vector]:
    """The frame and place farthest from the start, in whatever direction."""
    return max(course, key=lambda point: norm(point[1]))


def find_landing(course: Course, down: Vector) -> int:
    """The frame in which what falls has come down; it may topple from then on, and roll."""
    lowest = max(dot(p, down) for _, p in course)
    highest = min(dot(p, down) for _, p in course)
    return next(t for t, p in course if dot(p, down) >= lowest - _LANDED * (lowest - highest))


def find_first_response(course: Course, threshold: float) -> tuple[int, Vector] | None:
    """The first place beyond ``threshold``; None if it never gets there."""
    return next(((t, p) for t, p in course if norm(p) > threshold), None)


def _compare(
    series: Sequence[Value | None], first: int, last: int, compare: Callable[[Value, Value], Result]
) -> list[tuple[int, Result]]:
    """Every known value compared with that of frame ``first``; empty without that, or without another."""
    start = series[first] if first < len(series) else None
    if start is None:
        return []
    points = [(t, compare(v, start)) for t in range(first, last + 1) if (v := series[t]) is not None]
    return points if len(points) > 1 else []


def _project(tensor: Matrix, direction: Vector) -> float:
    """n.S.n."""
    return dot((dot(tensor[0], direction), dot(tensor[1], direction), dot(tensor[2], direction)), direction)


def measure_turn(end: Vector, start: Vector) -> Vector:
    """The rotation vector to one orientation from another, both from frame 0 [deg], with whole turns kept."""
    if norm(start) < 1e-9:
        return end
    w, x = _to_quaternion(end)
    v, y = _to_quaternion(scale(start, -1.0))
    real = w * v - dot(x, y)
    vector = add([scale(y, w), scale(x, v), cross(x, y)])
    difference, axis = subtract(end, start), normalise(vector)
    if axis is None:
        return difference
    angle = math.degrees(2.0 * math.atan2(norm(vector), real))
    turns = round((dot(difference, axis) - angle) / 360.0)
    return scale(axis, angle + 360.0 * turns)


def _to_quaternion(turn: Vector) -> tuple[float, Vector]:
    half = math.radians(norm(turn)) / 2.0
    return math.cos(half), scale(normalise(turn) or _ZERO, math.sin(half))
