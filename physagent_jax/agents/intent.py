"""Intent of a sentence: what it says, clause by clause, in words and numbers, never in vectors or frames.

Grammar and language models both write an `Intent`; one compiler (`agents.compiler`) turns it into a force field and
expectations. The words are those of the lexicon (`agents.lexicon`): a viewer's directions, names of motions and parts.
Each ``text`` holds the words in the sentence that say so.
"""

from __future__ import annotations

import enum
from typing import Annotated, Literal

from pydantic import Field

from physagent_jax.core.strict import Strict
from physagent_jax.motion.schema import Manner

Word = Annotated[str, Field(max_length=200)]
_MANY = Field(max_length=100_000)  # as many entries as a sentence of the longest kind has characters
Direction = Literal["left", "right", "up", "down", "toward", "away"]


class Relation(enum.StrEnum):
    """The relation of a direction word to the motion."""

    TO = "to"  # the object goes there: "to the left", "away from the viewer"
    FROM = "from"  # the cause comes from there: "hit from the right"
    ALONG = "along"  # a line: "stretch it along its height"
    ABOUT = "about"  # an axis of rotation: "about the vertical axis"
    IN = "in"  # a plane: "spin it horizontally"


class Way(Strict):
    """A direction word with its relation; several are added: "up" and "left" go up left.

    Attributes:
        relation: The relation to the motion.
        word: A direction (`Direction`); for lines and axes also "horizontal", "vertical", "depth", "lengthwise",
            "long axis", "x", "y", "z"; for planes "horizontal", "vertical", "diagonal"; or "both sides", "all sides",
            "outward", "inward"; or, relative to the clause before, "back", "same" or "other".
    """

    relation: Relation = Relation.TO
    word: Word
    text: Word = ""


class Part(Strict):
    """A part of the object.

    Attributes:
        word: A phrase of the lexicon: "head", "upper half", "left end".
        excluded: Whether the part is the one that is not meant: "all but the head".
    """

    word: Word
    excluded: bool = False
    text: Word = ""


class Quantity(Strict):
    """A number with its unit.

    Attributes:
        value: The number; at least 0.
        unit: "degrees", "lengths" (body lengths), "metres", "share" (of ``dimension``: 0.5 = half, 2 = twice), or
            "other" for what nothing here is measured in (newtons, pixels).
        dimension: Dimension of a share: "length", "height", "width", "depth", "size" or "volume"; "far" and "strength"
            compare with the clause before; "round" is a way along a circle; "" names none.
        relation: "by" so much, "to" so much, or "is": the quantity tells the change by itself ("doubles its height").
    """

    value: float = Field(ge=0, le=1e9)
    unit: Literal["degrees", "lengths", "metres", "share", "other"]
    dimension: Literal[
        "", "length", "height", "width", "depth", "size", "volume", "far", "strength", "round"
    ] = ""
    relation: Literal["", "by", "to", "is"] = ""
    text: Word = ""


class Duration(Strict):
    """A length of time, or a moment counted from the clip's start (negative: from its end).

    Attributes:
        value: In seconds, frames, or fractions of the whole clip.
    """

    value: float = Field(ge=-1e6, le=1e6)
    unit: Literal["seconds", "frames", "clip"] = "seconds"
    text: Word = ""


class Timing(Strict):
    """The time of a clause; None = the sentence does not say.

    Attributes:
        starts: The moment at which it begins.
        lasts: Its length.
        within: Whether ``lasts`` is the time in which all of it has happened ("within a second").
        overall: Whether ``lasts`` is that of all clauses so far ("left, then up, in a second").
    """

    starts: Duration | None = None
    lasts: Duration | None = None
    within: bool = False
    overall: bool = False


class Repetition(Strict):
    """The number of times a motion happens.

    Attributes:
        times: Number of strokes, or of swings there and back; None leaves it to the motion.
        often: Whether the sentence says "often" rather than how often.
        alternating: Whether it goes to and fro instead of again and again.
        first: Direction of the first swing, if it is named.
        in_turn: Whether several parts do it one after the other.
    """

    times: int | None = Field(default=None, ge=0, le=1_000_000)
    often: bool = False
    alternating: bool = False
    first: Direction | None = None
    in_turn: bool = False
    text: Word = ""


class Solid(Strict):
    """A wall or a block that the sentence names.

    Attributes:
        sides: Where it is, seen from the object; several are added; none = in the way of the motion.
        opposite: Where the second of two is; none = there is one.
        rebounds: Whether what meets it comes off it again.
    """

    kind: Literal["wall", "block"] = "wall"
    sides: tuple[Direction, ...] = ()
    opposite: tuple[Direction, ...] = ()
    rebounds: bool = False
    text: Word = ""


