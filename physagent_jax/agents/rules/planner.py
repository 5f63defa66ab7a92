"""The offline planner: compares a motion report with what the sentence leads a viewer to expect."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.protocols import PlannerAgent
from physagent_jax.agents.rules.checks import View, make_checks
from physagent_jax.agents.rules.tolerances import list_windows
from physagent_jax.agents.schema import Check, ExpectedMotion, Judgement, Verdict
from physagent_jax.agents.trace import Reply


class RulePlanner(PlannerAgent):
    """Judges by commonsense bands (`tolerances`), one or more checks per expectation."""

    def windows(self, context: AgentContext) -> list[tuple[int, int]]:
        """One per expectation."""
        return list_windows(context.expectations, context.brief.frame_count)

    def judge(self, context: AgentContext, seen: Observation) -> Reply[Judgement]:
        """Compares the report with what is expected of the sentence; see `protocols.PlannerAgent`.

        What the pictures do not show is not counted; if they show nothing of what was asked, the verdict
        is FAIL and the suggestion says why.
        """
        expectations = context.expectations
        view = View(seen.report, seen.force_field, context.brief, expectations)
        checks = [check for index, e in enumerate(expectations) for check in make_checks(index, e, view)]
        observable = [check for check in checks if check.passed is not None]
        success = bool(observable) and all(check.passed for check in observable)
        judgement = Judgement(
            verdict=Verdict.SUCCESS if success else Verdict.FAIL,
            score=round(sum(check.score for check in observable) / len(observable), 6) if observable else 0.0,
            checks=tuple(checks),
            suggestion="" if success else _suggestion(context.prompt, checks, observable, expectations),
        )
        return Reply(judgement)


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
