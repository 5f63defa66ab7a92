"""One expected motion in the view of the pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from physagent_jax.core.strict import Vector
from physagent_jax.motion import tolerances
from physagent_jax.motion.judging.seen import ALONG_END, SAME_LINE, Course, View, measure_turn
from physagent_jax.motion.matching import AXIAL, agrees, find_causes, share_time
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, ObstacleRequest
from physagent_jax.motion.vectors import add, cosine, dot, norm, normalise, reject, rotate, scale, subtract
from physagent_jax.perception.reasons import BY_SIZE, TURNED
from physagent_jax.perception.schema import PartMotion

_IN_THE_WAY = 0.7  # cosine
_ALONG_SIGHT = 0.5  # cosine of a way and the line of sight: less than 60 degrees off, its end lies in depth
_IN_PLANE = 0.7  # cosine of an axis and the line of sight: the turn shows in the picture plane
_BOTH = 0.5  # cosine: directions more than 60 degrees apart can be told apart
_FIGURES = {
    MotionKind.STRETCH: ("stretch", tolerances.VISIBLE_STRAIN),
    MotionKind.SQUEEZE: ("stretch", tolerances.VISIBLE_STRAIN),
    MotionKind.ROTATE: ("rotation", tolerances.VISIBLE_DEGREES),
}
"""The report's figure in which a kind of motion shows, and the least of it that is seen."""


