"""Sentences that go on with a part they have named, and parts that fall, hang or are told by what they do."""

import numpy as np
import pytest

from physagent_jax.forces.schema import ConstraintType
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.vectors import cosine, dot
from tests.agents.scenes import brief
from tests.agents.scenes import read as read_whole
from tests.agents.test_limbs import HEAD, LEFT_ARM, RIGHT_ARM, find_turn, make_part, read

DOWN = (0.0, 0.0, -1.0)
MOVE, SWAY = MotionKind.MOVE, MotionKind.SWAY


def list_limbs(reply):
    """The kind of each expected motion with its limb."""
    return [(each.kind, each.limb) for each in reply.expectations]


@pytest.mark.parametrize(("back", "share"), [("then to the right", 2.0), ("then back", 1.0)])
def test_a_head_turns_past_where_it_was_to_the_side_that_is_told(back, share):
    turns = read(f"its head turns to the left, {back}").force_field.constraints
    first, then = (t.magnitude * t.gain * (t.active_time[1] - t.active_time[0]) for t in turns)
    assert then == pytest.approx(share * first, rel=0.05)


@pytest.mark.parametrize(
    ("sentence", "told"),
    [
        ("the robot's arms rise and wobble", [(MOVE, 0), (MOVE, 1), (SWAY, 0), (SWAY, 1)]),
        ("someone pulls its arms up and they wobble", [(MOVE, 0), (MOVE, 1), (SWAY, 0), (SWAY, 1)]),
        ("its arms flap three times, then bend down", [(SWAY, 0), (SWAY, 1), (MOVE, 0), (MOVE, 1)]),
        ("the robot lifts its left arm and lowers it again", [(MOVE, 0), (MOVE, 0)]),
        ("its left arm hangs down limply while the right one flaps", [(MOVE, 0), (SWAY, 1)]),
        ("its arms twitch quickly, first the left one, then the right one", [(SWAY, 0), (SWAY, 1)]),
        ("it raises its left arm and points up at the sky", [(MOVE, 0)]),
        ("the robot raises its left arm and its head", [(MOVE, 0), (MOVE, 2)]),
        ("its left arm and the head twitch", [(SWAY, 0), (SWAY, 2)]),
        ("its left arm, the right arm and the head come off", [(MOVE, 0), (MOVE, 1), (MOVE, 2)]),
        ("the robot stretches its arms forward", [(MOVE, 0), (MOVE, 1)]),
        ("pinch its left arm and bend it down", [(MOVE, 0)]),
        ("its arms wave but the robot stays where it is", [(SWAY, 0), (SWAY, 1)]),
        ("the robot raises its left arm and lets it drop again", [(MOVE, 0), (MOVE, 0)]),
        ("the robot lets its left arm fall", [(MOVE, 0)]),
        ("the tip of its left arm rises", [(MOVE, 0)]),
        ("it bends its left arm up, then down", [(MOVE, 0), (MOVE, 0)]),
        ("it tilts its head to the left, then to the right", [(MOVE, 2), (MOVE, 2)]),
        ("the robot raises its left arm, then drops the arm", [(MOVE, 0), (MOVE, 0)]),
        ("raise its left arm, hold it, then lower it again", [(MOVE, 0), (MOVE, 0)]),
        ("the robot drops its right arm", [(MOVE, 1)]),
        ("pull its left arm out and drop it next to the robot", [(MOVE, 0), (MOVE, 0)]),
        ("its left arm is pulled out and falls over beside the robot", [(MOVE, 0), (MOVE, 0)]),
        ("take its head off and let it fall", [(MOVE, 2), (MOVE, 2)]),
        ("raise both arms above its head", [(MOVE, 0), (MOVE, 1)]),
        ("both arms sag down", [(MOVE, 0), (MOVE, 1)]),
        ("its left arm wiggles as if the head were stuck", [(SWAY, 0)]),
        ("the robot waves at us", [(SWAY, 0)]),
        ("its two little arms scuttle", [(SWAY, 0), (SWAY, 1)]),
    ],
)
def test_a_part_is_not_named_twice(sentence, told):
    reply = read(sentence)
    assert sorted(list_limbs(reply), key=str) == sorted(told, key=str)
    assert not reply.unsure


