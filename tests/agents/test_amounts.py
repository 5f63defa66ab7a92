"""Quantities of `quantities.yaml`: numbers with units, amounts of motions, and what nothing is measured in."""

import pytest

from physagent_jax.agents.grammar.measures import Words, match_quantity
from physagent_jax.agents.grammar.tokens import tokenise
from tests.agents.scenes import read
from tests.agents.sentences import load_table
from tests.agents.tellings import ground

TABLE = load_table("quantities.yaml")


@pytest.mark.parametrize(("words", "expected"), TABLE["quantities"].items())
def test_quantities_with_units(words, expected):
    """Numbers in digits, words and fractions, in the unit that they stand in."""
    tokens = tokenise(words)
    found = match_quantity(Words(tokens), 0)
    assert found is not None and found[1] == len(tokens)
    assert f"{found[0].value:.4g} {found[0].unit}".strip() == expected


@pytest.mark.parametrize("words", TABLE["no quantities"])
def test_what_is_no_quantity(words):
    """Times, parts and counts are other things' business."""
    assert match_quantity(Words(tokenise(words)), 0) is None


@pytest.mark.parametrize(("prompt", "expected"), TABLE["amounts"].items())
def test_quantities_are_targets(prompt, expected):
    """A quantity is the expectation's amount, and happens once."""
    reply = read(prompt, ground())
    told = [
        f"{m.kind.value} {m.amount.value:.4g} {m.amount.unit}" if m.amount else m.kind.value
        for m in sorted(reply.expectations, key=lambda m: m.window[0])
    ]
    assert ("; ".join(told), reply.unsure) == (expected, ())
    assert all(m.repeats == 1 for m in reply.expectations if m.amount)


@pytest.mark.parametrize("prompt", TABLE["unmeasured"])
def test_what_cannot_be_measured_is_said(prompt):
    assert any(
        "is a quantity that nothing here is measured in" in why for why in read(prompt, ground()).unsure
    )


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


@pytest.mark.parametrize(
    ("prompt", "way", "reach"),
    [
        ("the robot jumps back", 1, (0.4, 1.0)),
        ("the robot leaps forward", 1, (0.4, 1.0)),
        ("the robot hops to the left", 0, (0.4, 1.0)),
        ("the robot jumps to the right by one and a half times its length", 0, (1.4, 1.6)),
    ],
)
def test_a_leap_aside_is_low_and_near(prompt, way, reach):
    """A leap aside rises and lands as a thrown body does (`forces.opposition`); in body lengths."""
    (leap,) = read(prompt, ground()).force_field.actions
    up, aside = leap.vector[2], abs(leap.vector[way])
    rises = leap.magnitude * up**3
    assert 0.15 < rises < 0.7 * reach[1]
    assert reach[0] < 4 * rises * aside / up < reach[1]


@pytest.mark.parametrize(
    ("prompt", "lengths"),
    [
        ("slide it to the left by half its width", 0.2),
        ("it rises to twice its own height", 1.0),
        ("push it away by its depth", 0.3),
        ("slide it to the left by half its length", 0.5),
    ],
)
def test_a_share_of_a_side_is_of_that_side(prompt, lengths):
    """Every side was as long as the longest, so that what is slim went far and what is low rose out of the picture."""
    (motion, *_) = read(prompt, ground(extents=(0.4, 0.5, 0.3))).expectations
    assert motion.amount is not None and motion.amount.unit == "lengths"
    assert motion.amount.value == pytest.approx(lengths)
