"""What the planner's checks are made of: a view of the scene, and values compared with tolerances and directions."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_jax.agents.matching import agrees, find_causes
from physagent_jax.agents.rules import tolerances
from physagent_jax.agents.rules.tolerances import Tolerance
from physagent_jax.agents.schema import Check, ExpectedMotion, SceneBrief
from physagent_jax.agents.vectors import clamp, dot
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import ForceField
from physagent_jax.perception.schema import MotionReport, WindowMotion


@dataclass(frozen=True)
class View:
    """What the checks look at."""

    report: MotionReport
    force_field: ForceField
    brief: SceneBrief
    expectations: tuple[ExpectedMotion, ...]

    @property
    def anchored(self) -> bool:
        """Whether the object is held."""
        return self.brief.anchored is not None

    def window(self, expectation: ExpectedMotion) -> WindowMotion | None:
        """The report's window for an expectation; None if perception was not asked for it."""
        try:
            return self.report.window(*tolerances.round_window(expectation, self.report.frame_count))
        except KeyError:
            return None

    def causes(self, expectation: ExpectedMotion) -> str:
        """Names of the entries that should cause it, for remedies."""
        return ", ".join(cause.name for cause in find_causes(expectation, self.force_field))

    def driven(self, expectation: ExpectedMotion) -> bool:
        """Whether something in the force field drives it the way that the sentence says."""
        return any(agrees(cause, expectation) for cause in find_causes(expectation, self.force_field))

    def speed(self, frame: int, direction: Vector) -> float:
        """Speed along a direction when a window begins [body lengths per clip]; 0 if not observable."""
        before = max(frame - 2, 0)
        here, there = self.report.centroid[frame], self.report.centroid[before]
        if here is None or there is None or before == frame:
            return 0.0
        return (
            (dot(here, direction) - dot(there, direction)) / (frame - before) * (self.report.frame_count - 1)
        )

    @property
    def visible(self) -> float:
        """Smallest displacement that is not noise [body lengths]."""
        return clamp(self.report.quality.depth_noise, tolerances.VISIBLE, 0.08)


def make_unseen_check(index: int, expectation: ExpectedMotion, why: str) -> Check:
    """A check that the pictures do not allow; it is not counted."""
    return Check(
        expectation=index,
        question=f"does it {expectation.kind.value}?",
        expected=expectation.kind.value,
        observed=f"not observable ({why})",
        passed=None,
        score=0.0,
    )


def explain_unobservable(window: WindowMotion, field: str) -> str:
    """Why a field of the report is None."""
    return window.unobservable.get(field, f"{field} was not measured")


def compare_amount(
    index: int,
    expectation: ExpectedMotion,
    question: str,
    tolerance: Tolerance,
    value: float,
    seen: str,
    view: View,
) -> Check:
    """A value against its tolerance, with the factor that would mend it."""
    passed = tolerance.low <= value <= tolerance.high
    gain = None if passed else round(tolerance.gain(value), 4)
    return Check(
        expectation=index,
        question=question,
        expected=tolerance.text(),
        observed=seen,
        passed=passed,
        score=round(tolerance.score(value), 6),
        gain=gain,
        remedy="" if gain is None else _remedy(gain, expectation, view),
    )


def _remedy(gain: float, expectation: ExpectedMotion, view: View) -> str:
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
    index: int, expectation: ExpectedMotion, similarity: float, limit: float, what: str, view: View
) -> Check:
    """The cosine between seen and expected direction."""
    passed = similarity >= limit
    causes = view.causes(expectation) or "the force field"
    contrary = similarity < -limit
    if view.driven(expectation):
        fix = f"increase the magnitude of {causes}: it points the right way, but other motion overcomes it"
    else:
        fix = (
            f"reverse {causes}"
            if contrary
            else f"point {causes} along {format_vector(expectation.direction)}"
        )
    return Check(
        expectation=index,
        question=f"does it {what} the right way?",
        aspect="direction",
        expected=f"{what} along {format_vector(expectation.direction)}",
        observed=f"a direction whose cosine with it is {similarity:.2f}",
        passed=passed,
        score=round(clamp((similarity + 1.0) / 2.0, 0.0, 1.0), 6) if not passed else 1.0,
        gain=-1.0 if contrary else None,
        remedy="" if passed else fix,
    )


def format_vector(vector: Vector | None) -> str:
    """A direction for people."""
    return "any direction" if vector is None else "[" + ", ".join(f"{c:.2g}" for c in vector) + "]"
