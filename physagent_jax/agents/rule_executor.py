"""The offline executor: rewrites the force field by remedies, inside the hard rules, never twice the same."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.edits import Case, Change
from physagent_jax.agents.hard_rules import apply_hard_rules
from physagent_jax.agents.remedies import remedies
from physagent_jax.agents.schema import Check, ExpectedMotion, Judgement, Rewrite, SceneBrief
from physagent_jax.forces.schema import ForceField
from physagent_jax.perception.schema import MotionReport

_DEEPEST = 8  # remedies per expectation that are worth trying in turn


class RuleExecutor:
    """Implements `protocols.ExecutorAgent`: mends the failed expectations one after another."""

    def rewrite(
        self,
        prompt: str,
        expectations: Sequence[ExpectedMotion],
        force_field: ForceField,
        report: MotionReport,
        judgement: Judgement,
        brief: SceneBrief,
        history: Sequence[tuple[ForceField, Judgement]] = (),
    ) -> Rewrite:
        """Returns the next force field; ``history`` holds the earlier attempts, oldest first.

        The mildest remedies come first; if they lead to a force field that was tried before, the next
        ones are taken. If none is left, the field is returned unchanged and ``changes`` says so.
        """
        tried = [force_field, *(field for field, _ in history)]
        failed = _failed(judgement, len(expectations))
        for depth in range(_DEEPEST if failed else 0):
            changes = _mend(expectations, failed, force_field, report, brief, depth)
            if not changes:
                continue
            field, repairs = apply_hard_rules(changes[-1].force_field, brief, expectations)
            if field not in tried:
                rules = [
                    *(change.rule for change in changes if change.rule),
                    *(repair.rule for repair in repairs),
                ]
                return Rewrite(
                    force_field=field,
                    changes=tuple(
                        [*(change.why for change in changes), *(f"Hard rule: {r.why}." for r in repairs)]
                    ),
                    rules_applied=tuple(dict.fromkeys(rules)),
                )
        why = "every remedy has been tried" if failed else "no check failed that a force field could mend"
        return Rewrite(force_field=force_field, changes=(f"Nothing left to try: {why}.",))


def _failed(judgement: Judgement, count: int) -> dict[int, list[Check]]:
    """Failed checks by expectation, in the order of the sentence."""
    failed: dict[int, list[Check]] = {}
    for check in judgement.checks:
        if check.passed is False and 0 <= check.expectation < count:
            failed.setdefault(check.expectation, []).append(check)
    return dict(sorted(failed.items()))


def _mend(
    expectations: Sequence[ExpectedMotion],
    failed: dict[int, list[Check]],
    force_field: ForceField,
    report: MotionReport,
    brief: SceneBrief,
    depth: int,
) -> list[Change]:
    """One remedy per failed expectation, each on the result of the one before; ``depth`` skips the mildest."""
    changes: list[Change] = []
    field = force_field
    for index, checks in failed.items():
        case = Case(expectations[index], expectations, checks, field, report, brief)
        options = [change for change in remedies(case) if change.force_field != field]
        if not options:
            continue
        change = options[min(depth, len(options) - 1)]
        changes.append(change)
        field = change.force_field
    return changes
