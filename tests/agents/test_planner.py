"""The offline planner: synthetic motion reports against what sentences ask for."""

import math

import pytest

from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.agents.rules.tolerances import list_windows
from physagent_jax.agents.schema import ExpectedMotion, MotionKind, SemanticReply, Verdict
from physagent_jax.core.turning import find_turning_points
from physagent_jax.forces.schema import ForceField
from tests.agents.scenes import asked, brief, judge, read, report, seen_in, window


def judged(prompt: str, scene=None, field: ForceField | None = None, seen=None, **motion):
    """The judgement of a report that shows ``motion`` in every window that the sentence needs."""
    scene = scene or brief()
    reply = read(prompt, scene)
    seen = seen or seen_in(reply.expectations, scene.frame_count, **motion)
    return judge(prompt, reply, seen, scene, field).judgement


@pytest.mark.parametrize(
    ("prompt", "motion"),
    [
        ("push the robot to the left", {"displacement": (-1.0, 0.1, 0)}),
        ("push the robot slightly to the left", {"displacement": (-0.4, 0, 0)}),
        ("push the robot violently to the upper right", {"displacement": (1.1, 0, 1.1)}),
        ("spin the robot", {"rotation_axis": (0, 0, 1), "rotation_degrees": 95.0}),
        ("spin the robot clockwise", {"rotation_axis": (0, 0, -1), "rotation_degrees": 70.0}),
        ("stretch the robot", {"stretch": ((1.3, 0, 0), (0, 0.95, 0), (0, 0, 0.95)), "volume_ratio": 1.1}),
        ("compress the robot", {"stretch": ((1.1, 0, 0), (0, 1.1, 0), (0, 0, 0.7)), "volume_ratio": 0.85}),
        ("inflate the robot", {"volume_ratio": 1.3**3}),
        ("drop the robot", {"displacement": (0, 0, -0.5)}),
        ("the robot stands still", {"displacement": (0.01, 0, 0)}),
    ],
)  # fmt: skip
def test_right_motion_is_a_success(prompt, motion):
    """Motion as asked passes every check, with full score and no suggestion."""
    judgement = judged(prompt, **motion)
    assert judgement.verdict is Verdict.SUCCESS
    assert (judgement.score, judgement.suggestion) == (1.0, "")
    assert all(check.passed and not check.remedy for check in judgement.checks)


@pytest.mark.parametrize(
    ("prompt", "motion", "gain", "words"),
    [
        ("push the robot to the left", {"displacement": (-0.25, 0, 0)}, 4.0, "increase the magnitude of actions[0]"),
        ("push the robot to the left", {"displacement": (-4.0, 0, 0)}, 0.25, "decrease the magnitude of actions[0]"),
        ("spin the robot", {"rotation_axis": (0, 0, 1), "rotation_degrees": 30.0}, 3.0, "increase"),
        ("stretch the robot", {"stretch": ((1.05, 0, 0), (0, 1, 0), (0, 0, 1))}, 6.0, "increase"),
        ("squeeze the robot", {"stretch": ((0.2, 0, 0), (0, 1, 0), (0, 0, 1))}, 0.375, "decrease"),
    ],
)  # fmt: skip
def test_too_little_or_too_much_gives_a_gain(prompt, motion, gain, words):
    """The gain is target over seen, and the suggestion says it in words."""
    judgement = judged(prompt, **motion)
    assert judgement.verdict is Verdict.FAIL
    amount = next(check for check in judgement.checks if check.aspect == "amount")
    assert amount.gain == pytest.approx(gain, rel=1e-3)
    assert words in judgement.suggestion and "The sentence asks for" in judgement.suggestion


def test_wrong_way_with_a_wrong_vector_is_to_be_reversed():
    """A field that drives the object against the sentence is to be reversed; the score is near zero."""
    reply = read("push the robot to the right")
    judgement = judged("push the robot to the left", field=reply.force_field, displacement=(1.0, 0, 0))
    assert judgement.verdict is Verdict.FAIL and judgement.score < 0.1
    assert all(check.gain < 0 for check in judgement.checks)
    assert "reverse actions[0]" in judgement.suggestion


def test_wrong_way_with_the_right_vector_is_to_be_overcome():
    """The fixed mapping stays: what points as the sentence says is not to be reversed."""
    judgement = judged("push the robot to the left", displacement=(1.0, 0, 0))
    assert "reverse" not in judgement.suggestion and "overcomes" in judgement.suggestion


def test_score_grades_iterations():
    """Closer motion scores higher."""
    scores = [
        judged("push the robot to the left", displacement=(-d, 0, 0)).score for d in (0.05, 0.2, 0.4, 0.9)
    ]
    assert scores == sorted(scores) and scores[-1] == 1.0 and len(set(scores)) == 4


def test_wrong_kind_is_named():
    """Rotation in place of travel is said."""
    judgement = judged("push the robot left", rotation_axis=(0, 0, 1), rotation_degrees=60.0)
    assert "a rotation by 60 degrees" in judgement.suggestion


@pytest.mark.parametrize(
    ("prompt", "hidden"),
    [("push it left", {"displacement": None, "unobservable": {"displacement": "the mask was lost"}}),
     ("spin it", {"rotation_degrees": None, "unobservable": {"rotation_degrees": "the mask was lost"}}),
     ("stretch it", {"stretch": None, "volume_ratio": None, "unobservable": {"stretch": "the mask was lost"}})],
)  # fmt: skip
def test_nothing_observable_fails_and_says_so(prompt, hidden):
    """What cannot be seen is neither passed nor failed; if nothing can, the verdict is FAIL with the reason."""
    judgement = judged(prompt, **hidden)
    assert judgement.verdict is Verdict.FAIL and judgement.score == 0
    assert all(check.passed is None for check in judgement.checks)
    assert "not observable" in judgement.suggestion and "the mask was lost" in judgement.suggestion


