"""Measures of a sentence: quantities, durations, moments and counts.

They are short regular phrases inside free text, and the longest one that begins at a word is wanted. So each is a
regular expression over the words (a parser for whole texts, LALR or Earley, has no such use), and the table of them is
the grammar. The words are data: `lexicon/measures.yaml`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from physagent_jax.agents.grammar.tables import LEXICON, NUMBERS, get_set, read_rows, read_sections
from physagent_jax.agents.grammar.tokens import Token

BRIEF = 0.15
"""Share of the clip that "briefly" lasts."""


@dataclass(frozen=True)
class Quantity:
    """A number with its unit, as the sentence has it.

    Attributes:
        value: The number.
        unit: "degrees", "lengths" (body lengths), "metres", "share" (of ``dimension``) or "" (one that nothing
            here is measured in: newtons, pixels, metres per second).
        dimension: Dimension of a share: "length", "height", "width", "depth", "size", "volume", "far",
            "strength", or "".
        relative: It says by how much, not to what.
        acts: It says by itself that the size changes ("doubles its height", "becomes twice as tall").
        goal: It says to where ("to twice its height").
    """

    value: float
    unit: str
    dimension: str = ""
    relative: bool = False
    acts: bool = False
    goal: bool = False


@dataclass(frozen=True)
class Duration:
    """A length of time in "second", "millisecond", "frame" or "clip" (fraction of the whole)."""

    value: float
    unit: str

    def to_frames(self, frame_count: int, frame_dt: float) -> float:
        """The same in frames; the clip's last frame is ``frame_count - 1``."""
        per_unit = {
            "second": 1.0 / frame_dt,
            "millisecond": 0.001 / frame_dt,
            "frame": 1.0,
            "clip": float(frame_count - 1),
        }
        return self.value * per_unit[self.unit]


@dataclass(frozen=True)
class TimeSpan:
    """The sentence's statement about the time of an action; None = nothing.

    Attributes:
        start: When it begins.
        length: How long its cause acts; if ``whole``, in what time all of it has happened ("within a second").
        whole: See ``length``.
        total: ``length`` is that of all that was said so far: "left, then up, in a second".
    """

    start: Duration | None = None
    length: Duration | None = None
    whole: bool = False
    total: bool = False


class Words:
    """The words of a sentence as one string, in which patterns are matched at a token.

    Attributes:
        text: The tokens' texts, a space behind each; owners end in "'s".
    """

    def __init__(self, tokens: Sequence[Token]):
        self.tokens = tokens
        self._starts: list[int] = []
        parts: list[str] = []
        length = 0
        for token in tokens:
            self._starts.append(length)
            parts.append(token.text + ("'s " if token.possessive else " "))
            length += len(parts[-1])
        self.text = "".join(parts)

    def match(self, pattern: re.Pattern[str], at: int) -> re.Match[str] | None:
        """The match that begins at token ``at``."""
        return pattern.match(self.text, self._starts[at]) if 0 <= at < len(self._starts) else None

    def find_behind(self, at: int, match: re.Match[str]) -> int:
        """Index of the first token behind a match that begins at token ``at``."""
        return at + match.group().count(" ") + 1

    def get(self, at: int) -> str:
        """The text of a token; empty past the ends."""
        return self.tokens[at].text if 0 <= at < len(self.tokens) else ""


_TABLES = read_sections()
_SCALES = {word: value for word, value in LEXICON.fractions.items() if word != "half"} | _TABLES["scales"]
_VAGUE = get_set("vague")
_GROUPS = ("factors", "as_far", "dimensions", "angles", "metres", "other_units", "compared", "adjectives")
_BEGINNINGS = {word.split()[0] for name in ("factors", "as_far") for word in _TABLES[name]} | get_set(
    "before_factors"
)
_LEAST_DEGREES = 45  # of a "180 turn": nobody asks for so many turns


def _either(words) -> str:
    return "|".join(sorted(map(re.escape, words), key=len, reverse=True))


def _of(section: str) -> str:
    """A pattern of any word of a table."""
    return _either(_TABLES[section])


