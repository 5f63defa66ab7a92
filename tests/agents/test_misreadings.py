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
        ("its head, sorry, the whole robot slides to the left", "move left"),
        # what comes of it, and when
        ("it is pushed from the left, so it goes right", "move right"),
        ("it does not fall until it is pushed from the left", "move right; fall"),
        ("until it is kicked from behind, it stays still", "still; hit toward"),
        ("spin it, after which it wobbles", "rotate up; sway left x3"),
        ("first nothing, then a jolt upward", "still; hit up"),
        ("it shakes, then calm", "sway left x4; still"),
        ("toss it up and let it come back down", "hit up; fall"),
        ("it is thrown to the left and slides down", "hit left; move down"),
        ("it tips over to the left as soon as it is let go", "rotate toward & fall"),
        ("it bows and exits left", "rotate right; move left"),
        # how far a word reaches
        ("not only its head but all of it moves left", "move left"),
        ("instead of moving to the left the robot jumps", "hit up; fall"),
        ("it sways away from the wind that comes from the left", "sway right x2"),
        ("it slides to the left on its back", "move left"),
        ("its left arm goes up while the right one goes down", "move up on left & move down on right"),
        ("the upper shelf leans to the left", "rotate toward on up"),
        ("it is carried to the right and high", "move ?"),
        ("push it up to the wall on the left", "move left"),
        ("push it as far as the wall on the right", "move right"),
        ("turn it upside down and put it back down", "rotate toward & move down"),
        ("squeeze it from the left and the right at once", "squeeze right"),
        ("squash it from the sides", "squeeze right"),
        ("it grows, then shrinks back", "stretch; squeeze"),
        ("it nods twice and shakes its head once", "sway toward x2 & sway left on up"),
        ("all right, push it left", "move left"),
        ("right, now push it left", "move left"),
        ("right at the start give it a kick to the left", "hit left"),
        ("stop it with your hand after it has moved left for a second", "move left; still"),
        ("push it and it rolls to the right", "move right & rotate away"),
        ("it shakes so hard that it moves to the left", "sway left x4 & move left"),
        ("it is kicked to the left by somebody's foot", "hit left"),
        ("no breeze stirs it", "still"),
        ("it stands rock-steady", "still"),
        ("free fall from rest", "fall"),
        ("turn it over and back", "rotate toward; rotate away"),
        ("up 10 cm and back down", "move up; move down"),
        ("it rests for a while, then suddenly jumps", "still; hit up; fall"),
        ("an uppercut", "hit up"),
        ("lift it, swing it to the left, and set it down", "move up; sway left x2; move down"),
        ("first move it up, then to the right without dropping it", "move up; move right"),
        ("gently blow on it from the left", "move right"),
        ("let it fall over to the left", "rotate toward & fall"),
        ("push it left first and spin it afterwards", "move left; rotate up"),
        ("push it left, stretching it up at the same time", "move left & stretch up"),
        ("push it left, but spin it first", "rotate up; move left"),
        ("push it left; before that, lift it", "move up; move left"),
        ("lift it, having pushed it left", "move left; move up"),
        ("three blows from the left", "hit right x3"),
        ("a wind from the right blows it away", "move left"),
        # said several times, or only heard
        ("swing, robot, swing", "sway left x2"),
        ("they hit it from the left, bang bang bang", "hit right x3"),
        ("and then, with a bump, it landed", "fall"),
        ('"move over," said the king, and the robot rose', "move up"),
        # what is no motion
        ("what a pick-up, it is sent flying to the right", "move right"),
        ("3.2 Compress it from above", "squeeze down"),
        ("its feet planted, it leans to the left", "move left"),
    ],
)  # fmt: skip
def test_what_is_read(prompt, expected):
    """Motions in their order; the readings were written by hand."""
    assert order(prompt) == expected


