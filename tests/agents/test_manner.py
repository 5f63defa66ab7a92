"""The verdict on the manner of a motion: over the foot or sliding, in the air or not, flat, and of pairs of parts."""

import numpy as np
import pytest

from physagent_jax.agents.grammar.semantic import read_sentence
from physagent_jax.motion.parts import explain_guess
from physagent_jax.motion.schema import Verdict
from physagent_jax.perception.schema import Box, PartMotion
from physagent_jax.scene.priors import list_nouns
from tests.agents.scenes import IDENTITY, brief, judge, make_report, read
from tests.agents.test_limbs import HEAD, LEFT_ARM, RIGHT_ARM, make_part

FRAMES = 49
SWING = np.sin(np.arange(FRAMES) / 48 * 4 * np.pi)
RAMP = np.arange(FRAMES) / 48


def tell(sentence, path, foot=0.0, lift=None, stretches=None, **changes):
    """The judgement of what stands: its middle goes along ``path`` (x), its foot ``foot`` times as far as its top."""
    scene = brief(world="ground", **changes)
    reading = read(sentence, scene)
    lift = np.zeros(FRAMES) if lift is None else lift
    windows = [(round(e.window[0]), round(e.window[1])) for e in reading.expectations]
    seen = make_report(
        [(float(x), 0.0, float(z)) for x, z in zip(path, lift)], stretches=stretches, windows=windows
    )
    shares = {1.0: 2.0 / (1.0 + foot), -1.0: 2.0 * foot / (1.0 + foot)}
    parts = [
        part.model_copy(
            update={
                "centroid": tuple((p[0] * shares[part.direction[2]], p[1], p[2]) for p in part.centroid if p)
            }
        )
        if part.direction[2]
        else part
        for part in seen.parts
    ]
    seen = seen.model_copy(update={"parts": tuple(parts)})
    return judge(sentence, reading, seen, scene).judgement


def list_failed(judgement):
    return [check.question for check in judgement.checks if check.passed is False]


@pytest.mark.parametrize(
    ("sentence", "path"),
    [
        ("the robot rocks from side to side", -0.1 * SWING),
        ("the robot sways from side to side", -0.1 * SWING),
        ("the wind bends the robot to the left", -0.4 * RAMP),
    ],
)
def test_what_slides_does_not_bend(sentence, path):
    assert tell(sentence, path, foot=0.1).verdict is Verdict.SUCCESS
    assert list_failed(tell(sentence, path, foot=0.95)) == ["does it bend over its foot, or slide?"]


@pytest.mark.parametrize(("height", "verdict"), [(1.0, "FAIL"), (0.3, "SUCCESS")])
def test_the_middle_of_what_is_low_goes_less_far_as_it_rocks(height, verdict):
    scene = dict(extents=(1.0, height, 0.4))
    seen = tell("the robot rocks gently on the waves", -0.015 * SWING, foot=0.1, **scene)
    assert seen.verdict is Verdict(verdict), seen.suggestion


@pytest.mark.parametrize("sentence", ["shake the robot", "push the robot to the left"])
def test_what_is_pushed_or_shaken_may_slide(sentence):
    path = -0.4 * RAMP if "push" in sentence else -0.1 * np.sin(np.arange(FRAMES) / 48 * 8 * np.pi)
    assert tell(sentence, path, foot=1.0).verdict is Verdict.SUCCESS


def test_what_is_held_or_floats_has_no_foot_to_slide_on():
    path = -0.06 * SWING
    sentence = "the robot sways from side to side"
    question = "does it bend over its foot, or slide?"
    assert question not in list_failed(tell(sentence, path, foot=1.0, anchored="its base"))


def test_what_is_thrown_leaves_the_ground():
    arc = 0.6 * RAMP * (1 - RAMP)
    path = -0.8 * np.minimum(3.0 * RAMP, 1.0)
    sentence = "throw the robot to the left"
    assert tell(sentence, path, 1.0, arc).verdict is Verdict.SUCCESS
    assert list_failed(tell(sentence, path, 1.0)) == ["does it fly?"]
    assert "does it fly?" not in list_failed(tell("kick the robot to the left", path, 1.0))


