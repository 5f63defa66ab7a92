"""Quantities in a sentence: "90 degrees", "half a body length", "to twice its height", "by 30 percent"."""

from __future__ import annotations

import math
from dataclasses import dataclass

from physagent_jax.agents.rules.language.modifiers import FRACTIONS, NUMBERS, UNITS
from physagent_jax.agents.rules.language.tokens import Token

# Units in the one that is reckoned with.
ANGLES = {
    "degree": 1.0,
    "degrees": 1.0,
    "deg": 1.0,
    "turn": 360.0,
    "turns": 360.0,
    "rotation": 360.0,
    "rotations": 360.0,
    "revolution": 360.0,
    "revolutions": 360.0,
    "radian": math.degrees(1.0),
    "radians": math.degrees(1.0),
}
METRES = {
    "m": 1.0,
    "meter": 1.0,
    "meters": 1.0,
    "metre": 1.0,
    "metres": 1.0,
    "cm": 0.01,
    "centimeter": 0.01,
    "centimeters": 0.01,
    "centimetre": 0.01,
    "centimetres": 0.01,
    "mm": 0.001,
    "millimeter": 0.001,
    "millimeters": 0.001,
    "millimetre": 0.001,
    "millimetres": 0.001,
    "inch": 0.0254,
    "inches": 0.0254,
    "foot": 0.3048,
    "feet": 0.3048,
}
LENGTHS = frozenset({"length", "lengths"})
DIMENSIONS = {
    "length": "length",
    "height": "height",
    "width": "width",
    "breadth": "width",
    "depth": "depth",
    "thickness": "depth",
    "size": "size",
    "volume": "volume",
}
# "twice as tall": the dimension that an adjective is about, or what else is compared.
ADJECTIVES = {
    "long": "length",
    "tall": "height",
    "high": "height",
    "wide": "width",
    "broad": "width",
    "thick": "depth",
    "deep": "depth",
    "big": "size",
    "large": "size",
    "far": "far",
    "hard": "strength",
    "strong": "strength",
    "strongly": "strength",
    "fast": "strength",
}
_FACTORS = {"double": 2.0, "triple": 3.0, "quadruple": 4.0, "halve": 0.5}
_FACTOR_FORMS = {
    form: value
    for verb, value in _FACTORS.items()
    for form in (verb, verb + "s", verb + "d", verb[:-1] + "ing")
}
_TENS = {"thirty": 30, "forty": 40, "fifty": 50, "sixty": 60, "seventy": 70, "eighty": 80, "ninety": 90}
_TEENS = {
    "eleven": 11,
    "twelve": 12,
    "thirteen": 13,
    "fifteen": 15,
    "eighteen": 18,
    "twenty": 20,
    "hundred": 100,
}
_OWNERS = frozenset(
    {
        "its",
        "the",
        "rest",
        "initial",
        "resting",
        "undeformed",
        "their",
        "his",
        "her",
        "own",
        "original",
        "normal",
        "current",
        "body",
    }
)
_COMPARED = frozenset(
    {"longer", "taller", "higher", "wider", "broader", "bigger", "larger", "shorter", "flatter", "thinner"}
    | {"narrower", "smaller", "slimmer"}
)
# Before "around".
_CIRCLES = {("all", "the", "way"): 360.0, ("halfway",): 180.0, ("half", "way"): 180.0}
# As before: "then right by as much".
_AS_MUCH = (
    ("as", "far"),
    ("as", "much"),
    ("equally", "far"),
    ("the", "same", "distance"),
    ("the", "same", "amount"),
    ("an", "equal", "distance"),
    ("an", "equal", "amount"),
)
_LEAST_DEGREES = 45  # nobody asks for so many turns
_ABOUT = frozenset({"about", "roughly", "exactly", "nearly", "almost", "approximately"})
_WHOLE = frozenset({"full", "complete", "whole", "entire"})