@pytest.mark.parametrize(
    ("unclear", "clear"),
    [
        # what is only supposed or asked for, or was so before
        ("is it leaning to the left?", "can it lean to the left?"),
        ("will it fall?", "will it fall if it is pushed to the left?"),
        ("it would have fallen; push it to the left", "it would fall if it were pushed to the left"),
        ("it is too heavy to be pushed over", "it is too heavy, push it over"),
        ("if it were light it would fly up, but it trembles", "if it were pushed left it would fall"),
        ("the robot that had fallen spins", "once it had fallen it spins"),
        ("robot leaning to the left straightens up", "robot leaning to the left"),
        # lists and counts
        ("two nudges, the first left, the second right", "two nudges to the left"),
        ("left, left, right", "left, right"),
        ("nudge it left every time it stops", "nudge it left three times"),
        ("turn it 90 degrees twice", "turn it twice"),
        ("up a bit, left a lot", "a bit up and left"),
        ("alternately squeeze and stretch it", "alternately push it left and right"),
        # places that tell no way
        ("push it left past the wall", "push it left to the wall"),
        ("move it in front of us", "move it towards us"),
        ("push it to its own left", "push it to the left"),
        ("push it there", "push it left, there"),
        ("bring it back where it was", "push it left and bring it back"),
        ("put it back on its feet", "lift it and put it down"),
        ("it swings from its top", "it hangs from its top"),
        ("blow on it from where you are", "blow on it from the left"),
        # what is moved
        ("turn it so its back faces us", "turn it to face away"),
        ("blow the robot up", "the wind blows the robot up"),
        ("take away the table", "take the robot away"),
        ("lower a big plate onto it", "lower it"),
        ("all jump", "the robot jumps"),
        ("the wind drops", "the robot drops"),
        ("its falling is stopped", "it is falling"),
        ("its feet drop", "it lands on its feet"),
        ("pull it out to one and a half times its length", "stretch it to one and a half times its length"),
        ("push it left, no, lift it", "push it left, no, right"),
        ("the harder it is pushed left, the more it tilts", "it is pushed harder to the left and tilts left"),
        ("make it face left", "make it turn left"),
        ("a storm rips it out of the ground", "a storm pulls it out of the ground"),
        ("don't let it spring back", "pull it left, let it spring back"),
        ("over it goes, to the left", "up it goes"),
        ("poof, gone", "it has gone left"),
        ("hit it from the left and from the right", "hit it from the left, then from the right"),
        ("push it from the top to the left", "push it from the right to the left"),
        ("what's left of it falls", "the left half of it goes up"),
        ("it has the right to fall", "it has to fall to the right"),
        ("hit it low from the right", "kick it high into the air"),
        ("can we see it from the left while it falls?", "can we see a push from the left?"),
        ("push it left and then again", "push it left and then again to the left"),
        ("raise and lower it three times", "raise it, then lower it three times"),
        ("hit it from the left. Three times.", "hit it from the left. Three times it is hit from above."),
        ("hands up", "its head goes up"),
        ("spin it end over end", "tumble it end over end"),
        ("swing it around by its neck", "spin it around by its neck"),
        ("it spins down", "it spins"),
        ("let it fall from a tilt to the left", "let it fall to the left"),
        ("Force direction: left. Region: top.", "Force direction: left."),
        ("it hangs its head", "it bows its head"),
        ("do not lift it and drop it", "do not lift it, drop it"),
        # how it ends
        ("spin it three times and then let it slow down", "spin it three times and then let it stand still"),
        ("it collapses under its own weight", "it collapses"),
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


def test_two_words_for_one_change_of_size():
    """The measure of the second is the measure of both."""
    (motion,) = read("it deflates and shrinks to half its size", ground()).expectations
    assert motion.amount is not None and (motion.amount.unit, motion.amount.value) == ("factor", 0.5)


def test_what_holds_beside_a_motion():
    """Hanging and being clamped are no motions, and hide none."""
    hanging = read("it hangs from a rope, spinning", ground())
    assert hanging.anchor.kind == "top" and [tell(m) for m in hanging.expectations] == ["rotate up"]
    clamped = read("torsion by 45 degrees about the vertical axis with the lower end clamped", ground())
    assert clamped.anchor.kind == "base" and [tell(m) for m in clamped.expectations] == ["rotate up on up"]


@pytest.mark.parametrize(
    ("prompt", "unit", "value"),
    [
        ("one and a half somersaults", "degrees", 540.0),
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


def test_what_is_not_done_holds_nothing():
    """ "Instead of" and "free" anchor neither the top nor nothing."""
    assert read("instead of raising its head it spins", ground()).anchor.kind is None
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
