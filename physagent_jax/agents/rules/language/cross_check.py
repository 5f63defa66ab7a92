"""A second, simpler reading of a sentence, held against what the grammar made of it.

The grammar takes a sentence apart by many rules; where two of them meet, something may get lost that nobody foresaw.
Here words are only collected, whatever their order: ways, parts, sizes, verbs, what is held, let go or in the way.
Where none of the motions that were read has what such a word must have brought about, the sentence says more than was
read. `coherence` holds the motions against each other.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from physagent_jax.agents.rules.language.events import Event, is_way_assumed
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import NEGATIONS
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.tokens import Token
from physagent_jax.agents.rules.language.verbs import Effect, Verb
from physagent_jax.agents.schema import DirectionTable, ExpectedMotion, MotionKind
from physagent_jax.agents.vectors import add, dot
from physagent_jax.core.strict import Vector

_ALONG = 0.3  # cosine from which a motion goes a way at least in part
_AXES = (
    MotionKind.STRETCH,
    MotionKind.SQUEEZE,
    MotionKind.SWAY,
    MotionKind.ROTATE,
)  # either sense may be meant
_SHAPES = (MotionKind.STRETCH, MotionKind.SQUEEZE)
_GOING = (Effect.PUSH, Effect.STRIKE, Effect.LEAN, Effect.ROLL)
# Kinds of motion that a verb may bring about, whatever stands around it.
_BROUGHT = {
    Effect.SWAY: (MotionKind.SWAY,),
    Effect.SCALE: _SHAPES,
    Effect.SWELL: _SHAPES,
    Effect.TURN: (MotionKind.ROTATE,),
    Effect.LEAN: (MotionKind.MOVE, MotionKind.ROTATE, MotionKind.SWAY),
    Effect.FALL: (MotionKind.FALL, MotionKind.MOVE),
    Effect.TOPPLE: (MotionKind.FALL, MotionKind.ROTATE),
    Effect.JUMP: (MotionKind.MOVE, MotionKind.SWAY),
}
_NOT_ALWAYS = frozenset(
    {"turn", "bounce", "screw"}
)  # "a quarter turn", "bounce it up and down", "screwed to"
_FIXING = frozenset({"clamp", "fix", "anchor", "pin", "bolt", "nail", "glue", "root"})
_LETTING_GO = re.compile(r"\b(releas(e|es|ed|ing)|lets? go)\b")
# What is denied, supposed or compared did not happen: nothing need come of it.
_DENYING = NEGATIONS | frozenset(
    "nobody nothing instead rather hardly stop before unless if than prevent prevents keep keeps".split()
)
# Words that lead somewhere; behind them stands where to or where from.
_LEADING = frozenset(
    "toward towards at near nearer against past out where beside over off into onto from behind between among "
    "beyond direction way".split()
)
_RESTING = frozenset({"nothing", "nobody", "no", "still", "motionless", "rests", "stays"})
_PART_ADJECTIVES = frozenset("upper lower uppermost lowermost topmost bottommost hind rear".split())
_WALLS = {"wall": 1, "walls": 2, "obstacle": 1}
_BODIES = frozenset(
    "ceiling block blocks barrier floor roof box pillar post tree table ground hedge fence".split()
)
_ALL = re.compile(r"\b(whole|entire)\b(?! (time|clip|video|way|shot|scene|length))")
_FACTOR = r"(half|third|quarter|fifth|twice|thrice|double|triple|times|percent)"
_DIMENSION = r"(height|length|width|size|depth|thickness|volume)"
_AS_TALL = re.compile(_FACTOR + r" as (tall|high|long|wide|big|large|thick|flat|short|small|deep|broad)\b")
_TO_HEIGHT = re.compile(
    r"\b(to|at) (\S+ ){0,5}?" + _FACTOR + r" (of )?(its|the|his|her) (own |original |current )?" + _DIMENSION
)
_BY_HEIGHT = re.compile(r"\b(by|for) (\S+ ){0,4}?" + _FACTOR)


@dataclass(frozen=True)
class Outcome:
    """The reading of a sentence, as far as words are held against it.

    Attributes:
        motions, events: What is to be seen, and what brings it about.
        anchor: What is held: "base", "top", "none"; None = nothing was said.
        obstacles: Where walls and blocks stand, seen from the object.
        directions: The viewer's directions.
        reversed_gravity: Whether what falls goes up.
    """

    motions: Sequence[ExpectedMotion]
    events: Sequence[Event]
    anchor: str | None
    obstacles: Sequence[Vector]
    directions: DirectionTable
    reversed_gravity: bool = False


def find_disagreements(
    tokens: Sequence[Token], mentions: Sequence[Mention], names: frozenset[str], outcome: Outcome
) -> list[str]:
    """Plain sentences about words of which nothing that was read bears a trace."""
    words = [token.text for token in tokens]
    text = " ".join(words)
    doubts = _find_untold_ways(mentions, outcome) + _find_sizes(text, outcome)
    doubts += _find_counts(words, outcome) + _find_wholes(text, outcome)
    if not _DENYING & set(words):
        doubts += _find_lost_ways(mentions, outcome) + _find_lost_verbs(mentions, names, outcome)
        doubts += _find_lost_holds(tokens, names, text, outcome)
    doubts += _find_spared(words, outcome) + _find_turned_sides(mentions, outcome)
    doubts += _find_lost_parts(words, outcome) + _find_walls(words, names, outcome)
    return list(dict.fromkeys(doubts))


def _find_lost_ways(mentions: Sequence[Mention], outcome: Outcome) -> list[str]:
    """Ways that are told without "from" and that no motion, part or obstacle has."""
    if any(motion.kind in _AXES for motion in outcome.motions):
        return []
    found = [_to_vector(m.direction) for m in outcome.motions if m.direction is not None]
    found += [_to_vector(m.part) for m in outcome.motions if m.part is not None] + list(outcome.obstacles)
    table, doubts = outcome.directions, []
    falls = any(m.kind is MotionKind.FALL for m in outcome.motions)
    for before, mention in zip([None, *mentions], mentions):
        if mention.kind is not MentionKind.DIRECTION or mention.words.lower() == "back":
            continue
        if before is not None and isinstance(before.value, Verb) and before.value.effect is Effect.STILL:
            continue  # "as someone stands up"
        names = mention.value if isinstance(mention.value, tuple) else ()
        if not names or not all(name in DirectionTable.model_fields for name in names):
            continue
        way = add(getattr(table, name) for name in names)
        upright = abs(dot(way, table.up)) > _ALONG
        if upright and (falls or outcome.anchor in ("base", "top")):
            continue
        if not any(dot(way, each) > _ALONG for each in found):
            doubts.append(f"No motion that was read goes '{mention.words}'.")
    return doubts


def _find_untold_ways(mentions: Sequence[Mention], outcome: Outcome) -> list[str]:
    """Words that lead somewhere and were not read, beside a motion whose way had to be assumed."""
    assumed = [
        event
        for event in outcome.events
        if event.effect in _GOING and not event.verb.bound and is_way_assumed(event)
    ]
    passing = (
        {"over"} if any(event.wind for event in assumed) else set()
    )  # whichever way it goes over the object
    leading = [m.words for m in mentions if m.kind is MentionKind.FUNCTION and m.form in _LEADING - passing]
    if not assumed or not leading:
        return []
    return [f"Which way '{assumed[0].phrase}' goes may be told by '{leading[0]}', which is not understood."]


def _find_sizes(text: str, outcome: Outcome) -> list[str]:
    """The size that something is brought to, where nothing that was read changes its shape."""
    if any(motion.kind in _SHAPES for motion in outcome.motions):
        return []
    said = _AS_TALL.search(text) or (None if _BY_HEIGHT.search(text) else _TO_HEIGHT.search(text))
    return [f"What gets the size '{said.group()}' is not understood."] if said else []


def _find_counts(words: Sequence[str], outcome: Outcome) -> list[str]:
    """Numbers with a fraction that were taken for a count."""
    broken = [word for word in words if re.fullmatch(r"\d+\.\d*[1-9]\d*", word)]
    return [
        f"'{word}' is no count."
        for word in broken
        if any(m.repeats > 1 and m.repeats == int(float(word)) for m in outcome.motions)
    ]


def _find_wholes(text: str, outcome: Outcome) -> list[str]:
    """Find statements about the whole, where a part was read."""
    said = _ALL.search(text)
    parted = any(m.partial and not m.excludes_part for m in outcome.motions) or outcome.anchor == "top"
    return (
        [f"Whether a part or the '{said.group()}' object is meant is not understood."]
        if said and parted
        else []
    )


def _find_lost_verbs(mentions: Sequence[Mention], names: frozenset[str], outcome: Outcome) -> list[str]:
    """Verbs that bring about a kind of motion of which none was read."""
    kinds = {motion.kind for motion in outcome.motions}
    doubts = []
    for before, mention in zip([None, *mentions], mentions):
        verb = mention.value if mention.kind is MentionKind.VERB else None
        named = mention.form in names or before is not None and before.form in DETERMINERS | {"of"}
        if not isinstance(verb, Verb) or verb.generic or named or mention.phrase.split()[0] in _NOT_ALWAYS:
            continue
        lost = verb.effect in _BROUGHT and not kinds.intersection(_BROUGHT[verb.effect])
        if lost or verb.effect is Effect.PUSH and verb.bound and not _is_raised(verb.direction, outcome):
            doubts.append(f"No motion that was read is what '{mention.words}' says.")
    return doubts


def _is_raised(name: str | None, outcome: Outcome) -> bool:
    """Return whether something goes the way up or down that a verb means, or may do so as a part."""
    way = getattr(outcome.directions, name or "up")
    falls = dot(way, outcome.directions.up) < 0 or outcome.reversed_gravity
    return any(
        motion.partial
        or motion.kind is MotionKind.FALL
        and falls
        or motion.direction is not None
        and dot(_to_vector(motion.direction), way) > _ALONG
        for motion in outcome.motions
    )


def _find_lost_holds(
    tokens: Sequence[Token], names: frozenset[str], text: str, outcome: Outcome
) -> list[str]:
    """Words for fixing where nothing is held, and for letting go where nothing is let go."""
    doubts = []
    fixing = [token.text for token in tokens if token.lemma in _FIXING and token.text not in names]
    if fixing and outcome.anchor not in ("base", "top"):
        doubts.append(f"What is '{fixing[0]}' is not understood.")
    letting = _LETTING_GO.search(text)
    kinds = [motion.kind for motion in outcome.motions]
    freed = MotionKind.FALL in kinds or any(motion.released for motion in outcome.motions)
    if letting and kinds and not freed and kinds[0] is not MotionKind.STILL:
        doubts.append(f"What is let go ('{letting.group()}') is not understood.")
    return doubts


def _find_spared(words: Sequence[str], outcome: Outcome) -> list[str]:
    """A part that is excepted from rest, read as excepted from motion: "nothing may move except the head"."""
    spared = [m for m in outcome.motions if m.excludes_part and m.kind is not MotionKind.STILL]
    resting = _RESTING & set(words)
    return (
        [f"Whether '{spared[0].words}' is of the part or of the rest is not understood."]
        if spared and resting
        else []
    )


def _find_turned_sides(mentions: Sequence[Mention], outcome: Outcome) -> list[str]:
    """A side that is turned somewhere is the whole that turns: "turn its right side toward the camera"."""
    up = outcome.directions.up
    sides = [
        m
        for m in outcome.motions
        if m.kind is MotionKind.ROTATE and m.part is not None and abs(dot(_to_vector(m.part), up)) < _ALONG
    ]
    told = [m.words for m in mentions if m.kind is MentionKind.DIRECTION]
    return [f"How a side turns '{told[0]}' is not understood."] if sides and told else []


def _find_lost_parts(words: Sequence[str], outcome: Outcome) -> list[str]:
    """Parts by their place, where all that was read is of the whole."""
    if any(m.partial for m in outcome.motions) or outcome.anchor in ("base", "top") or outcome.obstacles:
        return []
    return [
        f"What '{word} {after}' does is not understood."
        for before, word, after in zip(words, words[1:], words[2:])
        if word in _PART_ADJECTIVES and before in DETERMINERS and after.isalpha()
    ]


def _find_walls(words: Sequence[str], names: frozenset[str], outcome: Outcome) -> list[str]:
    """More or fewer walls than the words for them."""
    told = sum(_WALLS.get(word, 0) for word in words if word not in names)
    denied = bool(_DENYING & set(words))
    read = len(outcome.obstacles)
    if told and not read and not denied:
        return ["Where the wall is, is not understood."]
    extra = read > max(told, 1) or read and not told and not _BODIES & set(words)
    if extra or read and re.search(r"\b(no|without) (a |any )?(walls?|obstacles?)\b", " ".join(words)):
        return ["What stands in the way is not understood."]
    return []


def _to_vector(values: Sequence[float]) -> Vector:
    return (values[0], values[1], values[2])
