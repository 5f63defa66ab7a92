"""Parts that have names of their own: which of them a sentence means, and what it does to them."""

import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion, ConstraintType
from physagent_jax.motion.parts import find_named, label_parts
from physagent_jax.motion.schema import MotionKind
from tests.agents.scenes import brief

MIDDLE = ((0.5, 0.5, 0.5), (0.5, 0.5, 0.3))


def make_part(name="", side=(0, 0, 1), origin="file", **fields):
    place = tuple(0.5 + 0.4 * c for c in side)
    return Part(
        name=name,
        origin=origin,
        moved=CellsRegion(inside=(place,), outside=MIDDLE),
        rest=CellsRegion(inside=MIDDLE, outside=(place,)),
        joint=place,
        arm=tuple(0.3 * c for c in side),
        side=side,
        share=0.1,
        **fields,
    )


LID, POT = make_part("pot lid", seated=True), make_part("pot", (0, 0, -1), seated=True)
ARM = make_part("left arm", (1, 0, 0))  # the figure's own left, on the viewer's right
HEAD = make_part(roles=("head",), origin="shape")


def read(sentence, *parts, **scene):
    about = brief(parts=label_parts(parts or (LID, POT, ARM, HEAD), brief().directions), **scene)
    return compile_intent(read_intent(sentence, about), about)


def find_limbs(sentence, *parts, **scene):
    reply = read(sentence, *parts, **scene)
    return [each.limb for each in reply.expectations], reply.unsure


@pytest.mark.parametrize(
    ("sentence", "limb"),
    [
        ("turn the lid", 0),
        ("lift the pot lid", 0),
        ("the lid of the robot turns to the left", 0),
        ("the robot lifts its lid and then turns it", 0),
        ("raise left_arm", 2),
        ("raise the left arm", 2),
        ("bend the Left Arm forward", 2),
        ("push the head to the left", 3),
        ("turn the lid round and round", 0),
    ],
)
def test_a_noun_that_is_a_parts_name_takes_that_part(sentence, limb):
    limbs, doubts = find_limbs(sentence)
    assert not doubts and limbs[0] == limb


def test_names_of_the_file_go_before_shapes_of_the_same_role():
    shape = make_part(roles=("head",), origin="shape")
    assert find_limbs("push the head to the left", shape, make_part("head"))[0] == [1]
    assert find_limbs("push the face to the left", shape, make_part("head"))[0] == [
        1
    ]  # the lexicon's word for it
    assert find_limbs("push the head to the left", make_part("head"), make_part("head", origin="option"))[
        0
    ] == [1]


def test_the_whole_body_is_the_object():
    body = make_part("body", seated=True)
    assert find_limbs("the whole body moves to the left", body)[0] == [None]
    assert find_limbs("the body moves to the left", body)[0] == [0]


@pytest.mark.parametrize("side", [(1, 0, 0), (0, -1, 0)])
@pytest.mark.parametrize(("verb", "sign"), [("poke", -1), ("a ball hits", -1), ("push", -1), ("pull", 1)])
def test_what_faces_aside_is_pressed_into_the_rest_or_pulled_out(verb, sign, side):
    """An eye, a door; what lies on top goes aside, as all else does."""
    (motion,) = read(f"{verb} the button", make_part("button", side, seated=True)).expectations
    assert motion.direction == pytest.approx(tuple(sign * c for c in side))
    (motion,) = read(f"{verb} the button", make_part("button", seated=True)).expectations
    assert motion.direction[0] < -0.7


def test_the_objects_own_name_is_the_object():
    assert find_limbs("push the pot to the left", object_name="pot")[0] == [None]
    assert find_limbs("turn the lid", object_name="pot with lid")[0] == [0]
    assert find_limbs("push the pot to the left")[0] == [1]
    arm = make_part("upper arm")
    assert find_limbs("push the robot arm to the left", arm, object_name="robot-arm") == ([None], ())
    assert find_limbs("push the upper arm to the left", arm, object_name="robot-arm")[0] == [0]


@pytest.mark.parametrize("name", ["coffee_grinder", "grinder"])
def test_numbered_pieces_of_the_objects_own_name_are_no_parts_by_that_word(name):
    pieces = [make_part(f"grinder {number}") for number in (1, 2, 3)]
    assert find_limbs("push the grinder to the left", *pieces, object_name=name) == ([None], ())
    assert find_limbs("push grinder 2 to the left", *pieces, object_name=name)[0] == [1]
    assert find_limbs("push the leg to the left", make_part("leg 1"), object_name=name)[0] == [0]


