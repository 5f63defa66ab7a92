"""Words for parts that tell a posture: nothing is done to those parts, and nothing is asked about them."""

import pytest

from physagent_jax.run.postures import list_acted, strip_postures


@pytest.mark.parametrize(
    ("sentence", "word"),
    [
        ("an iron jeep plunges nose first onto the ground", "nose"),
        ("the jeep rolls over sideways once and ends up on its wheels", "wheels"),
        ("the cat is dropped and lands on its feet", "feet"),
        ("throw it so that it lands head-first", "head"),
        ("it tumbles head over heels", "head"),
        ("the dog rolls over onto its back", "back"),
        ("the statue falls over, face down", "face"),
        ("the horse rears up on its hind legs", "legs"),
        ("the truck tips over and lies on its side", "side"),
        ("drop the plant upside down onto its leaves", "leaves"),
        ("the bear stands on the tip of its nose belly-up", "belly"),
    ],
)
def test_a_posture_acts_on_no_part(sentence, word):
    assert list_acted((word,), sentence) == ()
    assert len(strip_postures(sentence)) == len(sentence)


@pytest.mark.parametrize(
    ("sentence", "word"),
    [
        ("press on its nose", "nose"),
        ("tap the statue on its head", "head"),
        ("push the nose down first", "nose"),
        ("bend its head down", "head"),
        ("lift the cat's tail up", "tail"),
        ("spin the wheels", "wheels"),
        ("turn its head to the left", "head"),
        ("it lands on its feet and then wags its tail", "tail"),
        ("drop a stone on its back", "back"),
        ("the wheels turn and it ends up on its wheels", "wheels"),
    ],
)
def test_what_is_acted_on_is_a_part(sentence, word):
    assert list_acted((word,), sentence) == (word,)
