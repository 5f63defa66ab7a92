"""Stages of a sentence: motions that begin together, with a verdict on each stage."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.motion.schema import Check, ExpectedMotion, Stage, StageVerdict

_TOGETHER = 1.0  # frames by which the beginnings of motions of one stage may differ


def group_stages(expectations: Sequence[ExpectedMotion]) -> list[tuple[int, ...]]:
    """Indices of the expected motions, stage by stage, in the order of time."""
    ordered = sorted(range(len(expectations)), key=lambda index: (expectations[index].window[0], index))
    stages: list[list[int]] = []
    for index in ordered:
        begin = expectations[index].window[0]
        if stages and begin - expectations[stages[-1][0]].window[0] <= _TOGETHER:
            stages[-1].append(index)
        else:
            stages.append([index])
    return [tuple(sorted(stage)) for stage in stages]


def judge_stages(expectations: Sequence[ExpectedMotion], checks: Sequence[Check]) -> tuple[Stage, ...]:
    """Every stage of a sentence with its verdict, in the order of time."""
    stages = []
    for members in group_stages(expectations):
        motions = [expectations[index] for index in members]
        own = [check for check in checks if check.expectation in members]
        decisive = _find_decisive(own)
        stages.append(
            Stage(
                expectations=members,
                words=" and ".join(dict.fromkeys(each.words for each in motions if each.words)),
                window=(min(e.window[0] for e in motions), max(e.window[1] for e in motions)),
                verdict=_find_verdict(own),
                asked="" if decisive is None else f"{decisive.question} {decisive.expected}",
                measured="" if decisive is None else decisive.observed,
                misfit=round(max((1.0 - check.score for check in own if not check.passed), default=0.0), 6),
            )
        )
    return tuple(stages)


def find_stage(index: int, stages: Sequence[Stage]) -> int | None:
    """Number of the stage of an expected motion, counted from 1; None if there is only one, or none."""
    if len(stages) < 2:
        return None
    return next((n for n, stage in enumerate(stages, 1) if index in stage.expectations), None)


def _find_verdict(checks: Sequence[Check]) -> StageVerdict:
    if any(check.passed is False for check in checks):
        return StageVerdict.NOT_MET
    if not checks or any(check.passed is None for check in checks):
        return StageVerdict.NOT_SEEN
    return StageVerdict.MET


def _find_decisive(checks: Sequence[Check]) -> Check | None:
    """The check that says most about a stage: the worst that failed, else one that was not seen, else the amount."""
    failed = sorted((check for check in checks if check.passed is False), key=lambda check: check.score)
    unseen = [check for check in checks if check.passed is None]
    amounts = [check for check in checks if check.aspect == "amount"]
    return next(iter((*failed, *unseen, *amounts, *checks)), None)