@pytest.mark.parametrize(
    ("sentence", "depth", "verdict"),
    [
        ("press the robot flat", 0.19, "FAIL"),
        ("press the robot flat", 0.6, "SUCCESS"),
        ("squash the robot", 0.19, "SUCCESS"),
        ("squash the robot flat against the ground", 0.19, "FAIL"),
    ],
)
def test_flat_is_a_degree(sentence, depth, verdict):
    def press(share):
        return ((1.0 + 0.1 * share, 0, 0), (0, 1.0 + 0.1 * share, 0), (0, 0, 1.0 - depth * share))

    judgement = tell(sentence, 0 * RAMP, stretches=[press(float(s)) for s in RAMP])
    assert judgement.verdict is Verdict(verdict), judgement.suggestion


@pytest.mark.parametrize(("degrees", "verdict"), [(100, "FAIL"), (200, "SUCCESS"), (350, "SUCCESS")])
def test_what_rolls_over_may_end_on_its_back(degrees, verdict):
    """And the shape that is told from another side than at first is less sure."""
    scene = brief(frame_dt=0.08)
    reading = read("the robot rolls over", scene)
    (motion,) = reading.expectations
    assert motion.direction is not None
    share = np.minimum(np.arange(FRAMES) / max(motion.window[1], 1.0), 1.0)
    turns = [tuple(degrees * float(s) * np.asarray(motion.direction)) for s in share]
    wide = ((1.75, 0, 0), (0, 1, 0), (0, 0, 1))
    seen = make_report(
        [(0.0, 0.0, 0.0)] * FRAMES,
        turns,
        [wide if degrees * s > 60 and abs(motion.direction[1]) < 0.5 else IDENTITY for s in share],
        windows=[(0, round(motion.window[1]))],
    )
    assert judge("the robot rolls over", reading, seen, scene).judgement.verdict is Verdict(verdict)


def judge_arms(left, right):
    """The judgement of two arms whose middles rise as told, frame by frame; None where one is not seen."""
    return judge_parts("raise both arms", (LEFT_ARM, left), (RIGHT_ARM, right))


def judge_parts(sentence, *told):
    """The judgement of parts, each with the height of its middle, frame by frame; None where it is not seen."""
    scene = brief(parts=tuple(part for part, _ in told), anchored="all but the parts")
    reading = read_sentence(sentence, scene)
    seen = make_report(
        [(0.0, 0.0, 0.0)] * FRAMES,
        windows=[(round(e.window[0]), round(e.window[1])) for e in reading.expectations],
    )
    limbs = [
        PartMotion(
            direction=part.side,
            limb=limb,
            centroid=tuple(None if z is None else (0.0, 0.0, float(z)) for z in heights),
            rotation=((0.0, 0.0, 0.0),) * FRAMES,
        )
        for limb, (part, heights) in enumerate(told)
    ]
    return judge(sentence, reading, seen.model_copy(update={"parts": (*seen.parts, *limbs)}), scene).judgement


RAISED, HIDDEN = list(0.15 * RAMP), list(0.15 * RAMP[:5]) + [None] * (FRAMES - 5)


def test_one_of_a_pair_that_is_hidden_is_judged_by_the_other():
    assert judge_arms(RAISED, RAISED).verdict is Verdict.SUCCESS
    assert judge_arms(RAISED, HIDDEN).verdict is Verdict.SUCCESS


@pytest.mark.parametrize("right", [HIDDEN, list(0 * RAMP), list(-0.15 * RAMP)])
def test_a_pair_is_no_success_by_one_that_is_hidden_or_moves_otherwise(right):
    left = HIDDEN if right is HIDDEN else RAISED
    assert judge_arms(left, right).verdict is Verdict.FAIL


@pytest.mark.parametrize(("rising", "verdict"), [(4, "SUCCESS"), (2, "SUCCESS"), (1, "FAIL"), (0, "FAIL")])
def test_of_many_leaves_a_third_that_goes_as_said_tells(rising, verdict):
    sides = [(1, 0, 0.2), (-1, 0, 0.2), (0, 1, 0.2), (0, -1, 0.2)]
    leaves = [make_part("arm", tuple(0.3 * c for c in side), tuple(c / 1.02 for c in side)) for side in sides]
    told = [(leaf, RAISED if k < rising else list(0 * RAMP)) for k, leaf in enumerate(leaves)]
    assert judge_parts("the leaves rise", *told).verdict is Verdict(verdict)


