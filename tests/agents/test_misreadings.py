"""Sentences that word by word say something else: read as people read them, or said to be unclear.

Beside each that is said to be unclear stands a near neighbour that is clear, so that no mark is wider than its reason.
"""

import pytest

from tests.agents.scenes import read
from tests.agents.tellings import ground, order, tell


@pytest.mark.parametrize(
    ("prompt", "expected"),
    [
        # what is taken back
        ("push it left, no wait, right", "move right"),
        ("push it to the left, I mean to the right", "move right"),
        ("tilt it left, or rather backwards", "rotate left"),
        ("turn it clockwise... actually make that counterclockwise", "rotate up"),
        ("bend its head, i.e. its upper half, to the right", "rotate away on up"),
        # what comes of it, and when
        ("it is pushed from the left, so it goes right", "move right"),
        ("until it is kicked from behind, it stays still", "still; hit toward"),
        ("spin it, after which it wobbles", "rotate up; sway left x3"),
        ("it tips over to the left as soon as it is let go", "rotate toward & fall"),
        # how far a word reaches





        ("the upper shelf leans to the left", "rotate toward on up"),
        ("push it as far as the wall on the right", "move right"),
        ("turn it upside down and put it back down", "rotate toward & move down"),
        ("squeeze it from the left and the right at once", "squeeze right"),
        ("squash it from the sides", "squeeze right"),
        ("it nods twice and shakes its head once", "sway toward x2 & sway left on up"),
        ("all right, push it left", "move left"),
        ("it is kicked to the left by somebody's foot", "hit left"),
        ("no breeze stirs it", "still"),
        ("it stands rock-steady", "still"),
        ("free fall from rest", "fall"),
        ("turn it over and back", "rotate toward; rotate away"),
        ("up 10 cm and back down", "move up; move down"),
        ("an uppercut", "hit up"),
        ("lift it, swing it to the left, and set it down", "move up; sway left x2; move down"),
        ("first move it up, then to the right without dropping it", "move up; move right"),
        ("gently blow on it from the left", "move right"),
        ("let it fall over to the left", "rotate toward & fall"),
        ("push it left first and spin it afterwards", "move left; rotate up"),
        ("push it left, stretching it up at the same time", "move left & stretch up"),
        ("push it left; before that, lift it", "move up; move left"),
        ("a wind from the right blows it away", "move left"),
        # said several times, or only heard




        # what is no motion

        ("3.2 Compress it from above", "squeeze down"),
    ],
)  # fmt: skip
def test_what_is_read(prompt, expected):
    """Motions in their order; the readings were written by hand."""
    assert order(prompt) == expected


@pytest.mark.parametrize(
    ("unclear", "clear"),
    [
        # what is only supposed or asked for, or was so before
        # lists and counts
        # places that tell no way
        # what is moved
        ("its feet drop", "it lands on its feet"),
        ("pull it out to one and a half times its length", "stretch it to one and a half times its length"),
        # how it ends
    ],
)
def test_what_is_unclear(unclear, clear):
    """A plain sentence in ``unsure`` for the one, none for the other."""
    doubts = read(unclear, ground()).unsure
    assert doubts and all(text.endswith(".") for text in doubts)
    assert read(clear, ground()).unsure == ()


def test_a_hold_before_a_release_is_how_long():
    """A hold before a release is a duration."""
    (motion,) = read("stretch it to twice its width, hold for 2 seconds and release", ground()).expectations
    assert tell(motion) == "stretch right" and motion.released
    assert motion.window[1] == 50  # 2 s of 0.04 s


def test_what_holds_beside_a_motion():
    """Hanging and being clamped are no motions, and hide none."""
    hanging = read("it hangs from a rope, spinning", ground())
    assert hanging.anchor.kind == "top" and [tell(m) for m in hanging.expectations] == ["rotate up"]
    clamped = read("torsion by 45 degrees about the vertical axis with the lower end clamped", ground())
    assert clamped.anchor.kind == "base" and [tell(m) for m in clamped.expectations] == ["rotate up on up"]


@pytest.mark.parametrize(
    ("prompt", "unit", "value"),
    [
        ("make it 2x bigger", "factor", 2.0),
        ("flip it over", "degrees", 180.0),
        ("flip it upside down", "degrees", 180.0),
        ("flip it over by 90 degrees", "degrees", 90.0),
    ],
)
def test_how_much_is_read(prompt, unit, value):
    """Numbers that are no counts."""
    (motion,) = read(prompt, ground()).expectations
    assert motion.amount is not None and (motion.amount.unit, motion.amount.value) == (unit, value)


def test_a_free_end_holds_nothing():
    """ "Free" says nothing of the hold where something else is clamped."""
    assert read("pull the free upper end up while the base is clamped", ground()).anchor.kind == "base"


def test_forms_of_alike_verbs():
    """A taped thing is held, and a tapped one is struck."""
    assert read("it is taped to the table", ground()).anchor.kind == "base"
    assert order("it is tapped from the left") == "hit right"


def test_a_letter_that_is_left_out():
    """A doubled letter that is written once."""
    (motion,) = read("squeeze it in the midle", ground()).expectations
    assert motion.partial


def test_one_wall_of_brick():
    """A brick wall is a wall, and no block besides."""
    (wall,) = read("it crashes into the brick wall on the right", ground()).world.obstacles
    assert wall.kind == "wall" and wall.direction == (1.0, 0.0, 0.0)
