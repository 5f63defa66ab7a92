"""The offline executor: rewrites the force field by remedies, inside the hard rules, never twice the same."""

from __future__ import annotations

import math
from collections.abc import Sequence

from physagent_jax.agents.context import AgentContext, Round
from physagent_jax.agents.hard_rules import apply_hard_rules
from physagent_jax.agents.protocols import ExecutorAgent
from physagent_jax.agents.rules.edits import Case, Change
from physagent_jax.agents.rules.remedies import list_remedies
from physagent_jax.agents.schema import Check, ExpectedMotion, Judgement, Rewrite, SceneBrief
from physagent_jax.agents.trace import Reply
from physagent_jax.forces.schema import Action, ForceField
from physagent_jax.perception.schema import MotionReport

_LOST = 0.2  # share of tracks kept, below which the object cannot have stayed in one piece
_CALM_DOWN = 0.6  # factor on the cause of what could not be followed
_DEEPEST = 8  # remedies per expectation that are worth trying in turn


class RuleExecutor(ExecutorAgent):
    """Mends the failed expectations one after another; without checks it has nothing to go by."""

    def rewrite(self, context: AgentContext, failed: Round) -> Reply[Rewrite]:
        """Returns the next force field; see `protocols.ExecutorAgent`.

        The mildest remedies come first; if they lead to a force field that was tried before, the next
        ones are taken. If none is left, the field is returned unchanged and ``changes`` says so.
        """
        expectations, brief = context.expectations, context.brief
        force_field, report = failed.force_field, failed.report
        tried = [force_field, *(earlier.force_field for earlier in context.rounds)]
        unmet = _failed(failed.judgement, len(expectations), report)
        for depth in range(_DEEPEST if unmet else 0):
            changes = _mend(expectations, unmet, force_field, report, brief, depth)
            if not changes:
                continue
            bounded = _below_what_was_too_much(changes[-1].force_field, force_field, context.rounds)
            field, repairs = apply_hard_rules(bounded, brief, expectations)
            if field not in tried:
                rules = [
                    *(change.rule for change in changes if change.rule),
                    *(repair.rule for repair in repairs),
                ]
                reasons = [*(change.why for change in changes), *(f"Hard rule: {r.why}." for r in repairs)]
                return Reply(
                    Rewrite(
                        force_field=field,
                        changes=tuple(reasons),
                        rules_applied=tuple(dict.fromkeys(rules)),
                    )
                )
        why = "every remedy has been tried" if unmet else "no check failed that a force field could mend"
        return Reply(Rewrite(force_field=force_field, changes=(f"Nothing left to try: {why}.",)))


def _failed(judgement: Judgement, count: int, report: MotionReport) -> dict[int, list[Check]]:
    """Failed checks by expectation, in the order of the sentence.

    What could not be seen because the object left the picture or broke up counts as far too much.
    """
    failed: dict[int, list[Check]] = {}
    overdone = report.quality.leaves_frame is not None or report.quality.tracks_kept < _LOST
    for check in judgement.checks:
        if check.passed is None and overdone:
            check = check.model_copy(update=dict(passed=False, aspect="amount", gain=_CALM_DOWN))
        if check.passed is False and 0 <= check.expectation < count:
            failed.setdefault(check.expectation, []).append(check)
    return dict(sorted(failed.items()))


def _below_what_was_too_much(
    proposed: ForceField, current: ForceField, earlier: Sequence[Round]
) -> ForceField:
    """Halves the interval instead of leaping past a magnitude that an earlier attempt showed to be too much."""
    ceilings: dict[tuple, float] = {}
    for tried in earlier:
        if any(check.passed is None or (check.gain or 1) < 1 for check in tried.judgement.checks):
            for action in tried.force_field.actions:
                key = _same_action(action)
                ceilings[key] = min(ceilings.get(key, math.inf), abs(action.magnitude))
    now = {_same_action(action): abs(action.magnitude) for action in current.actions}

    def bounded(action: Action) -> Action:
        key = _same_action(action)
        ceiling, start = ceilings.get(key, math.inf), now.get(key, math.inf)
        if not start < ceiling <= abs(action.magnitude):
            return action
        between = math.copysign(math.sqrt(start * ceiling), action.magnitude)
        return action.model_copy(update=dict(magnitude=between))

    return proposed.model_copy(update=dict(actions=tuple(map(bounded, proposed.actions))))


def _same_action(action: Action) -> tuple:
    return action.action_type, action.vector, math.copysign(1, action.magnitude), action.region


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
        options = [change for change in list_remedies(case) if change.force_field != field]
        if not options:
            continue
        change = options[min(depth, len(options) - 1)]
        changes.append(change)
        field = change.force_field
    return changes
