"""Parts that stick out: which of them a word means, and how a sentence moves them."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.calibration import HELD_TIME, PRESCRIBED_TRAVEL
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion, ConstraintType
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.vectors import cosine, cross, dot
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


def test_a_limb_is_drawn_out_along_itself_and_snaps_back():
    """From its joint on: a force on it would draw all of the object out."""
    reply = read("stretch its left arm to twice its length and let it snap back", frame_count=100)
    out, back = reply.force_field.constraints
    assert not reply.force_field.actions and reply.anchor.kind == "rest"
    for made, way in ((out, (-1, 0, 0)), (back, (1, 0, 0))):
        assert made.constraint_type is ConstraintType.PARTICLE_TRANSLATION
        assert made.vector == pytest.approx(way) and made.bend.depth == pytest.approx(0.3)
        seconds = (made.active_time[1] - made.active_time[0]) * brief().frame_dt
        length = made.magnitude * made.gain * PRESCRIBED_TRAVEL * seconds / HELD_TIME
        assert length == pytest.approx(0.3, rel=0.02)  # by its own length
    assert out.held_until == back.active_time[0]


@pytest.mark.parametrize(
    "sentence",
    ["stretch its arms to twice their length", "raise both arms, stretch them to double the length"],
)
def test_limbs_are_stretched_by_what_is_told_each_along_itself(sentence):
    """Before, they were moved by two lengths."""
    made = [each for each in read(sentence).expectations if each.kind is MotionKind.STRETCH]
    assert [each.limb for each in made] == [0, 1]
    assert all(each.amount is not None and each.amount.value == 2 for each in made)


@pytest.mark.parametrize(
    ("sentence", "limbs"),
    [
        ("the robot lowers its arms one by one", [0, 1]),
        ("each of its arms is raised in turn", [0, 1]),
        ("it raises one arm, then the other one", [0, 1]),
        ("its arms swing, first the left, then the right", [0, 1]),
    ],
)
def test_limbs_of_one_kind_act_one_after_another(sentence, limbs):
    """Those that nobody names in their order go from the left to the right of the picture."""
    first, second = read(sentence).expectations
    assert [first.limb, second.limb] == limbs and first.window[1] == second.window[0]


def test_a_limb_comes_on_top_of_the_turn_of_the_whole():
    """The whole is led first: what comes later wins."""
    reply = read("the robot turns around, waving its left arm", frame_count=100, world="ground")
    whole, *limb = reply.force_field.constraints
    assert whole.region is None and limb and all(each.carried for each in limb)


@pytest.mark.parametrize(
    "sentence",
    [
        "raise its left arm, then let go so it flops back down",
        "pull its left arm up and let it go so that it falls",
    ],
)
def test_a_limb_that_is_let_go_falls_back_alone(sentence):
    reply = read(sentence)
    assert [(each.limb, each.released) for each in reply.expectations] == [(0, True)]
    assert not reply.unsure and reply.anchor.kind == "rest"


@pytest.mark.parametrize(
    "sentence",
    [
        "somebody pulls on its left arm and it stretches",
        "pull on the left arm, and the left arm gets longer",
        "the left arm is pulled until it stretches",
    ],
)
def test_the_part_that_is_pulled_stretches_and_not_all_of_it(sentence):
    (seen,) = read(sentence, frame_count=100).expectations
    assert (seen.kind, seen.limb) == (MotionKind.STRETCH, 0)
    assert abs(cosine(seen.direction, (1, 0, 0))) == pytest.approx(1.0)


def test_what_is_pulled_as_a_whole_stretches_as_a_whole():
    seen = read("somebody pulls it to the left and it stretches", frame_count=100).expectations
    assert seen[-1].kind is MotionKind.STRETCH and seen[-1].limb is None


def test_a_limb_goes_as_far_while_the_rest_moves():
    """M = 1 means less where nothing holds the object (`find_reference_time`)."""
    angles = []
    for sentence, reference in (
        ("raise its left arm", HELD_TIME),
        ("it jumps and raises its left arm", 1.92),
    ):
        made = read(sentence, world="ground").force_field.constraints
        turn = next(each for each in made if each.constraint_type is ConstraintType.PARTICLE_ROTATION)
        seconds = (turn.active_time[1] - turn.active_time[0]) * brief().frame_dt
        angles.append(turn.magnitude * turn.gain * seconds / reference)
    assert angles[1] == pytest.approx(angles[0], rel=0.02)


def test_a_limb_that_comes_back_is_there_before_the_clip_ends():
    out, back = read(
        "slowly tilt its left arm to the right and let it come back", frame_count=76
    ).force_field.constraints
    assert back.active_time[1] < 0.95 * 75 and out.magnitude * out.gain > 0


def test_a_limb_that_is_stretched_across_itself_is_left_to_a_force():
    reply = read("stretch its left arm upwards", frame_count=100)
    assert not [each for each in reply.force_field.constraints if each.bend is not None]


@pytest.mark.parametrize(
    ("sentence", "degrees"),
    [("twist its head all the way round to the back", 180.0), ("turn its head all the way around", 360.0)],
)
def test_a_head_turns_to_the_back_by_half_a_turn_about_the_vertical(sentence, degrees):
    (seen,) = read(sentence, frame_count=100).expectations
    assert seen.kind is MotionKind.ROTATE and abs(seen.direction[2]) == pytest.approx(1.0)
    assert (seen.amount.value, seen.amount.unit) == (degrees, "degrees")


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
    """To 50 degrees over the horizon: M times gain times a quarter turn per 0.7 s, while it acts."""
    (constraint,) = read("raise the left arm").force_field.constraints
    first, last = constraint.active_time
    rate = constraint.magnitude * constraint.gain * 90.0 / 0.7
    assert rate * (last - first) * 0.04 == pytest.approx(50.0, rel=0.01)


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


@pytest.mark.parametrize(
    "how", ["bend its tail to one side", "push the tail sideways", "the tail is bent over aside"]
)
@pytest.mark.parametrize("arm", [(0.2, 0, 0), (0.17, 0.05, -0.1)])
def test_a_tail_that_is_bent_aside_goes_across_itself_to_the_viewer(how, arm):
    """Its tip went along itself, or up, where the tail is seen from its side."""
    tail = make_part("tail", arm, (1, 0, 0))
    (motion, *_) = read(f"{how}, then let it go", tail).expectations
    assert motion.direction is not None and abs(motion.direction[2]) < 0.4
    assert dot(motion.direction, brief().directions.toward) > 0.5


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


def make_limb(role, arm, side, **fields):
    """A part whose neck is known: a disc of 0.08 lengths."""
    return make_part(role, arm, side).model_copy(update=dict(neck=(0.02, 0.02, 0.02)) | fields)


def find_turn(constraint):
    """The rotation vector of a constraint [degrees]."""
    first, last = constraint.active_time
    return (
        constraint.magnitude
        * constraint.gain
        * 90
        / 0.7
        * (last - first)
        * 0.04
        * np.asarray(constraint.vector)
    )


HANGING = [make_limb("arm", (0.05 * s, 0.1, -0.3), (0.9 * s, 0.1, 0.42)) for s in (-1, 1)]
"""Two arms that hang down, a little behind the body."""


@pytest.mark.parametrize(("sentence", "limb"), [("raise the left arm", 0), ("pull the right arm up", 1)])
def test_an_arm_that_hangs_is_raised_beside_the_body(sentence, limb):
    """In the plane of the picture and away from the body, although it hangs a little backwards; and far enough."""
    reply = read(sentence, *HANGING, HEAD)
    (constraint,) = reply.force_field.constraints
    turn, arm = find_turn(constraint), np.asarray(HANGING[limb].arm)
    way = np.cross(turn, arm)
    assert abs(way[1]) < 0.02 * np.linalg.norm(way) and way[0] * arm[0] > 0
    assert np.linalg.norm(turn) > 60
    assert constraint.bend is not None and 0.05 < constraint.bend.depth < 0.2


def test_a_short_limb_turns_no_farther_than_its_skin_allows():
    stub = make_limb("arm", (0.04, 0, -0.1), (1, 0, 0), neck=(0.04, 0.04, 0.04))
    (constraint,) = read("raise the right arm", stub, HEAD).force_field.constraints
    assert 14 < np.linalg.norm(find_turn(constraint)) < 40


def test_an_arm_waves_above_and_beside_the_body():
    """It is raised first, and then goes to and fro without hanging down again."""
    reply = read("it waves its right arm", *HANGING, HEAD)
    arm, heights, levels = np.asarray(HANGING[1].arm), [], []
    turns = [find_turn(each) for each in reply.force_field.constraints]
    for turn in np.cumsum(turns, axis=0):
        turned = Rotation.from_rotvec(turn, degrees=True).apply(arm)
        heights.append(turned[2])
        levels.append(turned[0])
    assert len(turns) >= 5 and min(levels) > 0.05 and min(heights) > arm[2] + 0.02
    (motion,) = reply.expectations
    assert motion.kind is MotionKind.SWAY and motion.repeats >= 2


@pytest.mark.parametrize("arm", ["hanging", "level"])
def test_a_raised_arm_waves_from_side_to_side_about_where_it_is(arm):
    """It was raised a second time, and its hand went into the head."""
    arms = HANGING if arm == "hanging" else [make_limb("arm", (0, 0, 0.3), (s * 0.35, 0, 0)) for s in (-1, 1)]
    reply = read("it raises its right arm and waves goodbye", *arms, HEAD)
    raised, *turns = [find_turn(each) for each in reply.force_field.constraints]
    assert not reply.unsure and len(turns) >= 5
    way = reply.expectations[1].direction
    up = Rotation.from_rotvec(raised, degrees=True).apply(np.asarray(arms[1].arm))
    assert way is not None and abs(np.dot(way, up)) < 0.4 * np.linalg.norm(up)
    angles = np.cumsum([turn[1] for turn in turns])
    assert -0.25 < (angles.max() + angles.min()) / np.ptp(angles) < 0.25


def test_a_head_that_nods_goes_forward_and_back():
    """A word that tells its own way keeps it."""
    (motion,) = read("the robot nods its head", HEAD).expectations
    assert abs(motion.direction[1]) > 0.9


def test_what_bends_is_brought_where_it_is_bent():
    """A free thing that is bent turns over as a whole; an ear that points right goes towards who looks."""
    ear = make_limb("ear", (0.3, 0, 0), (1, 0, 0))
    reply = read("bend the right ear towards us", ear, HEAD)
    (constraint,) = reply.force_field.constraints
    assert np.cross(find_turn(constraint), ear.arm)[1] < -0.29 * 40
    assert constraint.bend.depth == pytest.approx(0.3)


def test_a_blow_swings_a_part_at_once_and_lets_it_go():
    tail = make_limb("tail", (0, 0.3, 0), (0, 1, 0))
    reply = read("hit the tail from the left", tail, HEAD)
    (constraint,) = reply.force_field.constraints
    first, last = constraint.active_time
    assert (last - first) * 0.04 <= 0.25 and constraint.held_until is None
    assert np.cross(find_turn(constraint), tail.arm)[0] > 0 and reply.anchor.kind == "rest"


def test_a_twist_of_a_part_goes_about_its_own_line():
    arm = make_limb("arm", (0.3, 0, 0), (1, 0, 0), neck=(0.002, 0.02, 0.02))
    (constraint,) = read("twist the right arm", arm, HEAD).force_field.constraints
    assert constraint.bend.depth > 0.09  # as wide as the neck, which is thin along the arm
    assert abs(find_turn(constraint)[0]) > 20 and np.abs(find_turn(constraint)[1:]).max() < 1e-6


CHIN = dict(name="chin", roles=(), origin="place", seated=True)
KNOB = make_part("side", (0.3, 0, 0), (1, 0, 0))
GUESSED = TAIL.model_copy(update=dict(name="tail", stands_for="side (part 3)", confidence=0.5))


@pytest.mark.parametrize(
    ("sentence", "parts", "certain"),
    [
        ("raise the right arm", [HANGING[0], HANGING[1], HEAD], True),
        ("raise the right arm", [KNOB, HEAD], False),
        ("raise the right arm", [HANGING[1].model_copy(update=dict(confidence=0.3)), HEAD], False),
        ("pull the chin down", [HEAD, TAIL.model_copy(update=CHIN)], True),
        ("pull the chin down", [HEAD, TAIL.model_copy(update=CHIN | dict(confidence=0.3))], False),
        ("it wags its tail", [TAIL, make_part("tail", (0, 0.1, 0.1), (0, 0.9, 0.4))], False),
        ("raise the arms", [HANGING[1], HEAD], False),
        ("raise the right arm", [KNOB.model_copy(update=dict(name="arm", origin="option")), HEAD], True),
        ("lift the left wing", [HEAD, TAIL], False),
        ("pull the ears up", [HEAD, TAIL], False),
        ("push the head to the left", [TAIL], True),
        ("it wags its tail", [HEAD, GUESSED], False),
    ],
)  # fmt: skip
def test_a_part_that_nothing_tells_for_certain_is_a_doubt(sentence, parts, certain):
    """A place alone, an unclear shape, one tail of two, one arm of a pair, or no such part."""
    assert (read(sentence, *parts).unsure == ()) is certain


@pytest.mark.parametrize("parts", [(HEAD, TAIL), (make_part("side", (0.1, 0, 0), (0.6, 0, 0.8)),) * 2])
def test_a_part_that_the_shape_does_not_show_is_asked_for(parts):
    """A force on one side would take all of it along."""
    assert read("lift the left wing", *parts).unknown_parts == ("left wing",)
    assert read("pull the ears up", *parts).unknown_parts == ("ears",)
    assert read("lift the robot", *parts).unknown_parts == ()


def test_a_blow_on_the_end_of_a_part_tips_it_over_its_joint():
    """Along itself it could only be pushed into the body."""
    (constraint,) = read("hit the right arm from the right", RIGHT_ARM, HEAD).force_field.constraints
    assert constraint.constraint_type is ConstraintType.PARTICLE_ROTATION
    assert find_way(constraint, RIGHT_ARM)[2] > 0.29


MUZZLE = make_limb("nose", (0, -0.05, 0), (0, -1, 0), roles=(), name="muzzle", origin="place", seated=True)


@pytest.mark.parametrize(
    ("sentence", "way", "length"),
    [
        ("pull the muzzle up", (0, 0, 1), 0.12),
        ("push the muzzle to the left", (-1, 0, 0), 0.12),
        ("push the muzzle back", (0, 1, 0), 0.03),
        ("press on the muzzle", (0, 1, 0), 0.03),
    ],
)
def test_a_region_is_drawn_so_far_that_it_is_seen_with_a_soft_border(sentence, way, length):
    """It has no joint to turn about: it moves itself, and its border goes along in part."""
    reply = read(sentence, HEAD, MUZZLE)
    (made,) = reply.force_field.constraints
    first, last = made.active_time
    assert made.constraint_type is ConstraintType.PARTICLE_TRANSLATION and made.bend is not None
    assert dot(made.vector, way) > 0.99 and reply.anchor.kind == "rest" and not reply.unsure
    assert made.magnitude * made.gain * (last - first) * 0.04 == pytest.approx(
        length / PRESCRIBED_TRAVEL * HELD_TIME, rel=0.05
    )


def test_a_blow_on_the_front_drives_the_whole_away():
    belly = MUZZLE.model_copy(update=dict(name="belly"))
    assert read("hit the robot in the belly", HEAD, belly).anchor.kind is None
    assert read("push the robot's belly to the left", HEAD, belly).anchor.kind == "rest"


@pytest.mark.parametrize(
    ("sentence", "limbs"),
    [
        ("one of the robot's arms is bent inwards", [0]),
        ("bend both arms of the robot inwards", [0, 1]),
        ("bend one of its arms", [0]),
        ("it lifts an arm", [0]),
        ("a hand lifts the robot", [None]),
    ],
)
def test_one_of_several_is_one_and_both_are_all(sentence, limbs):
    assert sorted((each.limb for each in read(sentence).expectations), key=str) == limbs


@pytest.mark.parametrize(("word", "sign"), [("inwards", -1), ("outwards", 1)])
def test_parts_go_to_the_middle_or_away_from_it_each_by_itself(word, sign):
    parts = [make_part("leg", (0, 0, -0.3), (x, 0, -0.6)) for x in (-0.8, 0.8)]
    reply = read(f"bend the legs {word}", *parts)
    assert not reply.unsure and len(reply.expectations) == 2
    for each, constraint in zip(reply.expectations, reply.force_field.constraints):
        part = parts[each.limb]
        assert sign * find_way(constraint, part)[0] * part.side[0] > 0


@pytest.mark.parametrize(
    ("sentence", "parts", "certain"),
    [
        ("bend the antennae back", [make_part("ear", (0, 0, 0.2), (x, 0, 0.9)) for x in (-0.3, 0.3)], True),
        ("turn the dish around", [make_part("top", (0, 0, 0.2), (0, 0, 1)), TAIL], True),
        ("lift the wings", [LEFT_ARM.model_copy(update=dict(roles=("side", "wing"))), HEAD], False),
        ("pull the cap up", [make_part("top", (0, 0, 0.2), (0, 0, 1)), TAIL], False),
    ],
)  # fmt: skip
def test_a_word_for_a_place_or_for_what_a_part_alone_may_be_is_certain(sentence, parts, certain):
    reply = read(sentence, *parts)
    assert reply.expectations[0].limb is not None and (reply.unsure == ()) is certain


def test_left_is_as_the_file_has_it_where_it_names_sides():
    """A figure that looks at the viewer has its left arm on the viewer's right."""
    parts = [
        each.model_copy(update=dict(name=name, origin="file"))
        for each, name in ((LEFT_ARM, "right arm"), (RIGHT_ARM, "left arm"))
    ]
    assert [each.limb for each in read("it lifts its left hand", *parts, HEAD).expectations] == [1]


