"""Light touches: a finger goes into what is soft, and a push that sets something rocking is no push over the ground."""

import math

import numpy as np
import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.calibration import DROP_HEIGHT, GRAVITY
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import ActionType, ConstraintType
from physagent_jax.motion.matching import find_strays
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.vectors import cross, dot
from tests.agents.scenes import brief, read

UP, DOWN, LEFT, TOWARD = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)
JELLY = brief(world="ground", object_kind="jelly", frame_count=100)
HARD = brief(world="ground", object_kind="robot", frame_count=100)
PRESSES = ConstraintType.MOVING_PLATE


def list_fingers(reply):
    return [each for each in reply.force_field.constraints if each.constraint_type is PRESSES]


@pytest.mark.parametrize("verb", ["poke", "prod", "punch", "jab"])
def test_a_finger_goes_into_what_is_soft_and_pushes_what_is_hard(verb):
    soft, hard = (read(f"{verb} it from the right", scene) for scene in (JELLY, HARD))
    (finger,) = list_fingers(soft)
    assert finger.vector == LEFT and not soft.force_field.actions
    assert not list_fingers(hard) and [each.action_type for each in hard.force_field.actions] == [
        ActionType.IMPULSE
    ]


def test_the_sentence_says_what_it_is_made_of():
    assert list_fingers(read("poke him from the left, he's made of rubber", HARD))
    assert not list_fingers(read("poke the steel robot from the left", JELLY))


def test_each_poke_has_its_finger_and_is_over_before_the_next():
    fingers = list_fingers(read("poke it from the left three times", JELLY))
    ends = [2 * each.held_until - each.active_time[0] for each in fingers]
    assert len(fingers) == 3
    assert all(end < later.active_time[0] for end, later in zip(ends, fingers[1:]))


@pytest.mark.parametrize("frames", [1, 2, 3, 5, 8, 20, 50])
@pytest.mark.parametrize("often", ["", " four times"])
def test_a_finger_goes_back_within_the_clip_or_it_is_a_blow(frames, often):
    """A clip may be as short as one frame."""
    reply = read(f"poke it from the left{often}", JELLY.model_copy(update=dict(frame_count=frames)))
    fingers = list_fingers(reply)
    assert fingers or reply.force_field.actions
    assert all(2 * each.held_until - each.active_time[0] <= frames - 1 + 1e-6 for each in fingers[:-1])
    assert all(each.held_until <= frames - 1 for each in fingers)


def test_what_is_broad_is_poked_from_above_unless_a_way_is_told():
    broad = JELLY.model_copy(update=dict(extents=(1.0, 0.4, 0.9)))
    assert list_fingers(read("poke it", broad))[0].vector == DOWN
    assert list_fingers(read("poke it from the right", broad))[0].vector == LEFT


def test_the_finger_meets_the_side_that_it_comes_from():
    (finger,) = list_fingers(read("poke it from the right", JELLY))
    points = np.random.default_rng(0).random((2000, 3))
    met = points[make_region_mask(finger.region, points)]
    assert met[:, 0].min() > 0.45 and met[:, 0].max() > 0.95  # the half on the right
    assert np.ptp(met[:, 1:], axis=0).max() < 0.3 and np.abs(met[:, 1:].mean(0) - 0.5).max() < 0.05


def test_what_is_poked_wobbles_when_the_finger_has_gone():
    reply = read("poke it from the left and it wobbles", JELLY)
    (finger,) = list_fingers(reply)
    others = [each for each in reply.force_field.constraints if each is not finger]
    begins = [each.active_time[0] for each in (*others, *reply.force_field.actions)]
    assert begins and min(begins) >= finger.held_until


@pytest.mark.parametrize(
    "prompt",
    ["someone prods it from the left so that it jiggles", "it wobbles when a finger prods it from the left"],
)
def test_the_finger_is_seen_where_it_is_said_what_comes_of_it(prompt):
    reply = read(prompt, JELLY)
    assert len(list_fingers(reply)) == 1
    assert [each.kind for each in reply.expectations] == [MotionKind.SWAY]


@pytest.mark.parametrize(
    "prompt",
    [
        "it drops to the ground and bends and jiggles as it bounces",
        "drop it so that it stretches and wobbles when it lands",
        "it bends and jiggles when it hits the ground",
    ],
)
def test_what_a_soft_thing_does_as_it_lands_is_left_to_its_softness(prompt):
    reply = read(prompt, JELLY)
    assert reply.force_field.default_drop and [e.kind for e in reply.expectations] == [MotionKind.FALL]
    assert not [each for each in reply.force_field.constraints if each.constraint_type.skill.is_axis]


@pytest.mark.parametrize(
    ("prompt", "way"),
    [
        ("a gentle nudge from behind, it rocks a bit but never tips over", TOWARD),
        ("tap it from the right so that it rocks", LEFT),
        ("a small push from the right makes it rock", LEFT),
        ("nudge it from the right and it wobbles", LEFT),
    ],
)
def test_a_light_push_sets_it_rocking_along_its_own_way(prompt, way):
    reply = read(prompt, HARD)
    (seen,) = reply.expectations
    first = reply.force_field.constraints[0]
    assert seen.kind is MotionKind.SWAY and seen.direction == way
    assert not reply.force_field.actions  # pushed as well, it would slide or fall over
    assert dot(cross(first.vector, UP), way) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "prompt", ["push it two lengths to the left and it rocks", "shove it hard to the left, then it rocks"]
)
def test_a_push_that_goes_somewhere_is_one_of_its_own(prompt):
    kinds = [each.kind for each in read(prompt, HARD).expectations]
    assert kinds == [MotionKind.MOVE, MotionKind.SWAY]