@pytest.mark.parametrize(
    "rest",
    [
        "while both arms and everything else remain stacked",
        "while its left arm and the right one stay put",
        "while both arms and everything else stay where they are",
    ],
)
def test_parts_that_stay_put_with_all_the_rest_do_not_move(rest):
    moved = [
        each
        for each in read(f"turn its head to the left {rest}").expectations
        if each.kind is not MotionKind.STILL
    ]
    assert [each.limb for each in moved] == [2]


def test_a_subject_of_several_parts_may_come_first():
    reply = read("both arms and everything else stay put while its head turns to the left")
    assert {each.limb for each in reply.expectations if each.kind is not MotionKind.STILL} == {2}


@pytest.mark.parametrize(
    "sentence",
    [
        "its left arm waves while the rest of him stays frozen",
        "its left arm waves while the rest stays put",
        "its left arm waves, everything else stays still",
        "its left arm waves while the body stays still",
    ],
)
def test_the_rest_that_is_still_is_what_is_held(sentence):
    """Judged by the pictures, the whole would not be still: its arm waves."""
    reply = read(sentence)
    assert list_limbs(reply) == [(SWAY, 0)] and reply.anchor.kind == "rest" and not reply.unsure


def test_a_part_is_still_without_a_verb():
    reply = read("its left arm waves, its right arm perfectly still")
    arm, other = reply.expectations
    assert (arm.kind, arm.limb) == (SWAY, 0) and (other.kind, other.limb) == (MotionKind.STILL, 1)
    assert arm.window == other.window and not reply.unsure


@pytest.mark.parametrize(
    "sentence", ["its arms are made of rubber and wobble", "stretch its left arm like rubber"]
)
def test_the_material_of_a_part_is_no_doubt(sentence):
    reply = read(sentence)
    assert not reply.unsure and "rubber" in reply.ignored


def test_what_is_done_to_it_after_a_part_was_raised_is_done_to_the_part():
    lid = HEAD.model_copy(update=dict(roles=("lid",), seated=True))
    reply = read("lift the lid up, tilt it to the left and lower it again", lid)
    kinds = [(each.kind, each.limb) for each in reply.expectations]
    assert kinds == [(MOVE, 0), (MotionKind.ROTATE, 0), (MOVE, 0)]
    ends = [each.window for each in reply.expectations]
    assert all(
        one[1] <= other[0] for one, other in zip(ends, ends[1:])
    )  # at the same time, one would undo the other


@pytest.mark.parametrize(
    "sentence",
    ["the robot raises its left arm and lets it drop again", "it bends its left arm up and lets it fall"],
)
def test_a_limb_goes_up_before_it_drops(sentence):
    """At the same time, the two would cancel."""
    up, down = read(sentence).expectations
    assert up.window[1] <= down.window[0] and dot(up.direction, down.direction) < -0.9


@pytest.mark.parametrize(
    "sentence",
    [
        "someone hits the robot's head and it falls over",
        "the robot waves its left arm and jumps",
        "push its left arm down, then the robot slides to the right",
    ],
)
def test_the_object_itself_is_no_part(sentence):
    assert list_limbs(read(sentence))[-1][1] is None


@pytest.mark.parametrize(
    "verb", ["drops down", "flops down", "falls to its side", "hangs down limply", "collapses"]
)
def test_a_part_that_falls_or_hangs_turns_down_about_its_joint(verb):
    reply = read(f"its left arm {verb}")
    (motion,), (made,) = reply.expectations, reply.force_field.constraints
    assert (motion.kind, motion.limb) == (MOVE, 0) and dot(motion.direction, DOWN) > 0.5
    assert made.constraint_type is ConstraintType.PARTICLE_ROTATION
    assert not reply.unsure


