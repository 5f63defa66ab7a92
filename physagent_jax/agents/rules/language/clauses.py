"""A clause: one thing that the sentence says."""

from __future__ import annotations

from dataclasses import dataclass, field

from physagent_jax.agents.displacement import ends_elsewhere
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join, Names, Place, Repeat
from physagent_jax.agents.rules.language.verbs import Effect, Verb

WHERE = (
    MentionKind.DIRECTION,
    MentionKind.FROM,
    MentionKind.AXIS,
    MentionKind.PLANE,
    MentionKind.SIDES,
    MentionKind.SENSE,
    MentionKind.PLACE,
    MentionKind.EXCLUDED,
    MentionKind.REPEAT,
    MentionKind.REVERSAL,
)
TURNING = (Effect.TURN, Effect.ROLL, Effect.LEAN, Effect.TOPPLE)
HOLDABLE = (Effect.PUSH, Effect.LEAN, Effect.SCALE, Effect.SWELL, Effect.TURN)
OPPOSITES: tuple[tuple[Names, Names], ...] = (
    (("left",), ("right",)),
    (("up",), ("down",)),
    (("toward",), ("away",)),
)
HEADS = (MentionKind.VERB, MentionKind.CAUSE)


@dataclass
class Clause:
    """One thing that the sentence says.

    Attributes:
        join: Relation to the clause before.
        verb: The word that says what is done; None while only modifiers were met.
        cause: A noun that names what does it ("wind").
        modifiers: Everything else.
        negated: It is said *not* to happen.
        inherited: The verb is that of the clause before.
        stays: What it brings about is to be held.
        elsewhere: It says that what is moved ends at another place (`agents.displacement`).
        mentions: All mentions, for quoting.
    """

    join: Join
    verb: Mention | None = None
    cause: Mention | None = None
    modifiers: list[Mention] = field(default_factory=list)
    negated: bool = False
    inherited: bool = False
    stays: bool = False
    elsewhere: bool = False
    mentions: list[Mention] = field(default_factory=list)

    def select(self, *kinds: MentionKind) -> list[Mention]:
        """Its modifiers of these kinds."""
        return [mention for mention in self.modifiers if mention.kind in kinds]

    @property
    def head(self) -> Mention | None:
        """The mention that decides what is done."""
        return self.verb or self.cause

    @property
    def words(self) -> str:
        """The words of the mention that decides what is done."""
        return self.head.words if self.head else ""


def get_verb(mention: Mention | None) -> Verb:
    """The value of a VERB or CAUSE mention."""
    assert mention is not None and isinstance(mention.value, Verb)
    return mention.value


def mark_displacements(clauses: list[Clause], words: list[str]) -> None:
    """Mark the clauses whose words, from their first mention to the next clause's, tell of another place.

    Args:
        clauses: The clauses.
        words: The sentence's tokens in lower case.
    """
    firsts = [min((m.first for m in clause.mentions), default=len(words)) for clause in clauses]
    for clause, first in zip(clauses, firsts):
        end = min((each for each in firsts if each > first), default=len(words))
        clause.elsewhere = ends_elsewhere(words[first:end])


def find_places(clause: Clause) -> list[Place]:
    """The parts of the object that a clause names."""
    return [mention.value for mention in clause.select(MentionKind.PLACE) if isinstance(mention.value, Place)]


def find_excluded(clause: Clause) -> list[Place]:
    """The parts that a clause excepts."""
    return [
        mention.value for mention in clause.select(MentionKind.EXCLUDED) if isinstance(mention.value, Place)
    ]


def find_repeats(clause: Clause) -> list[Repeat]:
    """The counts that a clause names; "in both directions, left and right" goes there once."""
    counts = [
        mention.value for mention in clause.select(MentionKind.REPEAT) if isinstance(mention.value, Repeat)
    ]
    return [each for each in counts if not (each.names and clause.select(MentionKind.SIDES))]