@dataclass(frozen=True)
class Asked:
    """An expected motion with what is seen of it.

    Attributes:
        index: Its place among the expectations.
        motion: What is asked.
        view: What is seen.
    """

    index: int
    motion: ExpectedMotion
    view: View

    @property
    def kind(self) -> MotionKind:
        """The kind of motion."""
        return self.motion.kind

    @property
    def direction(self) -> Vector | None:
        """The direction or axis that is asked for."""
        return self.motion.direction

    @property
    def sign(self) -> float:
        """-1 for a squeeze, which is a strain below zero."""
        return -1.0 if self.kind is MotionKind.SQUEEZE else 1.0

    @cached_property
    def figure(self) -> str:
        """The report's figure in which the motion shows."""
        figure = _FIGURES.get(self.kind, ("displacement", 0.0))[0]
        told = self.view.report.uncertainty.along is not None
        return "along" if figure == "displacement" and told and self._leans(_ALONG_SIGHT) else figure

    @cached_property
    def visible(self) -> float:
        """The least of the motion that is seen."""
        return _FIGURES.get(self.kind, ("displacement", tolerances.VISIBLE))[1]

    @property
    def sigma(self) -> float:
        """Standard deviation of the figure in which the motion shows."""
        return self.view.sigma(self.figure)

    @cached_property
    def span(self) -> tuple[int, int]:
        """First and last frame in which the motion should be seen."""
        return self.view.span(self.motion)

    @property
    def hops(self) -> bool:
        """Return whether it leaps again and again, and comes down each time."""
        way, up = self.direction, self.view.brief.directions.up
        leaps = self.kind is MotionKind.MOVE and self.motion.sudden and self.motion.repeats > 1
        return leaps and self.view.gravity and way is not None and dot(way, up) > _BOTH

    @cached_property
    def until(self) -> int:
        """The end of the motion's visible consequences: the next motion's beginning, or the clip's end."""
        first, last = self.span
        later = [e for e in self.view.expectations if e.window[0] > self.motion.window[0] + 0.5]
        if self.hops:
            later = [e for e in later if e.words != self.motion.words]  # it comes down in between
        begins = [self.view.span(e)[0] for e in later]
        after = [begin for begin in begins if begin >= last - 1]
        if after:
            return max(last, min(after))
        return last if any(begin > first for begin in begins) else self.view.last

    @cached_property
    def end(self) -> PartMotion | None:
        """The end that is asked about; None for the whole, or if the report does not tell it apart.

        A limb of what moves meanwhile is followed from the middle of the whole, as if that did not turn.
        """
        part, limb = self.motion.part, self.motion.limb
        if limb is not None:
            end = next((each for each in self.view.report.parts if each.limb == limb), None)
            if end is None or not self.carried:
                return end
            return self._take_out_whole(end)
        if part is None:
            return None
        return self.view.find_end(scale(part, -1.0) if self.motion.excludes_part else part)

    def _take_out_whole(self, end: PartMotion) -> PartMotion:
        """The motion of a limb as the whole has it that carries it, turned back to how that was at first."""
        whole, away = self.view.report, end.place or (0.0, 0.0, 0.0)
        places: list[Vector | None] = []
        turns: list[Vector | None] = []
        for here, turn, all_, spun in zip(end.centroid, end.rotation, whole.centroid, whole.rotation):
            places.append(None)
            turns.append(None)
            if here is None or turn is None or all_ is None or spun is None:
                continue
            back = scale(spun, -1.0)
            places[-1] = subtract(rotate(subtract(add([here, away]), all_), back), away)
            turns[-1] = rotate(measure_turn(turn, spun), back)
        return end.model_copy(update=dict(centroid=tuple(places), rotation=tuple(turns)))

    @property
    def hidden(self) -> str:
        """The reason that the motion, or the end that is asked about, cannot be seen; empty if it can."""
        if self.motion.part is not None and self.end is None:
            return "the ends of the object are not told apart"
        if self.view.sight is None or self.kind in AXIAL:
            return ""
        if self.kind is MotionKind.ROTATE:
            return "" if self.direction is None or self._leans(_IN_PLANE) else TURNED
        if not self._leans(_ALONG_SIGHT):
            return ""
        if self.end is not None:
            return "how a part moves along the line of sight is not measured without depth"
        return "" if self.view.shows_approach(self.span[0], self.until) else BY_SIZE

    @property
    def askew(self) -> bool:
        """Return whether the whole leans towards the viewer or away, so that no angle in the picture tells how far."""
        axis, table = self.direction, self.view.brief.directions
        leans = self.kind is MotionKind.ROTATE and self.motion.part is None and self.motion.limb is None
        return leans and axis is not None and abs(cosine(axis, table.right)) > _IN_PLANE

    def _leans(self, share: float) -> bool:
        """Return whether the direction or axis lies along a line of sight without measured depth, by a cosine."""
        down = self.view.brief.directions.down if self.kind is MotionKind.FALL else None
        way, sight = self.direction or down, self.view.sight
        return way is not None and sight is not None and abs(cosine(way, sight)) > share

    @property
    def opens(self) -> bool:
        """Return whether a part opens or closes about a hinge, as a lid, a door or a jaw does and a drawer does not."""
        part = self.motion.part is not None or self.motion.limb is not None
        return part and self.motion.manner == "hinge"

    @property
    def wobbles(self) -> bool:
        """Return whether the whole is to wobble: any change of its shape or tilt that comes and goes is one."""
        whole = self.motion.part is None and self.motion.limb is None
        return whole and self.kind is MotionKind.SWAY and self.motion.jiggles

    @cached_property
    def together(self) -> list[ExpectedMotion]:
        """The motions that are asked for at the same time."""
        return [e for e in self.view.expectations if e is not self.motion and share_time(e, self.motion)]

    @property
    def carried(self) -> bool:
        """Return whether it is a limb that moves on something which is to move as well."""
        kinds = MotionKind.MOVE, MotionKind.ROTATE
        led = (e.limb is None and e.part is None and e.kind in kinds for e in self.together)
        return self.motion.limb is not None and any(led)

    @cached_property
    def limb_turns(self) -> bool:
        """Return whether it is a limb that is seen to turn about its joint; its middle goes along a chord."""
        limb = self.end if self.motion.limb is not None else None
        return limb is not None and self.view.turns_limb(limb, *self.span)

    @property
    def tumbles(self) -> bool:
        """Return whether it turns in a flight, in which the axis of what is not round wanders."""
        flies = (e.kind is MotionKind.MOVE and (e.sudden or e.manner == "fly") for e in self.together)
        return self.kind is MotionKind.ROTATE and self.end is None and any(flies)

    @property
    def rolls_as_it_lies(self) -> bool:
        """Return whether it rolls after it has tipped over: what is tapered goes along a curve."""
        earlier = (e for e in self.view.expectations if e.window[1] <= self.motion.window[0] + 0.5)
        return any(e.words == self.motion.words for e in self.together) and any(
            map(self.view.topples, earlier)
        )

    @cached_property
    def obstacle(self) -> ObstacleRequest | None:
        """The obstacle that the sentence puts in this motion's way."""
        way = self.direction
        met = (each for each in self.view.obstacles if way and cosine(each.direction, way) > _IN_THE_WAY)
        return next(met, None)

    @cached_property
    def causes(self) -> str:
        """Names of the entries that should cause it, for remedies."""
        return ", ".join(cause.name for cause in find_causes(self.motion, self.view.force_field))

    @cached_property
    def driven(self) -> bool:
        """Return whether something in the force field drives it the way that the sentence says."""
        return any(agrees(cause, self.motion) for cause in find_causes(self.motion, self.view.force_field))

    def course(self, first: int, last: int) -> Course:
        """Displacements of what is asked about."""
        return self.view.course(first, last, self.end)

    def turns(self, first: int, last: int) -> Course:
        """Rotation vectors; of one end that is to turn against the other, half of their difference.

        That difference is what is asked, and what both ends seem to do alike, as leaning does, is not in it.
        """
        turns, opposed = self.view.turns(first, last, self.end), self._find_opposed()
        against = self.view.find_end(opposed) if opposed and self.end else None
        if against is None:
            return turns
        back = dict(self.view.turns(first, last, against))
        return [(t, scale(subtract(v, back[t]), 0.5)) for t, v in turns if t in back]

    def _find_opposed(self) -> Vector | None:
        """The other end, if it is to turn the other way at the same time."""
        part, axis = self.motion.part, self.direction
        if self.kind is not MotionKind.ROTATE or self.motion.excludes_part or not part or not axis:
            return None
        for other in self.together:
            if other.kind is MotionKind.ROTATE and other.part and other.direction:
                if cosine(part, other.part) < -ALONG_END and cosine(axis, other.direction) < -SAME_LINE:
                    return other.part
        return None

    def clear_of_others(self, course: Course, drift: Vector) -> Course:
        """A course without what gravity, other motions at the same time and an earlier speed add across it."""
        direction = self.direction
        if direction is None or not course:
            return course
        up, down = self.view.brief.directions.up, self.view.brief.directions.down
        others = [up, down] if self.view.gravity and abs(dot(direction, up)) < _BOTH else []
        moves = (MotionKind.MOVE, MotionKind.SWAY)
        others += [e.direction for e in self.together if e.kind in moves and e.direction]
        others += [down for e in self.together if e.kind is MotionKind.FALL]
        across = [unit for o in others if abs(dot(o, direction)) < _BOTH and (unit := normalise(o))]
        gone_on = normalise(drift)
        if gone_on and abs(dot(gone_on, direction)) >= 0.7:
            gone_on = None
        cleared: Course = []
        for t, p in course:
            for other in across:
                p = reject(p, other, low=0.0)
            if gone_on:
                p = reject(p, gone_on, 0.0, norm(drift) * (t - course[0][0]))
            cleared.append((t, p))
        return cleared
