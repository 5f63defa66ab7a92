"""Durations and moments: "for half a second", "during the first third", "from frame 10 to 20"."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_jax.agents.rules.language.modifiers import CLIP_PARTS, FRACTIONS, MOMENTS, NUMBERS, UNITS
from physagent_jax.agents.rules.language.quantities import match_quantity
from physagent_jax.agents.rules.language.tokens import Token

_STOPS = frozenset({".", ";", ":", "!", "?"})
_NOT_OF_A_UNIT = frozenset("of turn turns body length lengths rotation revolution".split())
_FILMS = frozenset({"video", "clip", "shot", "scene", "animation", "film", "movie", "sequence", "take"})
BRIEF = MOMENTS["briefly"].lasts or 0.0  # of the clip


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


def match_time(tokens: list[Token], at: int) -> tuple[TimeSpan, int] | None:
    """The phrase of time that begins at ``tokens[at]`` and the index behind it, or None."""
    word = tokens[at].text
    if word == "for" and (part := _parse_part_of_clip(tokens, at + 1)):
        return part  # "for the first second"
    if word in ("for", "lasting"):
        return _map_match(_parse_quantity(tokens, at + 1), lambda a: TimeSpan(length=a))
    if word == "within" or word in ("in", "over") and _is_measured(tokens, at):
        part = None if word == "within" else _parse_part_of_clip(tokens, at + 1)
        total = word != "within" and at > 0 and tokens[at - 1].text == ","
        return part or _map_match(_parse_quantity(tokens, at + 1), lambda a: TimeSpan(None, a, True, total))
    if word in ("after", "at", "from", "between"):
        return _parse_span(tokens, at) or (
            None
            if word in ("from", "between")
            else _map_match(_parse_moment(tokens, at + 1), lambda a: TimeSpan(start=a))
        )
    if word in ("during", "in", "over", "throughout"):
        return _parse_part_of_clip(tokens, at + 1)
    counted = word not in ("a", "an") or (at > 0 and tokens[at - 1].lemma in ("wait", "pause"))
    if counted and (bare := _parse_quantity(tokens, at)) and bare[0].unit != "clip":
        behind = _get_word(tokens, bare[1] + 1)
        if _get_word(tokens, bare[1]) == "in" and (behind == "" or not behind[0].isalnum()):
            return TimeSpan(start=bare[0]), bare[1] + 1  # "half a second in, ..."
        if [_get_word(tokens, bare[1] + i) for i in (0, 1)] == ["into", "the"]:
            if _get_word(tokens, bare[1] + 2) in _FILMS:
                return TimeSpan(start=bare[0]), bare[1] + 3  # "half a second into the clip"
        return (
            None if _get_word(tokens, bare[1]) in ("later", "after") else (TimeSpan(length=bare[0]), bare[1])
        )
    return None


def _is_measured(tokens: list[Token], at: int) -> bool:
    """Return whether it was said how much: "by half its length in a second"; "in a second push it" tells a start."""
    first = next((i + 1 for i in range(at - 1, -1, -1) if tokens[i].text in _STOPS), 0)
    last = at
    if at and tokens[at - 1].text == ":":  # "hit it: in a second it goes by half its length"
        last = next((i for i in range(at, len(tokens)) if tokens[i].text in _STOPS), len(tokens))
    found = [match_quantity(tokens, i) for i in range(first, last)]
    return any(each is not None and each[0].unit for each in found)


def parse_moment(phrase: str) -> TimeSpan:
    """The meaning of a fixed phrase of `modifiers.MOMENTS`."""
    moment = MOMENTS[phrase]
    return TimeSpan(
        None if moment.starts is None else Duration(moment.starts, "clip"),
        None if moment.lasts is None else Duration(moment.lasts, "clip"),
    )


def parse_number(tokens: list[Token], at: int) -> tuple[float, int] | None:
    """A number in digits or words ("2", "three", "half a", "a couple of") and the index behind it."""
    word = _get_word(tokens, at)
    if [_get_word(tokens, at + i) for i in (1, 2, 3)] == ["and", "a", "half"] and word in NUMBERS:
        return NUMBERS[word] + 0.5, at + 4
    if word and word[0].isdigit() and word[0].isascii():
        return float(word), at + 1
    if word not in NUMBERS:
        return None
    after = _get_word(tokens, at + 1)
    if (
        after in FRACTIONS and after != "half"
    ):  # "a third of a second", "four tenths of the clip", "a quarter second"
        of = [_get_word(tokens, at + i) for i in (2, 3)]
        behind = at + 4 if of[0] == "of" and of[1] in ("a", "one") else at + 2
        if _get_word(tokens, behind) in UNITS:
            return NUMBERS[word] * FRACTIONS[after], behind
    if word in ("a", "an") and after in ("half", "few", "couple"):
        return parse_number(tokens, at + 1)
    if after in ("a", "an", "of"):
        at += 1
    return NUMBERS[word], at + 1


def _get_word(tokens: list[Token], at: int) -> str:
    return tokens[at].text if at < len(tokens) else ""


def _map_match(found, build) -> tuple[TimeSpan, int] | None:
    return None if found is None else (build(found[0]), found[1])


def _parse_quantity(tokens: list[Token], at: int) -> tuple[Duration, int] | None:
    """Reads "two seconds", "half a second", "10 frames", "half of the clip"."""
    counted = parse_number(tokens, at)
    if counted is None:
        return None
    value, behind = counted
    unit = UNITS.get(_get_word(tokens, behind))
    if unit:
        more = [_get_word(tokens, behind + i) for i in range(1, 5)]
        if more[:2] == ["and", "a"] and more[2] in FRACTIONS and more[3] not in _NOT_OF_A_UNIT:
            return Duration(value + FRACTIONS[more[2]], unit), behind + 4  # "a second and a half"
        return Duration(value, unit), behind + 1
    if value == 0.5 and _get_word(tokens, behind) in ("the", "clip", "time"):
        return Duration(0.5, "clip"), behind + 1 + (_get_word(tokens, behind) == "the")
    return None


def _parse_moment(tokens: list[Token], at: int) -> tuple[Duration, int] | None:
    """Reads "frame 10" or a quantity."""
    named = UNITS.get(_get_word(tokens, at))
    if named and named != "clip" and (counted := parse_number(tokens, at + 1)):
        return Duration(counted[0], named), counted[1]  # "frame 10", "second 1"
    return _parse_quantity(tokens, _skip_symbol(tokens, at))


def _skip_symbol(tokens: list[Token], at: int) -> int:
    """Past "t" and "time" in "at t = 1 s"."""
    return at + (_get_word(tokens, at) in ("t", "time"))


def _parse_span(tokens: list[Token], at: int) -> tuple[TimeSpan, int] | None:
    """Reads "from frame 10 to 20", "between 1 and 2 seconds", "from t = 0.5 s to t = 1 s", "from 1 s on"."""
    first_at = _skip_symbol(tokens, at + 1)
    first_at += _get_word(tokens, first_at) in ("frame", "frames", "second")
    first = parse_number(tokens, first_at)
    if first is None or _get_word(tokens, at) not in ("from", "between"):
        return None
    early = UNITS.get(_get_word(tokens, first[1]))
    middle = first[1] + (early is not None)
    named = UNITS.get(_get_word(tokens, first_at - 1))
    if _get_word(tokens, middle) in ("on", "onward", "onwards") and (early or named):
        return TimeSpan(start=Duration(first[0], early or named or "second")), middle + 1
    if _get_word(tokens, middle) not in ("to", "and", "until", "till"):
        return None
    second_at = _skip_symbol(tokens, middle + 1)
    second = parse_number(tokens, second_at + (_get_word(tokens, second_at) in ("frame", "second")))
    unit = UNITS.get(_get_word(tokens, second[1])) if second else None
    if second is None or not (unit or named or early) or second[0] <= first[0]:
        return None
    amounts = [
        Duration(value, unit or named or early or "frame") for value in (first[0], second[0] - first[0])
    ]
    return TimeSpan(amounts[0], amounts[1]), second[1] + (unit is not None)


def _parse_part_of_clip(tokens: list[Token], at: int) -> tuple[TimeSpan, int] | None:
    """Reads "the first half", "the second third", "the last 10 frames", "the first second"."""
    at += _get_word(tokens, at) == "the"
    order = {"first": 0, "second": 1, "third": 2, "last": -1, "final": -1}.get(_get_word(tokens, at))
    if order is None:
        return None
    counted = parse_number(tokens, at + 1)
    value, behind = counted if counted and _get_word(tokens, counted[1]) in UNITS else (1.0, at + 1)
    noun = _get_word(tokens, behind)
    if noun in CLIP_PARTS:
        size = CLIP_PARTS[noun]
        start = 1.0 - size if order < 0 else min(order * size, 1.0 - size)
        return TimeSpan(Duration(start, "clip"), Duration(size, "clip")), behind + 1
    named = [t.text for t in tokens[:at] if t.text in CLIP_PARTS]
    if not noun.isalnum() and order and named and _get_word(tokens, at - 1) == "the":
        size = CLIP_PARTS[named[-1]]  # "... in the first half and up in the second"
        start = 1.0 - size if order < 0 else min(order * size, 1.0 - size)
        return TimeSpan(Duration(start, "clip"), Duration(size, "clip")), at + 1
    unit = UNITS.get(noun)
    if unit is None or (order > 0 and value != 1.0):
        return None
    if order < 0:  # counted from the end: a negative start
        return TimeSpan(Duration(-value, unit), Duration(value, unit)), behind + 1
    return TimeSpan(Duration(order * value, unit), Duration(value, unit)), behind + 1
