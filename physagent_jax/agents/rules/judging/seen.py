"""The planner's view: the report's motion as courses of frames, from its series or else its windows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from physagent_jax.agents.matching import agrees, find_causes, share_time
from physagent_jax.agents.rules import tolerances
from physagent_jax.agents.schema import ExpectedMotion, MotionKind, ObstacleRequest, SceneBrief
from physagent_jax.agents.vectors import add, clamp, cosine, cross, dot, norm, normalise, scale
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import ForceField
from physagent_jax.perception.schema import Matrix, MotionReport, PartMotion, Uncertainty, WindowMotion

Course = list[tuple[int, Vector]]
"""Frames with a vector each, relative to the first."""

TO_SIGMA = (
    1 / 1.645
)  # half width of an interval that holds the truth in nine of ten clips -> standard deviation
_UNKNOWN = Uncertainty(displacement=0.04, rotation=8.0, axis=12.0, stretch=0.08, frequency=0.2)
_ALONG_END = 0.65  # cosine: the end nearest to a direction that lies between two of them is taken
_IN_THE_WAY = 0.7  # cosine
_SAME_LINE = 0.97  # cosine
_BOTH = 0.5  # cosine: directions more than 60 degrees apart can be told apart


@dataclass(frozen=True)
class View:
    """The measured motion as the checks use it.

    Attributes:
        report, brief, expectations: What was seen, where, and what was asked.
        force_field: Names what to change, and whether the object was let fall from above; else no yardstick.
        gravity: Whether things that are let go fall.
        obstacles: What the sentence puts in the way.
    """

    report: MotionReport
    brief: SceneBrief
    expectations: tuple[ExpectedMotion, ...]
    force_field: ForceField
    gravity: bool = False
    obstacles: tuple[ObstacleRequest, ...] = ()

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

    def span(self, expectation: ExpectedMotion) -> tuple[int, int]:
        """First and last frame in which the motion should be seen."""
        return tolerances.round_window(expectation, self.report.frame_count)

    def until(self, expectation: ExpectedMotion) -> int:
        """The end of a motion's visible consequences: the next motion's beginning, or the clip's end."""
        first, last = self.span(expectation)
        begins = [self.span(e)[0] for e in self.expectations if e.window[0] > expectation.window[0] + 0.5]
        later = [begin for begin in begins if begin >= last - 1]
        between = [begin for begin in begins if begin > first]
        return max(last, min(later)) if later else last if between else self.last

    def find_obstacle(self, expectation: ExpectedMotion) -> ObstacleRequest | None:
        """Find the obstacle that the sentence puts in this motion's way."""
        way = expectation.direction
        return next(
            (each for each in self.obstacles if way and cosine(each.direction, way) > _IN_THE_WAY), None
        )

    def seconds(self, first: int, last: int) -> float:
        """Duration of frames first..last [s]."""
        return (last - first) * self.report.frame_dt

    def together(self, expectation: ExpectedMotion) -> list[ExpectedMotion]:
        """The motions that are asked for at the same time."""
        return [e for e in self.expectations if e is not expectation and share_time(e, expectation)]

    def find_topples(self) -> list[Vector]:
        """Ways that the top of what stands goes as it tips over: a turn about a level axis whose end is a fall."""
        up = self.brief.directions.up
        if not self.grounded or self.anchored or self.force_field.default_drop:
            return []
        falls = [e for e in self.expectations if e.kind is MotionKind.FALL]
        ways = [
            cross(e.direction, up)
            for e in self.expectations
            if e.kind is MotionKind.ROTATE
            and e.direction is not None
            and any(share_time(e, f) for f in falls)
        ]
        return [normalise(way) or way for way in ways if norm(way) > _BOTH]

    def uncertainty(self, name: str) -> float:
        """Half width of the report's interval for a figure; a cautious one where the report says none."""
        told = getattr(self.report.uncertainty, name)
        return getattr(_UNKNOWN, name) if told is None else told

    def sigma(self, name: str) -> float:
        """Standard deviation of a figure."""
        return max(self.uncertainty(name) * TO_SIGMA, 1e-9)

    @property
    def visible(self) -> float:
        """Smallest displacement that is not noise [body lengths]."""
        return clamp(1.5 * self.uncertainty("displacement"), tolerances.VISIBLE, 0.08)

    # --- where things are ---------------------------------------------------------------------------------------------

    def find_end(self, direction: Vector) -> PartMotion | None:
        """The end towards a direction; None if the report tells no ends apart."""
        ends = [p for p in self.report.parts if cosine(p.direction, direction) >= _ALONG_END]
        return max(ends, key=lambda p: cosine(p.direction, direction), default=None)

    def course(self, first: int, last: int, end: PartMotion | None = None) -> Course:
        """Displacements from frame ``first`` on; empty if that frame or all others are not observable."""
        centroid = self.report.centroid if end is None else end.centroid
        start = centroid[first] if first < len(centroid) else None
        if start is None:
            return []
        back = scale(start, -1.0)
        points = [(t, add([p, back])) for t in range(first, last + 1) if (p := centroid[t]) is not None]
        return points if len(points) > 1 else []

    def speed_before(self, first: int, end: PartMotion | None = None) -> Vector:
        """Velocity when a window begins [body lengths per frame]; zero if not observable."""
        before = max(first - 3, 0)
        centroid = self.report.centroid if end is None else end.centroid
        here, there = centroid[first], centroid[before]
        if here is None or there is None or before == first:
            return (0.0, 0.0, 0.0)
        return scale(add([here, scale(there, -1.0)]), 1.0 / (first - before))

    def turns(self, first: int, last: int, end: PartMotion | None = None) -> Course:
        """Rotation vectors from frame ``first`` on [deg]; without a series, the window's alone."""
        series = self.report.rotation if end is None else end.rotation
        if series:
            start = series[first]
            if start is None:
                return []
            vectors = [(t, series[t]) for t in range(first, last + 1)]
            points = [(t, _measure_turn(start, v)) for t, v in vectors if v is not None]
            return points if len(points) > 1 else []
        window = self.window(first, last)
        if end is not None or window is None or window.rotation_degrees is None:
            return []
        axis = window.rotation_axis or (0.0, 0.0, 0.0)
        return [(window.first, (0.0, 0.0, 0.0)), (window.last, scale(axis, window.rotation_degrees))]

    def turns_asked(
        self, expectation: ExpectedMotion, first: int, last: int, end: PartMotion | None
    ) -> Course:
        """As `turns`; of one end that is to turn against the other, half of their difference.

        That difference is what is asked, and what both ends seem to do alike, as leaning does, is not in it.
        """
        turns, other = self.turns(first, last, end), self._find_opposed(expectation)
        against = None if other is None or end is None or other.part is None else self.find_end(other.part)
        if against is None:
            return turns
        back = dict(self.turns(first, last, against))
        return [(t, scale(add([v, scale(back[t], -1.0)]), 0.5)) for t, v in turns if t in back]

    def _find_opposed(self, expectation: ExpectedMotion) -> ExpectedMotion | None:
        """The turn of the other end the other way, at the same time."""
        part, axis = expectation.part, expectation.direction
        for other in self.together(expectation):
            turns = other.kind is expectation.kind is MotionKind.ROTATE and not expectation.excludes_part
            if turns and part and axis and other.part and other.direction:
                if cosine(part, other.part) < -_ALONG_END and cosine(axis, other.direction) < -_SAME_LINE:
                    return other
        return None

    def window(self, first: int, last: int) -> WindowMotion | None:
        """The report's window of these frames, or the shortest that holds them from the same frame on."""
        fitting = [w for w in self.report.windows if w.first == first and w.last >= last]
        return min(fitting, key=lambda w: w.last, default=None)

    def strains(self, direction: Vector, first: int, last: int) -> list[tuple[int, float]]:
        """Relative change of the length that lies along a direction in frame ``first``, frame by frame."""
        report = self.report
        if report.stretch:
            start = report.stretch[first]
            if start is None:
                return []
            turned = report.rotation[first] if report.rotation else None
            body = direction if turned is None else _rotate(direction, scale(turned, -1.0))
            rest = max(_project(start, body), 1e-6)
            tensors = [(t, report.stretch[t]) for t in range(first, last + 1)]
            points = [(t, _project(S, body) / rest - 1.0) for t, S in tensors if S is not None]
            return points if len(points) > 1 else []
        window = self.window(first, last)
        if window is None or window.stretch is None:
            return []
        return [(window.first, 0.0), (window.last, _project(window.stretch, direction) - 1.0)]

    def outline(self, direction: Vector, first: int, last: int) -> list[tuple[int, float, float]]:
        """Relative change of the outline's length along a direction since frame ``first``, with its half width.

        Empty where the direction is none of the report's, or not seen in that frame or in any other.
        """
        extent = next(
            (e for e in self.report.extents if abs(cosine(e.direction, direction)) > _SAME_LINE),
            None,
        )
        start = extent and extent.ratio[first]
        if not extent or not start:
            return []
        points = [(t, extent.ratio[t], extent.half_width[t]) for t in range(first, last + 1)]
        found = [(t, v / start - 1.0, w / start) for t, v, w in points if v is not None and w is not None]
        return found if len(found) > 1 else []

    def hides(self, direction: Vector) -> bool:
        """Return whether a stretch along a direction cannot be seen, because it is along the line of sight."""
        shown = any(w.stretch_view_axis_observable for w in self.report.windows)
        return not shown and abs(dot(direction, self.brief.directions.toward)) > 0.7

    def volumes(self, first: int, last: int) -> list[tuple[int, float]]:
        """Volume ratios of the box, frame by frame, relative to ``first``."""
        start = self.report.volume_ratio[first]
        if not start:
            return []
        ratios = [(t, self.report.volume_ratio[t]) for t in range(first, last + 1)]
        return [(t, v / start) for t, v in ratios if v is not None]

    # --- what goes with what ------------------------------------------------------------------------------------------

    @cached_property
    def falls(self) -> bool:
        """Return whether something is to fall."""
        return any(e.kind is MotionKind.FALL for e in self.expectations)

    def without_others(self, course: Course, expectation: ExpectedMotion, drift: Vector) -> Course:
        """A course without what gravity, other motions at the same time and an earlier speed add across it."""
        direction = expectation.direction
        if direction is None:
            return course
        up, down = self.brief.directions.up, self.brief.directions.down
        others = [up, down] if self.gravity and abs(dot(direction, up)) < _BOTH else []
        moves = (MotionKind.MOVE, MotionKind.SWAY)
        others += [e.direction for e in self.together(expectation) if e.kind in moves and e.direction]
        others += [down for e in self.together(expectation) if e.kind is MotionKind.FALL]
        across = [
            normalised for o in others if abs(dot(o, direction)) < _BOTH and (normalised := normalise(o))
        ]
        gone_on = normalise(drift)
        if gone_on and abs(dot(gone_on, direction)) >= 0.7:
            gone_on = None
        start = course[0][0] if course else 0
        cleared: Course = []
        for t, p in course:
            for other in across:
                p = add([p, scale(other, -max(dot(p, other), 0.0))])
            if gone_on:
                coasted = clamp(dot(p, gone_on), 0.0, norm(drift) * (t - start))
                p = add([p, scale(gone_on, -coasted)])
            cleared.append((t, p))
        return cleared

    def causes(self, expectation: ExpectedMotion) -> str:
        """Names of the entries that should cause it, for remedies."""
        return ", ".join(cause.name for cause in find_causes(expectation, self.force_field))

    def driven(self, expectation: ExpectedMotion) -> bool:
        """Return whether something in the force field drives it the way that the sentence says."""
        return any(agrees(cause, expectation) for cause in find_causes(expectation, self.force_field))