def test_what_falls_on_a_part_falls():
    reply = read("the robot falls on its left arm")
    assert MotionKind.FALL in [each.kind for each in reply.expectations]


def test_a_part_that_is_lowered_again_goes_back_by_as_much():
    reply = read("the robot lifts its left arm and lowers it again")
    up, down = reply.expectations
    assert up.window[1] <= down.window[0] + 0.5 and cosine(up.direction, down.direction) < -0.99
    first, second = reply.force_field.constraints
    turns = [each.magnitude * (each.active_time[1] - each.active_time[0]) for each in (first, second)]
    axes = cosine(first.vector, second.vector)
    assert turns[0] * turns[1] * axes < 0 and abs(turns[0]) == pytest.approx(abs(turns[1]), rel=1e-6)


def test_what_is_brought_to_the_other_side_goes_past_where_it_was():
    there, back = (
        [each.magnitude * each.gain * (each.active_time[1] - each.active_time[0]) for each in constraints]
        for constraints in (
            read(f"it tilts its head to the left, then {way}").force_field.constraints
            for way in ("to the right", "back")
        )
    )
    assert abs(there[1]) == pytest.approx(2 * abs(there[0]), rel=1e-3)
    assert abs(back[1]) == pytest.approx(abs(back[0]), rel=1e-3)


@pytest.mark.parametrize(
    "sentence",
    ["the robot's big shiny head wobbles", "its huge round head wobbles", "the robot's head wobbles"],
)
def test_adjectives_may_stand_between_an_owner_and_a_part(sentence):
    assert list_limbs(read(sentence)) == [(SWAY, 2)]


@pytest.mark.parametrize(
    ("sentence", "name"),
    [
        ("the robot waves its left hand", "left arm"),
        ("the robot raises its left hand", "left arm"),
        ("its left hand twists", "left hand"),
    ],
)
def test_hands_are_waved_and_raised_by_arms(sentence, name):
    parts = [LEFT_ARM.model_copy(update=dict(name=each, roles=())) for each in ("left arm", "left hand")]
    (limb,) = {each.limb for each in read(sentence, *parts).expectations}
    assert parts[limb].name == name


def test_what_a_head_does_is_done_by_the_head_where_there_is_one():
    assert list_limbs(read("the robot nods twice")) == [(SWAY, 2)]
    assert list_limbs(read("the robot nods twice", LEFT_ARM, RIGHT_ARM)) == [(SWAY, None)]


@pytest.mark.parametrize("words", ["looks around", "looks left and right"])
def test_what_looks_around_turns_its_head_to_and_fro(words):
    (look,) = read(f"the robot {words}").expectations
    assert (look.kind, look.limb) == (MotionKind.ROTATE, 2) and look.repeats > 1
    assert abs(look.direction[2]) == 1.0
    assert read(f"the robot {words}", LEFT_ARM, RIGHT_ARM).unsure  # no head is known


def test_what_the_whole_does_between_ends_what_a_part_does():
    """Its arm tilted and fell over."""
    seen = list_limbs(read("its left arm waves, the robot jumps up, tilts forward and falls over"))
    assert seen[0][1] is not None and {limb for _, limb in seen[1:]} == {None}


def test_the_leaves_of_a_plant_move_one_by_one():
    sides = [(1, 0, 0.2), (-1, 0, 0.2), (0, 1, 0.2), (0, -1, 0.2)]
    fronds = [make_part("arm", tuple(0.3 * c for c in side), tuple(c / 1.02 for c in side)) for side in sides]
    reply = read("the leaves droop down", *fronds, object_kind="plant")
    assert [each.limb for each in reply.expectations] == [0, 1, 2, 3]
    assert all(dot(each.direction, DOWN) > 0.5 for each in reply.expectations)
    fruit = read("the leaves on top of it sway", *fronds, object_kind="food")  # a pineapple's
    assert [each.limb for each in fruit.expectations] == [0, 1, 2, 3] and not fruit.unsure
    few = read("the leaves droop down", *fronds[:2], object_kind="plant")  # the rest of them is not found
    assert [each.limb for each in few.expectations] == [None]