@dataclass(frozen=True)
class Quantity:
    """A number with its unit, as the sentence has it.

    Attributes:
        value: How much.
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


def match_quantity(tokens: list[Token], at: int) -> tuple[Quantity, int] | None:
    """The quantity that begins at ``tokens[at]`` and the index behind it, or None."""
    text = _get(tokens, at)
    relative = _get(tokens, at - 1) == "by" or (
        _get(tokens, at - 1) == "about" and _get(tokens, at - 2) == "by"
    )
    if text in _FACTOR_FORMS:
        behind, dimension = _match_dimension(tokens, at + 1)
        return Quantity(_FACTOR_FORMS[text], "share", dimension, acts=_get(tokens, at - 1) != "to"), behind
    if text.endswith("fold") and text.removesuffix("fold") in NUMBERS:
        return Quantity(NUMBERS[text.removesuffix("fold")], "share"), at + 1
    if text in ("its", "their", "one") and relative:
        behind, dimension = _match_dimension(tokens, at)
        if dimension:
            return Quantity(1.0, "share", dimension), behind
    words = [_get(tokens, at + i) for i in range(4)]
    for phrase in _AS_MUCH:
        if words[: len(phrase)] == list(phrase) and words[len(phrase)] != "as":  # "as far as" is a place
            far = (
                2.0 if _is_from_the_start(tokens, at + len(phrase)) else 1.0
            )  # through where it began, and on
            return Quantity(far, "share", "far", acts=True), at + len(phrase)
    for phrase, value in _CIRCLES.items():
        if words[: len(phrase)] == list(phrase) and words[len(phrase)] in ("around", "round"):
            return Quantity(value, "degrees"), at + len(phrase) + 1
    factor = at + (text in ("a", "the"))
    if _get(tokens, factor) == "factor" and _get(tokens, factor + 1) == "of":  # "by a factor of 1.3"
        counted = match_number(tokens, factor + 2)
        return None if counted is None else (Quantity(counted[0], "share"), counted[1])
    counted = match_number(tokens, at)
    if counted is None:
        return None
    preceding = at - 1 - (_get(tokens, at - 1) in _ABOUT)
    before = _get(tokens, preceding)
    return _match_unit(tokens, *counted, before=before, relative=relative, bare=text in ("a", "an"))


def _is_from_the_start(tokens: list[Token], at: int) -> bool:
    """Return whether a way is measured from where all began: "as far to the right of where it began"."""
    words = [_get(tokens, i) for i in range(at, at + 8)]
    where = [i for i in range(5) if words[i : i + 2] == ["of", "where"]]
    return any(words[i + 3] in ("began", "started", "was", "stood") for i in where)


def match_number(tokens: list[Token], at: int) -> tuple[float, int] | None:
    """A number in digits or words, with fractions, and the index behind it."""
    text, after = _get(tokens, at), _get(tokens, at + 1)
    if text in ("a", "an", "one") and after in FRACTIONS:
        return FRACTIONS[after], at + 2
    if text == "pi":
        return math.pi, at + 1
    if text in ("twice", "thrice"):
        return (2.0 if text == "twice" else 3.0), at + 1
    if text[:1].isdigit() and text.isascii():
        value, behind = float(text), at + 1
    elif text in _TENS or text in _TEENS:
        value, behind = float(_TENS.get(text, _TEENS.get(text, 0))), at + 1
        if text in _TENS and 0 < NUMBERS.get(after, 0) < 10 and after not in ("a", "an", "half"):
            value, behind = value + NUMBERS[after], at + 2
    elif text in ("half", "quarter"):
        return FRACTIONS[text], at + 1
    elif text in NUMBERS and text not in ("few", "couple"):
        value, behind = float(NUMBERS[text]), at + 1
    else:
        return None
    if _get(tokens, behind) == "pi":
        return value * math.pi, behind + 1
    if _get(tokens, behind) in FRACTIONS and _get(tokens, behind) != "half" and value > 0:
        return value * FRACTIONS[_get(tokens, behind)], behind + 1  # "two thirds"
    words = [_get(tokens, behind + i) for i in range(3)]
    if words[:2] == ["and", "a"] and words[2] in FRACTIONS:
        return value + FRACTIONS[words[2]], behind + 3
    return value, behind


def _match_unit(
    tokens: list[Token], value: float, at: int, *, before: str, relative: bool, bare: bool
) -> tuple[Quantity, int] | None:
    """Match a count from ``at`` on, ``before``: the word before; ``bare``: the number is only an article."""
    part = value < 1.0  # "half a turn", "a quarter of a body length"
    start = at
    while _get(tokens, at) in ("a", "an", "of", "one") and part:
        at += 1
    times = _get(tokens, at) in ("times", "time")
    times = times or _get(tokens, at) == "x" and _get(tokens, at + 1) in _COMPARED  # "2x bigger"
    at += times
    if _get(tokens, at) in ("around", "round") and times:
        return Quantity(360.0 * value, "degrees"), at + 1
    whole = _get(tokens, at) in _WHOLE
    at += whole
    body = _get(tokens, at) == "body"
    at += body
    unit, behind = _get(tokens, at), at + 1
    bare = bare and not (part or whole or body)
    if _get(tokens, behind) in ("per", "each", "every") and not bare:  # a speed or a frequency
        return Quantity(value, ""), behind + 2
    if unit in ("turn", "spin", "flip", "rotation") and value >= _LEAST_DEGREES and not times:
        return Quantity(value, "degrees"), behind  # "a 180 turn"
    if unit in ANGLES and not bare and not (unit in ("turn", "turns") and times):
        return Quantity(value * ANGLES[unit], "degrees"), behind
    if unit in METRES and not (bare and unit in ("m", "foot", "feet")):
        return Quantity(value * METRES[unit], "metres"), behind
    if unit in LENGTHS and not bare and not times:
        return Quantity(value, "lengths"), behind
    if unit in UNKNOWN_UNITS and not bare:
        return Quantity(value, ""), behind
    if unit in ("percent", "%"):
        value, at, part = value / 100.0, behind, True
        while _get(tokens, at) == "of":
            at += 1
        found, dimension = _match_dimension(tokens, at)
        compared = _get(tokens, behind) in _COMPARED  # "30 percent shorter"
        compared = compared or before not in ("to", "at", "until")  # "stretched 20 %"
        return Quantity(value, "share", dimension, (relative and not dimension) or compared), (
            found if dimension else behind
        )
    if unit == "as" and _get(tokens, behind) in ADJECTIVES:
        dimension = ADJECTIVES[_get(tokens, behind)]
        behind += 2 if _get(tokens, behind + 1) == "as" else 1
        return Quantity(value, "share", dimension, acts=True), behind
    found, dimension = _match_dimension(tokens, at)
    owned = at < len(tokens) and tokens[at].possessive  # "a chair's length"
    if dimension and (owned or not bare and _get(tokens, at) in _OWNERS):
        return Quantity(value, "share", dimension, relative and part, goal=before == "to"), found
    if times and unit in _COMPARED:  # "three times taller"
        return Quantity(value, "share"), at
    if times and value != round(value):
        return Quantity(value, "share"), at  # "stretch it 1.5 times"
    if part and unit in _COMPARED:  # "a fifth longer"
        return Quantity(value, "share", "", True), at
    if relative and part and _get(tokens, at) not in UNITS:
        return Quantity(value, "share", "", True), start
    return None


def _match_dimension(tokens: list[Token], at: int) -> tuple[int, str]:
    """The dimension in "its own height", "in width", "the jelly's length"; the place before it if there is none."""
    for reach in range(5):
        text = _get(tokens, at + reach)
        if text in DIMENSIONS:
            return at + reach + 1, DIMENSIONS[text]
        if (
            text not in _OWNERS
            and text != "in"
            and not (at + reach < len(tokens) and tokens[at + reach].possessive)
        ):
            break
    return at, ""


# Units of what is not controlled: forces, speeds, rates, energies, pixels, masses.
UNKNOWN_UNITS = frozenset(
    (
        "newton newtons n kn hz hertz rpm bpm pixel pixels px joule joules j kg kilogram kilograms gram grams g gs "
        "mph kmh kph pound pounds lbs watt watts volt volts pascal pascals pa bar psi km kilometer kilometers mile "
        "miles yard yards step steps beat beats"
    ).split()
)


def _get(tokens: list[Token], at: int) -> str:
    return tokens[at].text if 0 <= at < len(tokens) else ""