# A number: "2.5", "forty five", "two and a half", "a third", "three quarters", "a couple of".
_FRACTION = _either(LEXICON.fractions)
_DIGITS = _either(
    word
    for word, value in LEXICON.numbers.items()
    if 1 <= value < 10 and len(word) > 2 and word not in _VAGUE
)
_CARDINAL = (
    rf"\d[\d.]*|(?:{_of('tens')})(?: (?:{_DIGITS}))?|{_either(NUMBERS.keys() - _VAGUE - {'a', 'an', 'half'})}"
)
_NUMBER = (
    rf"(?:(?:a|an|one) (?:{_FRACTION})|(?:{_CARDINAL})(?: and an? (?:{_FRACTION})| (?:{_either(_SCALES)}))?"
    rf"|(?:a )?(?:{_either(_VAGUE)})(?: of)?|half|quarter|(?:a )?hundred|pi|an?)(?= )"
)
_UNIT = _either(LEXICON.units)
# The placeholders of `lexicon/quantities.yaml`; a table is a group of its own name.
_PLACES = {
    "N": rf"(?P<n>{_NUMBER})",
    "link": "(?: (?:an?|of|one))*",
    "whole": f"(?P<whole>(?: (?:{_of('full')}))?(?: body)?)",
    "owner": rf"(?:\S+'s|{_of('owners')})",
    "time": f"(?:{_UNIT})",
    "n_fold": f"(?P<n>{_either(NUMBERS)})",
} | {name: f"(?P<{name}>{_of(name)})" for name in _GROUPS}


def compute_number(text: str) -> float:
    """The value of a phrase that `_NUMBER` matches."""
    whole, _, more = text.partition(" and ")
    words = [word for word in whole.split() if word != "of"]
    value = _SCALES.get(words[-1])
    rest = words if value is None else words[:-1]
    counted = rest if len(rest) == 1 else [word for word in rest if word not in ("a", "an")]
    number = sum(float(word) if word[0].isdigit() else NUMBERS[word] for word in counted) if counted else 1.0
    fraction = LEXICON.fractions[more.split()[-1]] if more else 0.0
    return number * (1.0 if value is None else value) + fraction


def _compile(row: dict[str, Any]) -> re.Pattern[str]:
    """The pattern of a row of `lexicon/quantities.yaml`."""
    filled = re.sub(r"\{(\w*[a-zA-Z]\w*)\}", lambda found: _PLACES[found[1]], row["words"])
    return re.compile(filled + "(?= )")


_QUANTITIES = [(_compile(row), row) for row in read_rows("quantities")]


def match_quantity(words: Words, at: int) -> tuple[Quantity, int] | None:
    """The quantity that begins at token ``at`` and the index behind it, or None."""
    if not _begins_number(words.get(at)) and words.get(at) not in _BEGINNINGS:
        return None
    for pattern, row in _QUANTITIES:
        match = words.match(pattern, at)
        quantity = _make_quantity(row, match.groupdict(), match.group(), words, at) if match else None
        if match and quantity:
            return quantity, words.find_behind(at, match)
    return None


def _make_quantity(
    row: dict[str, Any], groups: dict[str, str], text: str, words: Words, at: int
) -> Quantity | None:
    """The quantity of a row whose pattern matches, or None if its condition does not hold."""
    number = groups.get("n") or ""
    value = compute_number(number) if number else 1.0
    before = words.get(at - 1)
    by = before == "by" or (before == "about" and words.get(at - 2) == "by")
    before = words.get(at - 2) if before in _TABLES["about"] else before
    counted = number not in ("a", "an") or bool(groups.get("whole"))
    holds = {
        "": False,
        "always": True,
        "counted": counted,
        "measured": counted or groups.get("metres") not in ("m", "foot", "feet"),  # "a foot"
        "owned": counted or "'s" in text,
        "part": value < 1.0,
        "by": by,
        "part_by": value < 1.0 and by,
        "broken": value != round(value),
        "large": value >= _LEAST_DEGREES,
        "to": before == "to",
        "unless_to": before not in ("to", "at", "until"),
    }
    if not holds[row.get("when", "always")]:
        return None
    scales = [_TABLES[name][groups[name]] for name in ("factors", "angles", "metres") if groups.get(name)]
    named = [_TABLES[name][groups[name]] for name in ("dimensions", "adjectives") if groups.get(name)]
    return Quantity(
        value * float(row.get("scale", 1.0)) * math.prod(map(float, scales)),
        row["unit"],
        named[0] if named else row.get("dimension", ""),
        *(holds[row.get(name, "")] for name in ("relative", "acts", "goal")),
    )