@pytest.mark.parametrize("words", ["the dish turns around", "the head turns around"])
def test_what_stands_on_the_rest_turns_by_half_a_turn_and_a_head_less(words):
    top = make_part("top", (0, 0, 0.2), (0, 0, 1))
    turned, other = (
        abs(made.magnitude) * made.gain * (made.active_time[1] - made.active_time[0])
        for text in (words, f"{words} by 45 degrees")
        for made in read(text, top, TAIL).force_field.constraints
    )
    assert turned / other == pytest.approx(4.0 if "dish" in words else 1.0, rel=0.3)


def test_a_head_that_looks_aside_nods_down_and_shakes_levelly():
    head = make_part("head", (-0.3, 0, 0.05), (-0.9, 0, 0.4))
    nod, shake = (read(f"it {verb} its head", head, TAIL).expectations[0] for verb in ("nods", "shakes"))
    assert abs(nod.direction[2]) > 0.8 > 0.3 > abs(shake.direction[2])


def test_of_parts_that_are_alike_the_one_in_front_is_meant():
    legs = [make_part("leg", (0, 0, -0.3), (x, y, -0.6)) for x, y in ((0.1, 0.8), (-0.1, -0.8))]
    assert [each.limb for each in read("bend one of its legs to the left", *legs).expectations] == [1]


