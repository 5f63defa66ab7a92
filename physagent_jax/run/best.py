"""Which of several judged rounds is the result."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.schema import Judgement, Verdict


def find_best_round(judgements: Sequence[Judgement]) -> int:
    """Index of the highest score, the first of equals; without scores the first success, else the last round."""
    scores = [judgement.score for judgement in judgements if judgement.score is not None]
    if len(scores) == len(judgements):
        return scores.index(max(scores))
    verdicts = [judgement.verdict for judgement in judgements]
    return verdicts.index(Verdict.SUCCESS) if Verdict.SUCCESS in verdicts else len(verdicts) - 1
