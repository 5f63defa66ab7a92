"""The verdict on a clip: every comparison of what is asked with what is seen, and why it fails."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.changing import check_rotation, check_still, check_strain
from physagent_jax.motion.judging.collateral import check_collateral
from physagent_jax.motion.judging.explaining import explain_failure
from physagent_jax.motion.judging.following import check_following
from physagent_jax.motion.judging.manner import check_manner, check_outline, check_split
from physagent_jax.motion.judging.moving import check_fall, check_move, check_sway
from physagent_jax.motion.judging.seen import View
from physagent_jax.motion.judging.stages import find_stage, judge_stages
from physagent_jax.motion.schema import Check, Judgement, MotionKind, Stage, Verdict

HIGHEST_FAILURE = 0.99
"""Score of a FAIL, at most."""
_PAIR = 2
_SOME = 1 / 3
"""Share of more parts than a pair, of those that are seen, which tells that all of them move."""
_SMALL = 0.3
"""Share of the volume of another part of the same words below which one says little."""
_UNDERSTOOD = "What is understood of the sentence is seen."
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


def judge(view: View, unsure: Sequence[str] = ()) -> Judgement:
    """Compare what is seen with what is asked.

    SUCCESS needs every motion to be seen and met, nothing that nobody asked for beyond what goes with the motions, and
    no doubt.

    Args:
        view: What is asked and seen.
        unsure: Doubts about what is asked, in plain sentences.
    """
    checks = _make_checks(view)
    stages = judge_stages(view.expectations, checks)
    success = bool(checks) and all(check.passed for check in checks) and not unsure
    mean = sum(check.score for check in checks) / len(checks) if checks else 0.0
    asked = any(each.kind is not MotionKind.STILL for each in view.expectations)
    if asked and not success and view.motionless:
        mean = 0.0  # that nothing is spoilt either is no merit
    return Judgement(
        verdict=Verdict.SUCCESS if success else Verdict.FAIL,
        score=round(mean if success else min(mean, HIGHEST_FAILURE), 6),
        checks=tuple(checks),
        stages=stages,
        suggestion="" if success else _suggest(view, checks, stages, unsure, mean == 0.0),
    )


def describe_doubts(unsure: Sequence[str]) -> str:
    """The sentence that says why no motion can be called a success."""
    doubts = "; ".join(doubt.removesuffix(".") for doubt in unsure)
    return f"Not understood for certain, so no motion can be called a success: {doubts}."


def _make_checks(view: View) -> list[Check]:
    """Every comparison of what is asked with what is seen, in the order of the sentence, then collateral motion."""
    checks: list[Check] = []
    for index, expectation in enumerate(view.expectations):
        asked = Asked(index, expectation, view)
        crumples = expectation.manner == "crumple" and not expectation.partial
        if expectation.manner == "fold" or crumples:
            checks += check_outline(asked)
            continue
        if expectation.manner == "split":
            checks += check_split(asked)
            continue
        checks += _CHECKERS[expectation.kind](asked) + check_following(asked) + check_manner(asked)
    checks = _leave_to_fellows(view, checks)
    return checks + check_collateral(view) if view.expectations else []


def _leave_to_fellows(view: View, checks: list[Check]) -> list[Check]:
    """Checks without those of a part that says little beside another of the same words, which is seen to move.

    Of two wings one may be behind the body, and lost from sight; of arms some may be small pieces at the shoulders. A
    viewer goes by the others. Of many leaves some go as the sentence says.
    """
    parts = {index for index, each in enumerate(view.expectations) if each.limb is not None}
    lost = {check.expectation for check in checks if check.passed is None} & parts

    def say(index: int) -> tuple[MotionKind, str]:
        return view.expectations[index].kind, view.expectations[index].words

    shares = {i: view.brief.parts[view.expectations[i].limb or 0].share for i in parts}
    left: set[int] = set()
    for index in parts:
        beside = [shares[other] for other in parts - lost - {index} if say(other) == say(index)]
        if beside and (index in lost or shares[index] < _SMALL * max(beside)):
            left.add(index)
    failed = {check.expectation for check in checks if not check.passed}
    for said in {say(index) for index in parts}:
        members = {index for index in parts if say(index) == said}
        seen = members - left
        if len(members) > _PAIR and len(seen - failed) >= _SOME * len(seen):
            left |= members & failed
    return [check for check in checks if check.passed is True or check.expectation not in left]


def _suggest(
    view: View, checks: list[Check], stages: Sequence[Stage], unsure: Sequence[str], motionless: bool
) -> str:
    """One plain sentence that says why; doubts, the failed clauses, stage by stage and worst first, and the unseen."""
    if not checks:
        return (
            f"Nothing is expected of the sentence '{view.sentence.strip()[:120]}', so nothing can be judged."
        )
    failed = [check for check in checks if check.passed is False]
    failed.sort(key=lambda check: (find_stage(check.expectation, stages) or 0, check.score))
    unseen = [check for check in checks if check.passed is None]
    words = [each.words for each in view.expectations]
    parts = [explain_failure(failed, unseen, words, motionless=motionless) or _UNDERSTOOD]
    parts += [describe_doubts(unsure)] if unsure else []
    parts += [_describe_failure(check, words[check.expectation], stages) for check in failed]
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
