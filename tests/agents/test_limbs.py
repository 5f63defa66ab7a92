"""Parts that stick out: which of them a word means, and how a sentence moves them."""

import math

import numpy as np
import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion, ConstraintType
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.vectors import cross, dot
from tests.agents.scenes import brief

MIDDLE = ((0.5, 0.5, 0.5), (0.5, 0.5, 0.3))


def make_part(role, arm, side):
    """A part whose cells lie where ``side`` points to."""
    place = tuple(0.5 + 0.4 * c for c in side)
    bend = tuple(0.5 + 0.2 * c for c in side)
    return Part(
        roles=(role,),
        moved=CellsRegion(inside=(place,), outside=(bend, *MIDDLE)),
        rest=CellsRegion(inside=MIDDLE, outside=(place, bend)),
        joint=bend,
        arm=arm,
        side=side,
        share=0.1,
    )


LEFT_ARM, RIGHT_ARM = make_part("arm", (-0.3, 0, 0), (-1, 0, 0)), make_part("arm", (0.3, 0, 0), (1, 0, 0))
HEAD = make_part("head", (0, 0, 0.2), (0, 0, 1))
TAIL = make_part("tail", (0, 0.2, 0), (0, 1, 0))


def read(sentence, *parts, **scene):
    """The reply to a sentence about an object with these parts."""
    about = brief(parts=parts or (LEFT_ARM, RIGHT_ARM, HEAD), **scene)
    return compile_intent(read_intent(sentence, about), about)


def find_way(constraint, part):
    """The way in which a rotation begins to move the tip of a part."""
    axis = np.asarray(constraint.vector) * math.copysign(1.0, constraint.magnitude)
    return np.cross(axis, part.arm)


@pytest.mark.parametrize(
    ("sentence", "limb", "part", "way"),
    [
        ("raise the left arm", 0, LEFT_ARM, (0, 0, 1)),
        ("the robot lifts its right arm", 1, RIGHT_ARM, (0, 0, 1)),
        ("push the head to the left", 2, HEAD, (-1, 0, 0)),
    ],
)
def test_a_limb_turns_about_its_joint_the_way_that_is_asked(sentence, limb, part, way):
    reply = read(sentence)
    (constraint,) = reply.force_field.constraints
    assert reply.force_field.actions == () and not reply.unsure
    assert constraint.constraint_type is ConstraintType.PARTICLE_ROTATION
    assert (constraint.region, constraint.pivot) == (part.moved, part.joint)
    assert dot(tuple(find_way(constraint, part)), way) > 0.9 * np.linalg.norm(part.arm)
    assert [each.limb for each in reply.expectations] == [limb]


@pytest.mark.parametrize("word", ["ears", "head"])
def test_the_head_of_what_stands_on_legs_is_not_whatever_is_on_top(word):
    """A cat's tail may be higher than its head: where the head is not found, nothing is moved in its place."""
    legs = [make_part("leg", (0, 0, -0.2), (x, 0.0, -math.sqrt(1 - x * x))) for x in (0.5, -0.5)]
    reply = read(f"pull the {word} up", *legs, TAIL)
    assert any(f"'{word}'" in doubt and "leg, tail" in doubt for doubt in reply.unsure)
    assert all(each.region is None for each in reply.force_field.actions)


def test_a_leg_that_is_lifted_swings_forward_and_not_into_the_body():
    """It hangs: along itself it would only get shorter. Forward is where an animal's head is."""
    places = [(0.5, 0.2, -0.8), (-0.5, 0.2, -0.8), (0.5, -0.2, -0.8)]
    legs = [make_part("leg", (0, 0, -0.2), tuple(c / math.hypot(*place) for c in place)) for place in places]
    reply = read("lift the right leg", *legs, make_part("head", (0.2, 0, 0.1), (1, 0, 0)))
    (constraint,) = reply.force_field.constraints
    assert constraint.constraint_type is ConstraintType.PARTICLE_ROTATION
    assert find_way(constraint, legs[0])[0] > 0.19
    (motion,) = reply.expectations
    assert motion.direction[0] > 0.8 and motion.direction[2] > 0.3


def test_front_and_hind_are_told_by_the_head_of_an_animal():
    """Of what has no head and legs, the front is the side towards the viewer."""
    places = [(0.6, 0.3, -0.75), (0.6, -0.3, -0.75), (-0.6, 0.3, -0.75), (-0.6, -0.3, -0.75)]
    legs = [make_part("leg", (0, 0, -0.2), tuple(c / math.hypot(*place) for c in place)) for place in places]
    head = make_part("head", (0.2, 0, 0.1), (1, 0, 0))
    hind = read("push the hind legs to the left", *legs, head)
    assert sorted(each.limb for each in hind.expectations) == [2, 3]
    near = read("push the front legs to the left", *legs)
    assert sorted(legs[each.limb].side[1] for each in near.expectations)[-1] < 0


