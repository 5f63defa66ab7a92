"""Words for fingers, ends and sections: which part they mean, and what is done to it alone."""

import math

import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.schema import ConstraintType
from physagent_jax.motion.parts import label_parts
from physagent_jax.motion.schema import MotionKind
from tests.agents.scenes import brief, table
from tests.agents.test_limbs import make_part

NAMES = ("forefinger", "middlefinger", "ringfinger", "littlefinger")
THUMB = make_part("thumb", (-0.15, 0, 0.2), (-0.8, 0, 0.6))
FINGERS = [
    make_part(name, (0.1 * k, 0, 0.3), (math.sin(0.2 * k), 0, math.cos(0.2 * k))).model_copy(
        update=dict(roles=(name, "finger"))
    )
    for k, name in enumerate(NAMES)
]
HAND = (THUMB, *FINGERS)
BOOT = (make_part("toe", (0.25, 0, 0), (0.1, 0, -0.995)), make_part("heel", (-0.2, 0, 0), (-0.1, 0, -0.995)))
MUSHROOM = (make_part("stem", (0, 0, 0.7), (0, 0, -1)), make_part("crown", (0, 0, 0.4), (0, 0, 1)))
SWORD = (
    make_part("blade", (-0.7, 0, 0), (-1, 0, 0)),
    make_part("handle", (0.2, 0, 0), (1, 0, 0)),
    make_part("tip", (-0.2, 0, 0), (-1, 0, 0)),
)


def read(sentence, parts, name):
    about = brief(parts=label_parts(parts, table()), object_name=name, world="ground")
    return about, compile_intent(read_intent(sentence, about), about)


@pytest.mark.parametrize(
    ("sentence", "parts", "name", "limbs"),
    [
        ("push the thumb down", HAND, "hand", {0}),
        ("bend the fingers back", HAND, "hand", {1, 2, 3, 4}),
        ("bend the index finger forward", HAND, "hand", {1}),
        ("pull the pinky to the right", HAND, "hand", {4}),
        ("bend the toe up", BOOT, "boot", {0}),
        ("push the heel of the boot to the left", BOOT, "boot", {1}),
        ("bend the stem to the left", MUSHROOM, "mushroom", {0}),
        ("pull the cap of the mushroom to the left", MUSHROOM, "mushroom", {1}),
        ("bend the tip of the sword up", SWORD, "sword", {2}),
        ("bend the blade up", SWORD, "sword", {0}),
        ("push the hilt down", SWORD, "sword", {1}),
    ],
)
def test_a_word_moves_its_part_alone_and_says_so(sentence, parts, name, limbs):
    about, reply = read(sentence, parts, name)
    assert not reply.unsure and reply.anchor.kind == "rest"
    assert {each.limb for each in reply.expectations} == limbs
    regions = [about.parts[limb].moved for limb in sorted(limbs)]
    found = [each.region for each in reply.force_field.constraints]
    assert not reply.force_field.actions and sorted(map(str, found)) == sorted(map(str, regions))
    assert all(any(region.label in note for note in reply.notes) for region in regions)


@pytest.mark.parametrize(
    ("sentence", "parts", "name", "limb"),
    [
        ("press down on the toe of the boot", BOOT, "boot", 0),
        ("push the toe down", BOOT, "boot", 0),
        ("hit the heel from above", BOOT, "boot", 1),
        ("press down on the cap of the mushroom", MUSHROOM, "mushroom", 1),
    ],
)
def test_what_cannot_give_way_is_pressed_by_a_plate_of_its_size(sentence, parts, name, limb):
    about, reply = read(sentence, parts, name)
    (plate,) = reply.force_field.constraints
    assert plate.constraint_type is ConstraintType.MOVING_PLATE
    assert plate.region == about.parts[limb].moved and plate.vector == (0, 0, -1)
    (motion,) = reply.expectations
    assert (motion.kind, motion.limb, motion.direction) == (MotionKind.MOVE, limb, (0, 0, -1))
    assert not reply.unsure and reply.anchor.kind == "rest"


def test_a_part_that_is_pressed_where_it_is_free_gives_way():
    _, reply = read("press the thumb down", HAND, "hand")
    (turn,) = reply.force_field.constraints
    assert turn.constraint_type is ConstraintType.PARTICLE_ROTATION and turn.region == THUMB.moved.model_copy(
        update=dict(label=turn.region.label)
    )


def test_a_part_is_squeezed_between_two_plates_of_its_size():
    about, reply = read("squeeze the toe of the boot", BOOT, "boot")
    plates = reply.force_field.constraints
    assert [each.constraint_type for each in plates] == [ConstraintType.MOVING_PLATE] * 2
    assert all(each.region == about.parts[0].moved for each in plates) and reply.anchor.kind == "rest"


@pytest.mark.parametrize(
    "sentence",
    [
        "bend the fingers back",
        "push the thumb down",
        "press down on the toe",
        "press on the jaw",
        "press on the forehead",
        "poke the corner of it",
        "squash the heel",
    ],
)
def test_a_place_that_the_object_does_not_show_is_a_doubt(sentence):
    _, reply = read(sentence, (), "lump")
    assert reply.unsure


@pytest.mark.parametrize(
    "words", ["its handle", "the end of its handle", "the end of the handle", "the hilt"]
)
def test_what_it_is_taken_by_is_no_part_that_moves(words):
    for parts in (SWORD, ()):
        _, reply = read(f"lift the sword by {words}", parts, "sword")
        assert not reply.unsure and [each.limb for each in reply.expectations] == [None]


def test_a_finger_that_acts_is_no_part():
    _, reply = read("someone pokes the hand from the left with a finger", HAND, "hand")
    assert [each.limb for each in reply.expectations] == [None] and not reply.unsure
