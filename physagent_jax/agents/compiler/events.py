"""Events: one motion of a sentence, as values that a force field can be made of."""

from __future__ import annotations

from dataclasses import dataclass, field

from physagent_jax.agents.intent import Timing
from physagent_jax.agents.lexicon import Effect, Motion, Repeat
from physagent_jax.agents.schema import Amount, ObstacleRequest
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import Region

BY_DEFAULT = "by default"


@dataclass(frozen=True)
class ValueSource:
    """The words that led to a value of an event, and the rule that applied."""

    words: str
    why: str


@dataclass(frozen=True)
class Event:
    """One thing that happens.

    Attributes:
        motion, phrase: What is done, and the lexicon's word for it.
        words: The clause's words.
        order: Relation to the event before (`intent.Clause.order`).
        direction: Unit world direction, stretch axis or rotation axis; None if the motion needs none or acts in all
            directions.
        strength: Magnitude in [0.4, 1.6].
        region: Part of the object; None = all of it.
        part: The end that is named (unit vector towards it); None = none, or a part that is no end.
        excludes_part: Whether ``part`` is the one that is not meant.
        amount: A quantity that the sentence names.
        stays: Whether it is to be held where it was brought.
        even: Whether it is to go at one speed.
        obstacles: Solids that it meets.
        repeat: Count and alternation.
        when: Time that the sentence names.
        wind: Whether a wind does it.
        elsewhere: Whether the sentence says that the object ends at another place: "away", "aside", "off the table".
        sources: Where each value comes from.
        notes: Assumptions.
        doubts: What was not understood and matters.
    """

    motion: Motion
    phrase: str
    words: str
    order: str
    direction: Vector | None
    strength: float
    region: Region | None = None
    part: Vector | None = None
    excludes_part: bool = False
    amount: Amount | None = None
    stays: bool = False
    even: bool = False
    obstacles: tuple[ObstacleRequest, ...] = ()
    repeat: Repeat = Repeat()
    when: Timing = Timing()
    wind: bool = False
    elsewhere: bool = False
    sources: dict[str, ValueSource] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def effect(self) -> Effect:
        """The kind of effect."""
        return self.motion.effect

    @property
    def is_way_assumed(self) -> bool:
        """Whether the sentence does not say which way it goes."""
        source = self.sources.get("vector")
        return source is not None and source.why.endswith(BY_DEFAULT)

    @property
    def is_timed(self) -> bool:
        """Whether the sentence says when or how long it is."""
        return self.when != Timing()