def test_a_leg_that_kicks_swings_out_and_not_into_the_other():
    right = make_part("leg", (0.02, 0, -0.4), (0.3, 0, -0.95))
    left = make_part("leg", (-0.02, 0, -0.4), (-0.3, 0, -0.95))
    for sentence, leg, sign in (("kick with the right leg", right, 1), ("kick with the left leg", left, -1)):
        (kick, *_) = read(sentence, left, right, HEAD).force_field.constraints
        assert sign * find_way(kick, leg)[0] > 0


@pytest.mark.parametrize(
    "sentence", ["the robot spreads its arms", "spread out both arms", "it unfolds its arms"]
)
def test_parts_that_are_spread_go_apart_each_by_itself(sentence):
    arms = [make_part("arm", (0.1 * s, 0, -0.3), (s, 0, 0)) for s in (-1, 1)]
    left, right = read(sentence, *arms, HEAD).force_field.constraints
    assert find_way(left, arms[0])[0] < 0 < find_way(right, arms[1])[0]


@pytest.mark.parametrize("sentence", ["the robot opens its mouth", "open the jaw"])
def test_a_jaw_opens_downwards(sentence):
    noun = sentence.split()[-1]
    jaw = make_part("side", (0, -0.2, 0), (0, -1, 0)).model_copy(
        update=dict(roles=(), name=noun, origin="place", neck=(0.03, 0.03, 0.03))
    )
    reply = read(sentence, jaw, HEAD)
    assert find_way(reply.force_field.constraints[0], jaw)[2] < 0
    (closes,) = read(f"the {noun} snaps shut", jaw, HEAD).force_field.constraints
    assert find_way(closes, jaw)[2] > 0
    assert reply.expectations[0].direction[2] < 0


