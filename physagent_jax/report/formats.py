"""Numbers as people read them: true minus signs, SI prefixes, few digits."""

from __future__ import annotations

import math
from collections.abc import Sequence

MINUS, THIN_SPACE, TIMES = "\u2212", "\u202f", "\u00d7"
UNKNOWN = "\u2014"
PREFIXES = {-12: "p", -9: "n", -6: "\u00b5", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_RAISED = "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"
SUPERSCRIPTS = str.maketrans("-0123456789", _RAISED)


def format_fixed(value: float | None, decimals: int = 2) -> str:
    """A fixed number of decimals, for columns; no negative zero."""
    if value is None:
        return UNKNOWN
    rounded = round(value, decimals) + 0.0
    return f"{rounded:.{decimals}f}".replace("-", MINUS)


def format_number(value: float | None, digits: int = 3) -> str:
    """Significant digits without trailing zeros; powers of ten where decimals would be many."""
    if value is None:
        return UNKNOWN
    if value == 0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if exponent < -3 or exponent > 5:
        mantissa = format_fixed(value / 10.0**exponent, digits - 1)
        return f"{_strip(mantissa)} {TIMES} {format_power_of_ten(exponent)}"
    return _strip(format_fixed(value, max(0, digits - 1 - exponent)))


def format_power_of_ten(exponent: int) -> str:
    """Ten with a raised exponent."""
    return f"10{str(exponent).translate(SUPERSCRIPTS)}"


def format_count(value: int) -> str:
    """Thousands set apart by thin spaces."""
    return f"{value:,}".replace(",", THIN_SPACE).replace("-", MINUS)


def format_percent(share: float | None) -> str:
    """A share as a percentage."""
    return UNKNOWN if share is None else f"{format_fixed(100 * share, 0 if share >= 0.0995 else 1)} %"


def find_prefix(largest: float) -> tuple[float, str]:
    """The SI prefix that brings ``largest`` into 1..1000: (factor to multiply by, prefix)."""
    if largest <= 0 or not math.isfinite(largest):
        return 1.0, ""
    power = max(-12, min(9, 3 * math.floor(math.log10(largest) / 3 + 1e-9)))
    return 10.0**-power, PREFIXES[power]


def format_quantity(value: float | None, unit: str, digits: int = 3) -> str:
    """A value with its unit and an SI prefix: ``format_quantity(1e5, "Pa")`` is "100 kPa"."""
    if value is None:
        return UNKNOWN
    factor, letter = find_prefix(abs(value))
    return f"{format_number(value * factor, digits)} {letter}{unit}"


def format_seconds(value: float) -> str:
    """A duration for people."""
    if value >= 60:
        minutes, rest = divmod(round(value), 60)
        return f"{minutes} min {rest} s"
    if value >= 0.1 or value == 0:
        return f"{format_number(value)} s"
    return format_quantity(value, "s")


def format_vector(value: Sequence[float] | None, decimals: int = 2) -> str:
    """Components in brackets."""
    if value is None:
        return UNKNOWN
    return "(" + ", ".join(format_fixed(component, decimals) for component in value) + ")"


def format_window(first: float, last: float, frame_dt: float | None = None) -> str:
    """A span of frames, with seconds if the frame time is known."""
    text = f"frames {format_number(first, 4)}\u2013{format_number(last, 4)}"
    if frame_dt is None:
        return text
    return f"{text} ({format_fixed(first * frame_dt)}\u2013{format_fixed(last * frame_dt)} s)"


def spell_out(identifier: str) -> str:
    """An identifier as words."""
    return identifier.replace("_", " ")


def format_plural(many: int, thing: str) -> str:
    """A number of things: "1 frame", "3 frames"."""
    return f"{format_count(many)} {thing}{'' if many == 1 else 's'}"


def _strip(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text else text
