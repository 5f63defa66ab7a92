"""The lexicon's YAML files, read once and checked row by row.

Words that mean the same stand in one row, separated by commas. In a phrase, ``a/b`` stands for either word, ``/b`` for
the word or none, and ``~`` for up to four words of the sentence.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import is_dataclass, replace
from enum import Enum
from fractions import Fraction
from functools import partial
from importlib import resources
from typing import Any, Literal, get_args, get_origin, get_type_hints

import yaml

from physagent_jax.agents.lexicon.types import Effect, Lexicon, Motion, Names
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.skills import Skill, list_skills

FILES = tuple("motions causes forms ways strengths numbers parts surroundings function_words".split())
_ROWS = ("motions", "causes")  # files that are one list of rows
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_LIMITS = {"min": MAGNITUDE_MIN, "max": MAGNITUDE_MAX}
Reader = Callable[[Any], Any]  # of a value of YAML
Parser = Callable[[Any, str], Any]  # of a section and the words for where it stands
_DIRECTIONS = frozenset(
    "left right up down toward away x y z long lengthwise own beside ahead behind".split()
)


class LexiconError(ValueError):
    """A row of the lexicon that says something which the lexicon has no meaning for."""


@functools.cache
def read_lexicon() -> Lexicon:
    """The lexicon of the package."""
    folder = resources.files("physagent_jax.agents.lexicon")
    lexicon = make_lexicon({name: (folder / f"{name}.yaml").read_text(encoding="utf-8") for name in FILES})
    return replace(
        lexicon,
        motions=_add_skills(lexicon.motions, lambda skill: skill.verbs),
        causes=_add_skills(lexicon.causes, lambda skill: skill.nouns),
    )


def _add_skills(table: dict[str, Motion], get_words: Callable[[Skill], tuple[str, ...]]) -> dict[str, Motion]:
    """The table with the words of skills; what it says of them already stays."""
    named = {word: skill for skill in list_skills("actions") for word in get_words(skill)}
    return table | {
        word: replace(table.get(word) or _make_motion(skill), skill=skill.name)
        for word, skill in named.items()
    }


def _make_motion(skill: Skill) -> Motion:
    """The meaning of a skill's word, which is read like the words of the skill's kind."""
    effect = Effect.STRIKE if skill.is_sudden else Effect.TURN if skill.is_axis else Effect.PUSH
    effect = Effect.SCALE if skill.is_two_sided else effect
    return Motion(effect, direction=skill.towards, brief=skill.is_brief, skill=skill.name)


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


def split_phrases(words: str) -> Iterator[str]:
    """Every phrase of a row of words."""
    for phrase in str(words).split(","):
        if "/" not in phrase:
            yield phrase.strip()
            continue
        for chosen in itertools.product(*(word.split("/") for word in phrase.split())):
            yield " ".join(word for word in chosen if word)


def _make_rows(kind: type) -> Parser:
    """A parser of rows whose fields are those of a data class."""
    readers = {name: _choose_reader(name, hint) for name, hint in get_type_hints(kind).items()}

    def parse(rows: list[dict], where: str) -> dict[str, Any]:
        table = {}
        for row in rows:
            told = {name: value for name, value in row.items() if name != "words"}
            words = row.get("words", "")
            if unknown := sorted(set(told) - set(readers)):
                known = ", ".join(sorted(readers))
                raise LexiconError(f"{where}, {words!r}: unknown field {unknown[0]!r}; known are {known}")
            try:
                value = kind(**{name: readers[name](each) for name, each in told.items()})
            except (ValueError, TypeError) as error:
                raise LexiconError(f"{where}, {words!r}: {error}") from error
            table.update(dict.fromkeys(split_phrases(words), value))
        return table

    return parse


def _make_map(read: Reader) -> Parser:
    """A parser of a section whose keys are values and whose values are words."""

    def parse(rows: dict, where: str) -> dict[str, Any]:
        table = {}
        for key, words in rows.items():
            try:
                table.update(dict.fromkeys(split_phrases(words), read(key)))
            except (ValueError, TypeError) as error:
                raise LexiconError(f"{where}, {key!r}: {error}") from error
        return table

    return parse


def _make_parser(name: str, hint: Any) -> Parser:
    """The parser of a section, by the type of its attribute in `Lexicon`."""
    if hint == frozenset[str]:
        return lambda words, where: frozenset(split_phrases(words))
    value = get_args(hint)[1]
    if value is str:
        return lambda rows, where: {str(key): str(each) for key, each in rows.items()}
    if isinstance(value, type) and is_dataclass(value):
        return _make_rows(value)
    return _make_map(_choose_reader(name, value))


def _choose_reader(name: str, hint: Any) -> Reader:
    """The function that turns a value of YAML into one of a field's type."""
    if name in _READERS:
        return _READERS[name]
    if get_origin(hint) is Literal:
        return partial(_choose, get_args(hint))
    if isinstance(hint, type) and issubclass(hint, Enum):
        return hint
    return {Names: _read_names, float: _read_number}.get(hint, lambda value: value)


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


def _choose(choices: Sequence[str], value: Any) -> str:
    if str(value) not in choices:
        raise ValueError(f"must be one of {', '.join(choices)}")
    return str(value)


def _read_sense(value: str) -> int:
    return 1 if _choose(("clockwise", "counterclockwise"), value) == "counterclockwise" else -1


_READERS: dict[str, Reader] = {"direction": _read_name, "senses": _read_sense}
_PARSERS = {name: _make_parser(name, hint) for name, hint in get_type_hints(Lexicon).items()}
