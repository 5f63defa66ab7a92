"""The offline planner: compares a motion report with what the sentence leads a viewer to expect."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.rules.checks import View, checks_of
from physagent_jax.agents.schema import Check, ExpectedMotion, Judgement, SceneBrief, Verdict
from physagent_jax.forces.schema import ForceField
from physagent_jax.perception.schema import MotionReport


class RulePlanner:
    """Implements `protocols.PlannerAgent` by commonsense bands (`bands`), one or more checks per expectation."""

    def judge(
        self,
        prompt: str,
        expectations: Sequence[ExpectedMotion],
        report: MotionReport,
        force_field: ForceField,
        brief: SceneBrief,
    ) -> Judgement:
        """Compares ``report`` with what ``prompt`` asked for.

        What the pictures do not show is not counted; if they show nothing of what was asked, the verdict
        is FAIL and the suggestion says why.
        """
        view = View(report, force_field, brief, tuple(expectations))
        checks = [check for index, e in enumerate(expectations) for check in checks_of(index, e, view)]
        seen = [check for check in checks if check.passed is not None]
        success = bool(seen) and all(check.passed for check in seen)
        return Judgement(
            verdict=Verdict.SUCCESS if success else Verdict.FAIL,
            score=round(sum(check.score for check in seen) / len(seen), 6) if seen else 0.0,
            checks=tuple(checks),
            suggestion="" if success else _suggestion(prompt, checks, seen, expectations),
        )


def _suggestion(
    prompt: str, checks: list[Check], seen: list[Check], expectations: Sequence[ExpectedMotion]
) -> str:
    """The failed checks in words, worst first; the reason if there is nothing to go by."""
    if not checks:
        return f"Nothing is expected of the sentence '{prompt.strip()[:120]}', so nothing can be judged."
    if not seen:
        reasons = "; ".join(dict.fromkeys(check.observed for check in checks))
        return f"Nothing that the sentence asks for is observable in the pictures: {reasons}."
    failed = sorted((check for check in seen if not check.passed), key=lambda check: check.score)
    return " ".join(_sentence(check, expectations[check.expectation].words) for check in failed)


def _sentence(check: Check, words: str) -> str:
    asked = f"The sentence asks for '{words}'" if words else "The sentence asks for this motion"
    return f"{asked} ({check.question}: {check.expected}), but the pictures show {check.observed}; {check.remedy}."
