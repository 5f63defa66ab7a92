"""Sentences that name a skill: they make an action of it and expect the motion that it causes."""

import pytest

from physagent_jax.agents.hard_rules import apply_hard_rules
from physagent_jax.motion.kinds import choose_kinds
from physagent_jax.motion.matching import find_causes
from physagent_jax.motion.schema import MotionKind
from tests.agents.scenes import brief, read

LEFT, RIGHT, UP = (-1, 0, 0), (1, 0, 0), (0, 0, 1)


@pytest.mark.parametrize(
    ("prompt", "skill", "kind", "vector"),
    [
        ("a vortex swirls the leaves", "vortex", MotionKind.ROTATE, UP),
        ("a strong whirlwind spins it clockwise", "vortex", MotionKind.ROTATE, (0, 0, -1)),
        ("swirl the robot around", "vortex", MotionKind.ROTATE, UP),
        ("a vortex hits the robot", "vortex", MotionKind.ROTATE, UP),
        ("a sudden gust of wind hits the robot from the left", "wind_gust", MotionKind.MOVE, RIGHT),
        ("a squall pushes it to the left", "wind_gust", MotionKind.MOVE, LEFT),
    ],
)
def test_a_word_of_a_skill_makes_an_action_of_it(prompt, skill, kind, vector):
    scene = brief(object_nouns=("leaves",))
    reply = read(prompt, scene)
    assert {action.action_type.value for action in reply.force_field.actions} == {skill}
    assert reply.force_field.actions[0].vector == vector
    (expected,) = reply.expectations
    assert expected.kind is kind and expected.direction == vector and not reply.unsure
    assert find_causes(expected, reply.force_field)
    choice = choose_kinds(reply.force_field, reply.expectations, scene)
    assert apply_hard_rules(choice.force_field, scene, reply.expectations) == (choice.force_field, ())


def test_a_gust_bends_a_plant_and_is_over_soon():
    scene = brief(object_name="ficus", object_kind="plant", object_nouns=("plant",), anchored="its base")
    reply = read("a sudden gust of wind hits the plant", scene)
    (gust,) = reply.force_field.actions
    assert gust.action_type == "wind_gust" and gust.active_time is not None and gust.active_time[1] < 24
    assert reply.expectations[0].released and not reply.unsure


def test_counted_gusts_are_as_many():
    scene = brief(object_name="ficus", object_kind="plant", object_nouns=("plant",), anchored="its base")
    reply = read("three gusts of wind hit the plant from the left", scene)
    assert [action.action_type.value for action in reply.force_field.actions] == ["wind_gust"] * 3
    assert reply.expectations[0].repeats == 3


@pytest.mark.parametrize("prompt", ["spin the robot", "the wind pushes it to the left"])
def test_other_words_keep_their_skills(prompt):
    names = {action.action_type.value for action in read(prompt).force_field.actions}
    assert names <= {"torque", "translation"}