class Clause(Strict):
    """One thing that the sentence asks for.

    Attributes:
        motion: A motion of the lexicon, in its base form: "push", "twist", "let go"; also a noun that names a motion
            ("compression"). Empty if only a cause is named: "a gentle wind".
        cause: A noun that names what does it: "wind", "explosion", "gravity"; None = none is named.
        order: "then" follows the clause before in time; "together" happens at the same time as it; "and" leaves that
            to the two motions: together, unless they would cancel or one can only come after the other.
        ways: Directions, lines and axes.
        turning: Sense of a rotation, seen by the viewer or from ``seen_from``.
        seen_from: Side from which ``turning`` is meant.
        parts: Parts of the object that are acted on, or excepted.
        strength: Words for how strong it is, in their order: "very", "gently", "harder".
        quantities: Distances, angles and shares.
        timing: When it happens and for how long.
        repetitions: How often, and whether to and fro.
        solids: Walls and blocks that it meets.
        negated: Whether the sentence says that it does not happen.
        inherited: Whether the motion is understood from the clause before ("push it left, then right").
        stays: Whether the result is held ("and hold it there").
        manner: How it goes on, where the words tell another manner than the motion's own.
        pace: Whether it goes at one speed, or begins and ends at once.
        elsewhere: Whether the object ends at another place: "away", "aside", "off the table".
        pose: The side of it that points down as it begins to fall: "up" is upside down, "head" its front or its top.
        said: The words in the sentence that name the motion.
    """

    motion: Word
    cause: Word | None = None
    order: Literal["then", "together", "and"] = "then"
    ways: Annotated[tuple[Way, ...], _MANY] = ()
    turning: Literal["clockwise", "counterclockwise"] | None = None
    seen_from: Direction | None = None
    parts: Annotated[tuple[Part, ...], _MANY] = ()
    strength: Annotated[tuple[Word, ...], _MANY] = ()
    quantities: Annotated[tuple[Quantity, ...], _MANY] = ()
    timing: Timing = Timing()
    repetitions: Annotated[tuple[Repetition, ...], _MANY] = ()
    solids: Annotated[tuple[Solid, ...], _MANY] = ()
    negated: bool = False
    inherited: bool = False
    stays: bool = False
    manner: Manner = ""
    pace: Literal["", "even", "sudden"] = ""
    elsewhere: bool = False
    pose: Literal[
        "", "up", "down", "head", "toward", "behind", "away", "belly", "left", "right", "beside", "askew"
    ] = ""
    said: Word = ""
    text: Word = ""


class Held(Strict):
    """Words of the sentence about holding the object.

    Attributes:
        end: "base", "top", or "none" (free).
        described: Whether a word describes the object so ("potted") rather than asks for it ("hold the pot").
    """

    end: Literal["base", "top", "none"]
    described: bool = False
    text: Word = ""


class Surroundings(Strict):
    """Words of the sentence about gravity and ground; None = nothing.

    Attributes:
        gravity: "up" is reversed.
        solids: Walls and blocks that no motion is said to meet.
    """

    gravity: Literal["down", "up", "none"] | None = None
    ground: bool | None = None
    solids: Annotated[tuple[Solid, ...], _MANY] = ()
    text: Word = ""


class Intent(Strict):
    """Everything that a sentence says about one object.

    Attributes:
        clauses: Motions in the order in which they happen.
        held: What is held or free.
        surroundings: Gravity, ground, walls and blocks.
        materials: Words for what the object is made of: "jelly" in "a robot made of jelly".
        ignored: Words that do not bear on the motion: looks, scenery, camera, mood. No bar to success.
        unknown: Content words that are not understood and may bear on the motion.
        unknown_parts: Those of them that stand for a part of the object.
        doubts: Plain sentences about what was not understood and would change the motion. Like ``unknown``, they
            bar a motion from being called a success.
        notes: Assumptions made, in plain sentences.
    """

    clauses: Annotated[tuple[Clause, ...], _MANY] = ()
    held: Held | None = None
    surroundings: Surroundings = Surroundings()
    materials: Annotated[tuple[Word, ...], _MANY] = ()
    ignored: Annotated[tuple[Word, ...], _MANY] = ()
    unknown: Annotated[tuple[Word, ...], _MANY] = ()
    unknown_parts: Annotated[tuple[Word, ...], _MANY] = ()
    doubts: Annotated[tuple[Annotated[str, Field(max_length=1000)], ...], _MANY] = ()
    notes: Annotated[tuple[Annotated[str, Field(max_length=1000)], ...], _MANY] = ()
