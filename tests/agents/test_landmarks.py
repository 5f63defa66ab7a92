"""Parts that only tell where or which way: nothing is done to them."""

import pytest

from physagent_jax.motion.schema import MotionKind
from tests.agents.test_limbs import HEAD, LEFT_ARM, RIGHT_ARM, TAIL, make_part, read

HANDLE = make_part("handle", (0.3, 0, 0), (1, 0, 0))
GROUND = dict(world="ground", frames_fixed=False)


@pytest.mark.parametrize(
    ("sentence", "kind", "way"),
    [
        ("tip it gently toward its handle", MotionKind.ROTATE, (0, 1, 0)),
        ("slide the robot towards its handle", MotionKind.MOVE, (1, 0, 0)),
        ("the robot leans in the direction of its tail", MotionKind.ROTATE, (-1, 0, 0)),
        ("push it toward its tail", MotionKind.MOVE, (0, 1, 0)),
    ],
)
def test_all_of_it_goes_towards_a_part(sentence, kind, way):
    """The part tells the way, and does not move alone."""
    reply = read(sentence, HANDLE, TAIL, **GROUND)
    (motion,) = reply.expectations
    assert (motion.kind, motion.limb) == (kind, None) and not reply.unsure
    assert motion.direction == pytest.approx(way)


def test_a_part_goes_towards_another_one():
    (motion,) = read("it curls its tail towards its head", HEAD, TAIL, **GROUND).expectations
    assert motion.limb == 1 and motion.direction is not None and motion.direction[2] > 0


def test_a_part_that_is_not_there_is_no_way():
    reply = read("lean toward the handle", **GROUND)
    assert reply.unknown_parts and reply.unsure


@pytest.mark.parametrize(
    "sentence",
    [
        "his left arm comes loose at the shoulder and drops to the floor",
        "its left arm breaks off at the elbow",
        "the left arm tears off at the seam",
    ],
)
def test_a_joint_tells_where_a_part_comes_off(sentence):
    reply = read(sentence, **GROUND)
    (motion,) = reply.expectations
    assert (motion.limb, motion.manner) == (0, "detach") and not (reply.unsure or reply.not_understood)


def test_a_joint_that_is_struck_is_a_part():
    assert read("hit it at the shoulder", **GROUND).unsure


@pytest.mark.parametrize(
    "sentence",
    [
        "the robot tilts its head to one side, keeps it there for a moment, and straightens up again",
        "it leans to the left, stays like that for a moment and comes back up",
    ],
)
def test_a_moment_of_holding_is_no_time_to_get_there(sentence):
    """It takes its usual time, is held, and comes back."""
    (motion,) = read(sentence, **GROUND).expectations
    assert motion.released and motion.window[1] - motion.window[0] > 20


def test_what_is_raised_is_held_up_and_lowered():
    kinds = [
        each.kind
        for each in read(
            "it raises its left arm, keeps it up for a moment and lowers it", **GROUND
        ).expectations
    ]
    assert kinds == [MotionKind.MOVE, MotionKind.STILL, MotionKind.MOVE]


@pytest.mark.parametrize("sentence", ["its arms hang down beside its body", "its arms dangle by its sides"])
def test_arms_hang_by_the_sides(sentence):
    reply = read(sentence, LEFT_ARM, RIGHT_ARM, **GROUND)
    assert {each.limb for each in reply.expectations} == {0, 1} and not reply.unsure


def test_the_raised_end_of_a_car_is_dropped_from_where_it_is():
    """It is let go, and not lifted as a whole first."""
    sentence = "pull up the front of the car until it stands on its back wheels, then drop it"
    (motion,) = read(sentence, HEAD, object_name="car", object_kind="vehicle", **GROUND).expectations
    assert motion.released


def test_a_tree_that_is_sawn_off_falls_over():
    scene = dict(object_name="tree", object_kind="plant", **GROUND)
    for sentence in (
        "the tree is sawn off and falls to the left",
        "saw the tree off at its base to the left",
    ):
        kinds = {each.kind for each in read(sentence, HEAD, **scene).expectations}
        assert kinds == {MotionKind.ROTATE, MotionKind.FALL}, sentence


@pytest.mark.parametrize(
    "sentence",
    [
        "its tail swings between its arms",
        "its tail wags slowly above its left arm",
        "the tail twists underneath the head",
    ],
)
def test_what_a_part_moves_between_or_above_stays(sentence):
    reply = read(sentence, HEAD, TAIL, **GROUND)
    assert {each.limb for each in reply.expectations} == {1} and not reply.unsure
