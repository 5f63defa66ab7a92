"""The lexicon's YAML files, read once and checked row by row.

Words that mean the same stand in one row, separated by commas. In a phrase, ``a/b`` stands for either word, ``/b`` for
the word or none, and ``~`` for up to four words of the sentence.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from fractions import Fraction
from importlib import resources
from typing import Any

import yaml

from physagent_jax.agents.lexicon.types import Effect, Join, Lexicon, Moment, Motion, Names, Place, Repeat
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN

FILES = (
    "motions",
    "causes",
    "forms",
    "ways",
    "strengths",
    "numbers",
    "parts",
    "surroundings",
    "function_words",
)
_ROWS = ("motions", "causes")  # files that are one list of rows
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_LIMITS = {"min": MAGNITUDE_MIN, "max": MAGNITUDE_MAX}
_DIRECTIONS = frozenset("left right up down toward away x y z long lengthwise".split())


class LexiconError(ValueError):
    """A row of the lexicon that says something which the lexicon has no meaning for."""


@functools.cache
def read_lexicon() -> Lexicon:
    """The lexicon of the package."""
    folder = resources.files("physagent_jax.agents.lexicon")
    return make_lexicon({name: (folder / f"{name}.yaml").read_text(encoding="utf-8") for name in FILES})


def make_lexicon(texts: Mapping[str, str]) -> Lexicon:
    """The lexicon from the texts of `FILES`.

    Raises:
        LexiconError: An unknown section, field or value, or a section that is missing.
    """
    tables: dict[str, Any] = {}
    for file, text in texts.items():
        content = yaml.load(text, _LOADER)
        for section, rows in ({file: content} if file in _ROWS else content).items():
            if section not in _PARSERS:
                raise LexiconError(
                    f"{file}.yaml: unknown section {section!r}; known are {', '.join(_PARSERS)}"
                )
            tables[section] = _PARSERS[section](rows, f"{file}.yaml, {section}")
    missing = [name for name in _PARSERS if name not in tables]
    if missing:
        raise LexiconError(f"The lexicon lacks {', '.join(missing)}")
    return Lexicon(**tables)


def _split(words: str) -> Iterator[str]:
    """Every phrase of a row."""
    for phrase in str(words).split(","):
        if "/" not in phrase:
            yield phrase.strip()
            continue
        for chosen in itertools.product(*(word.split("/") for word in phrase.split())):
            yield " ".join(word for word in chosen if word)


def _make_rows(kind: Callable[..., Any], convert: Mapping[str, Callable] | None = None) -> Callable:
    """A parser of rows whose fields are those of ``kind``."""
    known = {field.name for field in fields(kind)}  # type: ignore[arg-type]

    def parse(rows: list[dict], where: str) -> dict[str, Any]:
        table = {}
        for row in rows:
            told = dict(row)
            words = told.pop("words", "")
            if unknown := sorted(set(told) - known):
                known_text = ", ".join(sorted(known))
                raise LexiconError(
                    f"{where}, {words!r}: unknown field {unknown[0]!r}; known are {known_text}"
                )
            try:
                value = kind(**{name: (convert or {}).get(name, _keep)(each) for name, each in told.items()})
            except (ValueError, TypeError) as error:
                raise LexiconError(f"{where}, {words!r}: {error}") from error
            table.update(dict.fromkeys(_split(words), value))
        return table

    return parse


def _make_map(convert: Callable[[Any], Any]) -> Callable:
    """A parser of a section whose keys are values and whose values are words."""

    def parse(rows: dict, where: str) -> dict[str, Any]:
        table = {}
        for key, words in rows.items():
            try:
                value = convert(key)
            except (ValueError, TypeError) as error:
                raise LexiconError(f"{where}, {key!r}: {error}") from error
            table.update(dict.fromkeys(_split(words), value))
        return table

    return parse


def _make_set(words: str, where: str) -> frozenset[str]:
    """A section that is a set of words."""
    return frozenset(_split(words))


def _make_dict(rows: dict, where: str) -> dict[str, str]:
    """A section that is a dictionary already."""
    return {str(key): str(value) for key, value in rows.items()}


def _keep(value: Any) -> Any:
    return value


def _read_number(value: Any) -> float:
    return _LIMITS[value] if value in _LIMITS else float(Fraction(str(value)))


def _read_names(value: str) -> Names:
    names = tuple(str(value).split())
    if unknown := set(names) - _DIRECTIONS:
        raise ValueError(f"no direction: {', '.join(sorted(unknown))}")
    return names


def _read_name(value: str) -> str:
    (name,) = _read_names(value)
    return name


def _choose(*choices: str) -> Callable[[Any], str]:
    def read(value: Any) -> str:
        if str(value) not in choices:
            raise ValueError(f"must be one of {', '.join(choices)}")
        return str(value)

    return read


def _read_sense(value: str) -> int:
    return {"clockwise": -1, "counterclockwise": 1}[_choose("clockwise", "counterclockwise")(value)]


_MOTION = _make_rows(Motion, {"effect": Effect, "strength": _read_number, "direction": _read_name})
_NAMES, _NUMBERS = _make_map(_read_names), _make_map(_read_number)
_PARSERS: dict[str, Callable[[Any, str], Any]] = {
    "motions": _MOTION,
    "causes": _MOTION,
    "irregular": _make_dict,
    "directions": _NAMES,
    "ends": _NAMES,
    "axes": _NAMES,
    "planes": _NAMES,
    "views": _NAMES,
    "part_adjectives": _NAMES,
    "sides": _make_map(_choose("both", "all")),
    "senses": _make_map(_read_sense),
    "reversals": _make_map(_choose("other", "same")),
    "intensities": _NUMBERS,
    "degrees": _NUMBERS,
    "comparatives": _NUMBERS,
    "numbers": _NUMBERS,
    "fractions": _NUMBERS,
    "clip_parts": _NUMBERS,
    "part_nouns": _NUMBERS,
    "repeats": _make_rows(Repeat, {"names": _read_names}),
    "moments": _make_rows(Moment),
    "parts": _make_rows(Place, {"names": _read_names}),
    "units": _make_map(_choose("second", "millisecond", "frame")),
    "gravity": _make_map(_choose("down", "up", "none")),
    "anchors": _make_map(_choose("base", "top", "none")),
    "obstacles": _make_map(_choose("wall", "block")),
    "joins": _make_map(Join),
    **dict.fromkeys(
        "nouns addressees locations manners even fronts one_of_many unplaced wheeled ground scene_nouns negations "
        "exceptions whole agents moods phrases words".split(),
        _make_set,
    ),
}