def test_a_plural_means_all_and_a_word_for_several_the_one_that_is_seen_best():
    sides = {"top": (0, 0, 1), "bottom": (0, 0, -1), "front": (0, -1, 0)}
    boxes = [make_part(f"{where} box", side) for where, side in sides.items()]
    assert sorted(find_limbs("turn the boxes", *boxes)[0]) == [0, 1, 2]
    assert find_limbs("turn the top box", *boxes) == ([0], ())
    assert find_limbs("turn the box", *boxes) == ([2], ())


def test_wheels_are_told_by_their_corners():
    names = ("wheel fl", "wheel fr", "wheel rl", "wheel rr")
    wheels = [make_part(name, (0, 0, -1), label=name) for name in names]
    assert sorted(find_limbs("turn the wheels", *wheels)[0]) == [0, 1, 2, 3]
    assert find_limbs("turn the front right wheel", *wheels)[0] == [1]


@pytest.mark.parametrize("sentence", ["turn the lid", "lift the lid", "raise its tail"])
def test_a_part_that_nobody_knows_is_asked_for_with_those_that_are_known(sentence):
    _, doubts = find_limbs(sentence, ARM, HEAD)
    assert any("left arm, head" in each and "`--part`" in each for each in doubts)


def test_what_is_seated_moves_as_a_whole_and_turns_about_its_middle():
    (lift,) = read("lift the lid").force_field.constraints
    (push,) = read("push the lid to the left").force_field.constraints
    assert lift.constraint_type is push.constraint_type is ConstraintType.PARTICLE_TRANSLATION
    (turn,) = read("turn the lid").force_field.constraints
    assert (turn.constraint_type, turn.pivot) == (ConstraintType.PARTICLE_ROTATION, LID.joint)
    head = make_part("head", seated=True)  # a head is no lid, however it is modelled
    (nod,) = read("push the head to the left", head).force_field.constraints
    assert nod.constraint_type is ConstraintType.PARTICLE_ROTATION


def test_a_told_way_is_how_far_it_goes():
    """M times gain times the usual length per reference time, while it acts."""
    plain, told = (
        read(sentence).force_field.constraints[0]
        for sentence in ("lift the lid", "lift the lid by half a body length")
    )
    ways = [
        each.magnitude * each.gain * (each.active_time[1] - each.active_time[0]) for each in (plain, told)
    ]
    assert ways[1] / ways[0] == pytest.approx(0.5 / (0.3 * 0.3), rel=0.02)


def test_region_and_evidence_say_which_part_it_is_and_what_told_of_it():
    reply = read("turn the lid")
    assert reply.force_field.constraints[0].region.label == "pot lid (part 1, named in the file)"
    assert reply.anchor.kind == "rest" and reply.expectations[0].kind is MotionKind.ROTATE


def test_alike_parts_are_told_by_their_sides():
    parts = [make_part("", side, "shape", roles=("arm",)) for side in ((-1, 0, 0), (1, 0, 0))]
    labels = [part.label for part in label_parts((*parts, HEAD, ARM), brief().directions)]
    assert labels == ["left arm", "right arm", "head", "left arm"]


def test_a_name_is_found_whole_then_by_its_last_word():
    parts = [
        make_part("lid 1"),
        make_part("pot lid", origin="option"),
        make_part("wheel 1"),
        make_part("wheel 2"),
    ]
    assert find_named(parts, "lid 1") == (0,)
    assert find_named(parts, "lid") == (1,)  # somebody's own name goes first
    assert find_named(parts, "wheel") == () and find_named(parts, "wheels", plural=True) == (2, 3)


def test_a_wheel_turns_about_its_axle_once():
    wheel = make_part("wheel", (0, 0, -1), seated=True, axle=(0, 1, 0))
    (turn,) = read("spin the wheel", wheel).force_field.constraints
    assert turn.constraint_type is ConstraintType.PARTICLE_ROTATION
    assert turn.vector == pytest.approx((0, 1, 0)) and turn.pivot == wheel.joint
    (expected,) = read("the wheel turns", wheel).expectations
    assert expected.amount is None  # its blades are alike


