"""Sentences of the corpus, and the notation of what a person understands by them.

The corpus is a folder of YAML: ``corpus/SPLIT/AUTHOR.yaml`` has an author's sentences of a split, each with its text,
its object, its group, its readings, and readings that second readers ``added``. Any reading is right.

A reading is ``refused`` (no motion may be made of it), ``unsure`` (something that matters is outside the grammar, and
the reply must say so) or motions, then the surroundings behind bars:

    move left slight ; hit up & ?fall | gravity none | wall left | anchor base

``gravity`` is ``none``, ``down`` or ``up`` (or ``reversed``, the same). ``;`` is "then", ``&`` "at the same time",
``?`` marks what may be left out. A motion begins with its kind: one of
`MotionKind`, ``hit`` (a sudden move) or ``lean`` (a move along the direction, or the turn that brings the top there).
Its direction follows in the viewer's words (an axis for ``rotate``, by the right-hand rule): ``up+left``, ``+-up``
(either sense), ``*`` (any) or ``-`` (all directions at once). Then, in any order: ``slight``, ``strong`` or ``any``
(strength; else plain), ``=90deg``, ``=2x``, ``=0.5L``, ``=2m`` (a quantity), ``x3`` or ``x*`` (how often), ``on up``,
``on mid``, ``on any``, ``except up`` (the part), ``for=0.5``, ``at=0.5-1.5``, ``from=1`` (when the cause acts [s]),
``stays``, ``released``, ``first`` (a sway's first way counts), ``noted`` (an assumption must be said).

A ``?fall`` after a ``lean`` may as well begin with it: nobody sees where toppling ends and falling begins.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace
from pathlib import Path

import yaml

SPLITS = ("development", "test", "adversarial")
"""Folders: open sentences; those held back from rules; and hard ones, which are no sample and count for no total."""
AUTHORS = (
    "first",
    "second",
    "third",
    "fourth",
    "fifth",
    "sixth",
    "seventh",
    "eighth",
    "ninth",
    "maintainers",
)
CORPUS = Path(__file__).with_name("corpus")
FILES = tuple(
    f"{split}/{author}"
    for author in AUTHORS
    for split in SPLITS
    if (CORPUS / split / f"{author}.yaml").is_file()
)
UNITS = {"deg": "degrees", "x": "factor", "L": "lengths", "m": "metres"}


@dataclass(frozen=True)
class Clause:
    """A motion that a person expects; the fields are named after the notation."""

    kind: str
    direction: str = "*"
    strength: str = "plain"
    amount: tuple[float, str] | None = None
    repeats: str = ""
    part: str = ""
    excluded: bool = False
    span: tuple[float | None, float | None, float | None] = (None, None, None)  # length, start, end [s]
    flags: frozenset[str] = frozenset()
    optional: bool = False


@dataclass(frozen=True)
class Reading:
    """One way to understand a sentence.

    Attributes:
        answer: "motion", "unsure" or "refused".
        groups: Motions in their order; those of a group happen together.
        gravity, anchor: What is said of them; empty = nothing.
        obstacles: (kind, direction).
    """

    answer: str
    groups: tuple[tuple[Clause, ...], ...] = ()
    gravity: str = ""
    anchor: str = ""
    obstacles: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Sentence:
    """A sentence of the corpus.

    Attributes:
        text, object_name, group: The sentence, what it is about and which kind of sentence it is.
        expected: The readings as they are written.
        readings: The same, parsed; what may be left out is there in one and missing in another.
        author: Who wrote it, one of `AUTHORS`.
        split: One of `SPLITS`. It was drawn by the text's hash, and is written down so that no edit moves a sentence.
    """

    text: str
    object_name: str
    group: str
    expected: str
    readings: tuple[Reading, ...] = field(repr=False, default=())
    author: str = "first"
    split: str = "development"


def read_split(split: str) -> list[Sentence]:
    """All sentences of one of `SPLITS`."""
    return [each for file in FILES if file.startswith(f"{split}/") for each in read_sentences(file)]


def read_sentences(file: str) -> list[Sentence]:
    """All sentences of one of `FILES`."""
    split, author = file.split("/")
    rows = yaml.load((CORPUS / f"{file}.yaml").read_text(encoding="utf-8"), yaml.CSafeLoader)  # noqa: S506
    return [_make_sentence(author=author, split=split, **row) for row in rows]


def _make_sentence(text, object, group, readings, added=(), **origin) -> Sentence:
    written = (*readings, *added)
    parsed = tuple(each for reading in written for each in expand_options(parse_reading(reading)))
    return Sentence(text, object, group, " || ".join(written), parsed, **origin)


def parse_reading(text: str) -> Reading:
    if text in ("refused", "unsure"):
        return Reading(text)
    motions, *around = (part.strip() for part in text.split(" | "))
    groups = tuple(tuple(_parse_clause(each) for each in step.split("&")) for step in motions.split(";"))
    reading = Reading("motion", groups)
    for what in around:
        kind, value = what.split()
        if kind in ("gravity", "anchor"):
            value = {"reversed": "up"}.get(value, value)
            reading = replace(reading, **{kind: value})
        elif kind in ("wall", "block"):
            reading = replace(reading, obstacles=(*reading.obstacles, (kind, value)))
        else:
            raise ValueError(f"no such thing in the surroundings: {what!r}")
    return reading


def _parse_clause(text: str) -> Clause:
    words = text.split()
    clause = Clause(words[0].lstrip("?"), optional=words[0].startswith("?"))
    if clause.kind not in ("move", "hit", "lean", "sway", "fall", "stretch", "squeeze", "rotate", "still"):
        raise ValueError(f"no such motion: {text!r}")
    rest = iter(words[1:])
    if clause.kind not in ("fall", "still"):
        clause = replace(clause, direction=next(rest))
    for word in rest:
        clause = _add_word(clause, word, rest)
    return clause


def _add_word(clause: Clause, word: str, rest) -> Clause:
    if word in ("slight", "strong", "any"):
        return replace(clause, strength=word)
    if word.startswith("="):
        unit = next(unit for unit in UNITS if word.endswith(unit))
        return replace(clause, amount=(float(word[1 : -len(unit)]), UNITS[unit]))
    if word[0] == "x":
        return replace(clause, repeats=word[1:])
    if word in ("on", "except"):
        return replace(clause, part=next(rest), excluded=word == "except")
    if word.startswith("for="):
        return replace(clause, span=(float(word[4:]), None, None))
    if word.startswith("from="):
        return replace(clause, span=(None, float(word[5:]), None))
    if word.startswith("at="):
        start, end = map(float, word[3:].split("-"))
        return replace(clause, span=(None, start, end))
    if word in ("stays", "released", "first", "noted"):
        return replace(clause, flags=clause.flags | {word})
    raise ValueError(f"no such word: {word!r}")


def expand_options(reading: Reading) -> list[Reading]:
    """The reading with and without each motion that may be left out, and with a fall that begins with the lean."""
    if reading.answer != "motion":
        return [reading]
    return [each for reading in (reading, *_join_falls(reading)) for each in _leave_out(reading)]


def _join_falls(reading: Reading) -> list[Reading]:
    """The reading with every ``?fall`` that follows a ``lean`` at the same time as that; none if there is no such."""
    groups: list[tuple[Clause, ...]] = []
    for group in reading.groups:
        falls = [clause.kind for clause in group] == ["fall"] and group[0].optional
        if falls and groups and any(clause.kind == "lean" for clause in groups[-1]):
            groups[-1] += group
        else:
            groups.append(group)
    return [] if len(groups) == len(reading.groups) else [replace(reading, groups=tuple(groups))]


def _leave_out(reading: Reading) -> list[Reading]:
    """With and without each motion that may be left out."""
    choices = [
        [clause, None] if clause.optional else [clause] for group in reading.groups for clause in group
    ]
    sizes = [len(group) for group in reading.groups]
    variants = []
    for chosen in itertools.product(*choices):
        remaining = iter(chosen)
        groups = [[next(remaining) for _ in range(size)] for size in sizes]
        kept = tuple(tuple(c for c in group if c is not None) for group in groups)
        kept = tuple(group for group in kept if group)
        if kept:
            variants.append(replace(reading, groups=kept))
    return variants
