"""The end of the rounds: reasons to make no further one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from physagent_jax.motion.judging.progress import has_stalled
from physagent_jax.motion.schema import Judgement, Verdict

StopReason = Literal[
    "success", "cap", "no improvement", "nothing left to try", "doubts", "not observable", "failed round"
]
"""Reasons for which no further round is made."""

STOP_REASONS: dict[StopReason, str] = {
    "success": "the planner is satisfied",
    "cap": "as many rounds as were allowed",
    "no improvement": "the last rounds brought no improvement",
    "nothing left to try": "the executor has nothing left to try",
    "doubts": "the sentence is not understood for certain, so no other force can make it right",
    "not observable": "all that can be seen is right, and what is left cannot be seen whatever the force",
    "failed round": "the next round could not be simulated",
}
"""The reasons in words."""


def find_stop(judgements: Sequence[Judgement], cap: int, *, doubts: bool = False) -> StopReason | None:
    """The reason to make no further round, as far as the judgements tell; None = go on.

    Args:
        judgements: Judgements of the rounds so far, oldest first.
        cap: Number of rounds at most.
        doubts: Whether the sentence is not understood for certain: what fails then is not the force.
    """
    if judgements[-1].verdict is Verdict.SUCCESS:
        return "success"
    if has_stalled(judgements):
        return "no improvement"
    if len(judgements) >= cap:
        return "cap"
    return "doubts" if doubts else None


def explain_rest(judgement: Judgement) -> StopReason:
    """The reason for which an executor leaves a force field as it is."""
    unseen = any(check.passed is None for check in judgement.checks)
    failed = any(check.passed is False for check in judgement.checks)
    return "not observable" if unseen and not failed else "nothing left to try"