def test_a_piece_of_a_part_goes_with_it_and_is_not_moved_twice():
    arms = []
    for side, x in (("left", -1.0), ("right", 1.0)):
        near, far = (0.5 + 0.2 * x, 0.5, 0.5), (0.5 + 0.4 * x, 0.5, 0.5)
        whole = make_part(f"{side} arm", (x, 0, 0))
        regions = dict(moved=CellsRegion(inside=(near, far), outside=MIDDLE), share=0.2)
        arms += [whole.model_copy(update=regions), make_part(f"{side} viking arm", (x, 0, 0))]
    reply = read("the viking raises both arms", *arms)
    assert {each.limb for each in reply.expectations} == {0, 2}


def test_a_piece_with_the_objects_own_name_is_all_of_it():
    """A fridge's body is the node "fridge_A": it waddles with its doors, and "A glass fridge" names no part."""
    body, door = make_part("fridge a"), make_part("door", (1, 0, 0))
    for sentence in ("the fridge slides to the left", "A glass fridge slides to the left"):
        limbs, doubts = find_limbs(sentence, body, door, object_name="fridge A", world="ground")
        assert limbs == [None] and not doubts


def test_an_adjective_of_a_part_does_not_weaken_its_motion():
    told = [
        read(f"the {each}tail sways", make_part("tail")).expectations for each in ("", "little ", "huge ")
    ]
    assert [[(each.limb, each.strength) for each in motions] for motions in told] == [[(0, 1.0)]] * 3


@pytest.mark.parametrize("sentence", ["the trunk bends to the right", "the stem sways", "twist the trunk"])
def test_the_stem_of_a_plant_takes_the_plant_along(sentence):
    """All the rest stands on it: held still, it would keep the stem from moving."""
    trunk, crown = make_part("trunk", (0, 0, -1)), make_part("crown", (0, 0, 1))
    plant = dict(object_name="tree", object_kind="plant", world="ground", anchored="rooted")
    assert [each.limb for each in read(sentence, trunk, crown, **plant).expectations] == [None]
    assert [each.limb for each in read("bend the crown to the left", trunk, crown, **plant).expectations] == [
        1
    ]


def test_a_numbered_piece_that_holds_all_wheels_is_none_of_them():
    left, right = (
        make_part(f"front {side} wheel", (x, -0.7, 0)) for side, x in (("left", -0.7), ("right", 0.7))
    )
    inside = tuple(place for each in (left, right) for place in each.moved.inside)
    all_of_them = make_part("front left wheel 2", (0, -1, 0)).model_copy(
        update=dict(
            moved=CellsRegion(inside=inside, outside=MIDDLE), rest=CellsRegion(inside=MIDDLE, outside=inside)
        )
    )
    parts = (left, right, all_of_them.model_copy(update=dict(share=0.3)))
    assert find_named(parts, "wheels", plural=True) == (0, 1)


@pytest.mark.parametrize(
    "sentence", ["the fancy bow flutters", "the big red bow droops", "the fluffy bow twitches in the wind"]
)
def test_a_noun_before_a_verb_is_no_verb(sentence):
    assert find_limbs(sentence, make_part("bow", (0, 0, 1)), object_name="gift")[0] == [0]


@pytest.mark.parametrize(
    "sentence",
    [
        "a hammer smashes into the front bumper and crumples it",
        "the front bumper gets hit and caves in",
        "hit the front bumper hard and it crumples",
    ],
)
def test_a_blow_on_a_part_that_gives_way_dents_it_alone(sentence):
    reply = read(sentence, make_part("front bumper", (0, -1, 0)), object_name="car")
    (dent,) = reply.expectations
    assert dent.limb == 0 and dent.sudden and dent.stays


@pytest.mark.parametrize("words", ["lime slice", "lime wedge", "slice of lime", "piece of the lime"])
def test_a_word_for_a_piece_goes_with_the_name_of_a_part(words):
    limbs, doubts = find_limbs(f"the {words} moves to the left", make_part("lime"), ARM)
    assert limbs == [0] and not doubts


def test_the_first_half_of_a_name_stands_for_it():
    """The "cogs" are the cogcaps; a word that means another thing does not, nor does one of another number."""
    cogs = make_part("cogcaps", (1, 0, 0))
    assert find_limbs("the cogs wobble", cogs) == ([0], ())
    assert find_limbs("the cog wobbles", cogs) == ([None], ("'cog' is not understood.",))


@pytest.mark.parametrize(
    ("prompt", "degrees"),
    [("the lid twists around a few times", 1080), ("the lid turns round and round", 720)],
)
def test_a_lid_turns_as_often_as_it_is_told(prompt, degrees):
    (turn,) = read(prompt).expectations
    assert turn.kind is MotionKind.ROTATE and turn.amount is not None and turn.amount.value == degrees
