"""Measures of a sentence: quantities, durations, moments and counts.

They are short regular phrases inside free text, and the longest one that begins at a word is wanted. So each is a
regular expression over the words (a parser for whole texts, LALR or Earley, has no such use), and the table of them is
the grammar. The words are data: `lexicon/measures.yaml`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import Any

from physagent_jax.agents.grammar.tables import LEXICON, LEXICON_PACKAGE, NUMBERS, get_set, read_sections
from physagent_jax.agents.grammar.tokens import Token
from physagent_jax.agents.intent import Duration, Quantity, Timing
from physagent_jax.agents.lexicon import Effect
from physagent_jax.core.reading import read_packaged_yaml


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
_GROUPS = (
    "somersaults factors as_far dimensions angles heights full metres other_units compared adjectives".split()
)
_BEGINNINGS = {
    word.split()[0] for name in ("factors", "as_far", "heights") for word in _TABLES[name]
} | get_set("before_factors")
_MOST, _LONGEST = 1e9, 1e6  # of a quantity, and of a time
_NEAR = 8  # words before a quantity in which its verb stands
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
    "link": "(?: (?:an?|of|one)){0,3}",
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


_QUANTITIES = [(_compile(row), row) for row in read_packaged_yaml(LEXICON_PACKAGE, "quantities.yaml")]


def match_quantity(words: Words, at: int) -> tuple[Quantity, int] | None:
    """The quantity that begins at token ``at`` and the index behind it, or None."""
    if not _begins_number(words.get(at)) and words.get(at) not in _BEGINNINGS:
        return None
    for pattern, row in _QUANTITIES:
        if match := words.match(pattern, at):
            if quantity := _make_quantity(row, match.groupdict(), match.group(), words, at):
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
    turned = words.get(at - 2) if before in get_set("pronouns") else before
    counted = number not in ("a", "an") or bool(groups.get("whole"))
    known = LEXICON.motions
    done = {
        known[token.lemma].effect for token in words.tokens[max(at - _NEAR, 0) : at] if token.lemma in known
    }
    holds = {
        "": False,
        "always": True,
        "counted": counted,
        "measured": (counted or groups.get("metres") not in ("m", "foot", "feet"))  # "a foot"
        and not (groups.get("metres") in ("foot", "feet") and words.get(at - 1) in get_set("before_feet")),
        "owned": counted or "'s" in text,
        "part": value < 1.0,
        "by": by,
        "part_by": value < 1.0 and by,
        "broken": value != round(value),
        "turned": value < 1.0 and turned in _TABLES["turns"],
        "leaned": Effect.LEAN in done,
        "pressed": Effect.SCALE in done,
        "spun": Effect.TURN in done,
        "wide": value >= _LEAST_DEGREES and turned in _TABLES["turns"],
        "apposed": before == "," and Effect.TURN in done,
        "driven": Effect.PUSH in done,
        "large": value >= _LEAST_DEGREES,
        "from": before == "from",
        "to": before == "to",
        "in": before == "in",
        "unless_to": before not in ("to", "at", "until"),
    }
    if not holds[row.get("when", "always")]:
        return None
    scales = [
        _TABLES[name][groups[name]] for name in ("factors", "angles", "metres", "heights") if groups.get(name)
    ]
    named = [_TABLES[name][groups[name]] for name in ("dimensions", "adjectives") if groups.get(name)]
    told = {name: holds[row.get(name, "")] for name in ("acts", "goal", "relative")}
    return Quantity(
        value=min(value * float(row.get("scale", 1.0)) * math.prod(map(float, scales)), _MOST),
        unit=row["unit"],
        dimension=named[0] if named else row.get("dimension", ""),
        relation="is" if told["acts"] else "to" if told["goal"] else "by" if told["relative"] else "",
    )


def _begins_number(word: str) -> bool:
    known = word in NUMBERS or word in _SCALES or word in _VAGUE or word.removesuffix("fold") in NUMBERS
    return known or word[:1].isdigit() and word.isascii()


# A length of time, and moments.
_LENGTH = (
    rf"(?:(?P<d_n>{_NUMBER})(?: of)?(?: an?| one)? (?P<d_unit>{_UNIT})(?: or (?P<d_most>{_DIGITS}))?"
    rf"(?: and an? (?P<d_more>{_FRACTION})(?! (?:{_of('not_of_a_time')}) ))?"
    rf"|half(?: of)? (?:the )?(?:clip|time))"
)
_NAMED = rf"(?:t |time )?(?P<named>frames?|second) (?P<named_n>{_NUMBER})"
_MOMENT = rf"(?:{_NAMED}|(?:t |time )?{_LENGTH})"
_CLIP_PARTS = _either(LEXICON.clip_parts)
_PART = (
    rf"(?P<order>first|second|third|last|final)(?: (?P<part_n>{_NUMBER}))? (?P<noun>{_CLIP_PARTS}|{_UNIT})"
)
_SPAN = (
    r"(?:from|between) (?:t |time )?(?:(?P<first_named>frames?|second) )?"
    rf"(?P<first>{_NUMBER})(?: (?P<first_unit>{_UNIT}))?"
    r"(?: (?P<on>on|onwards?)| (?:to|and|until|till) (?:t |time )?(?:frame |second )?"
    rf"(?P<last>{_NUMBER})(?: (?P<unit>{_UNIT}))?)"
)


def _last(value: float, unit: str) -> Duration:
    """A length of time in a unit of the lexicon, or in parts of the clip."""
    value = min(max(value / 1000.0 if unit == "millisecond" else value, -_LONGEST), _LONGEST)
    return Duration(
        value=value, unit="clip" if unit == "clip" else "frames" if unit == "frame" else "seconds"
    )


def _make_duration(match: re.Match[str]) -> Duration:
    if match["d_n"] is None:
        return _last(0.5, "clip")
    more = LEXICON.fractions[match["d_more"]] if match["d_more"] else 0.0
    return _last(compute_number(match["d_most"] or match["d_n"]) + more, LEXICON.units[match["d_unit"]])


def _make_moment(match: re.Match[str]) -> Timing:
    if match.groupdict().get("named"):
        return Timing(starts=_last(compute_number(match["named_n"]), LEXICON.units[match["named"]]))
    return Timing(starts=_make_duration(match))


def _make_span(starts: float, lasts: float, unit: str) -> Timing:
    return Timing(starts=_last(starts, unit), lasts=_last(lasts, unit))


def _find_part(size: float, order: str) -> Timing:
    """A part of the clip: the second third."""
    count = _TABLES["orders"][order]
    return _make_span(1.0 - size if count < 0 else min(count * size, 1.0 - size), size, "clip")


def _make_part(match: re.Match[str]) -> Timing | None:
    """Reads "the first half", "the last 10 frames", "the first second"."""
    if match["noun"] in LEXICON.clip_parts and not match["part_n"]:
        return _find_part(LEXICON.clip_parts[match["noun"]], match["order"])
    order, unit = _TABLES["orders"][match["order"]], LEXICON.units.get(match["noun"])
    value = compute_number(match["part_n"]) if match["part_n"] else 1.0
    if unit is None or (order > 0 and value != 1.0):
        return None
    return _make_span(-value if order < 0 else order * value, value, unit)  # negative: from the end


def _make_interval(match: re.Match[str]) -> Timing | None:
    """Reads "from frame 10 to 20", "between 1 and 2 seconds", "from 1 s on"."""
    named = LEXICON.units.get(match["first_named"] or match["first_unit"] or "")
    first = compute_number(match["first"])
    if match["on"]:
        return Timing(starts=_last(first, named)) if named else None
    last, unit = compute_number(match["last"]), LEXICON.units.get(match["unit"] or "") or named
    return _make_span(first, last - first, unit) if unit and last > first else None


def _make_length(match: re.Match[str]) -> Timing:
    return Timing(lasts=_make_duration(match), within=match.group().startswith(("within", "in ", "over")))


_INTO = f"into the (?:{_of('films')})"
# Patterns of times in the order in which they are tried, each with its condition.
_TIMES: tuple[tuple[str, re.Pattern[str], Callable[[re.Match[str]], Timing | None]], ...] = tuple(
    (condition, re.compile(pattern + "(?= )"), make)
    for condition, pattern, make in (
        ("", rf"(?:for|in|over|during|throughout) (?:the )?{_PART}", _make_part),
        ("", rf"(?:for|lasting|within) {_LENGTH}", _make_length),
        ("measured", rf"(?:in|over) {_LENGTH}", _make_length),
        ("", _SPAN, _make_interval),
        ("", rf"(?:after|at) {_MOMENT}", _make_moment),
        ("counted", rf"{_LENGTH} (?:in(?= (?:[^\w\s]|$))|{_INTO})", _make_moment),
        ("counted", rf"(?!half of|half the|half clip){_LENGTH}(?! (?:later|after|in |into) )", _make_length),
    )
)
_REST_OF_CLIP = re.compile(r"(?:in|during|over) the (?P<order>second|third|last) (?:[^\w\s]|$)")


def match_time(words: Words, at: int, is_measured: Callable[[], bool]) -> tuple[Timing, int] | None:
    """The phrase of time that begins at token ``at`` and the index behind it, or None.

    Args:
        words: The sentence.
        at: Index of a token.
        is_measured: Whether a quantity was told, so that "in a second" is the time that it takes; else it is a moment.
    """
    if words.get(at) not in _TABLES["before_times"] and not _begins_number(words.get(at)):
        return None
    counted = words.get(at) not in ("a", "an") or words.get(at - 1) in _TABLES["before_a_time"]
    for condition, pattern, make in _TIMES:
        match = words.match(pattern, at) if condition != "counted" or counted else None
        span = make(match) if match else None
        if match and span and (condition != "measured" or is_measured()):
            total = condition == "measured" and words.get(at - 1) == ","
            return span.model_copy(update={"overall": total}), words.find_behind(at, match)
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


def make_moment(starts: float | None, lasts: float | None) -> Timing:
    """A fixed phrase of time in fractions of the clip; None leaves it to the sequence."""
    return Timing(
        starts=None if starts is None else _last(starts, "clip"),
        lasts=None if lasts is None else _last(lasts, "clip"),
    )
