"""Events: one motion of a sentence, as values that a force field can be made of."""

from __future__ import annotations

from dataclasses import dataclass, field

from physagent_jax.agents.compiler.words import Meaning
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


@dataclass
class Event:
    """One thing that happens.

    Attributes:
        meaning: The clause that tells it.
        motion, phrase: What is done, and the lexicon's word for it.
        when: Time that the sentence names.
        direction: Unit world direction, stretch axis or rotation axis; None if the motion needs none or acts in all
            directions.
        strength: Magnitude in [0.4, 1.6].
        region: Part of the object; None = all of it.
        part: The end that is named (unit vector towards it); None = none, or a part that is no end.
        excludes_part: Whether ``part`` is the one that is not meant.
        amount: A quantity that the sentence names.
        stays: Whether it is to be held where it was brought.
        obstacles: Solids that it meets.
        repeat: Count and alternation.
        sources: Where each value comes from.
        notes: Assumptions.
        doubts: What was not understood and matters.
    """

    meaning: Meaning
    motion: Motion
    phrase: str
    when: Timing
    direction: Vector | None = None
    strength: float = 1.0
    region: Region | None = None
    part: Vector | None = None
    excludes_part: bool = False
    amount: Amount | None = None
    stays: bool = False
    obstacles: list[ObstacleRequest] = field(default_factory=list)
    repeat: Repeat = Repeat()
    sources: dict[str, ValueSource] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)

    @property
    def words(self) -> str:
        """The clause's words."""
        return self.meaning.text

    @property
    def effect(self) -> Effect:
        """The kind of effect."""
        return self.motion.effect

    @property
    def count(self) -> int:
        """Number of repetitions, 1 unless the sentence counts."""
        return self.repeat.count or 1

    @property
    def is_in_wind(self) -> bool:
        """Whether a wind does it."""
        return any(each is not None and each.wind for each in (self.meaning.cause, self.meaning.verb))

    @property
    def is_timed(self) -> bool:
        """Whether the sentence says when or how long it is."""
        return self.when != Timing()
