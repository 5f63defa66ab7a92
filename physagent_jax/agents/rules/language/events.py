"""Events: one motion of a sentence, as values that a force field can be made of."""

from __future__ import annotations

from dataclasses import dataclass, field

from physagent_jax.agents.rules.language.modifiers import Join, Repeat
from physagent_jax.agents.rules.language.timing import TimeSpan
from physagent_jax.agents.rules.language.verbs import Effect, Verb
from physagent_jax.agents.schema import Amount, ObstacleRequest
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import Region

TOLD = "time as told"
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
        verb, phrase: What is done, and the lexicon's entry.
        words: The clause's words.
        join: Relation to the event before.
        direction: Unit world direction, stretch axis or rotation axis; None if the verb needs none or
            acts in all directions.
        strength: Magnitude in [0.4, 1.6].
        region: Part of the object; None = all of it.
        part: The end that is named (unit vector towards it); None = none, or a part that is no end.
        excludes_part: ``part`` is the one that is not meant.
        amount: A quantity that the sentence names.
        stays: It is to be held where it was brought.
        even: It is to go at one speed.
        obstacles: Solids that it meets.
        repeat: Count and alternation.
        when: Time that the sentence names.
        wind: A wind does it.
        elsewhere: The sentence says that the object ends at another place: "away", "aside", "off the table".
        sources: Where each value comes from.
        notes: Assumptions.
        doubts: What was not understood and matters.
    """

    verb: Verb
    phrase: str
    words: str
    join: Join
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
    when: TimeSpan = TimeSpan()
    wind: bool = False
    elsewhere: bool = False
    sources: dict[str, ValueSource] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def effect(self) -> Effect:
        """The kind of effect."""
        return self.verb.effect


def is_way_assumed(event: Event) -> bool:
    """Return whether the sentence does not say, as far as it was read, which way an event goes."""
    source = event.sources.get("vector")
    return source is not None and source.why.endswith(BY_DEFAULT)