def test_of_two_parts_behind_each_other_a_side_tells_one():
    horns = [make_part("horn", (0, 0.1 * s, 0.2), (0.05 * s, 0.6 * s, 0.8)) for s in (-1, 1)]
    assert read("bend the left horn back", *horns).expectations[0].limb == 0
    assert read("bend the right horn back", *horns).expectations[0].limb == 1


@pytest.mark.parametrize(
    ("sentence", "front", "way"),
    [
        ("bend the head backwards", (1.0, 0.0, 0.0), (-1, 0, 0)),
        ("bend the head forward", (1.0, 0.0, 0.0), (1, 0, 0)),
        ("bend the head away from us", (1.0, 0.0, 0.0), (0, 1, 0)),
        ("bend the head backwards", None, (0, 1, 0)),
    ],
)
def test_backwards_is_where_the_back_is_if_that_is_known(sentence, front, way):
    upright = make_part("head", (0, 0, 0.3), (0, 0, 1)).model_copy(update=dict(front=front))
    (constraint,) = read(sentence, upright).force_field.constraints
    assert np.allclose(np.cross(constraint.vector, (0, 0, 1)), way, atol=0.2)


def test_what_wags_on_a_free_object_does_not_rock_all_of_it():
    reply = read("it wags its tail", TAIL, HEAD, world="ground", may_be_held=True)
    assert reply.force_field.constraints and all(each.region for each in reply.force_field.constraints)


