"""Mentions of a sentence: a phrase of the lexicon, its kind and its value."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace


class MentionKind(enum.Enum):
    """The kind of a mention; in brackets the type of its value."""

    VERB = enum.auto()  # Verb
    CAUSE = enum.auto()  # Verb
    DIRECTION = enum.auto()  # names
    FROM = enum.auto()  # names: where the cause comes from
    AXIS = enum.auto()  # names
    PLANE = enum.auto()  # names
    SIDES = enum.auto()  # bool: all around
    SENSE = enum.auto()  # int
    VIEW = enum.auto()  # names
    INTENSITY = enum.auto()  # float
    DEGREE = enum.auto()  # float
    COMPARATIVE = enum.auto()  # float
    EVEN = enum.auto()  # None: at one speed
    REPEAT = enum.auto()  # Repeat
    PLACE = enum.auto()  # Place
    EXCLUDED = enum.auto()  # Place that is not meant
    EXCEPT = enum.auto()  # None: what is not meant is not understood
    TIME = enum.auto()  # TimeSpan
    QUANTITY = enum.auto()  # Quantity
    REVERSAL = enum.auto()  # None: the other way; "same": the same
    ORDINAL = enum.auto()  # int: "the second time"
    SOLID = enum.auto()  # Solid
    GRAVITY = enum.auto()  # str: where to
    ANCHOR = enum.auto()  # str
    JOIN = enum.auto()  # Join
    NOT = enum.auto()  # None
    FUNCTION = enum.auto()  # None
    UNKNOWN = enum.auto()  # None


@dataclass(frozen=True)
class Mention:
    """A phrase of the lexicon as it stands in the prompt.

    Attributes:
        kind, value: What it says.
        words: The words in the prompt.
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


def empty(mention: Mention, why: str = "aside") -> Mention:
    """The mention without what it says; ``why`` stands for its phrase."""
    return replace(mention, kind=MentionKind.FUNCTION, value=None, phrase=why, form=why)
