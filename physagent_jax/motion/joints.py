"""The motion of a limb about its joint: the axis, the angle, and where it bends.

A limb is moved by what is prescribed: it turns about its joint so that its tip goes where it is to go, or moves along
itself where the way leads along it. It swings where a body lets it: what hangs beside the body is raised away from it,
and never through it. Its skin bends over a way that is long enough for it, or the angle gets less.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
import operator

from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import BLOW
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.part import Part, split_name
from physagent_jax.forces.schema import Bend, VelocityConstraint
from physagent_jax.motion.hinges import find_box, stand_up
from physagent_jax.motion.limbs import SEATED, find_facing
from physagent_jax.motion.schema import Amount, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import (
    add,
    clamp,
    cosine,
    cross,
    dot,
    norm,
    normalise,
    rotate,
    scale,
    subtract,
)
from physagent_jax.motion.windows import OVERSHOOT, SPRING, list_springs

_PLAIN = 45.0  # [degrees] that a plain word turns a limb by
_LEAST, _MOST = 15.0, 80.0  # [degrees]
_RAISED, _LOWERED = 50.0, -50.0  # [degrees] over the horizon, where a plain word brings a limb up or down to
_HANGING = -80.0  # the same of what is lowered until it hangs
_OVERHEAD = 80.0  # the same of what is raised over the head
_FARTHEST = 120.0  # [degrees] that it turns by for that
_SWAYS = 0.75  # of a plain angle, to either side of a limb that goes to and fro
_SEEN = 0.08  # [body lengths] that its tip goes to either side at least, so that it is seen
_WIDEST = 40.0  # [degrees] that a short one swings by for that at most
_ALONG = 0.85  # cosine to the limb from which on a way leads along it
_AGAINST = -0.7  # cosine of the way back
_REACH = 0.3  # of its length, by which a plain word moves a limb along itself
_DENTED = 0.6  # the same of a region that is pressed into what it is one skin with
_SHOWN = 0.08  # [body lengths] that a loose piece is moved along itself at least, so that it is seen
_DRAWN = 0.12  # [body lengths] that such a region is drawn at least, or by its length, as its border hardly goes along
_LIMIT = 1.0  # of its length, by which a short limb is drawn at most, so that it is seen
_PRESSED, _DEEPEST = (
    0.5,
    0.6,
)  # of its extent, by which a plain word presses what cannot give way, and at most
_INTO = 0.045  # [body lengths] that a region is pressed into the rest at least, so that it is seen
_BUCKLES = 0.5  # of that, of what sits on the rest: pressed deeper, it tilts and slips out
_FOOT = 0.12  # of the object's height, below which a limb lies on what bears the object
_LIFTED = 1.0  # the same of a lid, which lies loose and comes off
_HANGS = 0.7  # cosine to the vertical from which on a limb hangs, or stands upright
_BESIDE = 0.7  # cosine to the way out from which on a limb points there
_INWARD = -0.3  # cosine to the way out below which a level way leads into the body
_SUPPLE = frozenset(
    ("tail", "wing", "ear", "horn", "nose")
)  # roles of what bends everywhere, and not at its joint alone
_CURLED = 140.0  # [degrees] that a plain word curls a limb by
_REACHED, _STEP = (
    0.06,
    5.0,
)  # [body lengths] over the ground, where it has come down; [degrees] of the search for that
_NEARLY = 0.1  # of its length, over where a limb is lowest: farther on, it would only be tucked in
_CURLS = 1.4  # times the angle that a supple limb turns by: its tip goes less far
_WIDE = 4.0  # standard deviations of a disc in its diameter
_ZONE = 1.25  # widths of the limb, over which it bends beside its joint
_SHORT = 0.6  # of its length, at most
_STRAIN = 0.85  # [1] of the skin on the outside of a bend, at most
_CREASED = 30.0  # [degrees] that it is turned by though its skin creases, so that it is seen
_WRUNG = 40.0  # [degrees] that what is twisted is turned by, as the rest below it is twisted as well
_STEEPEST = 1.5  # slope of u^2 (3 - 2 u) in its middle
_BORDER = 3.0  # standard deviations of the neck, within which the rest borders on the part
_SPUN = 180.0  # [degrees] that a plain word turns what stands on the rest about the upright
_WHEELED, _FAST = 360.0, 2.0  # [degrees] that it turns a wheel; times that, of a strong word
_GEARS = 4  # steps in which it gets faster and faster
_NECKED = frozenset(("head", "face", "neck"))  # words for what does not turn so far
_CURLING = frozenset(("curl", "coil"))  # begins of words for what bends over all of its length
_JAWS = frozenset(("jaw", "mouth"))  # words for what opens downwards
_ASIDE = frozenset(("left", "right"))  # words for a side that a limb is brought to
_LIMP, _CREASES = (
    ("droop", "flop", "hang", "wilt", "fall", "drop", "limp"),
    75.0,
)  # begins of words; [degrees] for them, though the skin creases
_FLOPPED = 75.0  # [degrees] that such a word turns a limb by aside
_FAR = (
    "overhead",
    "sky",
    "ceiling",
    "straight",
    "hang",
    "point",
)  # begins of words for a limb that goes all the way up or down
_SLOW = ("slow", "gradual", "lazi", "limp")  # begins of words for the pace alone
_OWN_WAYS = dict(
    forward=1.0, forwards=1.0, backward=-1.0, backwards=-1.0, back=-1.0
)  # as it looks, and the other way
_SWINGS = 2  # of a limb that wags, unless the sentence counts them
_HOME = 0.75  # of what is left of its time, by which what comes back is there: it is seen to have come
_TIME = 1.0  # [s] in which a limb gets where it goes, at most; less strongly is slower
Window = tuple[float, float]


@dataclasses.dataclass(frozen=True)
class Turning:
    """The turning of one limb in a clip, as constraints.

    Attributes:
        part: The limb.
        brief: The scene.
        frame_count: Length of the clip [frames].
        slides: Whether it sits loose on the rest, as a lid does, and is moved rather than turned.
        curls: Whether it bends over all of its length.
        held: Whether the object is held somewhere; else the rest carries the limb.
        brought: Whether it has been brought where it is, and is not raised first to wave.
    """

    part: Part
    brief: SceneBrief
    frame_count: int
    slides: bool = False
    curls: bool = False
    held: bool = True
    brought: bool = False

    @functools.cached_property
    def arm(self) -> Vector:
        """The way from the joint to the tip, a unit vector."""
        return normalise(self.part.arm) or self.brief.directions.up

    @functools.cached_property
    def out(self) -> Vector:
        """The level way that leads away from the body: from its mirror image to it, else to where it is."""
        front = find_facing(self.brief.parts)
        if front is not None and "leg" in self.part.roles[:1]:
            return front
        side = self.part.side
        twins = [
            each.side
            for each in self.brief.parts
            if each.roles[:1] == self.part.roles[:1] and each.side != side
        ]
        across = subtract(side, twins[0]) if len(twins) == 1 else side
        return normalise((across[0], across[1], 0.0)) or self.brief.directions.right

    @functools.cached_property
    def height(self) -> float:
        """The limb's angle over the horizon [degrees]."""
        return math.degrees(math.asin(clamp(dot(self.arm, self.brief.directions.up), -1.0, 1.0)))

    @property
    def hangs(self) -> bool:
        """Return whether it hangs down."""
        return dot(self.arm, self.brief.directions.up) < -_HANGS

    @property
    def is_head(self) -> bool:
        """Return whether it is a head, by its shape or its name."""
        return "head" in (*self.part.roles, *split_name(self.part.name))

    @property
    def swing(self) -> Vector:
        """The way across a limb that it swings to and fro: a tail and a head levelly, others across the sight."""
        table = self.brief.directions
        level = not {"tail", "head"}.isdisjoint((*self.part.roles[:1], *split_name(self.part.name)))
        way = normalise(cross(table.up if level else table.toward, self.arm)) or table.right
        return scale(way, -1.0) if dot(way, self.out if self.hangs else table.up) < 0 else way

    def is_borne(self, way: Vector) -> bool:
        """Return whether it cannot go a way (unit world vector): the ground is there, or what it sits on."""
        down = dot(way, self.brief.directions.down) > _ALONG
        placed = self.part.origin == "place" and self.part.seated and down
        # A neck goes over.
        seated = not SEATED.isdisjoint(self.part.roles[:1]) and "neck" not in self.part.roles
        if (seated or placed) and dot(self.arm, way) < -_ALONG:
            return True
        lowest = min(place[2] for place in self.part.moved.inside)
        return (
            self.brief.world == "ground" and dot(way, self.brief.directions.down) > _ALONG and lowest < _FOOT
        )

    def drive(self, motion: ExpectedMotion, until: float) -> tuple[list[VelocityConstraint], ExpectedMotion]:
        """The constraints that bring about a motion, and the motion as it is then expected.

        Args:
            motion: The motion.
            until: Frame at which the limb's next one begins, or the clip's last.
        """
        motion = self._face(motion)
        if not self.curls and not _CURLING.isdisjoint(each[:4] for each in split_name(motion.words)):
            return dataclasses.replace(self, slides=False, curls=True).drive(motion, until)
        if motion.kind is MotionKind.SWAY:
            standing = stand_up(self.part, self.brief) if self.part.seated else self.part
            return dataclasses.replace(self, part=standing, slides=False)._drive_swings(motion)
        axis = motion.direction
        if motion.kind is MotionKind.ROTATE and axis is not None and motion.repeats > 1:
            angle = self.find_angle(motion, axis)
            strokes = _time_strokes(motion.window, _list_strokes(angle, motion.repeats))
            made = [self.turn(axis, stroke, window, None) for stroke, window in strokes]
            return made, motion.model_copy(update=dict(window=strokes[0][1]))
        if motion.kind is MotionKind.ROTATE and axis is not None and (spun := self._find_spun(motion, axis)):
            if spun < _WHEELED:  # pictures do not tell one turn of alike blades from a part of it
                motion = motion.model_copy(update=dict(amount=Amount(value=spun, unit="degrees")))
            if spun >= _WHEELED or not motion.released:
                first, end = motion.window[0], min(motion.window[1], until)
                parts = _GEARS if split_name(motion.words).count("faster") > 1 else 1
                times = [first + (end - first) * k / parts for k in range(parts + 1)]
                gears = [(2 * k + 1) * spun / parts**2 for k in range(parts)]  # as much faster each time
                stop = until if until > end else None  # what is let go would hang from its hub
                stops = [None] * (parts - 1) + [stop]
                made = [self.turn(axis, *each) for each in zip(gears, itertools.pairwise(times), stops)]
                return made, motion
        window = self._find_window(motion, until)
        let_go = motion.released or motion.sudden and not motion.stays
        stop = None if let_go or until <= window[1] else until
        swing = self.brief.count_frames(SPRING)
        kept = max(window[1], min(motion.window[1], until - swing * motion.springs))
        back = (kept, kept + min(window[1] - window[0], _HOME * (until - kept)))
        if motion.kind is MotionKind.ROTATE and axis is not None:
            angle, course, turns = self.find_angle(motion, axis), axis, motion.manner != "hinge"
            bring = functools.partial(self.turn, axis)
        else:
            way = self._gape(motion) or motion.direction or self.swing
            if self.curls and abs(dot(way, self.arm)) > _ALONG:  # it cannot curl along itself
                way = self.swing if self.hangs else self.brief.directions.toward
            angle = self._find_seen(motion, way)
            course = motion.direction and self.find_course(way, angle, sudden=motion.sudden)
            turns = not (self.slides or self.is_borne(way)) and self.find_axis(way) is not None
            bring = functools.partial(self.bring, way, motion)
            far = (
                turns and not self.supple and any(each.startswith(_FAR) for each in split_name(motion.words))
            )
            if far and motion.amount is None:  # half of the way is too little
                motion = motion.model_copy(update=dict(amount=Amount(value=angle, unit="degrees")))
        returns = turns and motion.released and not motion.sudden and back[1] - back[0] >= 2.0
        stop = kept if returns and kept > window[1] else stop
        made = [bring(angle, window, stop)]
        if returns:  # what is stiff, or lies where it was brought, would not come back by itself
            swings = list_springs(kept, until, swing) if motion.springs else [(-1.0, back)]
            low = motion.kind is not MotionKind.ROTATE and self._meets_ground(course, angle)
            if motion.springs and (low or not swings):
                swings = [(-1.0, (kept, min(kept + swing, back[1])))]
            made += [bring(share * angle, span, None) for share, span in swings]
            if until > swings[-1][1][1]:
                made[-1] = made[-1].model_copy(update=dict(held_until=until))
        return made, motion.model_copy(update=dict(direction=course))

    def _meets_ground(self, course: Vector | None, angle: float) -> bool:
        """Return whether it would go into the ground if it sprang back too far from where it goes."""
        up = self.brief.directions.up
        down = self.brief.world == "ground" and course is not None and dot(course, up) > _BESIDE
        height = min(place[2] for place in self.part.moved.inside) * self.brief.extents[1]
        return down and height < norm(self.part.arm) * math.sin(math.radians(OVERSHOOT * abs(angle)))

    def swing_on(
        self, done: ExpectedMotion, motion: ExpectedMotion, until: float
    ) -> tuple[list[VelocityConstraint], ExpectedMotion]:
        """As `drive`, to and fro about where ``done`` has brought it: a raised arm waves from side to side."""
        done = self._face(done)
        way = done.direction or self.swing
        axis = None if self.slides or done.kind is not MotionKind.MOVE else self.find_axis(way)
        if axis is None:
            return self.drive(motion, until)
        arm = rotate(self.part.arm, scale(axis, self._find_seen(done, way)))
        own = motion.direction is not None and abs(cosine(motion.direction, self.swing)) > _ALONG
        motion = motion.model_copy(update=dict(direction=None)) if own else motion  # of the limb at rest
        part = self.part.model_copy(update=dict(arm=arm))
        return dataclasses.replace(self, part=part, brought=True).drive(motion, until)

    def undo(
        self, done: ExpectedMotion, motion: ExpectedMotion, until: float
    ) -> tuple[list[VelocityConstraint], ExpectedMotion]:
        """As `drive`, for a motion that takes the limb back from where ``done`` has brought it.

        Where it is told a side ("to the left, then to the right"), it goes on by as much to there.
        """
        done, aside = self._face(done), _goes_aside(motion)
        window, way = self._find_window(motion, until), done.direction or self.swing
        stop = until if until > window[1] else None
        if done.kind is MotionKind.ROTATE:
            angle = self.find_angle(done, way) + (self.find_angle(motion, way) if aside else 0.0)
            return [self.turn(way, -angle, window, stop)], motion
        angle = self._find_seen(done, way)
        made = self.bring(way, done, -2.0 * angle if aside else -angle, window, stop)
        course = scale(self.find_course(way, angle), -1.0)
        return [made], motion.model_copy(update=dict(direction=course))

    def _find_spun(self, motion: ExpectedMotion, axis: Vector) -> float:
        """The turn of a wheel about its axle, or of a dish about the upright on what bears it [degrees]; else 0."""
        plain = motion.amount is None and not motion.sudden and _NECKED.isdisjoint(split_name(motion.words))
        upright = abs(dot(axis, self.brief.directions.up)) > _ALONG
        seated = upright and not SEATED.isdisjoint(self.part.roles[:1])
        wheel = self.part.axle is not None and abs(dot(axis, self.part.axle)) > _ALONG
        turns = _WHEELED * (_FAST if motion.strength > 1.0 else 1.0)
        usual = _WHEELED if motion.manner == "spin" else _SPUN
        return (turns if wheel else usual) if plain and (wheel or seated) else 0.0

    def _drive_swings(self, motion: ExpectedMotion) -> tuple[list[VelocityConstraint], ExpectedMotion]:
        """As `drive`, to and fro: each stroke takes as long as its angle needs."""
        count = max(motion.repeats, _SWINGS)
        way, angles = self.list_swings(motion, count)
        if self._shakes(motion):
            way = self.brief.directions.right  # so the face goes
        made = [
            self.turn(self.brief.directions.up, angle, window, None)
            if self._shakes(motion)
            else self.bring(way, motion, angle, window, None)
            for angle, window in _time_strokes(motion.window, angles)
            if window[1] - window[0] >= 1.0
        ]
        course = way if self._shakes(motion) else self.find_course(way, angles[0])
        return made, motion.model_copy(update=dict(direction=course, repeats=count))

    def _shakes(self, motion: ExpectedMotion) -> bool:
        """Return whether it is an upright head that is shaken, which turns to either side."""
        shaken = any(each.startswith("shak") for each in split_name(motion.words))
        upright = dot(self.arm, self.brief.directions.up) > _HANGS
        return shaken and upright and self.is_head

    def find_axis(self, way: Vector, *, sudden: bool = False) -> Vector | None:
        """The axis about which a limb turns so that its tip goes a way; None where the way leads along it.

        What is raised or lowered turns in the upright plane in which it points, or away from the body where it hangs;
        it is then turned however steep it is. A level way into the body leads past its front.

        Args:
            way: Unit world vector.
            sudden: Whether it is a blow, which tips over what it meets end on.
        """
        up, rise = self.brief.directions.up, dot(way, self.brief.directions.up)
        along = dot(self.arm, way)
        raised = rise > _ALONG and self.height >= _RAISED  # an upright ear that is pulled up is drawn out
        if abs(rise) > _ALONG and along < _ALONG and not raised:
            level = subtract(self.arm, scale(up, dot(self.arm, up)))
            points = norm(level) > math.sqrt(1 - _HANGS**2) and cosine(level, self.out) < _BESIDE
            plane = normalise(level) if points else None
            return scale(cross(plane or self.out, up), math.copysign(1.0, rise))
        if raised or abs(along) >= _ALONG:
            return normalise(cross(up, way)) if sudden else None
        if self.hangs and abs(rise) < 1 - _ALONG and cosine(way, self.out) < _INWARD:
            way = add((way, self.brief.directions.toward))
        return normalise(cross(self.arm, way))

    def find_angle(self, motion: ExpectedMotion, axis: Vector | None, way: Vector | None = None) -> float:
        """Angle that a limb turns by [degrees]: as told, or as a plain word leads a viewer to expect.

        It is no more than leaves the skin without a crease, unless it is told.

        Args:
            motion: The motion.
            axis: The axis (unit world vector); None = it moves along itself.
            way: Where its tip is to go (unit world vector); None = the axis alone is told.
        """
        if motion.amount is not None and motion.amount.unit == "degrees":
            return motion.amount.value
        words = split_name(motion.words)
        slow, limp, far = (any(each.startswith(begins) for each in words) for begins in (_SLOW, _LIMP, _FAR))
        far |= limp
        strength = max(motion.strength, 1.0) if slow else motion.strength  # as far as else, in more time
        plain, most = (_CURLED, _CURLED) if self.curls else (_FLOPPED if limp else _PLAIN, _MOST)
        angle = clamp(plain * strength, _LEAST, most)
        rise = 0.0 if way is None else dot(way, self.brief.directions.up)
        if axis is None:
            return angle
        if abs(rise) > _ALONG and not motion.sudden and "leg" not in self.part.roles[:1]:
            low, high = (_HANGING, _OVERHEAD) if far else (_LOWERED, _RAISED)
            wanted = high - self.height if rise > 0 else self.height - low
            angle = clamp(wanted * min(strength, 1.0), angle, _FARTHEST)
        if motion.to_ground and rise < -_ALONG:
            return min(self._find_way_down(axis), self._find_zone(axis)[1])
        curls = _CURLS if self.supple and not self.curls else 1.0
        return min(angle * curls, max(self._find_zone(axis)[1], _CREASES * far))

    def _find_way_down(self, axis: Vector) -> float:
        """The angle about an axis at which it meets the ground, or is nearly as low as it can be [degrees]."""
        box, up = find_box(self.brief), self.brief.directions.up
        joint = (self.part.joint[0] * box[0], self.part.joint[1] * box[1], self.part.joint[2] * box[2])
        arms = [subtract((x * box[0], y * box[1], z * box[2]), joint) for x, y, z in self.part.moved.inside]
        angles = [_STEP * each for each in range(1, round(_FARTHEST / _STEP))]
        lowest = [
            dot(joint, up) + min(dot(rotate(arm, scale(axis, angle)), up) for arm in arms) for angle in angles
        ]
        enough = max(_REACHED, min(lowest) + _NEARLY * norm(self.part.arm))
        return next(angle for angle, z in zip(angles, lowest) if z <= enough)

    @property
    def supple(self) -> bool:
        """Return whether it bends everywhere."""
        if self.curls and norm(self.part.neck) > 0:
            return True
        return not _SUPPLE.isdisjoint(self.part.roles[:1]) and norm(self.part.neck) > 0

    def turn(self, axis: Vector, angle: float, window: Window, stop: float | None) -> VelocityConstraint:
        """The limb turned about an axis.

        Args:
            axis: Unit world vector.
            angle: [degrees]; negative = the other way.
            window: First and last frame.
            stop: Frame until which it is held there; None = not.
        """
        return self._bend(self.driver.turn(axis, angle, window, stop), self._find_zone(axis)[0])

    def _find_zone(self, axis: Vector) -> tuple[float, float]:
        """The way over which it bends [body lengths], and the largest angle that leaves no crease [degrees]."""
        length = norm(self.part.arm)
        twisted = abs(dot(axis, self.arm)) > _ALONG
        across = None if twisted else normalise(cross(axis, self.arm))
        spread = (
            max(self.part.neck) if across is None else math.hypot(*map(operator.mul, across, self.part.neck))
        )
        width = _WIDE * spread
        if not width:
            return 0.0, math.inf
        depth = length if self.supple else min(_ZONE * width, _SHORT * length)
        least = _WRUNG if across is None else _CREASED
        return depth, max(math.degrees(2 * _STRAIN * depth / (_STEEPEST * width)), least)

    def _bend(self, made: VelocityConstraint, depth: float) -> VelocityConstraint:
        reach, part = _BORDER * max(self.part.neck), self.part
        if not depth or not reach or part.moved.rigid:
            return made
        bend = Bend(joint=part.joint, rest=part.rest, reach=min(reach, 2.0), depth=min(depth, 2.0))
        return made.model_copy(update=dict(bend=bend))

    def list_swings(self, motion: ExpectedMotion, count: int) -> tuple[Vector, list[float]]:
        """The way of the first of several swings, and the angles of all strokes [degrees].

        What hangs swings out and back, and not into the body. An arm that goes up and down is raised first: it waves.
        """
        up, way = self.brief.directions.up, self._nod(motion) or motion.direction or self.swing
        waves = "arm" in self.part.roles[:1] and (self.hangs or abs(dot(way, up)) > _ALONG)
        waves &= not self.brought
        if not waves and not (self.hangs and abs(cosine(way, self.out)) > -_INWARD):
            angle = self._widen(_SWAYS * self.find_angle(motion, self.find_axis(way)), motion)
            return way, _list_strokes(angle, count)
        if not waves:
            angle = self._widen(2 * _SWAYS * self.find_angle(motion, self.find_axis(self.out)), motion)
            return self.out, [angle, -angle] * count
        raised = motion.model_copy(update=dict(kind=MotionKind.MOVE, amount=None))
        most = self.find_angle(raised, self.find_axis(up), up)
        angle = min(2 * _SWAYS * self.find_angle(motion, None), 0.6 * most)
        return up, [most, *[-angle, angle] * count]

    def _widen(self, angle: float, motion: ExpectedMotion) -> float:
        """The angle of a swing [degrees], or a wider one if a short limb would hardly be seen to move by it."""
        if motion.amount is not None:
            return angle
        angle *= _CURLS if self.supple else 1.0
        return math.copysign(max(abs(angle), self._find_least(motion)), angle)

    def _find_seen(self, motion: ExpectedMotion, way: Vector) -> float:
        """As `find_angle`, but no less than is seen of a short limb; what has only a place has no joint."""
        axis = None if self.part.origin == "place" else self.find_axis(way, sudden=motion.sudden)
        angle = self.find_angle(motion, axis, way)
        return angle if axis is None else max(angle, min(self._find_least(motion), _CREASED))

    def _find_least(self, motion: ExpectedMotion) -> float:
        """The angle by which a short limb is seen to turn [degrees]; 0 where the sentence tells how far it goes."""
        seen = math.degrees(_SEEN / max(norm(self.part.arm), 1e-9))
        return 0.0 if motion.amount is not None else min(seen, _WIDEST)

    def _nod(self, motion: ExpectedMotion) -> Vector | None:
        """The way of a head that nods: down where it looks aside, forward where it is upright."""
        if not self.is_head or not any(each.startswith(("nod", "bob")) for each in split_name(motion.words)):
            return None
        level = abs(dot(self.arm, self.brief.directions.up)) < _HANGS
        table = self.brief.directions
        return table.down if level else find_facing(self.brief.parts) or table.toward

    def _face(self, motion: ExpectedMotion) -> ExpectedMotion:
        """The motion as the object has it: what is bent "backwards" goes to its own back, where its front is known.

        A head that is seen from its side and tilted "to the left" goes to the left of who looks it in the face.
        """
        front, table, way = find_facing(self.brief.parts), self.brief.directions, motion.direction
        said = [sign for word, sign in _OWN_WAYS.items() if word in split_name(motion.words)]
        if front is None or way is None or motion.kind is MotionKind.ROTATE:
            return motion
        aside = dot(way, table.left)
        if motion.manner == "rock" and self.is_head and min(abs(aside), abs(dot(way, front))) > _ALONG:
            return motion.model_copy(update=dict(direction=scale(cross(front, table.up), aside)))
        if len(said) != 1:
            return motion
        if dot(way, scale(table.toward, said[0])) < _ALONG:  # other words tell it
            return motion
        return motion.model_copy(update=dict(direction=scale(front, said[0])))

    def _gape(self, motion: ExpectedMotion) -> Vector | None:
        """The way of a jaw that opens or closes; None = it is no jaw, or does something else."""
        if _JAWS.isdisjoint(split_name(self.part.name)):
            return None
        table, words = self.brief.directions, split_name(motion.words)
        ways = {"open": table.down, "clos": table.up, "shut": table.up}
        return next((way for begin, way in ways.items() if any(w.startswith(begin) for w in words)), None)

    def bring(
        self, way: Vector, motion: ExpectedMotion, angle: float, window: Window, stop: float | None
    ) -> VelocityConstraint:
        """The limb turned by an angle [degrees] so that its tip goes ``way``, or moved along itself.

        Args:
            way: Unit world vector.
            motion: For the length that the sentence tells.
            angle: [degrees]; negative = the other way.
            window: First and last frame.
            stop: Frame until which it is held there; None = not.
        """
        if self.is_borne(way):
            depth = min(_PRESSED * motion.strength, _DEEPEST)
            if self.part.origin == "place":
                depth = clamp(_INTO / max(norm(self.part.arm), 1e-9), 0.6 * depth, _DEEPEST)
            elif dot(self.arm, way) < -_ALONG:
                depth *= _BUCKLES
            return self.driver.press(way, depth, window, stop)
        axis = None if self.slides else self.find_axis(way, sudden=motion.sudden)
        if axis is not None:
            return self.turn(axis, angle, window, stop)
        told = motion.amount if motion.kind is MotionKind.MOVE else None
        if told is not None and told.unit in ("lengths", "metres"):
            size = self.brief.size if told.unit == "metres" else 1.0
            return self.driver.shift(way, told.value / size, window, stop)
        place, pressed = self.part.origin == "place", dot(self.arm, way) < -_ALONG
        least = _DRAWN if max(self.part.neck) else _SHOWN
        drawn = clamp(least / max(norm(self.part.arm), 1e-9), _REACH, _LIMIT)
        reach = _LIFTED if "lid" in self.part.roles[:1] else drawn
        if place:
            reach = _DENTED if pressed else max(1.0, _DRAWN / max(norm(self.part.arm), 1e-9))
        made = self.driver.shift(way, reach * norm(self.part.arm) * angle / _PLAIN, window, stop)
        return (
            made
            if self.slides and not place
            else self._bend(made, norm(self.part.arm) if max(self.part.neck) else 0.0)
        )

    def find_course(self, way: Vector, angle: float, *, sudden: bool = False) -> Vector:
        """The way that the tip goes when it is brought ``way`` by an angle [degrees]."""
        axis = None if self.slides or self.is_borne(way) else self.find_axis(way, sudden=sudden)
        if axis is None:
            return way
        turned = rotate(self.arm, scale(axis, angle))
        return normalise(subtract(turned, self.arm)) or way

    def _find_window(self, motion: ExpectedMotion, until: float) -> Window:
        """The frames in which it goes where it is to go, before ``until``; a blow is short."""
        first, end = motion.window
        frames = self.brief.count_frames(BLOW if motion.sudden else _TIME / min(motion.strength, 1.0))
        return (first, min(end, first + max(frames, 2.0), until))

    @property
    def driver(self) -> PartDriver:
        """Makes the constraints."""
        return PartDriver(self.part, self.brief.frame_dt, self.frame_count, self.held)


