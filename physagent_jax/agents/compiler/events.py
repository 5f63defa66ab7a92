"""Events: one motion of a sentence, from the meanings of its words to values that a force field can be made of."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

from physagent_jax.agents.intent import Clause, Timing
from physagent_jax.agents.lexicon import Effect, Motion, Names, Place, Repeat
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import Region
from physagent_jax.motion.schema import Amount, ObstacleRequest

BY_DEFAULT = "by default"
ACROSS = "across the part"
ALONG = "along the part"


class WayKind(enum.Enum):
    """The kinds of ways."""

    TO = enum.auto()  # a direction
    FROM = enum.auto()  # where the cause comes from
    LINE = enum.auto()  # of a stretch, or axis of a turn
    PLANE = enum.auto()  # of a turn
    SIDES = enum.auto()  # several at once
    AGAIN = enum.auto()  # as before, or the other way


WAYS = (WayKind.TO, WayKind.FROM)


@dataclass(frozen=True)
class KnownWay:
    """A way with its meaning.

    Attributes:
        kind: Its kind.
        names: Directions that are added; for sides "both" or "all", for `WayKind.AGAIN` "same" or "other".
        phrase: The lexicon's phrase.
        text: The words in the sentence.
        place: The part that it goes towards ("toward its handle"), until it is known which way that is; else None.
    """

    kind: WayKind
    names: Names
    phrase: str
    text: str
    place: Place | None = None


@dataclass(frozen=True)
class KnownPart:
    """A part with its place, the lexicon's phrase and the words in the sentence."""

    place: Place
    phrase: str
    text: str


@dataclass(frozen=True)
class ValueSource:
    """The words that led to a value of an event, and the rule that applied."""

    words: str
    why: str


