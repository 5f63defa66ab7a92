"""The reply in the making: actions with their evidence, expectations, notes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from physagent_jax.agents.compiler.amounts import MOST
from physagent_jax.agents.compiler.events import Event
from physagent_jax.agents.compiler.schedule import find_frames
from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.schema import (
    Amount,
    Evidence,
    ExpectedMotion,
    MotionKind,
    ObstacleRequest,
    SceneBrief,
)
from physagent_jax.agents.vectors import clamp
from physagent_jax.agents.windows import Window
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ForceField, VelocityConstraint, is_too_short

MAX_ACTIONS = 60  # more would only slow the simulation; no sentence for a clip of a few seconds needs them


@dataclass
class ForceFieldBuilder:
    """The force field that follows from the events so far.

    Attributes:
        brief, anchored: The scene, with the clip's length.
        gravity: What the sentence says about gravity: "down", "up", "none"; None = nothing.
        room: Frame at which what follows the present event is over: its brake ends there.
        unsure: What was not understood and matters.
        obstacles: Walls and blocks that it names.
    """

    brief: SceneBrief
    anchored: bool
    gravity: Literal["down", "up", "none"] | None = None
    room: float = 0.0
    default_drop: bool = False
    actions: list[Action] = field(default_factory=list)
    expectations: list[ExpectedMotion] = field(default_factory=list)
    evidence: list[Evidence] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    unsure: list[str] = field(default_factory=list)
    obstacles: list[ObstacleRequest] = field(default_factory=list)

    @property
    def grounded(self) -> bool:
        """Return whether gravity acts all the time, on an object that stands on the ground."""
        return self.brief.world == "ground" and self.gravity not in ("none", "up")

    @property
    def last(self) -> float:
        """Index of the clip's last frame."""
        return float(self.brief.frame_count - 1)

    def add_action(
        self, event: Event, kind: ActionType, vector: Vector, magnitude: float, window: Window
    ) -> None:
        """Adds an action with its evidence; windows are kept inside the clip."""
        if len(self.actions) >= MAX_ACTIONS:
            self.add_note(f"More than {MAX_ACTIONS} actions: the rest of the sentence is left out.")
            return
        size = clamp(abs(magnitude), MAGNITUDE_MIN, MAGNITUDE_MAX)
        action = Action(
            action_type=kind,
            vector=vector,
            magnitude=round(size if magnitude > 0 else -size, 3),
            active_time=self.fit_window(window),
            region=event.region,
        )
        if action in self.actions:  # "squashed and flattened" says one thing twice
            return
        place = f"actions[{len(self.actions)}]"
        self.actions.append(action)
        for name, value in describe_skill(action).items():
            if source := event.sources.get(name):
                self.evidence.append(
                    Evidence(words=source.words, field=f"{place}.{name}", value=value, why=source.why)
                )

    def add_expectation(
        self, event: Event, kind: MotionKind, direction: Vector | None, window: Window, **more
    ) -> None:
        """Adds an expectation, with the event's values but for ``more``; once."""
        strength = more.pop("strength", event.strength)
        expected = ExpectedMotion(
            kind=kind,
            direction=direction,
            strength=clamp(strength, MAGNITUDE_MIN, MAGNITUDE_MAX),
            window=self.fit_window(window) or (0.0, self.last),
            partial=event.region is not None,
            part=event.part,
            excludes_part=event.excludes_part,
            stays=event.stays,
            even=event.meaning.clause.even and kind in (MotionKind.MOVE, MotionKind.ROTATE),
            amount=more.pop("amount", event.amount or self._find_duration(event)),
            words=event.words[:200],
            **more,
        )
        known = map(_identify, self.expectations)
        if len(self.expectations) < MAX_ACTIONS and _identify(expected) not in known:
            self.expectations.append(expected)

    def _find_duration(self, event: Event) -> Amount | None:
        """The cause's duration, if the sentence says so in seconds or frames."""
        told = event.when.lasts
        if told is None or told.unit == "clip" or told.value <= 0 or event.effect is Effect.STILL:
            return None
        seconds = (find_frames(told, self.brief) or 0.0) * self.brief.frame_dt
        return Amount(value=round(min(seconds, MOST), 6), unit="seconds")

    def enable_gravity(self, words: str, why: str) -> None:
        """Lets the object fall from the first frame."""
        if self.gravity in ("none", "up"):
            return
        if not self.default_drop:
            self.evidence.append(Evidence(words=words, field="default_drop", value="true", why=why))
        self.default_drop = True

    def add_note(self, text: str) -> None:
        """Adds an assumption once."""
        if text not in self.notes:
            self.notes.append(text)

    def add_doubt(self, text: str) -> None:
        """Adds what was not understood and matters, once."""
        if text not in self.unsure:
            self.unsure.append(text)

    def fit_window(self, window: Window) -> Window | None:
        """``window`` inside the clip, in whole frames if it keeps one; None (all) if the clip has one frame."""
        if self.last < 1:
            return None
        first, end = (clamp(edge, 0.0, self.last) for edge in window)
        if round(end) > round(first):
            return (float(round(first)), float(round(end)))
        return (self.last - 1.0, self.last) if is_too_short(first, end) else (first, end)

    def build(self) -> ForceField:
        """The result."""
        return ForceField(default_drop=self.default_drop, actions=tuple(self.actions))


def _identify(motion: ExpectedMotion) -> tuple:
    """The values by which two motions are told apart."""
    return motion.kind, motion.direction, motion.window, motion.part


def describe_skill(skill: Action | VelocityConstraint) -> dict[str, str]:
    """Describe the fields of a skill in words."""
    name = "action_type" if isinstance(skill, Action) else "constraint_type"
    return {
        name: getattr(skill, name).value,
        "vector": _format(skill.vector),
        "magnitude": f"{skill.magnitude:g}",
        "active_time": _format(skill.active_time),
        "region": getattr(skill.region, "kind", ""),
    }


def _format(values: Vector | Window | None) -> str:
    return "whole clip" if values is None else "[" + ", ".join(f"{round(v, 3):g}" for v in values) + "]"