def _begins_number(word: str) -> bool:
    return word[:1].isdigit() and word.isascii() or word in NUMBERS or word in _SCALES or word in _VAGUE


# A length of time, and moments.
def _duration(name: str) -> str:
    return (
        rf"(?:(?P<{name}_n>{_NUMBER})(?: of)?(?: an?| one)? (?P<{name}_unit>{_UNIT})"
        rf"(?: and an? (?P<{name}_more>{_FRACTION})(?! (?:{_of('not_of_a_time')}) ))?"
        rf"|half(?: of)? (?:the )?(?:clip|time))"
    )


_LENGTH = _duration("d")
_NAMED = rf"(?:t |time )?(?P<named>frames?|second) (?P<named_n>{_NUMBER})"
_MOMENT = rf"(?:{_NAMED}|(?:t |time )?{_LENGTH})"
_PART = rf"(?P<order>first|second|third|last|final)(?: (?P<part_n>{_NUMBER}))? (?P<noun>{_either(LEXICON.clip_parts)}|{_UNIT})"
_SPAN = (
    rf"(?:from|between) (?:t |time )?(?:(?P<first_named>frames?|second) )?(?P<first>{_NUMBER})(?: (?P<first_unit>{_UNIT}))?"
    rf"(?: (?P<on>on|onwards?)| (?:to|and|until|till) (?:t |time )?(?:frame |second )?(?P<last>{_NUMBER})(?: (?P<unit>{_UNIT}))?)"
)


def _make_duration(match: re.Match[str]) -> Duration:
    if match["d_n"] is None:
        return Duration(0.5, "clip")
    more = LEXICON.fractions[match["d_more"]] if match["d_more"] else 0.0
    return Duration(compute_number(match["d_n"]) + more, LEXICON.units[match["d_unit"]])


def _make_moment(match: re.Match[str]) -> TimeSpan:
    if match["named"]:
        return TimeSpan(Duration(compute_number(match["named_n"]), LEXICON.units[match["named"]]))
    return TimeSpan(_make_duration(match))


def _make_start(match: re.Match[str]) -> TimeSpan:
    return TimeSpan(_make_duration(match))


def _make_length(match: re.Match[str]) -> TimeSpan | None:
    return TimeSpan(length=_make_duration(match)) if match["d_n"] else None


def _find_part(size: float, order: str) -> TimeSpan:
    """A part of the clip: the second third."""
    count = _TABLES["orders"][order]
    start = 1.0 - size if count < 0 else min(count * size, 1.0 - size)
    return TimeSpan(Duration(start, "clip"), Duration(size, "clip"))


def _make_part(match: re.Match[str]) -> TimeSpan | None:
    """Reads "the first half", "the last 10 frames", "the first second"."""
    order = _TABLES["orders"][match["order"]]
    if match["noun"] in LEXICON.clip_parts and not match["part_n"]:
        return _find_part(LEXICON.clip_parts[match["noun"]], match["order"])
    unit = LEXICON.units.get(match["noun"])
    value = compute_number(match["part_n"]) if match["part_n"] else 1.0
    if unit is None or (order > 0 and value != 1.0):
        return None
    start = -value if order < 0 else order * value  # counted from the end: a negative start
    return TimeSpan(Duration(start, unit), Duration(value, unit))