def test_unobservable_parts_are_not_counted():
    """One observable expectation decides if the other cannot be seen."""
    judgement = judged(
        "push the robot left while spinning it",
        displacement=(-1, 0, 0), rotation_degrees=None, rotation_axis=None,
    )  # fmt: skip
    assert judgement.verdict is Verdict.SUCCESS
    assert [check.passed for check in judgement.checks] == [True, True, None]


def test_window_that_perception_was_not_asked_for():
    """A report without the window is not observable rather than an error."""
    reply = read("push it left, then up")
    judgement = judge("", reply, report([window(0, 48)]), brief()).judgement
    assert judgement.verdict is Verdict.FAIL and "not in the motion report" in judgement.suggestion


def test_leaving_the_picture_hides_the_distance():
    """Too small a distance is no failure if the object left the picture on its way."""
    reply = read("push it left")
    seen = report([window(0, 48, displacement=(-0.3, 0, 0))], leaves_frame=20)
    judgement = judge("", reply, seen, brief()).judgement
    assert judgement.checks[0].passed is None and "frame 20" in judgement.suggestion


def test_a_held_object_moves_less():
    """A tenth of a body length is right for a held plant and too little for a free robot."""
    assert (
        judged("push it left", brief(anchored="base"), displacement=(-0.1, 0, 0)).verdict is Verdict.SUCCESS
    )
    assert judged("push it left", displacement=(-0.1, 0, 0)).verdict is Verdict.FAIL


def test_depth_stretch_falls_back_to_the_bounding_box():
    """Along the line of sight the affine fit guesses: the box's volume is used, and said."""
    judgement = judged(
        "stretch it along its depth", stretch_view_axis_observable=False, volume_ratio=1.12,
        stretch=((1, 0, 0), (0, 5.0, 0), (0, 0, 1)),
    )  # fmt: skip
    assert judgement.verdict is Verdict.SUCCESS
    assert "bounding box" in judgement.checks[0].observed


def sway_report(scene, prompt, cycles: float, amplitude: float):
    path = [(amplitude * math.sin(2 * math.pi * cycles * f / 48), 0, 0) for f in range(49)]
    spans = [(0, 48), *list_windows(read(prompt, scene).expectations, 49)]
    return report([window(*span) for span in dict.fromkeys(spans)], centroid=path)


@pytest.mark.parametrize(
    ("cycles", "amplitude", "passed"),
    [(2, 0.1, True), (0.2, 0.1, False), (2, 0.001, False), (20, 0.1, False)],
)
def test_sway_needs_size_and_turns(cycles, amplitude, passed):
    """A sway must be visible and turn back about as often as told."""
    scene, prompt = brief(anchored="base"), "the plant sways left and right twice"
    judgement = judged(prompt, scene, seen=sway_report(scene, prompt, cycles, amplitude))
    assert (judgement.verdict is Verdict.SUCCESS) == passed


def test_let_go_must_come_back():
    """After the release a held object must come back towards rest."""
    scene = brief(anchored="base")
    prompt = "bend the plant to the left, then let go"
    for rest, verdict in ((0.02, Verdict.SUCCESS), (0.2, Verdict.FAIL)):
        path = [(-0.2 * min(f / 24, 1), 0, 0) for f in range(25)] + [(-rest, 0, 0)] * 24
        windows = [window(0, 48, displacement=(-rest, 0, 0)), window(0, 24, displacement=(-0.2, 0, 0))]
        judgement = judged(prompt, scene, seen=report(windows, centroid=path))
        assert judgement.verdict is verdict
    assert "end earlier" in judgement.suggestion


@pytest.mark.parametrize(
    ("path", "turns"),
    [
        ([0, 1, 2, 3], 0),
        ([0, 1, 0], 1),
        ([0, 1, 0, 1, 0], 3),
        ([0, 1, 0.99, 1.0], 0),
        ([0, 0, 0], 0),
        ([0, -1, 1], 1),
    ],
)
def test_reversals(path, turns):
    """Turns larger than the noise are counted, smaller ones are not."""
    assert len(find_turning_points(path, 0.05)) == turns


def test_expectation_windows_are_whole_inside_and_unique():
    """Fractional and repeated windows become whole frames inside the clip, once each."""
    expectations = [
        ExpectedMotion(kind=MotionKind.MOVE, window=span)
        for span in ((0.2, 9.7), (0, 10), (47.9, 48), (0, 500))
    ]
    assert list_windows(expectations, 49) == [(0, 10), (47, 48), (0, 48)]
    assert list_windows(expectations[:1], 1) == [(0, 0)]


def test_the_planner_asks_for_a_window_per_expectation():
    """They come from the planner, which knows what it compares; without expectations it needs none."""
    prompt = "push it left, then up"
    reply = read(prompt)
    context = asked(prompt, brief(), reply)
    assert RulePlanner().windows(context) == list_windows(reply.expectations, 49)
    assert RulePlanner().windows(asked(prompt, brief(), SemanticReply(force_field=reply.force_field))) == []


def test_without_expectations_nothing_can_be_judged_by_rules():
    """A reading without expectations is whole; the rules say that they have nothing to compare."""
    reply = SemanticReply(force_field=ForceField())
    judgement = judge("", reply, report([window(0, 48)]), brief()).judgement
    assert judgement.verdict is Verdict.FAIL and "Nothing is expected" in judgement.suggestion
