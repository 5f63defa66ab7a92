"""Forces and torques that act for a time: how strong, how long, and how they are stopped.

A free object keeps its speed when a force ends, so a push that is followed by another motion or by stillness brakes in
the second half of its window; an anchored one comes back by itself. A length that the sentence tells is the cause's
own: what is to stop then is braked after it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_jax.agents.compiler.amounts import MOST, find_effort, find_word_effort
from physagent_jax.agents.compiler.builder import MAX_ACTIONS, ForceFieldBuilder
from physagent_jax.agents.compiler.events import ACROSS, BY_DEFAULT, Event
from physagent_jax.agents.compiler.schedule import find_frames, has_to_stop
from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import (
    GAIN_MAX,
    GAIN_MIN,
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    TURN,
    find_magnitude,
)
from physagent_jax.forces.description import describe_entry
from physagent_jax.forces.schema import Action, ActionType
from physagent_jax.motion.efforts import find_held_magnitude, find_spin
from physagent_jax.motion.joints import Turning
from physagent_jax.motion.schema import Amount, MotionKind, SceneBrief
from physagent_jax.motion.vectors import clamp, dot, normalise, scale
from physagent_jax.motion.windows import Window, halve, shorten

SHORTEST_STROKE, _SHORTEST_SWING = 2.0, 4.0  # frames; faster ones alias in the pictures
_PUSHED = 0.5  # of the way of what is shoved, along which it is pushed; it slides on
_BEFORE_FALL = 0.65  # of the way, so that it has room to fall over behind it
_RUBS = 0.3  # most of its direction that points upwards, for the ground to stop by friction what is shoved along it
_DRIFTS = "The object is free and would drift on: it is braked"
BRAKED_BEFORE = f"{_DRIFTS} before what follows."


@dataclass(frozen=True)
class Task:
    """An event in its window, to be compiled.

    Attributes:
        event, window: The event, and its time [frames].
        after: Events of the slot that follows.
        builder: The reply in the making.
    """

    event: Event
    window: Window
    after: list[Event]
    builder: ForceFieldBuilder

    @property
    def brief(self) -> SceneBrief:
        """The scene."""
        return self.builder.brief

    @property
    def direction(self) -> Vector:
        """The event's direction, of an effect that always has one."""
        assert self.event.direction is not None
        return self.event.direction

    def act(
        self, kind: ActionType, vector: Vector, magnitude: float, window: Window, *, gains: bool = False
    ) -> None:
        """Adds an action with its evidence; windows are kept inside the clip, and magnitudes in range but for gains."""
        builder, event = self.builder, self.event
        if len(builder.actions) >= MAX_ACTIONS:
            builder.notes.append(f"More than {MAX_ACTIONS} actions: the rest of the sentence is left out.")
            return
        size = round(clamp(abs(magnitude), MAGNITUDE_MIN, MAGNITUDE_MAX), 3)
        action = Action(
            action_type=kind,
            vector=vector,
            magnitude=size if magnitude > 0 else -size,
            gain=round(clamp(abs(magnitude) / size, GAIN_MIN, GAIN_MAX), 3) if gains else 1.0,
            active_time=builder.fit_window(window),
            region=event.region,
        )
        if action in builder.actions:  # "squashed and flattened" says one thing twice
            return
        place = f"actions[{len(builder.actions)}]"
        builder.actions.append(action)
        for name, value in describe_entry(action).items():
            if source := event.sources.get(name):
                builder.add_evidence(source.words, f"{place}.{name}", value, source.why)

    def expect(self, kind: MotionKind, direction: Vector | None, window: Window, **more) -> None:
        """Adds once what a viewer should see: the event's values but for ``more``."""
        event, builder = self.event, self.builder
        clause, motion = event.clause, event.motion
        even = clause.pace == "even" or motion.floats or event.is_quick
        values = dict(
            strength=event.strength, part=event.part, excludes_part=event.excludes_part, stays=event.stays,
            partial=event.region is not None, manner=motion.manner, jiggles=motion.jiggles or event.trembles > 0,
            means=event.means, counted=any(each.times is not None and not each.often for each in clause.repetitions),
            springs=any(later.motion.springs for later in self.after),
            even=even and kind in (MotionKind.MOVE, MotionKind.ROTATE),
            put_back=motion.puts_back or event.is_back and window[0] > 0,
            may_stop_short=motion.loose and not (clause.quantities or clause.repetitions),
            amount=event.amount or self._find_duration(),
            to_ground=any(way.phrase in read_lexicon().grounding for way in event.ways),
        )  # fmt: skip
        for limb in event.limbs or (None,):
            part = event.part if limb is None else builder.brief.parts[limb].side
            own = event.radial and part and normalise(scale((part[0], part[1], 0.0), event.radial))
            if limb is not None and event.sources["vector"].why == ACROSS:  # each has its own way across
                own = Turning(builder.brief.parts[limb], builder.brief, builder.brief.frame_count).swing
            told = values | dict(limb=limb, part=part) | more
            builder.expect(kind, own or direction, window, event.text, **told)

    def _find_duration(self) -> Amount | None:
        """The cause's duration, if the sentence says so in seconds or frames."""
        told = self.event.when.lasts
        if told is None or told.unit == "clip" or told.value <= 0 or self.event.effect is Effect.STILL:
            return None
        seconds = (find_frames(told, self.brief) or 0.0) * self.brief.frame_dt
        return Amount(value=round(min(seconds, MOST), 6), unit="seconds")

    @property
    def is_reached_within(self) -> bool:
        """Return whether the told time is the one in which a quantity is reached, and says nothing of later."""
        event = self.event
        return event.when.within and event.amount is not None and not event.motion.brief

    @property
    def is_kept(self) -> bool:
        """Return whether a change of shape that is reached in its time is to stay: nothing says that it is let go."""
        return self.is_reached_within and not self._is_let_go

    @property
    def is_released(self) -> bool:
        """Return whether the cause ends and leaves the object to itself, which was brought to no place to stay."""
        dips = self.event.effect is Effect.LEAN and self.event.motion.brief  # it comes back
        if self.event.stays or not dips and (self._is_measured or self.is_kept):
            return False
        ends_early = not self.after and self.window[1] < self.builder.brief.last - 0.5
        return self._is_let_go or ends_early or self.event.motion.brief

    @property
    def spin(self) -> float | None:
        """The angle by which a spin of all of it shows its far side [degrees]; None = it is none."""
        event, whole = self.event, self.event.region is None and not self.event.limbs
        turns = whole and event.effect is Effect.TURN and not self.builder.anchored
        return find_spin(event.amount, event.motion.manner, event.direction, self.brief) if turns else None

    @property
    def is_raised(self) -> bool:
        """Return whether something keeps it up: what was planned last raised it."""
        last, up = self.builder.expectations[-1:], self.brief.directions.up
        return any(each.kind is MotionKind.MOVE and dot(each.direction or up, up) > 0.5 for each in last)

    @property
    def is_gentle(self) -> bool:
        """Return whether something on the ground is pushed gently: no farther than that promises."""
        event, builder = self.event, self.builder
        pushed = event.effect is Effect.PUSH and event.strength < 1 and not (event.limbs or event.is_in_wind)
        return pushed and builder.grounded and not (builder.anchored or event.region or event.when.lasts)

    @property
    def is_shoved(self) -> bool:
        """Return whether something on the ground is pushed briefly: it goes as far as if that lasted, and stops."""
        event, builder, up = self.event, self.builder, self.brief.directions.up
        whole = builder.grounded and not (builder.anchored or event.region or event.limbs or event.when.lasts)
        kept = event.stays or self._is_measured or self._has_to_stop and dot(self.direction, up) > _RUBS
        return event.effect is Effect.PUSH and event.motion.brief and whole and not kept

    @property
    def rolls_on(self) -> bool:
        """Return whether it rolls as it lies, having fallen over."""
        fallen = Effect.TOPPLE in self.builder.earlier and self.builder.grounded
        return fallen and self.event.effect is Effect.ROLL

    @property
    def needs_brake(self) -> bool:
        """Return whether it must be stopped before what comes next can be seen; friction stops shoves and what lies."""
        stops = self.event.stays or self._is_measured or self._has_to_stop
        return stops and not (self.builder.anchored or self.is_shoved or self.rolls_on)

    @property
    def _has_to_stop(self) -> bool:
        return has_to_stop(self.event, self.after, self.brief.directions.up, self.builder.grounded)

    @property
    def leaves_place(self) -> bool:
        """Return whether a push or a blow takes the whole object elsewhere: thrown, to another place, or so far.

        A lean and a wind bend what is rooted, however far. So may a push or a blow of which neither a distance nor
        another place is told; a motion that says no more than that the object goes a told way does not. What is let go
        afterwards springs back, and is in no other place.
        """
        event, motion = self.event, self.event.motion
        whole = event.region is None and event.part is None
        if not whole or event.is_in_wind or event.effect is Effect.LEAN:
            return False
        thrown = event.effect is Effect.STRIKE and (motion.gravity or motion.direction == "up")
        way_told = event.effect is Effect.PUSH and not event.sources["vector"].why.endswith(BY_DEFAULT)
        elsewhere = event.clause.elsewhere or way_told and motion.hauls
        far = event.amount is not None and event.amount.unit in ("lengths", "metres")
        goes = way_told and motion.generic or elsewhere and not self._is_let_go
        return thrown or far or goes or event.effect is Effect.JUMP

    @property
    def _is_let_go(self) -> bool:
        return any(later.effect is Effect.RELEASE for later in self.after)

    @property
    def _is_measured(self) -> bool:
        """Return whether a free object is to go so far, or turn by so much, and no further; a lean may come back."""
        effort = find_effort(self.event.amount, self.event.effect, self.brief)
        leaves = self.event.effect is Effect.LEAN and self._is_let_go
        return not (self.builder.anchored or leaves) and effort is not None

    def limit_count(self, count: int, shortest: float = _SHORTEST_SWING) -> int:
        """``count`` limited to what the pictures can show, at ``shortest`` frames each, and the list can hold."""
        frames = self.window[1] - self.window[0]
        fits = max(1, min(int(frames / shortest), MAX_ACTIONS // 3))
        if fits < count:
            note = f"{count} repetitions do not fit into {frames:.0f} frames: {fits} are made."
            self.builder.notes.append(note)
        return min(count, fits)


def add_steady(task: Task, kind: ActionType, vector: Vector, magnitude: float) -> Window:
    """Adds a force or torque over the window, braked in its second half if need be; returns where it acts."""
    event, window, builder = task.event, task.window, task.builder
    lasts, stops = event.when.lasts, task.needs_brake
    if event.motion.brief and lasts is None and not stops:  # what is braked needs its time
        window = shorten(window, builder.brief.last)
    told = lasts is not None and lasts.unit != "clip" and not event.when.within
    brakes = stops and not told
    speed_up, slow_down = halve(window)
    gains = kind is ActionType.TORQUE and task.spin is not None or task.is_gentle or task.is_shoved
    frames = slow_down[1] - speed_up[0] if brakes else window[1] - window[0]
    magnitude *= _find_dose(task, magnitude, frames * builder.brief.frame_dt, brakes)
    if kind is ActionType.TRANSLATION and any(each.effect is Effect.TOPPLE for each in task.after):
        magnitude *= 1.0 if brakes or event.amount else _BEFORE_FALL
    if builder.anchored and task.is_reached_within and not task.after:
        task.act(kind, vector, magnitude, (window[0], builder.brief.last))
    elif brakes:
        task.act(kind, vector, magnitude, speed_up, gains=gains)
        task.act(kind, scale(vector, -1.0), magnitude, slow_down, gains=gains)
        builder.notes.append(BRAKED_BEFORE)
    else:
        task.act(kind, vector, magnitude, window, gains=gains)
        rests = any(later.effect is Effect.STILL for later in task.after)
        if stops and rests and window[1] < builder.brief.last:
            _brake_after(task, kind, vector, magnitude, window)
    return window


def _brake_after(task: Task, kind: ActionType, vector: Vector, magnitude: float, window: Window) -> None:
    """Adds the brake behind a told time."""
    first, end = round(window[0]), round(window[1])
    brake = (float(end), float(min(2 * end - first, math.floor(task.builder.room))))
    if brake[1] > brake[0]:
        task.act(kind, scale(vector, -1.0), magnitude, brake)
        task.builder.notes.append(f"{_DRIFTS} after the time that is told.")


def _find_dose(task: Task, magnitude: float, seconds: float, braked: bool) -> float:
    """Factor on the magnitude so that the event's quantity is reached where nothing opposes.

    Without one, what is braked goes as far as its word promises: half of its time goes to stopping.
    """
    event, brief = task.event, task.brief
    if event.amount is not None and task.builder.anchored:
        wanted = find_held_magnitude(event.amount, brief, event.effect is Effect.SWAY)
    else:
        effort = find_effort(event.amount, event.effect, brief)
        if event.amount is None and task.spin is not None:
            effort = math.radians(task.spin) / TURN
        elif event.amount is None and (braked or task.is_gentle or task.is_shoved):
            effort = find_word_effort(event.strength, event.effect)
            effort = effort and effort * (_PUSHED if task.is_shoved else 1.0)
        shortest = max(seconds, brief.frame_dt)
        wanted = effort and find_magnitude(effort, shortest, brief.seconds, braked=braked)
    return 1.0 if wanted is None else max(wanted, 1e-3) / abs(magnitude)