@dataclass
class Event:
    """One thing that happens: first its words with their meanings, then what follows from them.

    Attributes:
        clause: The clause.
        when: Its time.
        stays: Whether the result is to be held.
        verb, cause: What is done, and what does it; None = not named.
        phrase, cause_phrase: The lexicon's words for motion and cause.
        motion: What it comes to: the verb's, else the cause's, as what stands beside it makes it.
        ways, parts, excluded: Ways, parts that are acted on, and parts that are not.
        strengths: Words for strength, as `words.find_strength` knows them.
        unknown_parts: Words for parts that the object does not show.
        doubts, notes: What was not understood and matters; what was assumed.
        repeat: Count and alternation.
        facing: Angle about the vertical by which it has been turned before, counter-clockwise from above [degrees].
        direction: Unit world direction, stretch axis or rotation axis; None if the motion needs none or acts in all
            directions.
        strength: Magnitude in [0.4, 1.6].
        region: Part of the object; None = all of it.
        part: The end that is named (unit vector towards it); None = none, or a part that is no end.
        excludes_part: Whether ``part`` is the one that is not meant.
        limbs: Places in the brief's parts of those that are meant.
        radial: 1 = parts go out from the middle, -1 = inwards; 0 = as ``direction`` tells.
        amount: A quantity that the sentence names.
        rebounds: How often it comes up again from what it falls onto.
        trembles: How strongly it wobbles where it stands as it has landed; 0 = it does not.
        bursts: Whether it ends in pieces.
        nudged: Whether a push that was named by itself sets it going.
        obstacles: Solids that it meets.
        means: Whether it only makes possible what is asked, as a lift before a drop.
        sources: Where each value comes from.
    """

    clause: Clause
    when: Timing
    stays: bool = False
    verb: Motion | None = None
    cause: Motion | None = None
    phrase: str = ""
    cause_phrase: str = ""
    motion: Motion = Motion(Effect.STILL)
    ways: list[KnownWay] = field(default_factory=list)
    parts: list[KnownPart] = field(default_factory=list)
    excluded: list[KnownPart] = field(default_factory=list)
    strengths: list[tuple[str, float]] = field(default_factory=list)
    unknown_parts: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    repeat: Repeat = Repeat()
    facing: float = 0.0
    direction: Vector | None = None
    strength: float = 1.0
    region: Region | None = None
    part: Vector | None = None
    excludes_part: bool = False
    limbs: tuple[int, ...] = ()
    radial: int = 0
    amount: Amount | None = None
    rebounds: int = 0
    trembles: float = 0.0
    bursts: bool = False
    nudged: bool = False
    obstacles: list[ObstacleRequest] = field(default_factory=list)
    means: bool = False
    sources: dict[str, ValueSource] = field(default_factory=dict)

    @property
    def words(self) -> str:
        """The words in the sentence that name the motion."""
        return self.clause.said or self.clause.motion or self.clause.cause or ""

    @property
    def text(self) -> str:
        """The clause's words in the sentence."""
        return self.clause.text or self.words

    @property
    def effect(self) -> Effect:
        """The kind of effect."""
        return self.motion.effect

    @property
    def count(self) -> int:
        """Number of repetitions, 1 unless the sentence counts."""
        return self.repeat.count or 1

    def pick(self, *kinds: WayKind) -> list[KnownWay]:
        """Its ways of these kinds."""
        return [way for way in self.ways if way.kind in kinds]

    @property
    def is_known(self) -> bool:
        """Return whether a motion or a cause is known."""
        return self.verb is not None or self.cause is not None

    @property
    def is_bare(self) -> bool:
        """Return whether nothing but its strength is told."""
        told = self.clause
        rest = told.quantities or told.repetitions or told.solids or told.turning or told.seen_from
        return not (self.ways or self.parts or self.excluded or rest or self.is_timed)

    @property
    def is_timed(self) -> bool:
        """Return whether the sentence says when or how long it is."""
        return self.when != Timing()

    @property
    def is_back(self) -> bool:
        """Return whether it goes back where it came from."""
        return any(way.phrase == "back" for way in self.pick(WayKind.TO))

    @property
    def is_quick(self) -> bool:
        """Return whether it is over in an instant: a flinch, or a turn or a way over the ground that is sudden."""
        goes = self.effect is Effect.PUSH and self.motion.direction is None and not self.is_upwards
        sudden = self.clause.pace == "sudden" and not (self.when.lasts or self.parts or self.is_in_wind)
        return self.motion.quick or sudden and (goes or self.effect in (Effect.TURN, Effect.LEAN))

    @property
    def is_upwards(self) -> bool:
        """Return whether it goes up."""
        return any(way.names == ("up",) for way in self.pick(WayKind.TO))

    @property
    def is_blow(self) -> bool:
        """Return whether something meets it: a blow, or a shove."""
        shoved = self.effect is Effect.PUSH and self.motion.brief and not self.is_in_wind
        return shoved or self.effect is Effect.STRIKE

    @property
    def lands_aside(self) -> bool:
        """Return whether it tells where something comes down: "as it reaches the ground it is farther to the right"."""
        return self.verb is not None and self.verb.lands and not self.clause.negated and self.goes_aside

    @property
    def lies_aside(self) -> bool:
        """Return whether it tells that it comes to lie on a side of its own: "tip it over onto its side"."""
        return not {"side", "rim", "edge"}.isdisjoint(self.text.lower().split())

    @property
    def goes_aside(self) -> bool:
        """Return whether a way is told that is neither up nor down."""
        return any(way.names not in (("up",), ("down",)) for way in self.pick(WayKind.TO))

    @property
    def is_in_wind(self) -> bool:
        """Return whether a wind does it."""
        return any(each is not None and each.wind for each in (self.cause, self.verb))

    @property
    def is_nudged(self) -> bool:
        """Return whether a finger or a hand does it, or sets it going."""
        pushed = self.cause is not None and self.cause.touches
        return self.nudged or pushed or self.motion.touches and self.effect is Effect.STRIKE


def is_landing_meanwhile(before: Event, event: Event) -> bool:
    """Return whether an event is the landing from which on another goes on: "it wobbles *when it lands*"."""
    goes_on = before.effect in (Effect.SWAY, Effect.TURN, Effect.ROLL, Effect.TOPPLE)
    goes_on |= before.effect is Effect.LEAN and before.motion.manner == "bend"
    return goes_on and event.motion.lands and event.clause.order == "together" and not event.clause.negated
