"""Motions that the pictures do not show are no success and no error."""

import numpy as np
import pytest

from physagent_jax.motion.schema import Verdict
from physagent_jax.perception.reasons import FILLING, GONE
from physagent_jax.perception.schema import MotionReport
from physagent_jax.perception.unobservable import report_nothing
from tests.agents.scenes import ZERO, brief, judge, list_windows, make_report, ramp, read, rewrite

COUNT = 49
SENTENCES = [
    "push the robot to the left",
    "the robot stands still",
    "nothing happens",
    "spin the robot about the vertical axis",
    "stretch the robot upwards",
    "squash the robot",
    "inflate the robot",
    "drop the robot",
    "the robot sways twice to the left and right",
    "twist the head of the robot by 90 degrees",
    "bend the robot to the left, then let go",
    "push the robot to the left by half its length, then lift it and hold it there",
    "hit the robot three times from the right",
]
SCENES = [brief(), brief(world="ground"), brief(anchored="base")]


def hide(report: MotionReport, first: int) -> MotionReport:
    """The report of a clip in which the object is gone from frame ``first`` on, without a way out of the picture."""

    def cut(series):
        return tuple(value if t < first else None for t, value in enumerate(series))

    fields = ("displacement", "path_length", "rotation_axis", "rotation_degrees", "stretch", "volume_ratio")
    lost = dict.fromkeys(fields) | {"unobservable": dict.fromkeys(fields, GONE)}
    series = ("centroid", "rotation_degrees", "volume_ratio", "rotation", "stretch", "box", "pieces")
    ends = [
        p.model_copy(update=dict(centroid=cut(p.centroid), rotation=cut(p.rotation))) for p in report.parts
    ]
    windows = [w if w.last < first else w.model_copy(update=lost) for w in report.windows]
    changed = {name: cut(getattr(report, name)) for name in series}
    return report.model_copy(update=changed | {"parts": tuple(ends), "windows": tuple(windows)})


@pytest.mark.parametrize("sentence", SENTENCES)
def test_a_clip_that_shows_nothing_is_no_success(sentence):
    for scene in SCENES:
        reading = read(sentence, scene)
        asked = list_windows(reading.expectations, COUNT)
        masks = np.zeros((COUNT, 20, 20), bool)
        reports = [
            report_nothing(masks, GONE, 0.04, [(0, COUNT - 1), *asked], []),
            report_nothing(~masks, FILLING, 0.04, [(0, COUNT - 1), *asked], []),
            hide(make_report([ZERO] * COUNT, windows=asked), 1),
        ]
        for report in reports:
            failed = judge(sentence, reading, report, scene)
            assert failed.judgement.verdict is Verdict.FAIL
            assert "not observable" in failed.judgement.suggestion
            if set(report.centroid) == {None}:
                assert not any(check.passed for check in failed.judgement.checks)
            rewrite(sentence, reading, failed, scene)


@pytest.mark.parametrize("first", [5, 12, 24, 40])
def test_a_clip_that_ends_in_the_dark_is_no_success(first):
    """Half the way is enough, and so is standing still, but nobody knows what comes after."""
    for sentence, places in (
        ("push the robot to the left", [(-0.8 * ramp(t, 0, 24), 0.0, 0.0) for t in range(COUNT)]),
        ("the robot stands still", [ZERO] * COUNT),
    ):
        reading = read(sentence)
        whole = make_report(places, windows=list_windows(reading.expectations, COUNT))
        assert judge(sentence, reading, whole, brief()).judgement.verdict is Verdict.SUCCESS
        judgement = judge(sentence, reading, hide(whole, first), brief()).judgement
        assert judgement.verdict is Verdict.FAIL
        assert (
            f"not known in {COUNT - first} of {COUNT} frames, first in frame {first}" in judgement.suggestion
        )


def test_a_frame_or_two_without_the_object_do_not_matter():
    sentence = "the robot stands still"
    reading = read(sentence)
    whole = make_report([ZERO] * COUNT, windows=list_windows(reading.expectations, COUNT))
    places = tuple(None if t in (20, 30) else p for t, p in enumerate(whole.centroid))
    seen = whole.model_copy(update={"centroid": places})
    assert judge(sentence, reading, seen, brief()).judgement.verdict is Verdict.SUCCESS