def _make_span(match: re.Match[str]) -> TimeSpan | None:
    """Reads "from frame 10 to 20", "between 1 and 2 seconds", "from 1 s on"."""
    named = LEXICON.units.get(match["first_named"] or match["first_unit"] or "")
    first = compute_number(match["first"])
    if match["on"]:
        return TimeSpan(Duration(first, named)) if named else None
    last = compute_number(match["last"])
    unit = LEXICON.units.get(match["unit"] or "") or named
    if not unit or last <= first:
        return None
    return TimeSpan(Duration(first, unit), Duration(last - first, unit))


_TIMES: tuple[tuple[str, re.Pattern[str], Callable[[re.Match[str]], TimeSpan | None]], ...] = tuple(
    (condition, re.compile(pattern + "(?= )"), make)
    for condition, pattern, make in (
        ("", rf"(?:for|in|over|during|throughout) (?:the )?{_PART}", _make_part),
        ("", rf"(?:for|lasting) {_LENGTH}", lambda m: TimeSpan(length=_make_duration(m))),
        ("", rf"within {_LENGTH}", lambda m: TimeSpan(None, _make_duration(m), True)),
        ("measured", rf"(?:in|over) {_LENGTH}", lambda m: TimeSpan(None, _make_duration(m), True)),
        ("", _SPAN, _make_span),
        ("", rf"(?:after|at) {_MOMENT}", _make_moment),
        ("counted", rf"{_LENGTH} (?:in(?= (?:[^\w\s]|$))|into the (?:{_of('films')}))", _make_start),
        ("counted", rf"{_LENGTH}(?! (?:later|after|in |into) )", _make_length),
    )
)
_REST_OF_CLIP = re.compile(r"(?:in|during|over) the (?P<order>second|third|last) (?:[^\w\s]|$)")


def match_time(words: Words, at: int, measured: bool) -> tuple[TimeSpan, int] | None:
    """The phrase of time that begins at token ``at`` and the index behind it, or None.

    Args:
        words: The sentence.
        at: Index of a token.
        measured: Whether a quantity was told, so that "in a second" is the time that it takes; else it is a moment.
    """
    if words.get(at) not in _TABLES["before_times"] and not _begins_number(words.get(at)):
        return None
    counted = words.get(at) not in ("a", "an") or words.get(at - 1) in _TABLES["before_a_time"]
    holds = {"": True, "measured": measured, "counted": counted}
    for condition, pattern, make in _TIMES:
        match = words.match(pattern, at) if holds[condition] else None
        span = make(match) if match else None
        if match and span:
            total = condition == "measured" and words.get(at - 1) == ","
            return replace(span, total=total), words.find_behind(at, match)
    match = words.match(_REST_OF_CLIP, at)
    named = [token.text for token in words.tokens[:at] if token.text in LEXICON.clip_parts] if match else []
    if match and named:  # "... in the first half and up in the second"
        return _find_part(LEXICON.clip_parts[named[-1]], match["order"]), at + 3
    return None


_COUNT = re.compile(rf"(?P<n>{_NUMBER}) (?:{_of('times')})(?= )")
_COUNTED = re.compile(rf"(?P<n>{_NUMBER})(?= )")


def match_count(words: Words, at: int) -> tuple[float, int] | None:
    """The number in "three times" and the index behind it, or None."""
    match = words.match(_COUNT, at) if _begins_number(words.get(at)) else None
    if match is None or words.get(at) in ("a", "an"):
        return None
    return compute_number(match["n"]), words.find_behind(at, match)


def match_number(words: Words, at: int) -> tuple[float, int] | None:
    """The number that begins at token ``at`` and the index behind it, or None."""
    match = words.match(_COUNTED, at) if _begins_number(words.get(at)) else None
    return None if match is None else (compute_number(match["n"]), words.find_behind(at, match))


def parse_moment(start: float | None, length: float | None) -> TimeSpan:
    """A span in fractions of the clip; None leaves it to the sequence, a negative length is brief."""
    return TimeSpan(
        None if start is None else Duration(start, "clip"),
        None if length is None else Duration(BRIEF if length < 0 else length, "clip"),
    )
