"""Types of the lexicon: what its words mean."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Literal

from physagent_jax.motion.schema import SeenManner

Names = tuple[str, ...]
"""Names of directions (`motion.schema.DirectionTable`); several are added as vectors."""

Side = Literal["up", "down", "head", "toward", "behind", "away", "belly", "left", "right", "beside", "askew"]
"""A side of the object that points down (`motion.attitudes`)."""

OPPOSITES = (("left", "right"), ("up", "down"), ("toward", "away"))
"""Names of directions that cancel."""


class Effect(enum.Enum):
    """The ways in which a motion acts on the object; the compiler has one function for each."""

    PUSH = "push"  # steady force along a direction
    LEAN = "lean"  # the upper end goes along a direction
    SWAY = "sway"  # to and fro
    SCALE = "scale"  # stretch or squeeze along one axis
    SWELL = "swell"  # stretch or squeeze along all axes
    STRIKE = "strike"  # sudden velocity along a direction
    BURST = "burst"  # sudden outward force
    TURN = "turn"  # rotation about an axis
    ROLL = "roll"  # rotation with travel
    FALL = "fall"  # gravity
    TOPPLE = "topple"  # gravity and a lean
    JUMP = "jump"  # a leap against gravity
    HOLD = "hold"  # something is held fixed
    RELEASE = "release"  # what acted before stops, the object comes back
    STILL = "still"  # nothing moves


HOLDABLE = (Effect.PUSH, Effect.LEAN, Effect.SCALE, Effect.SWELL, Effect.TURN)
"""Effects whose result can be held."""


@dataclass(frozen=True)
class Motion:
    """The meaning of a verb, or of a noun that names a cause.

    Attributes:
        effect: The way in which it acts.
        strength: Factor on the magnitude that the word itself carries ("tap" is weak, "smash" is not).
        direction: The direction (or axis) assumed if the sentence names none; None = left, the most
            visible one, with a note.
        sign: +1 stretches, -1 squeezes.
        pulls: Whether the cause stands where the object goes: "pulled from the left" moves left.
        draws: Whether a part goes out of the rest, along itself.
        hauls: Whether what it takes a told way leaves its place, as what slides or is carried does.
        gravity: Whether gravity acts with it (a thrown thing comes down).
        strokes: Number of blows, unless the sentence counts.
        cycles: Number of swings there and back, unless the sentence counts.
        brief: Whether the cause lasts only a part of its time ("gust").
        generic: Whether it adds nothing to a more telling verb beside it: "a kick *sends* it *flying*",
            "squash it *flat*", "*stands* swaying".
        wind: Whether it is a cause that pushes whatever verb it "does" ("the wind hits the plant").
        wrings: Whether one end turns against the other, unless the sentence names a part.
        holds: The end that a HOLD verb or adjective fixes unless the sentence names one.
        bound: Whether ``direction`` is part of what it means: nothing is lifted downwards.
        angle: Angle by which it turns, unless the sentence says [degrees]; 0 = no certain one.
        tumbles: Whether a direction is where the top of a turn goes.
        leaps: Whether what stands leaps for it.
        picture: Whether a turn's clockwise is meant in the picture plane, not as seen from above.
        lands: Whether it is how a fall ends: told after a fall, it tells of the same one.
        floats: Whether it is at rest where there is no gravity.
        bounces: Whether it comes up again.
        coasts: Whether it goes on by itself unless a way is told.
        by: What alone does it: what is limp, a part, or a whole; empty = anything.
        topples: Whether what stands falls over if it does so.
        springs: Whether it comes back as a spring does.
        lets_go: Whether what was held falls, if nothing else was done to it.
        gives: Whether the matter itself gives way: to what acted before, else to its weight.
        manner: The manner in which it goes on (`motion.schema.SeenManner`).
        alone: The motion that it is where nothing was done before; empty = none.
        quick: Whether it is over in an instant.
        pose: The side that points down as it falls; empty = none in particular.
        taps: Whether it is a blow to what is soft.
        pokes: Whether a finger or a fist does it, which goes into what is soft.
        palm: Whether an open hand does, which makes it quiver.
        steps: Whether it goes on feet: what has wheels rolls instead.
        puts_back: Whether it ends where it was before.
        after: The verb for what is done to it first: what is screwed off is turned.
        loose: Whether its angle is only about so large.
        jiggles: Whether any change of place, tilt or shape that comes and goes is one.
        skill: Name of the skill that it stands for; None = what its effect is compiled to.
    """

    effect: Effect
    strength: float = 1.0
    direction: str | None = None
    sign: int = 1
    pulls: bool = False
    draws: bool = False
    hauls: bool = False
    gravity: bool = False
    cycles: int = 2
    strokes: int = 1
    brief: bool = False
    generic: bool = False
    wind: bool = False
    wrings: bool = False
    holds: Literal["base", "top"] = "base"
    bound: bool = False
    angle: float = 0.0
    tumbles: bool = False
    leaps: bool = False
    picture: bool = False
    lands: bool = False
    floats: bool = False
    bounces: bool = False
    coasts: bool = False
    by: Literal["", "limp", "part", "whole"] = ""
    topples: bool = False
    springs: bool = False
    lets_go: bool = False
    gives: bool = False
    manner: SeenManner = ""
    alone: str = ""
    quick: bool = False
    pose: Side | Literal[""] = ""
    taps: bool = False
    pokes: bool = False
    palm: bool = False
    steps: bool = False
    puts_back: bool = False
    after: str = ""
    loose: bool = False
    jiggles: bool = False
    skill: str | None = None

    @property
    def touches(self) -> bool:
        """Return whether a finger or a hand does it, whoever's it is."""
        pushes = self.effect is Effect.PUSH and not (self.wind or self.pulls or self.gravity or self.manner)
        presses = self.effect is Effect.SCALE and self.sign < 0 and not self.gives  # "presses against it"
        return any((pushes, presses, self.pokes, self.taps, self.palm))

    @property
    def drops(self) -> bool:
        """Return whether it is a plain fall."""
        return self.effect is Effect.FALL and not (self.topples or self.lands or self.gives or self.bounces)

    @property
    def wobbles(self) -> bool:
        """Return whether what is soft only wobbles: it is tapped or shaken."""
        if self.pokes:
            return True
        light = self.effect is Effect.STRIKE and self.strength < 1.0 and not self.gravity
        return self.effect is Effect.SWAY or self.taps or light


