"""The words of a clause with their meanings in the lexicon.

An intent may come from a grammar, which takes its words from the lexicon, or from a language model, which takes them
from anywhere: articles are ignored, inflected verbs are known, and a word that is not known is a doubt.
"""

from __future__ import annotations

import difflib
import enum
from dataclasses import dataclass, field

from physagent_jax.agents import intent
from physagent_jax.agents.lexicon import Motion, Names, Place, read_forms, read_lexicon

_IGNORED = (
    "to the ",
    "from the ",
    "toward the ",
    "towards the ",
    "the ",
    "a ",
    "an ",
    "its ",
    "to ",
    "from ",
)
_OPPOSITES = (("left", "right"), ("up", "down"), ("toward", "away"))
_BASE = frozenset(name for pair in _OPPOSITES for name in pair)
_NEAREST = 3
_ALIKE = 0.6  # similarity of spelling, 0 .. 1
_ENDS_AT = 2 / 3  # of the extent: where "the top" or "its left" begins
_NOT_LESS, _NOT_MORE = 0.8, 1.2  # factors of "not hard" and "not gently"


class WayKind(enum.Enum):
    """The kinds of ways."""

    TO = enum.auto()  # a direction
    FROM = enum.auto()  # where the cause comes from
    LINE = enum.auto()  # of a stretch, or axis of a turn
    PLANE = enum.auto()  # of a turn
    SIDES = enum.auto()  # several at once
    AGAIN = enum.auto()  # as before, or the other way


@dataclass(frozen=True)
class KnownWay:
    """A way with its meaning.

    Attributes:
        kind: Its kind.
        names: Directions that are added; for sides "both" or "all", for `WayKind.AGAIN` "same" or "other".
        phrase: The lexicon's phrase.
        text: The words in the sentence.
    """

    kind: WayKind
    names: Names
    phrase: str
    text: str


@dataclass(frozen=True)
class KnownPart:
    """A part with its place."""

    place: Place
    phrase: str
    text: str


@dataclass
class Meaning:
    """A clause with the meanings of its words.

    Attributes:
        clause: The clause.
        verb: What is done; None if only a cause is named.
        cause: What does it.
        phrase, cause_phrase: The lexicon's words for them.
        ways, parts, excluded: Ways, parts that are acted on, and parts that are not.
        doubts: Words that the lexicon has no meaning for, in sentences.
        stays: Whether the result is held.
    """

    clause: intent.Clause
    verb: Motion | None = None
    cause: Motion | None = None
    phrase: str = ""
    cause_phrase: str = ""
    ways: list[KnownWay] = field(default_factory=list)
    parts: list[KnownPart] = field(default_factory=list)
    excluded: list[KnownPart] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)
    stays: bool = False
    timing: intent.Timing = intent.Timing()

    @property
    def motion(self) -> Motion | None:
        """The motion of the verb, else of the cause; None if neither is known."""
        return self.verb or self.cause

    @property
    def words(self) -> str:
        """The words in the sentence that name the motion."""
        return self.clause.said or self.clause.motion or self.clause.cause or ""

    @property
    def text(self) -> str:
        """The clause's words in the sentence."""
        return self.clause.text or self.words

    def pick(self, *kinds: WayKind) -> list[KnownWay]:
        """Its ways of these kinds."""
        return [way for way in self.ways if way.kind in kinds]

    @property
    def bare(self) -> bool:
        """Whether nothing but its strength is told."""
        told = self.clause
        rest = told.quantities or told.repetitions or told.solids or told.turning or told.seen_from
        return not (self.ways or self.parts or self.excluded or rest or self.timing != intent.Timing())


def look_up(clause: intent.Clause) -> Meaning:
    """The meanings of a clause's words."""
    found = Meaning(clause, stays=clause.stays, timing=clause.timing)
    _look_up_motion(clause, found)
    for way in clause.ways:
        known = find_way(way)
        if known is None:
            found.doubts.append(f"The way '{way.word}' is not understood.")
        else:
            found.ways.append(known)
    for part in clause.parts:
        place = find_place(part.word)
        if place is None:
            found.doubts.append(f"The part '{part.word}' is not understood.")
        else:
            known_part = KnownPart(place, normalise(part.word), part.text or part.word)
            (found.excluded if part.excluded else found.parts).append(known_part)
    unknown = [word for word in clause.strength if find_strength(word) is None]
    found.doubts += [f"The strength '{word}' is not understood." for word in unknown]
    return found