@pytest.mark.parametrize("word", ["handle", "end of the handle"])
def test_what_alone_sticks_out_is_the_handle(word):
    side, rim = make_part("side", (0.3, 0, 0), (1, 0, 0)), make_part("side", (0, 0.3, 0), (0, 1, 0))
    assert not read(f"push the {word} up", side).unsure
    assert read(f"push the {word} up", side, rim).unsure


@pytest.mark.parametrize("rest", ["nothing else moves", "everything else stays still", "all else is still"])
def test_that_nothing_else_moves_is_no_motion(rest):
    reply = read(f"the robot lifts its left arm, {rest}")
    assert list_limbs(reply) == [(MOVE, 0)] and not reply.unsure


def test_the_rest_stays_still_where_a_part_moves_alone():
    assert not read("the robot turns its head while the rest of the body stays still").unsure


@pytest.mark.parametrize(
    "sentence",
    [
        "the robot rolls away like a barrel",
        "the chubby little robot falls over",
        "drop the robot so that it clangs",
        "the robot hops on the spot",
    ],
)
def test_what_tells_no_motion_is_no_doubt(sentence):
    reply = read_whole(sentence)
    assert not reply.unsure and reply.expectations


def test_round_is_around():
    turned = [read_whole(f"the robot spins {word} twice").expectations for word in ("round", "around")]
    assert turned[0] == turned[1] and turned[0][0].amount.value == 720


def test_what_stops_and_shakes_stops_first():
    still, shakes = read_whole("the robot slides to the right, then stops and shakes").expectations[1:]
    assert (still.kind, shakes.kind) == (MotionKind.STILL, SWAY)
    assert still.window[1] <= shakes.window[0] + 1


def test_a_noun_of_its_kind_is_the_object_on_the_spot():
    scene = brief(object_name="skater male", object_kind="object", object_nouns=("boy", "spot"))
    (leap, *_) = read_whole("boy hops on the spot three times", scene).expectations
    assert (leap.kind, leap.repeats) == (MOVE, 3)


def test_a_mouth_that_is_not_known_is_asked_for():
    reply = read("it opens its mouth wide", LEFT_ARM, HEAD)
    assert any("mouth" in each for each in reply.unsure + reply.unknown_parts)


def test_a_head_is_lowered_by_the_neck_that_bears_it():
    neck = make_part("head", (-0.2, 0, 0.2), (-0.8, 0, 0.6)).model_copy(update=dict(name="neck"))
    head = make_part("head", (-0.1, 0, 0), (-1, 0, 0)).model_copy(update=dict(name="head"))
    assert list_limbs(read("the horse lowers its head", neck, head)) == [(MOVE, 0)]
    assert read("the horse turns its head to the left", neck, head).expectations[0].limb == 1
    assert list_limbs(read("the horse lowers its head", head)) == [(MOVE, 0)]


def measure_turn(reply):
    """The angle [degrees] that the first constraint turns by, and the frames that it takes."""
    made = reply.force_field.constraints[0]
    return float(np.linalg.norm(find_turn(made))), made.active_time[1] - made.active_time[0]


def test_what_turns_slowly_turns_as_far():
    (plain, short), (slow, long), (slight, _) = (
        measure_turn(read(f"the robot {word} raises its left arm")) for word in ("", "slowly", "slightly")
    )
    assert slow == pytest.approx(plain, rel=0.05) and long > 1.2 * short
    assert slight < 0.8 * plain


def test_a_tail_goes_to_its_own_sides():
    """It points away from the viewer's left and right where the object stands so."""
    tail = make_part("tail", (0.3, 0, 0), (1, 0, 0))
    assert abs(read("it swishes its tail from side to side", tail).expectations[0].direction[1]) > 0.9
    assert abs(read("it swishes its tail up and down", tail).expectations[0].direction[2]) > 0.9


