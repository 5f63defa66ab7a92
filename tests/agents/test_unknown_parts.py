"""Words for parts that an object does not show: they are told apart from scenery, looks and other things."""

import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.motion.parts import label_parts
from tests.agents.scenes import brief, table
from tests.agents.test_limbs import HEAD, LEFT_ARM, RIGHT_ARM, make_part

PARTS = (LEFT_ARM, RIGHT_ARM, HEAD)


def read(sentence, *parts):
    about = brief(object_name="lumberjack", parts=label_parts(parts or PARTS, table()))
    return compile_intent(read_intent(sentence, about), about)


@pytest.mark.parametrize(
    ("sentence", "word"),
    [
        ("swing the axe of the lumberjack", "axe"),
        ("raise the lumberjack's axe", "axe"),
        ("the lumberjack swings his axe", "axe"),
        ("the lumberjack's old axe turns to the left", "axe"),
        ("the plume of the lumberjack is lifted", "plume"),
        ("tap the lumberjack on its badge", "badge"),
        ("bend the knee", "knee"),
        ("press on the jaw", "jaw"),
        ("pull the ears of the lumberjack up", "ears"),
        ("push the thumb down", "thumb"),
        ("it wags its tail", "tail"),
        ("lift the left leg", "left leg"),
        ("everything but its axe moves to the left", "axe"),
        ("bend the spikes to the left", "spikes"),
        ("the candles on the lumberjack sway", "candles"),
        ("pull the ribbons on the lumberjack up", "ribbons"),
    ],
)
def test_a_part_that_is_not_there_is_told(sentence, word):
    assert read(sentence).unknown_parts == (word,)


@pytest.mark.parametrize(
    "sentence",
    [
        "push the lumberjack with its axe to the left",
        "lift the lumberjack by its axe",
        "push the lumberjack on the lawn to the left",
        "the wooden lumberjack in a forest is pushed to the left",
        "the lumberjack's shadow moves to the left",
        "push the statue to the left",
        "the lumberjack in its green shirt falls",
        "push the lumberjack to the edge of the table",
        "the colour of the lumberjack fades as it falls",
        "the lumberjack shows its strength and jumps",
        "the lumberjack hangs from a hook and swings",
        "push the head to the left",
        "raise the left arm",
        "push the top to the left",
        "push the tip to the left",
        "the lumberjack lands on his feet",
    ],
)
def test_what_is_no_part_is_not_asked_for(sentence):
    assert read(sentence).unknown_parts == ()


@pytest.mark.parametrize(
    "sentence",
    [
        "A hand tugs at one of the lumberjack's arms, then lets go.",
        "a finger lifts one of his arms and releases it",
        "a gardener pulls on one of the lumberjack's arms, then lets it go",
        "a child bends both of the lumberjack's arms down, then lets go of them",
    ],
)
def test_a_hand_that_acts_on_a_part_lets_that_go(sentence):
    """All that was done was left out, and it fell."""
    seen = read(sentence).expectations
    assert seen and all(each.limb in (0, 1) and each.released for each in seen)
    assert read(sentence.replace("arms", "antlers")).unknown_parts


@pytest.mark.parametrize(
    "sentence",
    [
        "his left arm waves while the backpack stays put",
        "the badges stay where they are while his left arm waves",
        "his left arm waves, but its tail stays still",
        "his left arm waves while the medal does not move",
    ],
)
def test_what_only_stays_put_need_not_be_known(sentence):
    reply = read(sentence)
    assert not (reply.unsure or reply.unknown_parts)
    assert [each.limb for each in reply.expectations] == [0]


@pytest.mark.parametrize(
    ("sentence", "role", "limb"),
    [
        ("raise the left claw", "arm", 0),
        ("push the bill to the left", "nose", 2),
        ("lift the muzzle", "nose", 2),
        ("raise the left forearm", "arm", 0),
        ("the lumberjack nods his skull", "head", 2),
    ],
)
def test_a_synonym_is_the_part_that_is_there(sentence, role, limb):
    third = make_part(role, (0, 0, 0.2), (0, 0, 1)) if role != "arm" else HEAD
    reply = read(sentence, LEFT_ARM, RIGHT_ARM, third)
    assert not reply.unknown_parts and [each.limb for each in reply.expectations] == [limb]