def test_a_limb_curls_farther_than_it_bends_and_over_all_of_its_length():
    tail = TAIL.model_copy(update=dict(neck=(0.01, 0.0, 0.01)))
    (bend, *_), (curl, *_) = (
        read(f"it {verb}s its tail", tail).force_field.constraints for verb in ("lift", "curl")
    )
    assert find_way(curl, tail)[2] > 0 and curl.bend.depth == pytest.approx(0.2)
    assert abs(curl.magnitude) * curl.gain > 1.3 * abs(bend.magnitude) * bend.gain


def test_a_head_that_is_bent_to_the_ground_turns_until_it_is_there():
    head = make_part("head", (-0.4, 0, 0.1), (-1, 0, 0.2))
    to_ground, down = (
        read(f"bend its head down{more}", head, TAIL, world="ground").force_field.constraints[0]
        for more in (" to the ground", "")
    )
    assert to_ground.magnitude * to_ground.gain != pytest.approx(down.magnitude * down.gain)
    assert find_way(to_ground, head)[2] < 0


def test_what_sits_on_the_rest_sways_about_its_foot():
    rows = [0.3 + 0.1 * k for k in range(5)]
    sign = tuple((x, y, z) for x in rows for y in rows for z in (0.8, 0.9, 1.0))
    roof = tuple((x, y, z) for x in rows for y in rows for z in (0.0, 0.4, 0.75))
    part = make_part("top", (0, 0, 0.2), (0, 0, 1)).model_copy(
        update=dict(
            name="sign",
            origin="option",
            seated=True,
            moved=CellsRegion(inside=sign, outside=roof),
            rest=CellsRegion(inside=roof, outside=sign),
            joint=(0.5, 0.5, 0.9),
        )
    )
    made = read("the sign sways", part, extents=(1.0, 1.0, 1.0)).force_field.constraints
    assert made and all(each.constraint_type is ConstraintType.PARTICLE_ROTATION for each in made)
    assert all(each.pivot[2] < 0.88 for each in made)


