"""All clauses of a judgement: those of every expectation, and those of what nobody asked for."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.judging.asked import Asked
from physagent_jax.agents.rules.judging.changing import check_rotation, check_still, check_strain
from physagent_jax.agents.rules.judging.collateral import check_collateral
from physagent_jax.agents.rules.judging.following import check_following
from physagent_jax.agents.rules.judging.moving import check_fall, check_move, check_sway
from physagent_jax.agents.rules.judging.seen import View
from physagent_jax.agents.schema import Check, MotionKind

_CHECKERS: dict[MotionKind, Callable[[Asked], list[Check]]] = {
    MotionKind.MOVE: check_move,
    MotionKind.ROTATE: check_rotation,
    MotionKind.STRETCH: check_strain,
    MotionKind.SQUEEZE: check_strain,
    MotionKind.SWAY: check_sway,
    MotionKind.FALL: check_fall,
    MotionKind.STILL: check_still,
}


def make_checks(view: View) -> list[Check]:
    """Every comparison of what is asked with what is seen, in the order of the sentence, then collateral motion."""
    checks: list[Check] = []
    for index, expectation in enumerate(view.expectations):
        asked = Asked(index, expectation, view)
        checks += _CHECKERS[expectation.kind](asked) + check_following(asked)
    return checks + check_collateral(view) if view.expectations else []
