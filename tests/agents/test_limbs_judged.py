"""The verdict on a part that sticks out: by its own motion, in lengths of the part."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.metrics import report_true_motion
from physagent_jax.motion.schema import MotionKind, Verdict
from tests.agents.scenes import Unseen, brief
from tests.agents.test_limbs import HEAD, make_part, read

SENTENCE = "raise the right arm"
ARM = make_part("arm", (0.15, 0, 0), (1, 0, 0))
SHOULDER = np.array([0.2, 0.0, 0.1])


def judge(degrees, *, whole=0.0, seen_until=49, shown=1.0, still=None, stays=None, sentence=SENTENCE):
    """The verdict on an arm of 0.15 lengths that turns up evenly within a second, on a body that rises by ``whole``.

    Of the way of its middle a share is ``shown``, as of what turns a hidden side. The part ``still`` is called an arm
    as well, and does not move.
    """
    chance = np.random.default_rng(0)
    body = chance.uniform((-0.2, -0.1, -0.5), (0.2, 0.1, 0.5), (600, 3))
    arm = chance.uniform((0.2, -0.03, 0.07), (0.35, 0.03, 0.13), (60, 3))
    frames = []
    for frame in range(49):
        share = min(frame / 25, 1.0)
        c, s = np.cos(np.radians(degrees) * share), np.sin(np.radians(degrees) * share)
        turned = SHOULDER + (arm - SHOULDER) @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        frames.append(np.concatenate([body, turned]) + (0, 0, whole * share))
    reply, parts = read(sentence, ARM, HEAD), (ARM, still or HEAD)
    if still:
        asked = (*reply.expectations, reply.expectations[0].model_copy(update=dict(limb=1)))
        reply = reply.model_copy(update=dict(expectations=asked))
    if stays:
        quiet = dict(kind=MotionKind.STILL, direction=None, limb=parts.index(stays))
        asked = (*reply.expectations, reply.expectations[0].model_copy(update=quiet))
        reply = reply.model_copy(update=dict(expectations=asked))
    context = AgentContext(sentence, brief(parts=parts, anchored="all but the part"), (), reply)
    windows = RulePlanner().windows(context)
    report = report_true_motion(
        np.stack(frames),
        frame_dt=0.04,
        windows=windows,
        parts={0: np.arange(660) >= 600, 1: np.arange(660) < 30},
    )
    parts = [
        each.model_copy(
            update=dict(
                centroid=(
                    *[tuple(shown * x for x in place) for place in each.centroid[:seen_until]],
                    *[None] * (49 - seen_until),
                )
            )
        )
        if each.limb is not None
        else each
        for each in report.parts
    ]
    report = report.model_copy(update=dict(parts=tuple(parts)))
    return RulePlanner().judge(context, Observation(reply.force_field, report, Unseen())).value


@pytest.mark.parametrize(("degrees", "verdict"), [(45, "SUCCESS"), (2, "FAIL"), (-45, "FAIL"), (0, "FAIL")])
def test_an_arm_that_is_raised_is_judged_by_itself(degrees, verdict):
    """45 degrees move the middle of so short an arm by 0.06 body lengths: little of the object, much of the arm."""
    assert judge(degrees).verdict is Verdict(verdict)


@pytest.mark.parametrize(("degrees", "verdict"), [(75, "SUCCESS"), (40, "FAIL")])
@pytest.mark.parametrize("until", ["until it points at the sky", "straight up"])
def test_half_of_the_way_to_a_pose_is_too_little(until, degrees, verdict):
    assert judge(degrees, sentence=f"raise the right arm {until}").verdict is Verdict(verdict)


@pytest.mark.parametrize(("rigid", "verdict"), [(True, "SUCCESS"), (False, "FAIL")])
def test_a_piece_that_turns_about_its_axle_keeps_its_shape(rigid, verdict):
    """Blades that are alike are followed wrongly, which looks as if they stretched."""
    moved = HEAD.moved.model_copy(update=dict(rigid=rigid))
    rotor = HEAD.model_copy(update=dict(name="rotor", origin="file", moved=moved, axle=(0, 1, 0)))
    body = np.random.default_rng(0).uniform((-0.2, -0.1, -0.5), (0.2, 0.1, 0.5), (800, 3))
    turning = np.random.default_rng(1).uniform((-0.2, -0.1, -0.2), (0.2, 0.1, 0.2), (200, 3))
    turns = [Rotation.from_rotvec((0, np.radians(7.5) * k, 0)) for k in range(49)]
    reply = read(sentence := "the rotor spins", rotor)
    context = AgentContext(sentence, brief(parts=(rotor,), anchored="all but the part"), (), reply)
    way = np.sign(reply.expectations[0].direction[1])
    report = report_true_motion(
        np.stack(
            [np.concatenate([body, (turn if way > 0 else turn.inv()).apply(turning)]) for turn in turns]
        ),
        frame_dt=0.04,
        windows=RulePlanner().windows(context),
        parts={0: np.arange(1000) >= 800},
    )
    stretched = ((6.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    report = report.model_copy(update=dict(stretch=(stretched,) * 49, extents=()))
    judged = RulePlanner().judge(context, Observation(reply.force_field, report, Unseen())).value
    assert judged.verdict is Verdict(verdict), judged.checks


@pytest.mark.parametrize(("shown", "verdict"), [(0.33, "SUCCESS"), (0.15, "FAIL")])
def test_an_arm_that_is_seen_to_turn_may_show_less_of_its_way(shown, verdict):
    assert judge(45, shown=shown).verdict is Verdict(verdict)


@pytest.mark.parametrize(("share", "verdict"), [(0.1, "FAIL"), (0.01, "SUCCESS")])
def test_a_small_piece_that_is_called_an_arm_as_well_says_little(share, verdict):
    assert judge(45, still=ARM.model_copy(update=dict(share=share))).verdict is Verdict(verdict)


@pytest.mark.parametrize(("squeezed", "verdict"), [(0.6, "SUCCESS"), (0.02, "FAIL"), (-0.3, "FAIL")])
@pytest.mark.parametrize("sentence", ["squeeze the head from both sides", "squeeze the top from both sides"])
def test_a_part_that_is_squeezed_is_judged_by_its_own_breadth(sentence, squeezed, verdict):
    body = np.random.default_rng(0).uniform((-0.2, -0.2, -0.5), (0.2, 0.2, 0.5), (900, 3))
    head = body[:, 2] > 0.2
    frames = []
    for frame in range(49):
        frames.append(body.copy())
        frames[-1][head, 0] *= 1 - squeezed * min(frame / 25, 1.0)
    reply = read(sentence, HEAD)
    assert {each.kind for each in reply.expectations} == {MotionKind.SQUEEZE}
    context = AgentContext(sentence, brief(parts=(HEAD,)), (), reply)
    windows = RulePlanner().windows(context)
    report = report_true_motion(np.stack(frames), frame_dt=0.04, windows=windows, parts={0: head})
    judged = RulePlanner().judge(context, Observation(reply.force_field, report, Unseen())).value
    assert judged.verdict is Verdict(verdict), judged.checks


def test_a_limb_that_turns_the_wrong_way_is_no_stillness():
    assert "Nothing moves" in judge(2).suggestion
    assert "Nothing moves" not in judge(-40, shown=0.1).suggestion


def test_an_object_that_rises_with_its_arm_still_is_no_raised_arm():
    assert judge(0, whole=0.3).verdict is Verdict.FAIL


@pytest.mark.parametrize(("rigid", "verdict"), [(True, "SUCCESS"), (False, "FAIL")])
def test_a_piece_of_its_own_may_come_off(rigid, verdict):
    """A lid that is lifted is a second piece in the picture; the head of one skin is torn off."""
    moved = HEAD.moved.model_copy(update=dict(rigid=rigid))
    lid = HEAD.model_copy(update=dict(name="lid", origin="file", moved=moved, seated=True))
    sentence = "lift the lid"
    chance = np.random.default_rng(0)
    body = chance.uniform((-0.2, -0.2, -0.5), (0.2, 0.2, 0.3), (600, 3))
    top = chance.uniform((-0.2, -0.2, 0.3), (0.2, 0.2, 0.5), (200, 3))
    frames = [np.concatenate([body, top + (0, 0, 0.3 * min(k / 25, 1))]) for k in range(49)]
    reply = read(sentence, lid)
    context = AgentContext(sentence, brief(parts=(lid,), anchored="all but the part"), (), reply)
    report = report_true_motion(
        np.stack(frames),
        frame_dt=0.04,
        windows=RulePlanner().windows(context),
        parts={0: np.arange(800) >= 600},
    )
    report = report.model_copy(update=dict(pieces=tuple(1 + (k > 5) for k in range(49))))
    judged = RulePlanner().judge(context, Observation(reply.force_field, report, Unseen())).value
    assert judged.verdict is Verdict(verdict), judged.checks


def test_an_arm_that_hardly_moves_more_than_the_rest_is_no_raised_arm():
    """45 degrees of the arm, but the whole is thrown up as far."""
    judged = judge(45, whole=0.3)
    assert judged.verdict is Verdict.FAIL
    assert any(check.aspect == "part" and check.passed is False for check in judged.checks)


@pytest.mark.parametrize(("part", "still"), [(HEAD, True), (ARM, False)])
def test_a_part_is_still_by_itself_whatever_another_one_does(part, still):
    """The whole seems to deform as a blade turns beside the handle that is to be still."""
    judged = judge(45, stays=part)
    told = [check.passed for check in judged.checks if check.question == "is it still?"]
    assert told == [still]


def test_a_part_that_is_lost_from_sight_is_neither_still_nor_a_success():
    judged = judge(45, seen_until=8)
    assert judged.verdict is Verdict.FAIL
    assert any(check.passed is None for check in judged.checks)
    assert all(check.gain is None for check in judged.checks if check.passed is not True), judged.checks


@pytest.mark.parametrize(
    ("sentence", "degrees", "told"),
    [
        ("bend the head down", 60, []),
        ("bend the head down to the ground", 60, [False]),
        ("bend the head down to the ground", 160, [True]),
    ],
)
def test_a_part_that_is_to_come_to_the_ground_goes_most_of_the_way(sentence, degrees, told):
    chance = np.random.default_rng(0)
    body = chance.uniform((-0.1, -0.1, -0.5), (0.1, 0.1, -0.1), (600, 3))
    neck, joint = chance.uniform((-0.03, -0.03, -0.1), (0.03, 0.03, 0.5), (120, 3)), np.array((0, 0, -0.1))
    head = make_part("head", (0, 0, 0.6), (0, 0, 1)).model_copy(update=dict(joint=(0.5, 0.5, 0.4)))
    reply = read(sentence, head)
    way = np.array(reply.expectations[0].direction)
    axis = np.cross((0, 0, 1), way - way[2] * np.array((0, 0, 1)))
    turns = [axis / np.linalg.norm(axis) * np.radians(degrees) * min(k / 25, 1.0) for k in range(49)]
    frames = [np.concatenate([body, joint + Rotation.from_rotvec(v).apply(neck - joint)]) for v in turns]
    context = AgentContext(sentence, brief(parts=(head,), anchored="all but the part"), (), reply)
    windows, number = RulePlanner().windows(context), {0: np.arange(720) >= 600}
    report = report_true_motion(np.stack(frames), frame_dt=0.04, windows=windows, parts=number)
    judged = RulePlanner().judge(context, Observation(reply.force_field, report, Unseen())).value
    assert [c.passed for c in judged.checks if "reach the ground" in c.question] == told


def judge_waving(sentence, degrees, carry):
    """The verdict on an arm that waves by ``degrees`` on a body that ``carry(places, share)`` takes along."""
    chance = np.random.default_rng(0)
    body = chance.uniform((-0.2, -0.1, -0.5), (0.2, 0.1, 0.5), (600, 3))
    arm = chance.uniform((0.2, -0.03, 0.07), (0.35, 0.03, 0.13), (60, 3))
    reply = read(sentence, ARM, HEAD)
    assert all(each.carried for each in reply.force_field.constraints if each.region is not None)
    frames = []
    for frame in range(49):
        angle = np.radians(degrees) * np.sin(2 * np.pi * 3 * frame / 48)
        c, s = np.cos(angle), np.sin(angle)
        turned = SHOULDER + (arm - SHOULDER) @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        frames.append(carry(np.concatenate([body, turned]), frame / 48))
    context = AgentContext(sentence, brief(parts=(ARM, HEAD)), (), reply)
    windows = RulePlanner().windows(context)
    parts = {0: np.arange(660) >= 600}
    report = report_true_motion(np.stack(frames), frame_dt=0.04, windows=windows, parts=parts)
    observed = Observation(reply.force_field, report, Unseen())
    return RulePlanner().judge(context, observed).value


@pytest.mark.parametrize(
    ("degrees", "rises", "verdict"), [(30, 0.4, "SUCCESS"), (0, 0.4, "FAIL"), (30, 0.0, "FAIL")]
)
def test_what_waves_while_it_rises_is_judged_by_both(degrees, rises, verdict):
    """Its arm's path is followed from the middle of the whole, which takes it along."""
    sentence = "the robot lifts up into the air while its right arm waves"
    judged = judge_waving(sentence, degrees, lambda places, share: places + (0, 0, rises * share))
    assert judged.verdict is Verdict(verdict)


@pytest.mark.parametrize(
    ("degrees", "turns", "verdict"), [(30, 180, "SUCCESS"), (0, 180, "FAIL"), (30, 0, "FAIL")]
)
def test_what_waves_while_it_turns_is_judged_by_both(degrees, turns, verdict):
    """Its arm's path is that of the whole turned back, or it would wave off to the other side."""

    def turn(places, share):
        return Rotation.from_rotvec((0, 0, -np.radians(turns) * share)).apply(places)

    judged = judge_waving("the robot turns around clockwise while its right arm waves", degrees, turn)
    assert judged.verdict is Verdict(verdict), judged.checks