@pytest.mark.parametrize("verb", ["turn", "steer", "pivot"])
def test_wheels_that_steer_go_to_and_fro_about_the_upright(verb):
    """They turned once, in a tenth of the time."""
    wheel = make_part("side", (0, 0.1, 0), (0, -1, 0)).model_copy(update=dict(name="wheel", axle=(0, 1, 0)))
    reply = read(f"the wheel {verb}s left and right while the robot is parked", wheel)
    made = reply.force_field.constraints
    assert [cosine(each.vector, made[0].vector) for each in made] == pytest.approx([1, -1, 1, -1, 1])
    assert all(abs(each.vector[2]) > 0.99 for each in made) and made[-1].active_time[1] == 48
    assert not reply.unsure


def test_a_wheel_goes_around_twice_where_it_spins_fast():
    wheel = make_part("side", (0, 0.1, 0), (0, -1, 0)).model_copy(update=dict(name="wheel", axle=(0, 1, 0)))
    plain, fast = (
        abs(made.magnitude) * made.gain
        for text in ("the wheel spins", "the wheel spins fast")
        for made in read(text, wheel).force_field.constraints
    )
    assert fast == pytest.approx(2 * plain, rel=0.01)


def test_an_upright_head_that_shakes_turns_to_either_side():
    made = read("the robot shakes its head").force_field.constraints
    assert len(made) > 2 and all(abs(each.vector[2]) > 0.99 for each in made)
    assert {each.vector[2] > 0 for each in made} == {True, False}


def test_an_upright_head_nods_to_where_we_stand():
    (nod, *_) = read("the robot nods its head").force_field.constraints
    assert find_way(nod, HEAD)[1] < -0.1


def test_a_head_that_is_turned_is_twisted_visibly():
    head = HEAD.model_copy(update=dict(neck=(0.08, 0.08, 0.0)))
    (turn, *_) = read("turn the head to the left", head).force_field.constraints
    first, last = turn.active_time
    angle = 90 * abs(turn.magnitude) * turn.gain * (last - first) * brief().frame_dt / HELD_TIME
    assert angle >= 38


def test_a_limb_that_is_let_go_is_brought_back():
    """Stiff limbs spring back little, and soft ones swing on."""
    away, back = read(
        "the robot's left arm bends forward and then comes back", LEFT_ARM
    ).force_field.constraints
    assert (away.held_until or away.active_time[1]) == back.active_time[0] and back.active_time[1] <= 48
    assert np.dot(find_way(away, LEFT_ARM), find_way(back, LEFT_ARM)) < 0
    turns = [
        abs(each.magnitude * each.gain) * (each.active_time[1] - each.active_time[0]) for each in (away, back)
    ]
    assert turns[0] == pytest.approx(turns[1], rel=0.01)


def test_arms_that_swing_as_it_walks_are_not_left_behind():
    """They were turned about shoulders that stayed where they had been, and then not at all."""
    scene = dict(world="ground")
    for sentence, led in (("its arms swing while it walks to the left", True), ("its arms swing", False)):
        driven = [e for e in read(sentence, **scene).force_field.constraints if e.region is not None]
        assert driven and all(each.carried is led for each in driven)


@pytest.mark.parametrize("where", ["above its head", "over the head", "up to the sky"])
def test_arms_are_raised_as_high_as_is_told(where):
    """They stopped a little over the horizon."""
    plain, high = (
        read(f"it raises both its arms{place}").force_field.constraints for place in ("", f" {where}")
    )
    for low, up in zip(plain, high, strict=True):
        assert (
            up.vector == pytest.approx(low.vector) and up.magnitude * up.gain > 1.5 * low.magnitude * low.gain
        )


@pytest.mark.parametrize(
    "sentence",
    [
        "bend its right arm down until it hangs by its side",
        "lower its right arm straight down",
        "raise its right arm until it points at the sky",
        "it raises its right arm straight up",
    ],
)
def test_a_pose_tells_how_far_an_arm_goes(sentence):
    """They went half of the way, and the verdict did not mind."""
    reply = read(sentence)
    ((motion,), (constraint,)) = reply.expectations, reply.force_field.constraints
    assert motion.limb == 1 and reply.anchor.kind == "rest"
    assert motion.amount is not None and motion.amount.unit == "degrees"
    assert 70 < np.linalg.norm(find_turn(constraint)) == pytest.approx(motion.amount.value, rel=0.02)
    (plain,) = read("lower its right arm").expectations
    assert plain.amount is None


@pytest.mark.parametrize(
    "sentence", ["the wheel spins faster and faster", "the wheel rotates faster and faster"]
)
def test_a_wheel_gets_faster_and_faster(sentence):
    wheel = make_part("side", (0, 0.1, 0), (0, -1, 0)).model_copy(update=dict(name="wheel", axle=(0, 1, 0)))
    made = read(sentence, wheel).force_field.constraints
    turns = [np.linalg.norm(find_turn(each)) for each in made]
    assert len(made) > 2 and all(b > 1.2 * a for a, b in zip(turns, turns[1:])) and sum(turns) > 300