@pytest.mark.parametrize(
    ("sentence", "roles", "limb"),
    [
        ("raise the left arm", ("side", "top"), 0),
        ("push the head to the left", ("side", "top"), 1),
        ("lift the lid", ("handle", "top"), 1),
        ("push the handle up", ("handle", "side"), 0),
        ("push the handle up", ("side", "spout"), 0),
        ("push the left protrusion up", ("side", "side"), 0),
        ("push the back to the left", ("leg", "back"), 1),
        ("push the top to the left", ("side", "top"), None),
        ("push the left side up", ("side", "top"), None),
        ("raise the arm", ("tail", "top"), None),
    ],
)
def test_a_part_of_which_the_place_is_known_is_what_the_sentence_calls_it(sentence, roles, limb):
    left, top = (
        make_part(roles[0], (-0.3, 0, 0), (-1, 0, 0)),
        make_part(roles[1], (0, 0, 0.2), (0, 0, 1) if roles[1] != "side" else (1, 0, 0)),
    )
    reply = read(sentence, left, top)
    assert [each.limb for each in reply.expectations] == [limb]


def test_the_angle_follows_from_the_rate_and_the_window():
    """45 degrees for a plain word: M times gain times a quarter turn per 0.7 s, while it acts."""
    (constraint,) = read("raise the left arm").force_field.constraints
    first, last = constraint.active_time
    rate = constraint.magnitude * constraint.gain * 90.0 / 0.7
    assert rate * (last - first) * 0.04 == pytest.approx(45.0, rel=0.01)


def test_the_rest_is_held_where_parts_alone_move():
    reply = read("raise the left arm")
    assert reply.anchor.kind == "rest"
    assert set(LEFT_ARM.moved.inside) <= set(reply.anchor.region.outside)
    assert set(reply.anchor.region.inside) <= set(MIDDLE)
    both = read("push the robot to the right and raise the left arm")
    assert both.anchor.kind is None and both.force_field.actions


def test_a_plural_means_all_of_them():
    reply = read("the robot raises its arms")
    assert sorted(each.limb for each in reply.expectations) == [0, 1]
    ways = [find_way(c, p) for c, p in zip(reply.force_field.constraints, (LEFT_ARM, RIGHT_ARM))]
    assert all(way[2] > 0.2 for way in ways)


def test_a_tail_wags_to_and_fro_across_itself():
    reply = read("it wags its tail", TAIL)
    (motion,) = reply.expectations
    assert motion.kind is MotionKind.SWAY and motion.repeats >= 2
    constraints = reply.force_field.constraints
    turns = [
        c.magnitude * c.gain * np.asarray(c.vector) * (c.active_time[1] - c.active_time[0])
        for c in constraints
    ]
    assert np.abs(np.sum(turns, axis=0)).max() < 0.1 * np.abs(turns[1]).max()  # it ends where it began
    assert all(turns[k] @ turns[k + 1] < 0 for k in range(len(turns) - 1))
    assert abs(cross(tuple(constraints[0].vector), TAIL.arm)[0]) > 0.19  # sideways, not up


def test_a_part_that_is_not_there_is_asked_for():
    reply = read("it wags its tail")
    assert any("'tail'" in doubt and "arm, head" in doubt for doubt in reply.unsure)


def test_a_place_is_a_place_where_nothing_sticks_out():
    """Words that name a place keep it for objects without such a part: the head of a post is its upper end."""
    reply = read("push the head to the left", LEFT_ARM)
    assert reply.expectations[0].limb is None and reply.expectations[0].part == (0, 0, 1)


def test_evidence_follows_the_actions_that_are_left():
    """Words of the push stay beside the push, and nothing is left of the force on the limb."""
    reply = read("raise the left arm and push the robot to the right")
    (push,) = reply.force_field.actions
    told = {item.field: item.value for item in reply.evidence if item.field.startswith("actions")}
    assert told["actions[0].vector"] == "[1, 0, 0]" and push.vector == (1.0, 0.0, 0.0)
    assert all(field.startswith("actions[0].") for field in told) and "actions[0].region" not in told


def test_the_rest_of_several_parts_holds_none_of_them():
    """Of each arm the other one is a part of the rest; of both it is not."""
    pair = (LEFT_ARM, RIGHT_ARM)
    ends = [part.moved.inside[0] for part in pair]
    parts = [
        part.model_copy(update={"rest": part.rest.model_copy(update={"inside": (*MIDDLE, other)})})
        for part, other in zip(pair, reversed(ends))
    ]
    region = read("the robot raises its arms", *parts).anchor.region
    assert set(region.inside) == set(MIDDLE) and set(ends) <= set(region.outside)


@pytest.mark.parametrize(
    "sentence",
    [
        "lift the robot by its head",
        "pull it up by the left arm",
        "swing it by its arm",
        "spin it by the top",
        "lift it by the end of its arm",
    ],
)
def test_what_it_is_taken_by_is_no_part_that_is_moved(sentence):
    """The whole goes along with what is gripped."""
    (clause,) = read_intent(sentence, brief()).clauses
    assert clause.parts == ()
