"""The offline executor: mends the best force field so far, inside the hard rules, and never tries one twice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice, tee

from physagent_jax.agents.context import AgentContext, Round
from physagent_jax.agents.hard_rules import Repair, apply_hard_rules
from physagent_jax.agents.protocols import ExecutorAgent
from physagent_jax.agents.rules.holding import should_hold
from physagent_jax.agents.rules.remedies import list_remedies
from physagent_jax.agents.rules.sparing import find_kept
from physagent_jax.agents.schema import Rewrite
from physagent_jax.agents.trace import Reply
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.edits import Case, Change
from physagent_jax.motion.judging.progress import Rating, rate
from physagent_jax.motion.schema import Check, Judgement
from physagent_jax.perception.schema import MotionReport

_LOST = 0.2  # share of tracks kept, below which the object cannot have stayed in one piece
_CALM_DOWN = 0.6  # factor on the cause of what could not be followed
_DEEPEST = 8  # remedies per expectation that are worth trying in turn
_PASSED = 1.0  # gain of what needed no change


class RuleExecutor(ExecutorAgent):
    """Mends the failed stages of the best round, all at once, and leaves the entries of the others as they are.

    Without checks it has nothing to go by.
    """

    def rewrite(self, context: AgentContext, failed: Round) -> Reply[Rewrite]:
        """Return the next force field; see `protocols.ExecutorAgent`.

        It goes out from the round that came nearest: a change that made things worse is dropped. The mildest remedies
        come first; if they lead to a force field that was tried before, the next ones are taken, and then those of the
        round that came second. If none is left, or nothing that was measured failed in a round that came nearer, the
        last field is returned unchanged and ``changes`` says so. What goes over as a whole where it should change its
        shape is held first, with its force field as it is.
        """
        if should_hold(context, failed):
            why = "It goes over as a whole where it should change its shape: it is held at its base."
            return Reply(Rewrite(force_field=failed.force_field, hold="base", changes=(why,)))
        rounds = [*context.rounds, failed]
        tried = [each.force_field for each in rounds]
        limits: list[str] = []
        hopeful = False
        for base in rank(rounds):
            if base.judgement.checks and all(check.passed for check in base.judgement.checks):
                break  # only doubts about the sentence keep it from being a success
            unmet = _group_failed(base.judgement, len(context.expectations), base.report)
            hopeful = hopeful or bool(unmet)
            for depth in range(_DEEPEST if unmet else 0):
                changes = _mend(context, base, rounds, unmet, depth)
                if not changes:
                    continue
                field = changes[-1].force_field
                field, repairs = apply_hard_rules(field, context.brief, context.expectations)
                if field in tried:
                    limits += [change.why for change in changes if "cannot be made" in change.why]
                    continue
                return Reply(_explain(field, changes, repairs, base, rounds))
        why = "every remedy has been tried" if hopeful else "no check failed that a force field could mend"
        said = (f"Nothing left to try: {why}.", *dict.fromkeys(limits))
        return Reply(Rewrite(force_field=failed.force_field, changes=said))


def rank(rounds: Sequence[Round]) -> list[Round]:
    """Rounds by stages met, then by score, best first, the later of equals first; the last alone without scores."""
    if any(each.judgement.score is None for each in rounds):
        return [rounds[-1]]
    return sorted(reversed(rounds), key=lambda each: rate(each.judgement) or Rating(0, 0.0), reverse=True)


def _explain(
    field: ForceField, changes: list[Change], repairs: Sequence[Repair], base: Round, rounds: list[Round]
) -> Rewrite:
    back = ()
    if base is not rounds[-1]:
        best = "the best round" if base is rank(rounds)[0] else f"round {rounds.index(base) + 1}"
        back = (f"The last change made it no better: this goes out from {best}.",)
    rules = [*(change.rule for change in changes if change.rule), *(repair.rule for repair in repairs)]
    reasons = [*back, *(change.why for change in changes), *(f"Hard rule: {r.why}." for r in repairs)]
    return Rewrite(force_field=field, changes=tuple(reasons), rules_applied=tuple(dict.fromkeys(rules)))


def _group_failed(judgement: Judgement, count: int, report: MotionReport) -> dict[int, list[Check]]:
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


def _mend(
    context: AgentContext, base: Round, rounds: Sequence[Round], failed: dict[int, list[Check]], depth: int
) -> list[Change]:
    """One remedy per failed expectation, each on the result of the one before; ``depth`` skips the mildest.

    Remedies that leave the stages that were met as they are go before all others.
    """
    changes: list[Change] = []
    field, expectations = base.force_field, context.expectations
    kept = find_kept(base, expectations, failed)
    for index, checks in failed.items():
        earlier = tuple(_list_gains(index, [each for each in rounds if each is not base]))
        case = Case(field, expectations[index], expectations, context.brief, checks, base.report, earlier)
        effective, again = tee(_list_effective(case, context))
        spared = (each for change in effective if (each := kept.spare(change, field)))
        options = list(islice(spared, depth + 1)) or list(islice(again, depth + 1))
        if options:
            changes.append(options[-1])
            field = changes[-1].force_field
    return changes


def _list_effective(case: Case, context: AgentContext) -> Iterator[Change]:
    """Remedies that are left when the hard rules have had their say: what they undo is no remedy."""
    for change in list_remedies(case):
        field = change.force_field
        if field == case.force_field:
            continue
        if apply_hard_rules(field, context.brief, context.expectations)[0] != case.force_field:
            yield change


def _list_gains(index: int, rounds: Sequence[Round]):
    """Force fields of other rounds with the gain that their amount of an expectation asked for."""
    for each in rounds:
        seen = [c for c in each.judgement.checks if c.expectation == index and c.passed is not None]
        amounts = [check for check in seen if check.aspect == "amount"]
        if amounts:
            worst = min(amounts, key=lambda check: check.score)
            yield each.force_field, worst.gain if worst.gain is not None else _PASSED