def test_the_handle_of_what_lies_is_bent_alone():
    handle = make_part("handle", (-0.3, 0, 0), (-1, 0, -1))
    reply = read("bend the handle up", handle, HEAD, long_axis=(1, 0, 0), object_kind="tool")
    assert [each.limb for each in reply.expectations] == [0]


@pytest.mark.parametrize(
    "sentence", ["pull the robot arm to the left", "pull its grey robot arm to the left"]
)
def test_a_part_may_stand_behind_the_name_of_its_object(sentence):
    reply = read(sentence, LEFT_ARM, HEAD)
    assert [each.limb for each in reply.expectations] == [0] and not reply.unknown_parts


def test_an_arm_that_is_pulled_long_is_drawn_out():
    (first, _) = read("pull its left arm really long and let go", frame_count=100).force_field.constraints
    assert first.constraint_type is ConstraintType.PARTICLE_TRANSLATION
    assert first.vector == pytest.approx((-1, 0, 0))


@pytest.mark.parametrize(
    "prompt", ["it beats its wings slowly, twice", "its wings beat twice", "it flaps its wings twice"]
)
def test_wings_beat_to_and_fro(prompt):
    wings = [make_part("wing", (c, 0, 0), (c / abs(c), 0, 0)) for c in (-0.3, 0.3)]
    seen = read(prompt, *wings).expectations
    assert [(each.kind, each.limb, each.repeats) for each in seen] == [
        (MotionKind.SWAY, k, 2) for k in (0, 1)
    ]


@pytest.mark.parametrize(
    "prompt",
    [
        "it opens and closes its claws twice",
        "its claws open and shut twice",
        "its claws clack twice",
        "it snaps its claws twice",
    ],
)
def test_claws_open_and_close_to_and_fro(prompt):
    seen = read(prompt, LEFT_ARM, RIGHT_ARM)
    assert not seen.unsure and seen.anchor.kind == "rest"
    assert [(each.kind, each.limb, each.repeats) for each in seen.expectations] == [
        (MotionKind.SWAY, k, 2) for k in (0, 1)
    ]


def test_what_opens_and_stays_open_is_held_there():
    reply = read("the left claw opens wide and stays open", LEFT_ARM, RIGHT_ARM)
    assert [(each.limb, each.stays) for each in reply.expectations] == [(0, True)] and not reply.unsure


def test_a_side_tells_which_part_of_a_name_is_meant():
    """Parts of the file that are called alike are told apart by where they are."""
    named = dict(roles=(), name="wheel", origin="file")
    wheels = [make_part("side", (c, 0, 0), (c / abs(c), 0, 0)).model_copy(update=named) for c in (-0.3, 0.3)]
    for side, limb in (("left", 0), ("right", 1)):
        (seen,) = read(f"the {side} wheel comes off", *wheels).expectations
        assert (seen.limb, seen.manner) == (limb, "detach")


@pytest.mark.parametrize("prompt", ["it swings its left arm up", "swing the left arm upwards"])
def test_a_swing_one_way_is_one_move(prompt):
    (seen,) = read(prompt).expectations
    assert seen.kind is MotionKind.MOVE and seen.direction[2] > 0.5


def test_what_is_all_head_is_meant_by_its_head():
    """It has ears and horns and nothing else: "the head" was a piece of its surface."""
    ears, horns = (
        [make_part(role, (c, 0, 0), (c / abs(c), 0, 0)) for c in (-0.3, 0.3)] for role in ("ear", "horn")
    )
    (seen,) = read("the monster's head nods", *ears, *horns).expectations
    assert seen.limb is None and not seen.partial
    (seen,) = read("the head nods", *ears, HEAD).expectations
    assert seen.limb == 2


def test_a_short_limb_that_is_moved_gently_is_seen_to_move():
    """Its tip goes by 0.08 body lengths where its skin allows that: by a slight word it went a quarter of it."""
    short = make_part("arm", (-0.15, 0, 0), (-1, 0, 0))
    (made,) = read("gently push its left arm up a tiny bit", short, HEAD).force_field.constraints
    assert np.linalg.norm(find_turn(made)) == pytest.approx(30, abs=0.5)
    (made,) = read("tilt its left arm up by 10 degrees", short, HEAD).force_field.constraints
    assert np.linalg.norm(find_turn(made)) == pytest.approx(10, abs=0.5)


@pytest.mark.parametrize(
    "sentence",
    [
        "twist its head to the left, then let go so it springs back",
        "grab the head, turn it around and let it snap back",
    ],
)
def test_a_part_that_is_twisted_and_let_go_is_turned_back(sentence):
    out, *swings = read(sentence, frame_count=100).force_field.constraints
    back = swings[0]
    assert (
        back.vector == pytest.approx([-c for c in out.vector]) and back.active_time[0] >= out.active_time[1]
    )
    left = find_degrees(out) + sum(find_degrees(each) * cosine(each.vector, out.vector) for each in swings)
    assert out.held_until in (None, back.active_time[0]) and left == pytest.approx(0.0, abs=1.0)


