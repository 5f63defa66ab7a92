"""The offline planner: compares a motion report with what the sentence leads a viewer to expect."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.protocols import PlannerAgent
from physagent_jax.agents.trace import Reply
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.changing import check_rotation, check_still, check_strain
from physagent_jax.motion.judging.collateral import check_collateral
from physagent_jax.motion.judging.explaining import explain_failure
from physagent_jax.motion.judging.following import check_following
from physagent_jax.motion.judging.moving import check_fall, check_move, check_sway
from physagent_jax.motion.judging.seen import View
from physagent_jax.motion.judging.stages import find_stage, judge_stages
from physagent_jax.motion.schema import Check, Judgement, MotionKind, Stage, Verdict
from physagent_jax.motion.tolerances import list_windows

_HIGHEST_FAILURE = 0.99
_UNASKED = ("collateral", "integrity")
_CHECKERS: dict[MotionKind, Callable[[Asked], list[Check]]] = {
    MotionKind.MOVE: check_move,
    MotionKind.ROTATE: check_rotation,
    MotionKind.STRETCH: check_strain,
    MotionKind.SQUEEZE: check_strain,
    MotionKind.SWAY: check_sway,
    MotionKind.FALL: check_fall,
    MotionKind.STILL: check_still,
}


class RulePlanner(PlannerAgent):
    """Judges by the sentence and the motion alone: what the force field holds is no yardstick.

    SUCCESS needs every clause to be seen and met, nothing that nobody asked for beyond what goes with the motion, and a
    reading without doubts.
    """

    def windows(self, context: AgentContext) -> list[tuple[int, int]]:
        """One per expectation."""
        return list_windows(context.expectations, context.brief.frame_count)

    def judge(self, context: AgentContext, seen: Observation) -> Reply[Judgement]:
        """Compare the report with what is expected of the sentence; see `protocols.PlannerAgent`."""
        expectations, reading = context.expectations, context.reading
        obstacles, unsure = (reading.world.obstacles, reading.unsure) if reading else ((), ())
        gravity = _has_gravity(context, seen)
        field = seen.force_field
        view = View(seen.report, context.brief, expectations, field, gravity, obstacles, context.prompt)
        checks = _make_checks(view)
        stages = judge_stages(expectations, checks)
        success = bool(checks) and all(check.passed for check in checks) and not unsure
        mean = sum(check.score for check in checks) / len(checks) if checks else 0.0
        asked = any(each.kind is not MotionKind.STILL for each in expectations)
        if asked and not success and view.motionless:
            mean = 0.0  # that nothing is spoilt either is no merit
        judgement = Judgement(
            verdict=Verdict.SUCCESS if success else Verdict.FAIL,
            score=round(mean if success else min(mean, _HIGHEST_FAILURE), 6),
            checks=tuple(checks),
            stages=stages,
            suggestion="" if success else _suggest(context, checks, stages, unsure, mean == 0.0),
        )
        return Reply(judgement)


def _make_checks(view: View) -> list[Check]:
    """Every comparison of what is asked with what is seen, in the order of the sentence, then collateral motion."""
    checks: list[Check] = []
    for index, expectation in enumerate(view.expectations):
        asked = Asked(index, expectation, view)
        checks += _CHECKERS[expectation.kind](asked) + check_following(asked)
    return checks + check_collateral(view) if view.expectations else []


def _has_gravity(context: AgentContext, seen: Observation) -> bool:
    """Return whether what is let go falls: a fact about the world, from the sentence or the scene."""
    told = context.reading.world.gravity if context.reading else None
    if told is not None:
        return told == "down"
    falls = any(e.kind is MotionKind.FALL for e in context.expectations)
    return context.brief.world == "ground" or falls or seen.force_field.default_drop


def _suggest(
    context: AgentContext,
    checks: list[Check],
    stages: Sequence[Stage],
    unsure: Sequence[str],
    motionless: bool = False,
) -> str:
    """One plain sentence that says why; doubts, the failed clauses, stage by stage and worst first, and the unseen."""
    if not checks:
        return (
            f"Nothing is expected of the sentence '{context.prompt.strip()[:120]}', so nothing can be judged."
        )
    failed = [check for check in checks if check.passed is False]
    failed.sort(key=lambda check: (find_stage(check.expectation, stages) or 0, check.score))
    unseen = [check for check in checks if check.passed is None]
    doubts = "; ".join(doubt.removesuffix(".") for doubt in unsure)
    words = [each.words for each in context.expectations]
    parts = [explain_failure(failed, unseen, words, motionless=motionless)]
    parts += (
        [f"Not understood for certain, so no motion can be called a success: {doubts}."] if unsure else []
    )
    parts += [_describe_failure(c, context.expectations[c.expectation].words, stages) for c in failed]
    if unseen:
        what = "; ".join(dict.fromkeys(f"{check.question} {check.observed}" for check in unseen))
        parts.append(f"Asked for, but not observable in the pictures: {what}.")
    return " ".join(filter(None, parts))


def _describe_failure(check: Check, words: str, stages: Sequence[Stage]) -> str:
    number = find_stage(check.expectation, stages)
    place = "" if number is None else f"Stage {number} of {len(stages)}: "
    remedy = f"; {check.remedy}" if check.remedy else ""
    asked = f"The sentence asks for '{words}'" if words else "The sentence asks for this motion"
    if check.aspect in _UNASKED:
        asked = "Nobody asked for this"
    limits = f"{check.question} {check.expected}"
    return f"{place}{asked} ({limits}), but the pictures show {check.observed}{remedy}."