def _goes_aside(motion: ExpectedMotion) -> bool:
    """Return whether a side is told that a limb is brought to, and not only that it comes back."""
    words = motion.words.lower().split()
    return not _ASIDE.isdisjoint(words[-1:]) and "back" not in words


def is_undone(done: ExpectedMotion, motion: ExpectedMotion) -> bool:
    """Return whether a motion takes a limb back where it was: it is lifted, then lowered again."""
    first, then = done.direction, motion.direction
    plain = not (done.released or done.sudden or motion.sudden or done.manner == "hinge")
    plain &= (
        motion.kind is MotionKind.ROTATE
        and _goes_aside(motion)
        or motion.kind is MotionKind.MOVE
        and motion.amount is None
    )
    moves = done.kind is motion.kind and plain and done.repeats < 2
    return moves and first is not None and then is not None and cosine(first, then) < _AGAINST


def _list_strokes(angle: float, count: int) -> list[float]:
    """The angles of all strokes of what goes to and fro by an angle to either side, and ends where it began."""
    return [angle, *[-2 * angle, 2 * angle] * (count - 1), -2 * angle, angle]


def _time_strokes(window: Window, angles: list[float]) -> list[tuple[float, Window]]:
    """Strokes with their frames: each takes as long as its angle needs."""
    done = list(itertools.accumulate([0.0, *map(abs, angles)]))
    edges = [window[0] + (window[1] - window[0]) * each / done[-1] for each in done]
    return list(zip(angles, itertools.pairwise(edges)))
