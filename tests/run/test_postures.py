"""Words for parts that tell a posture: nothing is done to those parts, and nothing is asked about them."""

import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.run.postures import list_acted, strip_postures
from physagent_jax.run.reading import tell_parts
from tests.agents.scenes import brief
from tests.agents.test_named_parts import make_part


@pytest.mark.parametrize(
    ("sentence", "word"),
    [
        ("an iron jeep plunges nose first onto the ground", "nose"),
        ("the jeep rolls over sideways once and ends up on its wheels", "wheels"),
        ("the cat is dropped and lands on its feet", "feet"),
        ("throw it so that it lands head-first", "head"),
        ("it tumbles head over heels", "head"),
        ("a big hand pushes down on the truck and lets go", "hand"),
        ("it stands there, then a giant boxing fist hits it", "fist"),
        ("the dog rolls over onto its back", "back"),
        ("the statue falls over, face down", "face"),
        ("the horse rears up on its hind legs", "legs"),
        ("the truck tips over and lies on its side", "side"),
        ("drop the plant upside down onto its leaves", "leaves"),
        ("the bear stands on the tip of its nose belly-up", "belly"),
        ("the dog lifts a paw like it wants to shake hands", "hands"),
        ("it sways as if it had no legs, then falls", "legs"),
    ],
)
def test_a_posture_acts_on_no_part(sentence, word):
    assert list_acted((word,), sentence) == ()
    assert len(strip_postures(sentence)) == len(sentence)


@pytest.mark.parametrize(
    ("sentence", "word"),
    [
        ("press on its nose", "nose"),
        ("he waves a big hand", "hand"),
        ("tap the statue on its head", "head"),
        ("push the nose down first", "nose"),
        ("bend its head down", "head"),
        ("lift the cat's tail up", "tail"),
        ("spin the wheels", "wheels"),
        ("turn its head to the left", "head"),
        ("it lands on its feet and then wags its tail", "tail"),
        ("drop a stone on its back", "back"),
        ("the wheels turn and it ends up on its wheels", "wheels"),
        ("pull one of the robot's arms to the left", "one of its arms"),  # no quotation
    ],
)
def test_what_is_acted_on_is_a_part(sentence, word):
    assert list_acted((word,), sentence) == (word,)


WHEEL = make_part("wheel", stands_for="mill blades")


def tell(sentence, *parts):
    about = brief(parts=parts)
    return tell_parts(compile_intent(read_intent(sentence, about), about), sentence, about)


def test_the_plan_says_what_a_word_is_taken_to_be():
    assert "'wheel' is taken to be 'mill blades'." in tell("turn the wheel", WHEEL).notes
    (note,) = (each for each in tell("lift one end of the robot").notes if "taken to be" in each)
    assert "'one end" in note.lower() and "right" in note


def test_a_posture_leaves_no_doubt_about_a_part():
    told = tell("the robot falls nose first", WHEEL)
    assert not told.unknown_parts and not any("is not known" in each for each in told.unsure)
    asked = tell("push the nose to the left", WHEEL)
    assert asked.unknown_parts == ("nose",) and any("is not known" in each for each in asked.unsure)
