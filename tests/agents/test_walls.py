"""Walls: what meets one and comes off it, goes down it, or is crushed by it."""

import pytest

from physagent_jax.forces.schema import ActionType
from physagent_jax.motion.schema import MotionKind
from physagent_jax.scene.priors import list_nouns
from tests.agents.scenes import brief, read

BALL = brief(object_name="ball", object_kind="ball", world="ground")
VAN = brief(object_name="van", object_kind="vehicle", object_nouns=list_nouns("vehicle"), world="ground")


@pytest.mark.parametrize(
    "prompt",
    [
        "the ball slams into a wall and bounces back",
        "the ball is thrown hard into a wall and bounces off",
        "the ball rebounds from the wall on the left",
        "throw it at the wall so that it ricochets",
        "it bounces off the wall on the left",
    ],
)
def test_what_comes_off_a_wall_is_fast_there_and_led_by_nothing_behind_it(prompt):
    reply = read(prompt, BALL)
    (wall,) = reply.world.obstacles
    assert wall.direction == (-1.0, 0.0, 0.0) and reply.world.restitution == pytest.approx(0.7)
    assert {each.action_type for each in reply.force_field.actions} == {ActionType.IMPULSE}
    assert {each.kind for each in reply.expectations} == {MotionKind.MOVE} and not reply.unsure


def test_what_merely_meets_a_wall_does_not_rebound():
    reply = read("push the ball against the wall on the left", BALL)
    assert reply.world.obstacles and reply.world.restitution is None


def test_what_slides_down_the_wall_that_it_was_thrown_against_is_thrown_there():
    first, second = read("the ball is thrown against the wall on the left and slides down", BALL).expectations
    assert first.kind is MotionKind.MOVE and first.sudden and first.direction == (-1.0, 0.0, 0.0)
    assert second.direction == (0.0, 0.0, -1.0)


@pytest.mark.parametrize(
    "prompt",
    [
        "the van crashes into a wall at full speed, the front gets crumpled",
        "the van is thrown against the wall and is squashed flat",
        "the van drives into a brick wall and its front crumples",
    ],
)
def test_what_a_wall_crushes_is_of_what_gives_way_and_hits_it_hard(prompt):
    reply = read(prompt, VAN)
    assert reply.materials == ("clay",) and not reply.unsure
    assert {each.kind for each in reply.expectations} == {MotionKind.MOVE}
    assert {each.action_type for each in reply.force_field.actions} == {ActionType.IMPULSE}


def test_what_shatters_at_a_wall_keeps_its_own_word_for_it():
    reply = read("the van slams into the wall on the left and shatters", VAN)
    assert len(reply.expectations) == 1 and "clay" not in reply.materials


def test_a_vehicle_drives_into_a_wall_with_its_front():
    reply = read("the van races forward and crashes into a wall", VAN)
    (ahead,) = read("the van drives forward", VAN).expectations
    assert {each.direction for each in reply.expectations} == {ahead.direction}
    assert reply.world.obstacles[0].direction == ahead.direction


@pytest.mark.parametrize(
    "prompt, back",
    [
        ("its back end hops up and slams back down", 1.0),
        ("the front of the van lifts off the ground", -1.0),
        ("the nose of the van sinks", 1.0),
        ("its tail dips", -1.0),
    ],
)
def test_an_end_of_a_vehicle_that_rises_tips_it_over_the_other_one(prompt, back):
    (turn, *_) = read(prompt, VAN).expectations
    (ahead,) = read("the van drives forward", VAN).expectations
    axis = turn.direction
    assert turn.kind is MotionKind.ROTATE and not turn.partial
    # About the axis to the left of its way, its back rises.
    left = (-ahead.direction[1], ahead.direction[0], 0.0)
    assert sum(a * b for a, b in zip(axis, left)) == pytest.approx(back, abs=1e-6)


def test_the_front_dips_once_a_vehicle_has_driven_and_comes_back():
    drive, dip = read(
        "the van rolls along and brakes so hard that its front dips and its rear rises", VAN
    ).expectations
    assert drive.kind is MotionKind.MOVE and dip.kind is MotionKind.ROTATE
    assert dip.window[0] >= drive.window[1] and dip.released


def test_a_slide_after_a_fall_goes_the_way_of_that_fall():
    *fall, slide = read("the van tips over to the right and slides a bit", VAN).expectations
    assert slide.kind is MotionKind.MOVE and slide.direction == (1.0, 0.0, 0.0)
    assert slide.window[0] >= max(each.window[1] for each in fall)
