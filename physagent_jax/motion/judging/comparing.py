"""A value against its limits: every comparison becomes a `Check` with margin, confidence and remedy."""

from __future__ import annotations

import functools
import math
from typing import Any

from physagent_jax.core.reading import read_packaged_yaml
from physagent_jax.core.strict import Vector
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.seen import TO_SIGMA, View
from physagent_jax.motion.schema import Check, DirectionTable
from physagent_jax.motion.tolerances import Tolerance
from physagent_jax.motion.vectors import clamp, cosine, norm

START = 60.0  # [degrees] off what is asked that it may start: a viewer goes by the way that it takes then
SAME_WAY = 45.0  # [degrees] a viewer's "left" ends where another of the six directions is nearer
_TOO_COARSE = 1.0  # of the range's width that the half width of the report's interval may reach


def make_unseen_check(asked: Asked, why: str, question: str = "") -> Check:
    """A check of something asked for that the pictures do not allow: no success without it."""
    return Check(
        expectation=asked.index,
        question=question or f"does it {asked.kind.value}?",
        expected=asked.kind.value,
        observed=f"not observable ({why})",
        passed=None,
        score=0.0,
    )


def find_confidence(distance: float, sigma: float) -> float:
    """Chance that a value with a normal error of ``sigma`` lies on the stated side of a limit ``distance`` away."""
    return round(0.5 * (1.0 + math.erf(abs(distance) / (sigma * math.sqrt(2.0)))), 6)


def compare_range(tolerance: Tolerance, value: float, sigma: float) -> dict[str, Any]:
    """The fields of a check that a range decides."""
    return {
        "expected": tolerance.text(),
        "passed": tolerance.low <= value <= tolerance.high,
        "score": round(tolerance.score(value), 6),
        "margin": round(tolerance.margin(value), 6),
        "confidence": find_confidence(tolerance.distance(value), sigma),
    }


def compare_amount(
    asked: Asked,
    question: str,
    tolerance: Tolerance,
    value: float,
    seen: str,
    *,
    figure: str = "",
    half_width: float | None = None,
) -> Check:
    """A value against its range, with the factor on the cause that would mend it.

    Its uncertainty is ``half_width``, or that of the report's ``figure``: by default the one of such a motion.
    """
    half_width = asked.view.uncertainty(figure or asked.figure) if half_width is None else half_width
    if half_width > _TOO_COARSE * (min(tolerance.high, 3 * tolerance.target) - tolerance.low):
        return make_unseen_check(asked, f"it is known to +-{half_width:.2g} only", question)
    compared = compare_range(tolerance, value, max(half_width * TO_SIGMA, 1e-9))
    gain = None if compared["passed"] else round(tolerance.gain(value), 4)
    remedy = "" if gain is None else _name_remedy(gain, asked)
    return Check(
        expectation=asked.index, question=question, observed=seen, gain=gain, remedy=remedy, **compared
    )


def _name_remedy(gain: float, asked: Asked) -> str:
    causes = asked.causes
    if not causes:
        return f"nothing in the force field causes it: add an action that makes it {asked.kind.value}"
    if gain < 0 and asked.driven:
        return f"increase the magnitude of {causes}: other motion overcomes it"
    if gain < 0:
        return f"reverse {causes}: it goes the wrong way"
    verb = "increase" if gain > 1 else "decrease"
    return f"{verb} the magnitude of {causes} by a factor of {gain:.2g}"


def compare_direction(
    asked: Asked,
    question: str,
    seen: Vector,
    spread: float | None = None,
    wanted: Vector | None = None,
    how: str = "",
    within: float = SAME_WAY,
) -> Check:
    """The angle between a seen direction of any length and the expected one.

    ``spread`` is its standard deviation [degrees], by default that of a displacement; ``wanted`` stands for the
    motion's own direction, ``within`` how many degrees of which it passes.
    """
    direction = wanted or asked.direction
    assert direction is not None
    spread = find_spread(norm(seen), asked.view) if spread is None else spread
    angle = math.degrees(math.acos(clamp(cosine(seen, direction), -1.0, 1.0)))
    passed = angle <= within
    contrary = angle > 180.0 - SAME_WAY
    causes, table = asked.causes or "the force field", asked.view.brief.directions
    if asked.driven:
        fix = f"increase the magnitude of {causes}: it points the right way, but other motion overcomes it"
    elif contrary:
        fix = f"reverse {causes}"
    else:
        fix = f"point {causes} along {format_vector(direction)}"
    return Check(
        expectation=asked.index,
        question=question,
        aspect="direction",
        expected=f"within {within:.0f} degrees of {name_direction(direction, table)}",
        observed=f"{name_direction(seen, table)}, {angle:.0f} degrees off{how}",
        passed=passed,
        score=1.0 if passed else round(0.9 * (180.0 - angle) / 180.0, 6),
        margin=round((within - angle) / within, 6),
        confidence=find_confidence(angle - within, max(spread, 1e-6)),
        gain=-1.0 if contrary else None,
        remedy="" if passed else fix,
    )


@functools.cache
def read_words() -> dict[str, dict[str, Any]]:
    """The words of the checks with one limit, by name; the file says what they hold."""
    return read_packaged_yaml("physagent_jax.motion.judging", "checks.yaml")


def check_limit(
    asked: Asked,
    name: str,
    value: float,
    limit: float,
    sigma: float,
    gain: float | None = None,
    **figures: object,
) -> Check:
    """A value with one limit; its margin is 1 at zero for an upper limit, and from twice a lower one on.

    ``name`` tells its words in `checks.yaml`, which may need further ``figures``; ``sigma`` is the value's standard
    deviation, and ``gain`` the factor on the cause that would mend it.
    """
    words = read_words()[name]
    at_least = words.get("at_least", False)
    margin = min((value - limit) / limit, 1.0) if at_least else (limit - value) / limit
    passed = margin >= 0.0
    score = 1.0 if passed else 0.9 * (max(value, 0.0) / limit if at_least else limit / value)
    causes = asked.causes or words.get("cause", "the cause")
    figures |= {"value": value, "limit": limit, "causes": causes}
    told = ("question", "expected", "observed", *(() if passed else ("remedy",)))
    return Check(
        expectation=asked.index,
        passed=passed,
        aspect=words["aspect"],
        score=round(score, 6),
        margin=round(margin, 6),
        confidence=find_confidence(value - limit, max(sigma, 1e-9)),
        gain=None if passed or gain is None else round(gain, 4),
        **{field: words[field].format(**figures) for field in told},
    )


def find_spread(length: float, view: View) -> float:
    """Standard deviation of a displacement's direction [degrees]."""
    return math.degrees(math.atan2(view.sigma("displacement"), max(length, 1e-9)))


def name_direction(vector: Vector, table: DirectionTable) -> str:
    """A direction in the viewer's words: "left", "left and up", with the lesser part only if it matters."""
    if norm(vector) < 1e-9:
        return "nowhere"
    parts = {name: cosine(vector, getattr(table, name)) for name in type(table).model_fields}
    names = sorted((name for name, share in parts.items() if share > 0.35), key=lambda n: -parts[n])
    return " and ".join(names[:2]) or format_vector(vector)


def format_vector(vector: Vector) -> str:
    """A direction for people."""
    return "[" + ", ".join(f"{c:.2g}" for c in vector) + "]"