@pytest.mark.parametrize("words", ["the robot at the waist", "the middle of the robot", "the robot"])
def test_what_is_twisted_at_its_middle_is_wrung(words):
    reply = read_whole(f"someone twists {words}", brief(world="ground"))
    ways = [each.direction for each in reply.expectations if each.kind is MotionKind.ROTATE]
    assert len(ways) == 2 and cosine(*ways) < -0.99


@pytest.mark.parametrize(
    "sentence",
    [
        "it gets dropped from way up high and smashes into the ground",
        "it falls from way up there and slams onto the hard floor",
        "drop it from really high up",
    ],
)
def test_a_fall_from_high_up_goes_down_and_ends_on_the_ground(sentence):
    reply = read_whole(sentence, brief(world="ground"))
    assert [each.kind for each in reply.expectations] == [MotionKind.FALL]
    assert reply.force_field.default_drop and not reply.force_field.actions and not reply.unsure


def test_what_runs_into_the_object_hits_it():
    for words in ("A heavy ball smashes into the robot from the left.", "a ball slams into it"):
        (motion,) = read_whole(words, brief(world="ground")).expectations
        assert motion.kind is MOVE and motion.sudden


def test_each_of_a_pair_swings_across_itself():
    """Wings that hang to either side go out and up, each to its own side: they are no sheet that shears."""
    wings = [make_part("wing", (0.2 * s, 0, -0.18), (0.97 * s, 0, -0.22)) for s in (-1, 1)]
    left, right = (each.direction for each in read("the bird flaps both wings twice", *wings).expectations)
    assert left[0] == pytest.approx(-right[0]) and left[2] == pytest.approx(right[2])
    assert all(abs(cosine(way, wing.arm)) < 0.5 for way, wing in zip((left, right), wings))


def test_what_is_lowered_until_it_hangs_goes_on_down():
    angles = [
        abs(made.magnitude * made.gain * (made.active_time[1] - made.active_time[0]))
        for made in (
            read(f"the robot lowers its left arm{until}").force_field.constraints[0]
            for until in ("", " until it hangs down", " until it hangs by its side")
        )
    ]
    assert angles[1] == angles[2] > 1.4 * angles[0]


def test_a_part_that_moves_meanwhile_is_not_asked_to_be_still_and_that_is_said():
    reply = read("its left arm waves, its left arm perfectly still")
    assert list_limbs(reply) == [(SWAY, 0)] and any("not asked to be still" in note for note in reply.notes)


@pytest.mark.parametrize(
    "sentence",
    ["its left arm is pulled out", "someone pulls out its left arm", "yank its left arm out of the robot"],
)
def test_what_is_pulled_out_goes_along_itself(sentence):
    """It bent to the left, as what is pulled does."""
    (motion,) = read(sentence).expectations
    assert motion.kind is MOVE and cosine(motion.direction, LEFT_ARM.arm) > 0.95


@pytest.mark.parametrize(
    "sentence", ["pull its left arm off and drop it", "its head is lifted off and falls down"]
)
def test_what_was_taken_off_falls_by_itself(sentence):
    """It hung down from what it was off, or all of it fell."""
    *_, fall = read(sentence).expectations
    assert fall.manner == "detach"


def test_the_neck_of_a_thing_is_all_that_juts_out_on_top_with_the_head_at_its_end():
    """The head alone came off a guitar."""
    neck = make_part("top", (0, 0, 0.3), (0, 0, 1))
    assert list_limbs(read("its neck bends to the left", HEAD, neck))[0][1] == 1
    assert list_limbs(read("its neck bends to the left", HEAD))[0][1] == 0  # of a figure


def test_a_bone_is_what_a_joint_of_meat_is_held_by():
    grip = make_part("handle", (0.3, 0, 0), (1, 0, 0))
    reply = read("someone pulls on the bone until it snaps off", grip, object_name="ham", object_kind="food")
    assert {limb for _, limb in list_limbs(reply)} == {0} and not reply.unsure