def _look_up_motion(clause: intent.Clause, found: Meaning) -> None:
    lexicon = read_lexicon()
    found.phrase = _find_phrase(clause.motion, lexicon.motions)
    found.verb = lexicon.motions.get(found.phrase)
    if found.verb is None and (noun := _find_phrase(clause.motion, lexicon.causes)):
        found.cause, found.cause_phrase = lexicon.causes[noun], noun
    elif found.verb is None and clause.motion:
        found.doubts.append(f"The motion '{clause.motion}' is not understood.")
    if clause.cause and clause.cause != "gravity":
        noun = _find_phrase(clause.cause, lexicon.causes)
        verb = "" if noun else _find_phrase(clause.cause, lexicon.motions)
        if noun or verb:
            found.cause = lexicon.causes[noun] if noun else lexicon.motions[verb]
            found.cause_phrase = noun or verb
        elif found.motion is None:
            found.doubts.append(f"The cause '{clause.cause}' is not understood.")


def _find_phrase(word: str, table: dict[str, Motion]) -> str:
    """The phrase of ``table`` for a verb or noun in whatever form; empty if there is none."""
    text = normalise(word)
    head, _, rest = text.partition(" ")
    lemma = f"{read_forms().get(head, head)} {rest}".strip()
    return next((phrase for phrase in (text, lemma, text.removesuffix("s")) if phrase in table), "")


def normalise(word: str) -> str:
    """A word in lower case, with single spaces for hyphens and without articles."""
    text = " ".join(word.lower().replace("-", " ").replace("_", " ").split())
    for start in ("the ", "a ", "an ", "its "):
        text = text.removeprefix(start)
    return text


def find_way(way: intent.Way) -> KnownWay | None:
    """The way that a direction word with its relation is; None if the word is not known."""
    lexicon, relation = read_lexicon(), way.relation
    text = normalise(way.word)
    bare = next((text.removeprefix(start) for start in _IGNORED if text.startswith(start)), text)

    def make(kind: WayKind, names: Names) -> KnownWay:
        return KnownWay(kind, names, text, way.text or way.word)

    for said in (text, bare):
        if said in lexicon.reversals or said in ("same", "other", "opposite"):
            names = ("same",) if lexicon.reversals.get(said, said) == "same" else ("other",)
            return make(WayKind.AGAIN, names)
        if said in lexicon.sides:
            return make(WayKind.SIDES, (lexicon.sides[said],))
        line, plane = lexicon.axes.get(said), lexicon.planes.get(said) or lexicon.planes.get(said + "ly")
        named = _find_directions(said)
        if relation is intent.Relation.IN and (names := plane or line or named):
            return make(WayKind.PLANE, names)
        if relation in (intent.Relation.ALONG, intent.Relation.ABOUT) and (names := line or named or plane):
            return make(WayKind.LINE, names)
        if named:
            return make(WayKind.FROM if relation is intent.Relation.FROM else WayKind.TO, named)
        if line or said in ("x", "y", "z"):
            return make(WayKind.LINE, line or (said,))
        if plane:
            return make(WayKind.PLANE, plane)
    return None


def _find_directions(text: str) -> Names:
    """Names of a phrase of directions, or of several bare ones: "up left"; empty if there are none."""
    lexicon = read_lexicon()
    if found := lexicon.directions.get(text) or lexicon.ends.get(text) or lexicon.part_adjectives.get(text):
        return found
    names: Names = ()
    for word in text.replace(" and ", " ").split():
        found = (word,) if word in _BASE else lexicon.directions.get(word)
        if found is None:
            return ()
        names += found
    cancelling = any(one in names and other in names for one, other in _OPPOSITES)
    return () if cancelling else names


def find_place(word: str) -> Place | None:
    """The place of a part: a noun, a side with a noun ("upper half"), or a side alone ("left")."""
    lexicon = read_lexicon()
    text = normalise(word)
    if place := lexicon.parts.get(text) or lexicon.parts.get(text.removesuffix("s")):
        return place
    side, _, noun = text.rpartition(" ")
    start = lexicon.part_nouns.get(noun) or lexicon.part_nouns.get(noun.removesuffix("s"))
    if side and start is not None and (names := _find_directions(side)):
        return Place(names, start)
    if names := _find_directions(text):
        return Place(names, _ENDS_AT)
    return None


def find_strength(word: str) -> tuple[str, float] | None:
    """("degree", "absolute" or "relative", factor) of a word for strength."""
    lexicon = read_lexicon()
    text = " ".join(word.lower().split())
    if text.startswith("not "):
        told = find_strength(text.removeprefix("not "))
        return told and ("absolute", _NOT_LESS if told[1] > 1 else _NOT_MORE)
    tables = {
        "degree": lexicon.degrees,
        "absolute": lexicon.intensities,
        "relative": lexicon.comparatives,
    }
    found = (
        (kind, table[said])
        for said in (text, normalise(text))
        for kind, table in tables.items()
        if said in table
    )
    return next(found, None)


def suggest_motions(word: str) -> list[str]:
    """The known motions that are spelled most like a word."""
    lexicon = read_lexicon()
    known = [phrase for phrase in (*lexicon.motions, *lexicon.causes) if "~" not in phrase]
    return difflib.get_close_matches(normalise(word), known, _NEAREST, _ALIKE)
