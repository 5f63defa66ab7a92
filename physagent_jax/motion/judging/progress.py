"""Progress over the rounds of a run: the better of two judgements, the best round, and the end of improvement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from physagent_jax.motion.schema import Judgement, Verdict

PATIENCE = 2
"""Rounds in a row without an improvement after which a run ends."""
LEAST = 0.01
"""Part of a full score that the misfit has to shrink by to count as an improvement."""


class Rating(NamedTuple):
    """The quality of a round; rounds are compared by stages first.

    Attributes:
        stages_met: Number of stages that came true.
        score: Score of the whole.
    """

    stages_met: int
    score: float


def rate(judgement: Judgement) -> Rating | None:
    """The rating of a judgement; None if the planner gives no score."""
    return None if judgement.score is None else Rating(judgement.stages_met, judgement.score)


def find_best_round(judgements: Sequence[Judgement]) -> int:
    """Index of the round with most stages met, then of the highest score, the first of equals.

    Without scores it is the first success, else the last round.
    """
    ratings = [rating for each in judgements if (rating := rate(each)) is not None]
    if len(ratings) == len(judgements):
        return ratings.index(max(ratings))
    verdicts = [judgement.verdict for judgement in judgements]
    return verdicts.index(Verdict.SUCCESS) if Verdict.SUCCESS in verdicts else len(verdicts) - 1


def has_stalled(judgements: Sequence[Judgement]) -> bool:
    """Return whether the last `PATIENCE` rounds brought no improvement on those before.

    An improvement is one more stage met; or, with as many stages met, a sum of the stages' misfits that is smaller by
    `LEAST`, or a score that is higher by it. Without scores nothing is compared, and no run stalls.
    """
    before, after = judgements[:-PATIENCE], judgements[-PATIENCE:]
    if not before or any(each.score is None for each in judgements):
        return False
    met = max(each.stages_met for each in before)
    alike = [each for each in before if each.stages_met == met]
    misfit, score = min(map(_sum_misfits, alike)), max(each.score or 0.0 for each in alike)
    for each in after:
        closer = _sum_misfits(each) <= misfit - LEAST or (each.score or 0.0) >= score + LEAST
        if each.stages_met > met or (each.stages_met == met and closer):
            return False
    return True


def _sum_misfits(judgement: Judgement) -> float:
    return sum(stage.misfit for stage in judgement.stages)
