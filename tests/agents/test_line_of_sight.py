"""Pictures without depth: what lies along the line of sight is no success, what lies across it is judged as ever."""

import numpy as np
import pytest

from physagent_jax.motion.schema import Verdict
from physagent_jax.perception.reasons import BY_SIZE, TURNED
from physagent_jax.perception.schema import MotionReport
from tests.agents.scenes import ZERO, brief, judge, list_windows, make_report, read, rewrite, seen_in

AWAY = (0.0, 1.0, 0.0)
TALL = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.3))
GROWN = tuple(tuple(row) for row in (1.3 * np.eye(3)).tolist())
ACROSS = [
    ("push the robot to the left", dict(displacement=(-0.8, 0.0, 0.0))),
    ("lift the robot", dict(displacement=(0.0, 0.0, 0.8))),
    ("tilt the robot to the left", dict(turn=(0.0, -30.0, 0.0))),
    ("stretch the robot upwards", dict(stretch=TALL)),
]
ALONG = [
    ("push the robot away from the camera", dict(displacement=(0.0, 0.8, 0.0)), BY_SIZE),
    ("pull the robot towards the camera", dict(displacement=(0.0, -0.8, 0.0)), BY_SIZE),
    ("spin the robot about the vertical axis", dict(turn=(0.0, 0.0, 90.0)), TURNED),
    ("inflate the robot", dict(stretch=GROWN), BY_SIZE),
]


def flatten(report: MotionReport, approach_shown: bool = False) -> MotionReport:
    """The report as pictures without depth give it."""
    windows = tuple(
        w.model_copy(update=dict(displacement_view_axis_observable=approach_shown)) for w in report.windows
    )
    return report.model_copy(update=dict(windows=windows, unmeasured_direction=AWAY))


@pytest.mark.parametrize(("sentence", "motion"), ACROSS)
def test_motions_in_the_picture_plane_are_judged_as_with_depth(sentence, motion):
    reading = read(sentence)
    seen = seen_in(reading.expectations, **motion)
    assert judge(sentence, reading, seen, brief()).judgement.verdict is Verdict.SUCCESS
    for shown in (False, True):
        flat = judge(sentence, reading, flatten(seen, shown), brief()).judgement
        assert flat.verdict is Verdict.SUCCESS, flat.suggestion


@pytest.mark.parametrize(("sentence", "motion", "why"), ALONG)
def test_motions_along_the_line_of_sight_are_no_success(sentence, motion, why):
    reading = read(sentence)
    seen = seen_in(reading.expectations, **motion)
    assert judge(sentence, reading, seen, brief()).judgement.verdict is Verdict.SUCCESS
    failed = judge(sentence, reading, flatten(seen), brief())
    assert failed.judgement.verdict is Verdict.FAIL and why in failed.judgement.suggestion
    assert not any(check.passed is False for check in failed.judgement.checks)
    rewrite(sentence, reading, failed, brief())


def test_an_approach_that_the_ground_confirms_is_a_success():
    sentence = "push the robot away from the camera"
    reading = read(sentence)
    seen = flatten(seen_in(reading.expectations, displacement=(0.0, 0.8, 0.0)), approach_shown=True)
    unsure = seen.uncertainty.model_copy(update=dict(along=1.2))
    assert judge(sentence, reading, seen, brief()).judgement.verdict is Verdict.SUCCESS
    seen = seen.model_copy(update=dict(uncertainty=unsure))
    assert "known to +-1.2 only" in judge(sentence, reading, seen, brief()).judgement.suggestion


def test_what_stands_still_across_the_sight_alone_is_not_known_to_stand_still():
    sentence = "the robot stands still"
    reading = read(sentence)
    still = make_report([ZERO] * 49, windows=list_windows(reading.expectations, 49))
    assert judge(sentence, reading, flatten(still, True), brief()).judgement.verdict is Verdict.SUCCESS
    unknown = judge(sentence, reading, flatten(still), brief()).judgement
    assert unknown.verdict is Verdict.FAIL and BY_SIZE in unknown.suggestion


def test_a_part_that_moves_along_the_sight_is_not_seen_to():
    sentence = "push the top of the robot away from the camera"
    reading = read(sentence)
    seen = seen_in(reading.expectations, displacement=(0.0, 0.5, 0.0))
    judgement = judge(sentence, reading, flatten(seen, True), brief()).judgement
    assert (
        judgement.verdict is Verdict.FAIL and "a part moves along the line of sight" in judgement.suggestion
    )