def test_it_rocks_where_it_stands_once_it_has_arrived():
    reply = read("push it to the left, then it rocks back and forth", HARD)
    moved, rocked = (each.window for each in reply.expectations)
    turns = [each for each in reply.force_field.constraints if each.constraint_type.skill.is_axis]
    assert moved[1] == rocked[0] and turns and len(reply.force_field.actions) < 3


BROAD = JELLY.model_copy(update=dict(extents=(1.0, 0.3, 0.9)))
QUIVERS = ConstraintType.PARTICLE_TRANSLATION


@pytest.mark.parametrize("verb", ["slap", "pat", "smack", "spank"])
def test_an_open_hand_is_broader_than_a_finger_and_leaves_what_is_hard_alone(verb):
    (hand,), (finger,) = (list_fingers(read(f"{each} it from the right", JELLY)) for each in (verb, "poke"))
    breadths = [max(abs(place[1] - 0.5) for place in each.region.outside) for each in (hand, finger)]
    assert hand.vector == LEFT and breadths[0] > 1.5 * breadths[1]
    assert not list_fingers(read(f"{verb} it from the right", HARD))


def test_what_is_flat_quivers_after_a_hand_and_ends_where_it_was():
    """Its strokes get smaller, each goes against the one before, and their sum is nothing."""
    reply = read("slap it", BROAD)
    strokes = [each for each in reply.force_field.constraints if each.constraint_type is QUIVERS]
    (hand,) = list_fingers(reply)
    ways = [
        each.magnitude * each.gain * (each.active_time[1] - each.active_time[0]) * each.vector[0]
        for each in strokes
    ]
    assert hand.vector == DOWN and strokes[0].active_time[0] >= hand.held_until
    assert all(one * other < 0 for one, other in zip(ways, ways[1:]))
    assert all(abs(one) > abs(other) for one, other in zip(ways[1:], ways[2:]))
    assert sum(ways) == pytest.approx(0.0, abs=0.01 * abs(ways[0]))
    assert reply.expectations[0].kind is MotionKind.SWAY and reply.expectations[0].jiggles


def test_what_is_said_to_quiver_does_so_when_the_hand_has_gone():
    reply = read("someone slaps it on top and it quivers", BROAD)
    (hand,) = list_fingers(reply)
    first = min(each.active_time[0] for each in reply.force_field.constraints if each is not hand)
    assert first >= hand.held_until
    assert [each.kind for each in reply.expectations] == [MotionKind.SWAY, MotionKind.SWAY]


@pytest.mark.parametrize(
    ("sentence", "seen"),
    [
        ("a hand pushes the robot so that it wobbles back and forth", True),
        ("a finger pokes the robot and it rocks to and fro", True),
        ("someone flicks the robot", True),
        ("a hand presses against the robot so that it bends to the left", True),
        ("the robot wobbles back and forth", False),
        ("a gust of wind makes the robot rock to and fro", False),
    ],
)
def test_the_hand_that_sets_something_going_is_seen_at_the_first_stroke(sentence, seen):
    """Led to and fro, it moved as if by itself."""
    scene = brief(world="ground", may_be_held=True)
    field = compile_intent(read_intent(sentence, scene), scene).force_field
    touched = [each.touched for each in (*field.constraints, *field.actions)]
    assert sum(touched) == seen and touched[0] == seen


def test_a_poke_is_no_stray_and_what_it_sets_wobbling_may_move_from_then_on():
    """The poke of a jelly was taken out of the next round, as nothing seemed to ask for it."""
    scene = brief(world="ground", object_kind="jelly", object_name="jelly")
    reply = compile_intent(read_intent("a hand pokes the jelly so that it jiggles all over", scene), scene)
    (wobble,) = reply.expectations
    assert any(each.touched for each in reply.force_field.constraints) and wobble.window[0] == 0
    strays = find_strays(reply.expectations, reply.force_field)
    assert not any(cause.item.touched for cause in strays)


def test_what_jiggles_as_it_lands_quivers_from_then_on():
    """Its own swing ends with the stop of its landing; more strongly said, it quivers farther."""
    plain, crazy, none = (
        [each for each in read(say, JELLY).force_field.constraints if each.constraint_type == "quiver"]
        for say in ("drop it and it wobbles", "drop it so it wobbles like crazy", "drop it")
    )
    (one,), (other,) = plain, crazy
    landing = math.sqrt(2 * DROP_HEIGHT * JELLY.size / GRAVITY) / JELLY.frame_dt
    assert landing < one.active_time[0] < landing + 0.4 / JELLY.frame_dt
    assert one.active_time[1] - one.active_time[0] > 1.0 / JELLY.frame_dt
    assert other.magnitude * other.gain > 1.4 * one.magnitude * one.gain and not none


def test_what_has_tipped_over_quivers_as_it_lies():
    reply = read("it tips over and jiggles", JELLY)
    (shaken,) = [each for each in reply.force_field.constraints if each.constraint_type == "quiver"]
    assert not reply.force_field.actions and reply.expectations[-1].jiggles
    assert shaken.active_time[0] > max(
        each.active_time[1] for each in reply.force_field.constraints if each is not shaken
    )
