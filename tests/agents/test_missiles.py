"""Other things that meet the object: they are the blows that they give, and the object itself does not fly or fall."""

import pytest

from physagent_jax.motion.schema import MotionKind
from tests.agents.tellings import ground, read, tell


@pytest.mark.parametrize(
    ("prompt", "told"),
    [
        ("a heavy ball drops on the robot", "hit down"),
        ("drop a brick on the robot", "hit down"),
        ("an anvil lands on it", "hit down"),
        ("a steel ball is dropped onto it", "hit down"),
        ("throw a snowball at the robot", "hit left"),
        ("a ball is thrown at him", "hit left"),
        ("roll a barrel into the robot", "hit left"),
        ("a coconut flies into the robot", "hit left"),
        ("something heavy falls onto the robot", "hit down"),
        ("something is slammed down on it", "hit down"),
    ],
)
def test_a_thing_that_meets_the_object_hits_it(prompt, told):
    (motion,) = read(prompt, ground()).expectations
    assert tell(motion) == told


@pytest.mark.parametrize(
    ("prompt", "kind"),
    [
        ("drop the robot on a rock", MotionKind.FALL),
        ("the robot falls onto its back", MotionKind.ROTATE),
        ("throw the robot at the wall", MotionKind.MOVE),
        ("a hand pushes against the robot", MotionKind.MOVE),
        ("a robot falls on its head", MotionKind.FALL),
    ],
)
def test_what_the_object_does_stays_its_own(prompt, kind):
    motions = read(prompt, ground()).expectations
    assert kind in [each.kind for each in motions]
    assert tell(motions[0]) != "hit down" and not (prompt.startswith("a hand") and motions[0].sudden)
