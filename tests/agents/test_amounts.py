"""Quantities that compare with the object or with what came before: lengths, amounts, heights."""

import pytest

from tests.agents.scenes import read
from tests.agents.tellings import ground


def amounts(prompt):
    """A line for each motion: its kind and its target."""
    reply = read(prompt, ground())
    told = [
        f"{m.kind.value} {m.amount.value:.4g} {m.amount.unit}" if m.amount else m.kind.value
        for m in sorted(reply.expectations, key=lambda m: m.window[0])
    ]
    return told, reply.unsure


@pytest.mark.parametrize(
    ("prompt", "expected"),
    [
        ("it becomes a sixth taller", ["stretch 1.167 factor"]),
        ("within a third of a second it gets a quarter shorter", ["squeeze 0.75 factor"]),
        ("it gets a twelfth shorter", ["squeeze 0.9167 factor"]),
        ("move it left by half its length, then right by as much", ["move 0.5 lengths", "move 0.5 lengths"]),
        ("it moves up half a metre, then as far down", ["move 0.5 metres", "move 0.5 metres"]),
        ("move it up by a third of its length, then left the same distance", ["move 0.3333 lengths"] * 2),
        ("turn it left by 30 degrees, then back by as much", ["rotate 30 degrees"] * 2),
        ("drop it from half its length", ["fall"]),
    ],
)
def test_what_is_measured(prompt, expected):
    assert amounts(prompt) == (expected, ())


@pytest.mark.parametrize(
    "prompt",
    [
        "stretch it by a fifth, then squeeze it by as much",  # a factor is not undone by the same factor
        "push it left by half its length, then turn it by as much",
        "it moves as far to the right",  # as what
        "drop it from twice its length",  # it is always dropped from the same height
        "drop it from a metre",
    ],
)
def test_what_cannot_be_measured_is_said(prompt):
    assert any("is a quantity that nothing here is measured in" in why for why in amounts(prompt)[1])


@pytest.mark.parametrize("plane", ["picture", "image", "screen"])
def test_turns_in_the_plane_of_the_picture_are_about_the_line_of_sight(plane):
    """Counter-clockwise as the viewer sees it: by the right-hand rule about the way towards the viewer."""
    for words in (f"in the plane of the {plane}", "as seen by the viewer"):
        (motion,) = read(f"turn it counter-clockwise by 15 degrees {words}", ground()).expectations
        assert motion.direction == (0.0, -1.0, 0.0)


@pytest.mark.parametrize(
    "prompt", ["stretch it by a fifth within half a second and keep it so", "it becomes taller and stays so"]
)
def test_what_stays_so_stays(prompt):
    (motion,) = read(prompt, ground()).expectations
    assert motion.stays and not motion.released