def is_end(before: Motion, after: Motion) -> bool:
    """Return whether the second motion is how the first one ends: it shakes until it topples, it swells and bursts."""
    falls = after.effect is Effect.TOPPLE or after.topples
    turns = before.effect in (Effect.SWAY, Effect.TURN, Effect.ROLL)
    tips = before.effect is Effect.SWAY and after.effect is Effect.TURN and after.angle > 0
    bursts = after.effect is Effect.BURST and before.effect in (Effect.SWELL, Effect.SCALE)
    return falls and turns or tips or bursts


class Join(enum.Enum):
    """The relation of a clause to the one before it."""

    THEN = "then"  # follows in time
    COMMA = "comma"  # follows if a verb comes, else continues the clause
    AND = "and"  # at the same time
    WHILE = "while"  # at the same time, whatever stands between
    RESULT = "result"  # says what the clause before brings about
    BUT = "but"  # contrasts with a negated clause
    BEFORE = "before"
    AFTER = "after"


@dataclass(frozen=True)
class Repeat:
    """The number of repetitions, and whether the direction alternates.

    Attributes:
        count: Number of cycles or repetitions; None leaves the motion's own.
        alternate: Whether it goes to and fro instead of again and again.
        names: The direction of the first swing, if the phrase names it.
        vague: Whether it says "often", not how often.
        in_turn: Whether several parts do it one after the other.
    """

    count: int | None = None
    alternate: bool = False
    names: Names = ()
    vague: bool = False
    in_turn: bool = False


@dataclass(frozen=True)
class Place:
    """A part of the object.

    Attributes:
        names: The direction in which it lies from the middle; empty = the middle band.
        start: Fraction of the extent along that direction at which it begins.
        role: Role of a part of the brief that the word means first; empty = it means a place only.
    """

    names: Names = ()
    start: float = 0.5
    role: str = ""


NAMED = Place(role="named")
"""The place of a part that the object's file or a person names."""


@dataclass(frozen=True)
class Moment:
    """A fixed phrase of time, in fractions of the clip; None leaves it to the sequence.

    Attributes:
        starts: Its beginning.
        lasts: Its length.
    """

    starts: float | None = None
    lasts: float | None = None


@dataclass(frozen=True)
class Lexicon:
    """All tables of words, by phrase; each is a section of a YAML file, whose comments say what its words are.

    Motions are verbs (with adjectives of results), causes are nouns. Ways are names of directions; the senses of a
    rotation are -1 (clockwise) and +1; strengths are factors on the magnitude; the start of a part is a fraction of
    the extent.
    """

    motions: dict[str, Motion]
    causes: dict[str, Motion]
    irregular: dict[str, str]
    nouns: frozenset[str]
    directions: dict[str, Names]
    ends: dict[str, Names]
    axes: dict[str, Names]
    planes: dict[str, Names]
    own_ways: dict[str, Names]
    sides: dict[str, Literal["both", "all"]]
    senses: dict[str, int]
    views: dict[str, Names]
    reversals: dict[str, Literal["other", "same"]]
    poses: dict[str, Side]
    addressees: frozenset[str]
    locations: frozenset[str]
    intensities: dict[str, float]
    degrees: dict[str, float]
    comparatives: dict[str, float]
    manners: frozenset[str]
    paces: dict[str, Literal["even", "sudden"]]
    numbers: dict[str, float]
    fractions: dict[str, float]
    repeats: dict[str, Repeat]
    moments: dict[str, Moment]
    units: dict[str, Literal["second", "millisecond", "frame"]]
    clip_parts: dict[str, float]
    parts: dict[str, Place]
    part_nouns: dict[str, float]
    part_adjectives: dict[str, Names]
    fronts: frozenset[str]
    one_of_many: frozenset[str]
    unplaced: frozenset[str]
    wheeled: frozenset[str]
    gravity: dict[str, Literal["down", "up", "none"]]
    anchors: dict[str, Literal["base", "top", "none"]]
    obstacles: dict[str, Literal["wall", "block"]]
    ground: frozenset[str]
    grounding: frozenset[str]
    scene_nouns: frozenset[str]
    joins: dict[str, Join]
    negations: frozenset[str]
    exceptions: frozenset[str]
    whole: frozenset[str]
    agents: frozenset[str]
    moods: frozenset[str]
    phrases: frozenset[str]
    words: frozenset[str]