@pytest.mark.parametrize(("roles", "certain"), [(("top", "crown"), True), (("top",), False)])
def test_a_word_for_a_role_that_one_part_alone_may_have_is_certain(roles, certain):
    top = HEAD.model_copy(update={"roles": roles})
    doubt = explain_guess("crown", (top, LEFT_ARM), (0,), plural=False)
    assert (doubt is None) == certain


@pytest.mark.parametrize(("kind", "noun"), [("vehicle", "pickup"), ("object", "tower")])
def test_an_object_may_be_called_by_a_noun_of_its_kind(kind, noun):
    scene = brief(object_name="small-a", object_kind=kind, object_nouns=list_nouns(kind))
    assert not read_sentence(f"twist the {noun}", scene).unsure
    named = brief(object_name="teapot", object_kind="vessel", object_nouns=list_nouns("vessel"))
    assert read_sentence(f"twist the {noun}", named).unsure


@pytest.mark.parametrize(("strain", "passed"), [(0.7, True), (0.9, False)])
def test_one_map_does_not_fit_what_is_twisted(strain, passed):
    """Its shape then seems to change: by more than what only turns may, and not by any amount."""
    judgement = tell(
        "twist the robot", 0 * RAMP, stretches=[((1 + strain, 0, 0), (0, 1, 0), (0, 0, 1))] * FRAMES
    )
    assert passed == ("does its shape change although nobody asked for it?" not in list_failed(judgement))


@pytest.mark.parametrize("sentence", ["fold the robot in half", "crumple the robot"])
@pytest.mark.parametrize(("left", "verdict"), [(1.0, "FAIL"), (0.9, "FAIL"), (0.55, "SUCCESS")])
def test_a_fold_or_a_crumpling_is_seen_by_the_outline(sentence, left, verdict):
    """The half that comes to lie on top shows its other side: no track tells its place."""
    scene = brief(world="ground", may_be_held=True)
    reading = read(sentence, scene)
    seen = make_report([(0.0, 0.0, 0.0)] * FRAMES, windows=[(0, round(reading.expectations[0].window[1]))])
    boxes = [Box(low=(-0.5, -0.5, 0.0), high=(1.0 * s - 0.5, 0.5, 0.2)) for s in 1.0 - (1.0 - left) * RAMP]
    lost = tuple(part.model_copy(update={"centroid": (None,) * FRAMES}) for part in seen.parts)
    seen = seen.model_copy(update={"box": tuple(boxes), "parts": lost})
    assert judge(sentence, reading, seen, scene).judgement.verdict is Verdict(verdict)


@pytest.mark.parametrize(("rise", "verdict"), [(0.55, "SUCCESS"), (1.2, "FAIL")])
def test_the_middle_of_what_gets_twice_as_tall_rises(rise, verdict):
    taller = [((1, 0, 0), (0, 1, 0), (0, 0, 1.0 + float(s))) for s in RAMP]
    judgement = tell("make the robot twice as tall", 0 * RAMP, lift=rise * RAMP, stretches=taller)
    assert judgement.verdict is Verdict(verdict), judgement.suggestion


def test_what_topples_after_it_rolled_falls_its_own_way():
    """It goes over towards us where it came to rest, and no way was told."""
    scene = brief(world="ground", frames_fixed=False)
    sentence = "the robot rolls to the right and falls flat"
    reading = read(sentence, scene)
    count, begin = reading.frame_count, round(reading.expectations[-1].window[0])
    roll = np.minimum(np.arange(count) / begin, 1.0)
    fall = np.clip((np.arange(count) - begin) / (count - begin - 9), 0.0, 1.0)
    axes = [
        np.asarray(e.direction or (1.0, 0.0, 0.0)) for e in reading.expectations if e.kind.value == "rotate"
    ]
    seen = make_report(
        [(float(0.6 * r), float(-0.35 * f), float(-0.2 * f)) for r, f in zip(roll, fall)],
        [tuple(80.0 * r * axes[0] + 85.0 * f * axes[1]) for r, f in zip(roll, fall)],
        windows=[(round(e.window[0]), round(e.window[1])) for e in reading.expectations],
    )
    failed = list_failed(judge(sentence, reading, seen, scene).judgement)
    assert "which way does it fall?" not in failed