@pytest.mark.parametrize(
    ("sentence", "way"),
    [
        ("its left arm flops backwards and springs up again", (0, 1, 0)),
        ("the left arm flops back, then pops back up", (0, 1, 0)),
        ("its left arm flops down and springs up", (0, 0, -1)),
    ],
)
def test_what_flops_bends_far_over_and_comes_back(sentence, way):
    reply = read(sentence, frame_count=100)
    out = reply.force_field.constraints[0]
    assert np.dot(find_way(out, LEFT_ARM), way) > 0.1 and reply.expectations[0].released
    assert find_degrees(out) > 60


def find_degrees(turn):
    """The angle of a rotation [degrees]."""
    seconds = (turn.active_time[1] - turn.active_time[0]) * brief().frame_dt
    return 90 * turn.magnitude * turn.gain * seconds / HELD_TIME


@pytest.mark.parametrize(
    ("sentence", "like"),
    [
        ("it holds its left arm up", "it raises its left arm and keeps it raised"),
        ("it holds up its left arm", "it raises its left arm and keeps it raised"),
        ("it stands with both arms in the air", "it raises both arms and keeps them raised"),
        ("it sits there with its arms held high", "it raises both arms and keeps them raised"),
        ("it keeps its arms spread wide", "it spreads its arms and keeps them spread"),
        ("it stands with its arms stretched out", "it spreads its arms and keeps them spread"),
    ],
)
def test_a_posture_is_taken_and_kept(sentence, like):
    posture, told = (read(each, *HANGING, HEAD) for each in (sentence, like))
    assert not posture.unsure and all(each.stays for each in posture.expectations)
    assert posture.force_field.constraints == told.force_field.constraints


def test_arms_are_held_out_in_front():
    for each in (
        "holds both arms straight out in front",
        "stands with its arms stretched out in front of it",
    ):
        reply = read(f"the robot {each}", *HANGING, HEAD)
        assert not reply.unsure and all(m.stays and m.direction[1] < 0 for m in reply.expectations)


@pytest.mark.parametrize("sentence", ["it spins with arms raised", "it jumps with its arms out"])
def test_a_posture_of_what_moves_is_no_motion(sentence):
    assert all(each.limb is None for each in read(sentence, *HANGING, HEAD).expectations)


def test_the_leftmost_limb_is_so_in_the_picture():
    """Whatever the file calls it."""
    for names in (("", ""), ("right arm", "left arm")):
        arms = [arm.model_copy(update=dict(name=n, origin="file")) for arm, n in zip(HANGING, names)]
        (motion,) = read("the leftmost arm is raised", *(arms if names[0] else HANGING), HEAD).expectations
        assert motion.limb == 0


@pytest.mark.parametrize("where", ["at the front", "at the tip", "at the end"])
def test_the_end_at_which_a_limb_bends_is_no_second_part(where):
    reply = read(f"its left arm droops {where}")
    assert not reply.unsure and [each.limb for each in reply.expectations] == [0]


@pytest.mark.parametrize("word", ["white", "blue", "shiny"])
def test_an_adjective_of_a_part_is_not_the_object(word):
    assert (
        word in read(f"the {word} part lifts", HEAD, object_name="nes", object_kind="object").not_understood
    )


@pytest.mark.parametrize(
    ("words", "swings"),
    [("snaps back", 4), ("pings back up", 4), ("comes back", 1), ("slowly eases back up", 1)],
)
def test_a_part_that_springs_back_goes_too_far_and_comes_to_rest(words, swings):
    reply = read(f"its left arm bends down, then {words}", frame_count=100)
    there, *back = reply.force_field.constraints
    turned = [
        each.magnitude * each.gain * (each.active_time[1] - each.active_time[0]) for each in (there, *back)
    ]
    ways = [math.copysign(1.0, dot(each.vector, there.vector)) for each in (there, *back)]
    assert len(back) == swings and ways == [(-1.0) ** k for k in range(swings + 1)]
    assert sum(way * angle for way, angle in zip(ways, turned)) == pytest.approx(0.0, abs=0.02 * turned[0])
    assert reply.expectations[0].springs == (swings > 1)


def test_what_is_to_be_still_is_held_while_another_part_moves():
    """A handle that "stays still" was let go with the blade that spins."""
    reply = read("its left arm waves while its right arm stays still")
    kinds = {each.limb: each.kind for each in reply.expectations}
    assert kinds == {0: MotionKind.SWAY, 1: MotionKind.STILL} and not reply.unsure
    assert reply.anchor.kind == "rest" and reply.anchor.region.inside == LEFT_ARM.rest.inside