def find_farthest(course: Course) -> tuple[int, Vector]:
    """The frame and place farthest from the start, in whatever direction."""
    return max(course, key=lambda point: norm(point[1]))


def find_first_response(course: Course, threshold: float) -> tuple[int, Vector] | None:
    """The first place beyond ``threshold``; None if it never gets there."""
    return next(((t, p) for t, p in course if norm(p) > threshold), None)


def _project(tensor: Matrix, direction: Vector) -> float:
    """n.S.n."""
    return dot((dot(tensor[0], direction), dot(tensor[1], direction), dot(tensor[2], direction)), direction)


def _rotate(v: Vector, turn: Vector) -> Vector:
    """A vector turned by a rotation vector [deg] (Rodrigues)."""
    axis, angle = normalise(turn), math.radians(norm(turn))
    if axis is None:
        return v
    c, s = math.cos(angle), math.sin(angle)
    return add([scale(v, c), scale(cross(axis, v), s), scale(axis, dot(axis, v) * (1 - c))])


def _measure_turn(start: Vector, end: Vector) -> Vector:
    """The rotation vector from one orientation to another, both from frame 0 [deg], with whole turns kept."""
    if norm(start) < 1e-9:
        return end
    w, x = _to_quaternion(end)
    v, y = _to_quaternion(scale(start, -1.0))
    real = w * v - dot(x, y)
    vector = add([scale(y, w), scale(x, v), cross(x, y)])
    difference = add([end, scale(start, -1.0)])
    axis = normalise(vector)
    if axis is None:
        return difference
    angle = math.degrees(2.0 * math.atan2(norm(vector), real))
    turns = round((dot(difference, axis) - angle) / 360.0)
    return scale(axis, angle + 360.0 * turns)


def _to_quaternion(turn: Vector) -> tuple[float, Vector]:
    half = math.radians(norm(turn)) / 2.0
    axis = normalise(turn) or (0.0, 0.0, 0.0)
    return math.cos(half), scale(axis, math.sin(half))
