"""Mentions of a sentence: a phrase of the lexicon, its kind and its value; and the reader that collects them."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace
from itertools import pairwise

from physagent_jax.agents.grammar.measures import Words
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.grammar.tokens import correct_spelling, tokenise
from physagent_jax.agents.lexicon import Effect, Motion


class MentionKind(enum.Enum):
    """The kind of a mention; in brackets the type of its value."""

    VERB = enum.auto()  # Motion
    CAUSE = enum.auto()  # Motion
    DIRECTION = enum.auto()  # names
    FROM = enum.auto()  # names: where the cause comes from
    AXIS = enum.auto()  # names
    PLANE = enum.auto()  # names
    SIDES = enum.auto()  # "both" or "all"
    SENSE = enum.auto()  # int
    VIEW = enum.auto()  # names
    INTENSITY = enum.auto()  # float
    DEGREE = enum.auto()  # float
    COMPARATIVE = enum.auto()  # float
    PACE = enum.auto()  # "even" or "sudden"
    REPEAT = enum.auto()  # Repeat
    PLACE = enum.auto()  # Place
    LISTED = enum.auto()  # Place that stands in a list behind another
    EXCLUDED = enum.auto()  # Place that is not meant
    EXCEPT = enum.auto()  # None: what is not meant is not understood
    TIME = enum.auto()  # TimeSpan
    QUANTITY = enum.auto()  # Quantity
    REVERSAL = enum.auto()  # "other" or "same"
    POSE = enum.auto()  # Side that points down
    ORDINAL = enum.auto()  # int: "the second time"
    SOLID = enum.auto()  # Solid
    GRAVITY = enum.auto()  # str: where to
    ANCHOR = enum.auto()  # str
    JOIN = enum.auto()  # Join
    NOT = enum.auto()  # None
    FUNCTION = enum.auto()  # None
    UNKNOWN = enum.auto()  # None
    IGNORED = enum.auto()  # None: looks, scenery, camera


MOTIONS = (MentionKind.VERB, MentionKind.CAUSE)
WAYS = (MentionKind.DIRECTION, MentionKind.FROM)
_NEAR = 6  # words from "one of" to the part
LOOSE = (MentionKind.UNKNOWN, MentionKind.IGNORED, MentionKind.INTENSITY, MentionKind.DEGREE)


@dataclass(frozen=True)
class Mention:
    """A phrase of the lexicon as it stands in the sentence.

    Attributes:
        kind, value: Its meaning.
        words: The words in the sentence.
        phrase: The entry of the lexicon.
        first: Index of its first token.
        form: The first token's text ("pushing"), to tell participles.
    """

    kind: MentionKind
    value: object
    words: str
    phrase: str
    first: int
    form: str

    @property
    def motion(self) -> Motion | None:
        """The motion of a verb or a cause; None for others."""
        return self.value if isinstance(self.value, Motion) else None


def empty(mention: Mention, why: str = "aside") -> Mention:
    """The mention without what it says; ``why`` stands for its phrase."""
    return replace(mention, kind=MentionKind.FUNCTION, value=None, phrase=why, form=why)


def ignore(mention: Mention) -> Mention:
    """The mention without what it says, and a word that is not known as one that does not matter."""
    strange = mention.kind in (MentionKind.UNKNOWN, MentionKind.IGNORED)
    return replace(mention, kind=MentionKind.IGNORED) if strange else empty(mention)


def read_as(mention: Mention, word: str) -> Mention:
    """The mention as the verb that a word is."""
    return replace(mention, kind=MentionKind.VERB, value=LEXICON.motions[word], phrase=word)


def get_phrase(mentions: list[Mention], index: int) -> str:
    """The phrase of a mention; empty past the ends."""
    return mentions[index].phrase if 0 <= index < len(mentions) else ""


def get_last_motion(mentions: list[Mention]) -> Motion | None:
    """The last motion among mentions."""
    return next((mention.motion for mention in reversed(mentions) if mention.motion), None)


def has_motion(mentions: list[Mention]) -> bool:
    """Return whether something is done in them."""
    return any(mention.kind in MOTIONS for mention in mentions)


def list_segments(mentions: list[Mention]) -> list[tuple[int, int]]:
    """Beginnings and ends of what stands between connectives."""
    joins = [index for index, mention in enumerate(mentions) if mention.kind is MentionKind.JOIN]
    return list(zip([0, *(index + 1 for index in joins)], [*joins, len(mentions)]))


class Reader:
    """One sentence and its tokens while its phrases are looked for.

    Attributes:
        sentence: The sentence.
        tokens, words: Its tokens, and the same as one string.
        names: Words for the object.
        parts: Phrases for parts that the object's file or a person names.
        used: Indices of the tokens that belong to a mention.
        mentions: Mentions found so far, in order of the first words.
    """

    def __init__(self, sentence: str, names: frozenset[str], parts: frozenset[tuple[str, ...]] = frozenset()):
        known = names | {word for phrase in parts for word in phrase}
        self.sentence, self.tokens = sentence, correct_spelling(tokenise(sentence), known)
        self.words = Words(self.tokens)
        self.names, self.parts = names, parts
        self.used: set[int] = set()
        self.mentions: list[Mention] = []

    def make_mention(self, kind: MentionKind, value: object, phrase: str, used: list[int]) -> Mention:
        """The mention of the tokens ``used``, which belong to it from now on."""
        self.used.update(used)
        words = self.sentence[self.tokens[used[0]].start : self.tokens[used[-1]].end]
        before = [self.get_text(at) for at in range(max(used[0] - _NEAR, 0), used[0])]
        if kind is MentionKind.PLACE and ("one", "of") in pairwise(before):  # "one of the robot's legs"
            words = f"one of its {words}"
        return Mention(kind, value, words, phrase, used[0], self.tokens[used[0]].text)

    def make_span(self, kind: MentionKind, value: object, phrase: str, at: int, behind: int) -> Mention:
        """The mention of the tokens from ``at`` to ``behind`` that are free."""
        free = [index for index in range(at, min(behind, len(self.tokens))) if index not in self.used]
        return self.make_mention(kind, value, phrase, free)

    def get_text(self, at: int) -> str:
        """The text of a token; empty past the ends."""
        return self.words.get(at)

    def is_after_determiner(self, at: int) -> bool:
        """Return whether an article or the like stands before it."""
        return self.get_text(at - 1) in get_set("determiners")

    def get_preposition(self, at: int) -> str:
        """The word before, past a determiner."""
        return self.get_text(at - 2 if self.is_after_determiner(at) else at - 1)

    def is_striking(self) -> bool:
        """Return whether the last motion is a blow."""
        motion = get_last_motion(self.mentions)
        return motion is not None and motion.effect is Effect.STRIKE
