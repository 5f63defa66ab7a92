"""The reply in the making."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.schema import Evidence
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, VelocityConstraint, is_too_short
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, ObstacleRequest, SceneBrief
from physagent_jax.motion.vectors import clamp
from physagent_jax.motion.windows import Window

MAX_ACTIONS = 60  # more would only slow the simulation; no sentence for a clip of a few seconds needs them


@dataclass
class ForceFieldBuilder:
    """The force field that follows from the events so far.

    Attributes:
        brief, anchored: The scene, with the clip's length.
        rooted: Whether its foot is held, whoever says so.
        soft: Whether a finger goes into it.
        breaks: Whether it is said to break.
        bursts: How strongly it bursts into pieces, in one piece until then (`motion.breaking`); 0 = it does not.
        gravity: What the sentence says about gravity: "down", "up", "none"; None = nothing.
        room: Frame at which what follows the present event is over: its brake ends there.
        earlier: What the slots before do.
        notes, unsure: What was assumed; what was not understood and matters. Either may be told twice.
        obstacles: Walls and blocks that it names.
        drop_height: Height from which it falls [body lengths]; None = none is told.
        attitude: Turn with which it begins to fall, as in `WorldRequest`; None = as it stands.
    """

    brief: SceneBrief
    anchored: bool
    gravity: Literal["down", "up", "none"] | None = None
    room: float = 0.0
    earlier: list[Effect] = field(default_factory=list)
    default_drop: bool = False
    drop_height: float | None = None
    attitude: tuple[float, float] | None = None
    rooted: bool = False
    soft: bool = False
    breaks: bool = False
    bursts: float = 0.0
    actions: list[Action] = field(default_factory=list)
    constraints: list[VelocityConstraint] = field(default_factory=list)
    expectations: list[ExpectedMotion] = field(default_factory=list)
    evidence: list[Evidence] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    unsure: list[str] = field(default_factory=list)
    obstacles: list[ObstacleRequest] = field(default_factory=list)

    @property
    def grounded(self) -> bool:
        """Return whether gravity acts all the time, on an object that stands on the ground."""
        return self.brief.world == "ground" and self.gravity not in ("none", "up")

    def expect(self, kind: MotionKind, direction: Vector | None, window: Window, words: str, **more) -> None:
        """Adds a motion that a viewer should see; once."""
        strength = clamp(more.pop("strength", 1.0), MAGNITUDE_MIN, MAGNITUDE_MAX)
        shown = self.fit_window(window) or (0.0, self.brief.last)
        motion = ExpectedMotion(
            kind=kind, direction=direction, window=shown, words=words[:200], strength=strength, **more
        )
        told = [(each.kind, each.direction, each.window, each.part, each.limb) for each in self.expectations]
        if len(told) < MAX_ACTIONS and (kind, direction, shown, motion.part, motion.limb) not in told:
            self.expectations.append(motion)

    def add_evidence(self, words: str, field: str, value: str, why: str) -> None:
        """Adds the words that led to a value."""
        self.evidence.append(Evidence(words=words, field=field, value=value, why=why))

    def enable_gravity(self, words: str, why: str) -> None:
        """Lets the object fall from the first frame."""
        if self.gravity not in ("none", "up") and not self.default_drop:
            self.add_evidence(words, "default_drop", "true", why)
            self.default_drop = True

    def fit_window(self, window: Window) -> Window | None:
        """``window`` inside the clip, in whole frames if it keeps one; None (all) if the clip has one frame."""
        if self.brief.last < 1:
            return None
        first, end = (clamp(edge, 0.0, self.brief.last) for edge in window)
        if round(end) > round(first):
            return (float(round(first)), float(round(end)))
        return (self.brief.last - 1.0, self.brief.last) if is_too_short(first, end) else (first, end)
