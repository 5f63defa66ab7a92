"""A value against its limits: every comparison becomes a `Check` with margin, confidence and remedy."""

from __future__ import annotations

import math

from physagent_jax.agents.rules.judging.seen import TO_SIGMA, View
from physagent_jax.agents.rules.tolerances import Tolerance
from physagent_jax.agents.schema import Check, ExpectedMotion
from physagent_jax.agents.vectors import clamp, cosine, norm
from physagent_jax.core.strict import Vector

SAME_WAY = 45.0  # [degrees] a viewer's "left" ends where another of the six directions is nearer
_TOO_COARSE = 1.0  # of the range's width that the half width of the report's interval may reach


def make_unseen_check(index: int, expectation: ExpectedMotion, why: str, question: str = "") -> Check:
    """A check of something asked for that the pictures do not allow: no success without it."""
    return Check(
        expectation=index,
        question=question or f"does it {expectation.kind.value}?",
        expected=expectation.kind.value,
        observed=f"not observable ({why})",
        passed=None,
        score=0.0,
    )


def find_confidence(distance: float, sigma: float) -> float:
    """Chance that a value with a normal error of ``sigma`` lies on the stated side of a limit ``distance`` away."""
    return round(0.5 * (1.0 + math.erf(abs(distance) / (sigma * math.sqrt(2.0)))), 6)


def compare_amount(
    index: int,
    expectation: ExpectedMotion,
    question: str,
    tolerance: Tolerance,
    value: float,
    seen: str,
    view: View,
    figure: str,
    half_width: float | None = None,
) -> Check:
    """A value against its range, with the factor on the cause that would mend it.

    Args:
        index: Which expectation.
        expectation: What was asked.
        question: Asked of the pictures.
        tolerance: The range.
        value: What was seen.
        seen: The same in words.
        view: Where.
        figure: Which of the report's uncertainties the value has.
        half_width: The value's own instead.
    """
    half_width = view.uncertainty(figure) if half_width is None else half_width
    if half_width > _TOO_COARSE * (min(tolerance.high, 3 * tolerance.target) - tolerance.low):
        why = f"it is known to +-{half_width:.2g} only"
        return make_unseen_check(index, expectation, why, question)
    passed = tolerance.low <= value <= tolerance.high
    gain = None if passed else round(tolerance.gain(value), 4)
    return Check(
        expectation=index,
        question=question,
        expected=tolerance.text(),
        observed=seen,
        passed=passed,
        score=round(tolerance.score(value), 6),
        margin=round(tolerance.margin(value), 6),
        confidence=find_confidence(tolerance.distance(value), max(half_width * TO_SIGMA, 1e-9)),
        gain=gain,
        remedy="" if gain is None else _name_remedy(gain, expectation, view),
    )


def _name_remedy(gain: float, expectation: ExpectedMotion, view: View) -> str:
    causes = view.causes(expectation)
    if not causes:
        return f"nothing in the force field causes it: add an action that makes it {expectation.kind.value}"
    if gain < 0 and view.driven(expectation):
        return f"increase the magnitude of {causes}: other motion overcomes it"
    if gain < 0:
        return f"reverse {causes}: it goes the wrong way"
    verb = "increase" if gain > 1 else "decrease"
    return f"{verb} the magnitude of {causes} by a factor of {gain:.2g}"


def compare_direction(
    index: int,
    expectation: ExpectedMotion,
    question: str,
    seen: Vector,
    view: View,
    spread: float,
    wanted: Vector | None = None,
    how: str = "",
) -> Check:
    """The angle between a seen and the expected direction.

    Args:
        index: Which expectation.
        expectation: What was asked.
        question: Asked of the pictures.
        seen: What was seen, of any length.
        view: Where.
        spread: Standard deviation of the seen direction [degrees].
        wanted: The expected direction, if not the expectation's own.
        how: What the angle is that of, for people.
    """
    direction = wanted or expectation.direction
    assert direction is not None
    angle = math.degrees(math.acos(clamp(cosine(seen, direction), -1.0, 1.0)))
    passed = angle <= SAME_WAY
    contrary = angle > 180.0 - SAME_WAY
    causes = view.causes(expectation) or "the force field"
    if view.driven(expectation):
        fix = f"increase the magnitude of {causes}: it points the right way, but other motion overcomes it"
    elif contrary:
        fix = f"reverse {causes}"
    else:
        fix = f"point {causes} along {format_vector(direction)}"
    return Check(
        expectation=index,
        question=question,
        aspect="direction",
        expected=f"within {SAME_WAY:.0f} degrees of {name_direction(direction, view)}",
        observed=f"{name_direction(seen, view)}, {angle:.0f} degrees off{how}",
        passed=passed,
        score=1.0 if passed else round(0.9 * (180.0 - angle) / 180.0, 6),
        margin=round((SAME_WAY - angle) / SAME_WAY, 6),
        confidence=find_confidence(angle - SAME_WAY, max(spread, 1e-6)),
        gain=-1.0 if contrary else None,
        remedy="" if passed else fix,
    )


def make_limit_check(
    index: int,
    question: str,
    expected: str,
    observed: str,
    value: float,
    limit: float,
    *,
    aspect: str,
    at_least: bool = False,
    sigma: float = 0.0,
    gain: float | None = None,
    remedy: str = "",
) -> Check:
    """A value with one limit; its margin is 1 at zero for an upper limit, and from twice a lower one on.

    Args:
        index: Which expectation.
        question: Asked of the pictures.
        expected: The range in words.
        observed: The value in words.
        value: What is compared.
        limit: With what; above zero.
        aspect: Aspect of the motion.
        at_least: Whether the limit is the lowest value allowed.
        sigma: Standard deviation of the value.
        gain: Factor on the cause that would mend it.
        remedy: What to change.
    """
    margin = min((value - limit) / limit, 1.0) if at_least else (limit - value) / limit
    passed = margin >= 0.0
    score = 1.0 if passed else 0.9 * (max(value, 0.0) / limit if at_least else limit / value)
    return Check(
        expectation=index,
        question=question,
        expected=expected,
        observed=observed,
        passed=passed,
        aspect=aspect,  # type: ignore[arg-type]
        score=round(score, 6),
        margin=round(margin, 6),
        confidence=find_confidence(value - limit, max(sigma, 1e-9)),
        gain=None if passed or gain is None else round(gain, 4),
        remedy="" if passed else remedy,
    )


def find_spread(length: float, view: View) -> float:
    """Standard deviation of a displacement's direction [degrees]."""
    return math.degrees(math.atan2(view.sigma("displacement"), max(length, 1e-9)))


def name_direction(vector: Vector, view: View) -> str:
    """A direction in the viewer's words: "left", "left and up", with the lesser part only if it matters."""
    length = norm(vector)
    if length < 1e-9:
        return "nowhere"
    table = view.brief.directions
    parts = {name: cosine(vector, getattr(table, name)) for name in type(table).model_fields}
    names = sorted((name for name, share in parts.items() if share > 0.35), key=lambda n: -parts[n])
    return " and ".join(names[:2]) or format_vector(vector)


def format_vector(vector: Vector | None) -> str:
    """A direction for people."""
    return "any direction" if vector is None else "[" + ", ".join(f"{c:.2g}" for c in vector) + "]"
